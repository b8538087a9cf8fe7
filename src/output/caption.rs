//! The caption of a map: everything that is needed to compute it again.
//!
//! Owns its wording; breaks no lines.

use super::PROGRAM;
use super::ticks::number;
use crate::experiment::Scheme;
use crate::map::ParameterMap;
use crate::measurement::{QUANTITIES, Quantity, Values};

/// The paragraphs of the caption.
pub fn of(map: &ParameterMap) -> Vec<String> {
    vec![fixed_parameters(map), numerics(map)]
}

fn fixed_parameters(map: &ParameterMap) -> String {
    // No break within `symbol = value`.
    let fixed = map.experiment.fixed_parameters();
    let fixed: Vec<String> = fixed
        .map(|(parameter, value)| format!("{}\u{a0}=\u{a0}{}", parameter.info().symbol, number(value)))
        .collect();
    format!(
        "Fixed parameters: {}. All quantities are dimensionless.",
        fixed.join(", ")
    )
}

fn numerics(map: &ParameterMap) -> String {
    let settings = &map.experiment.settings;
    let scheme = match settings.scheme() {
        Scheme::Taylor => "Taylor series of order 8, steps ending at the friction layer’s boundaries",
        Scheme::Rk4 => "Runge–Kutta of order 4",
        Scheme::Radau => "Radau IIA of order 5, exact heat modes",
    };
    let (x, y) = (map.x_axis().count, map.y_axis().count);
    let mut text = format!(
        "Map of {x} × {y} points. {scheme}, {} steps per forcing period, transient of {} periods, {} measured periods",
        settings.steps_per_period(),
        settings.transient_periods,
        settings.periods
    );
    if settings.initial_states > 1 {
        text += &format!(
            ", {} initial states (seed {}) per point from x in {}, y in {}",
            settings.initial_states,
            settings.seed,
            range(settings.initial_box.x),
            range(settings.initial_box.y)
        );
    }
    let computed = (0..x * y).filter(|&index| map.is_computed(index)).count();
    if computed > 0 {
        text += &format!(", integrated on {}", backends(map).join(" and "));
    }
    text += ". ";
    if computed < x * y {
        text += &format!("Of the {} points, {computed} are computed. ", x * y);
    }
    text + &PROGRAM.replace(' ', "\u{a0}") + "."
}

fn range([low, high]: [f64; 2]) -> String {
    format!("[{}, {}]", number(low), number(high))
}

/// Where the points were integrated, in the table's order.
fn backends(map: &ParameterMap) -> Vec<String> {
    let Values::Code(names) = QUANTITIES[Quantity::Backend as usize].values else {
        return Vec::new();
    };
    let column = map.column(Quantity::Backend);
    let occurs = |code: usize| column.contains(&(code as f64));
    names
        .iter()
        .enumerate()
        .filter(|(code, _)| occurs(*code))
        .filter_map(|(_, name)| backend(name))
        .collect()
}

/// `cpu_f64` as `CPU (f64)`; None if it is no backend's name.
pub fn backend(name: &str) -> Option<String> {
    let (device, precision) = name
        .split_once('_')
        .filter(|(device, _)| ["cpu", "gpu"].contains(device))?;
    Some(format!("{} ({precision})", device.to_uppercase()))
}

/// The text with its first letter in upper case.
pub fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters
        .next()
        .map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
