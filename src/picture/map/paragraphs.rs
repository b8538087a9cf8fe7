//! The caption of a map: everything that is needed to compute it again.
//!
//! Owns the paragraphs below a map; what captions say of any computation is [`crate::picture::caption`]'s.

use std::fmt::Write as _;

use crate::design::Coordinate;
use crate::map::{CLOSED, ParameterMap, least_region};
use crate::measure::{QUANTITIES, Quantity, Values};
use crate::output::PROGRAM;
use crate::picture::caption;
use crate::picture::ticks::number;

/// All paragraphs except the one on the border.
pub fn of(map: &ParameterMap) -> Vec<String> {
    let paragraphs = [Some(fixed_parameters(map)), beyond_limits(map), Some(numerics(map))];
    paragraphs.into_iter().flatten().collect()
}

/// The paragraph that explains the border of chaos drawn over a map.
pub fn border(map: &ParameterMap) -> String {
    let left_out = match least_region(map) {
        0..=1 => String::new(),
        least => format!("; islands and gaps of fewer than {least} points are left out"),
    };
    format!(
        "Border of chaos: between chaotic points and regular or quasi-periodic ones; points of other kinds count as most of their \
         neighbours, up to {CLOSED} points away{left_out}."
    )
}

/// The paragraph on the points at which the map shows what no machine could do.
fn beyond_limits(map: &ParameterMap) -> Option<String> {
    let shares = map.shares_beyond_limits();
    let parts: Vec<String> = shares
        .iter()
        .enumerate()
        .map(|(index, (name, share))| {
            let how = match *name {
                "melting" => "the shaft hotter than its melting point",
                "yield" => "the shaft pressed beyond its yield strength",
                _ => "the bush turned further than the model holds",
            };
            let of_points = if index == 0 { " of the points" } else { "" };
            // a small share is not written as 0 %
            let percent = (1000.0 * share).round().max(1.0) / 10.0;
            format!("{how} at {}\u{a0}%{of_points}", number(percent))
        })
        .collect();
    (!parts.is_empty()).then(|| format!("Beyond the model's limits: {}.", parts.join(", ")))
}

fn fixed_parameters(map: &ParameterMap) -> String {
    let axes = map.experiment.design.axes().iter();
    let shown: Vec<Coordinate> = axes.map(|axis| axis.coordinate).collect();
    caption::fixed(&map.experiment.design.fixed, &shown)
}

fn numerics(map: &ParameterMap) -> String {
    let settings = &map.experiment.settings;
    let (x, y) = (map.x_axis().count(), map.y_axis().count());
    let run = if map.experiment.wears() {
        // without wear, a transient comes before the measurement
        format!("{} forcing periods from the start", settings.sampling.periods)
    } else {
        format!(
            "transient of {} periods, {} measured periods{}",
            settings.sampling.transient_periods,
            settings.sampling.periods,
            if map.experiment.decides_early() {
                ", less where the motion shows early what it is"
            } else {
                ""
            }
        )
    };
    let mut text = format!("Map of {x} × {y} points. {}, {run}", caption::scheme(settings));
    if settings.sampling.initial_states > 1 {
        let _ = write!(
            text,
            ", {} initial states (seed {}) per point from x in {}, y in {}",
            settings.sampling.initial_states,
            settings.sampling.seed,
            range(settings.sampling.initial_box.x),
            range(settings.sampling.initial_box.y)
        );
    }
    let computed = (0..x * y).filter(|&index| map.is_computed(index)).count();
    if computed > 0 {
        let _ = write!(text, ", integrated on {}", backends(map).join(" and "));
    }
    text += ". ";
    if computed < x * y {
        let _ = write!(text, "Of the {} points, {computed} are computed. ", x * y);
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
    let occurs = |code: usize| map.values(Quantity::Backend).any(|backend| backend == code as f64);
    names
        .iter()
        .enumerate()
        .filter(|(code, _)| occurs(*code))
        .filter_map(|(_, name)| caption::backend(name))
        .collect()
}
