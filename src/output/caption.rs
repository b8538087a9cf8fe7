//! The caption of a map: everything that is needed to compute it again.
//!
//! Owns its wording; breaks no lines.

use super::PROGRAM;
use super::panel::Scale;
use super::ticks::{Tick, number, rounded};
use crate::backend::BackendKind;
use crate::design::{Axis, Coordinate, Fixed, Spacing};
use crate::experiment::{Scheme, Settings};
use crate::machine::units::{Unit, five_digits};
use crate::map::{CLOSED, ParameterMap, least_region};
use crate::measure::{QUANTITIES, Quantity, Values};
use crate::parameters::{PARAMETERS, Parameter};

/// The paragraphs of the caption.
pub fn of(map: &ParameterMap) -> Vec<String> {
    let paragraphs = [Some(fixed_parameters(map)), beyond_limits(map), Some(numerics(map))];
    paragraphs.into_iter().flatten().collect()
}

/// What the border of chaos is that is drawn over a map.
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

/// Where no machine could do what is shown.
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
            // few are not none
            let percent = (1000.0 * share).round().max(1.0) / 10.0;
            format!("{how} at {}\u{a0}%{of_points}", number(percent))
        })
        .collect();
    (!parts.is_empty()).then(|| format!("Beyond the model's limits: {}.", parts.join(", ")))
}

/// The words of an axis, and what its values are multiplied with to be in the unit that the words tell.
#[derive(Clone, Debug)]
pub struct AxisLabel {
    pub words: String,
    pub factor: f64,
}

impl AxisLabel {
    /// What the axis' coordinate means, its symbol, and its unit with a prefix that suits the values.
    pub fn of(axis: &Axis, at: &Fixed) -> Self {
        let coordinate = axis.coordinate;
        // The table of parameters is in ASCII, for terminals.
        let meaning = [("epsilon", "ε"), ("h1", "h₁"), ("ramp_rate", "δ"), ("tau^2", "τ²")]
            .iter()
            .fold(coordinate.meaning().to_owned(), |words, (name, symbol)| {
                words.replace(name, symbol)
            });
        let unit = Unit::suited(
            at.unit(coordinate),
            axis.ends().map(f64::abs).into_iter().fold(0.0, f64::max),
        );
        Self {
            words: format!("{meaning}, {}{}", coordinate.symbol(), unit.bracketed()),
            factor: unit.factor,
        }
    }

    /// Where a value of the axis lies on its [`AxisLabel::scale`].
    pub fn place(&self, axis: &Axis, value: f64) -> f64 {
        match axis.spacing() {
            Spacing::Even { .. } => self.factor * value,
            Spacing::Logarithmic { .. } => (self.factor * value).log10(),
            Spacing::Listed(_) => axis.place(value),
        }
    }

    /// The axis of a panel, between two of its places: places are as [`Axis::place`] has them.
    pub fn scale(&self, axis: &Axis, from: f64, to: f64) -> Scale {
        let [low, high] = axis.ends().map(|end| self.place(axis, end));
        let between = |place: f64| low + place * (high - low) / (axis.count() - 1) as f64;
        match axis.spacing() {
            Spacing::Even { .. } => Scale::new(&self.words, between(from), between(to)),
            Spacing::Logarithmic { .. } => Scale::logarithmic(&self.words, between(from), between(to)),
            Spacing::Listed(_) => Scale {
                listed: self.listed(axis),
                ..Scale::new(&self.words, from, to)
            },
        }
    }

    /// Ticks at the values of a list, by their places, rising.
    pub fn listed(&self, axis: &Axis) -> Vec<Tick> {
        let rising = axis.rising().into_iter().enumerate();
        rising
            .map(|(place, index)| Tick {
                value: place as f64,
                label: number(rounded(self.factor * axis.value(index))),
            })
            .collect()
    }
}

/// `symbol = value`, without a break within.
pub fn assignment(parameter: Parameter, value: f64) -> String {
    format!("{}\u{a0}=\u{a0}{}", parameter.info().symbol, number(rounded(value)))
}

/// As [`assignment`], with the unit of a machine's quantity.
pub fn assigned(at: &Fixed, coordinate: Coordinate, value: f64) -> String {
    match coordinate {
        Coordinate::Parameter(parameter) => assignment(parameter, value),
        Coordinate::Si(quantity) => {
            let unit = Unit::suited(at.unit(coordinate), value);
            let value = number(five_digits(unit.factor * value));
            let text = format!("{} = {value} {}", quantity.info().symbol, unit.name);
            text.trim_end().replace(' ', "\u{a0}")
        }
    }
}

fn fixed_parameters(map: &ParameterMap) -> String {
    let axes = map.experiment.design.axes().iter();
    let shown: Vec<Coordinate> = axes.map(|axis| axis.coordinate).collect();
    fixed(&map.experiment.design.fixed, &shown)
}

/// What a picture shows nowhere else, but in `shown`: parameters, or the machine's quantities and the parameters that it
/// gives. Those of heat and wear only where there is some.
pub fn fixed(at: &Fixed, shown: &[impl Into<Coordinate> + Copy]) -> String {
    let shown: Vec<Coordinate> = shown.iter().map(|&coordinate| coordinate.into()).collect();
    let parameters = fixed_list(at, &shown);
    let Some(machine) = at.machine() else {
        return format!("Fixed parameters: {parameters}. All quantities are dimensionless.");
    };
    let quantities = machine
        .quantities()
        .filter(|quantity| !shown.contains(&(*quantity).into()));
    let list: Vec<String> = quantities
        .map(|quantity| assigned(at, quantity.into(), machine.value(quantity)))
        .collect();
    let material = machine
        .material()
        .map_or_else(String::new, |material| format!(" of {}", material.title));
    let list = list.join(", ");
    format!("Machine with a shaft{material}: {list}. Dimensionless parameters: {parameters}.")
}

fn fixed_list(at: &Fixed, shown: &[Coordinate]) -> String {
    use Parameter::{Biot, Gamma, KW, OmegaTilde, RampRate};
    let all: Vec<(Parameter, f64)> = PARAMETERS
        .iter()
        .map(|info| info.parameter)
        .filter(|parameter| !shown.iter().any(|coordinate| at.moves(*coordinate, *parameter)))
        .map(|parameter| (parameter, at[parameter]))
        .collect();
    let is_rubbed = [Gamma, KW].iter().any(|rubbing| !all.contains(&(*rubbing, 0.0)));
    let fixed: Vec<String> = all
        .into_iter()
        .filter(|(parameter, _)| is_rubbed || ![Gamma, KW, Biot, OmegaTilde, RampRate].contains(parameter))
        // no ramp
        .filter(|(_, value)| value.is_finite())
        .map(|(parameter, value)| match at.governing(parameter) {
            // what follows has more digits than the values that it follows from
            Some(_) => assignment(parameter, five_digits(value)),
            None => assignment(parameter, value),
        })
        .collect();
    fixed.join(", ")
}

fn numerics(map: &ParameterMap) -> String {
    let settings = &map.experiment.settings;
    let (x, y) = (map.x_axis().count(), map.y_axis().count());
    let run = if map.experiment.wears() {
        // where nothing wears a transient comes before
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
    let mut text = format!("Map of {x} × {y} points. {}, {run}", scheme(settings));
    if settings.sampling.initial_states > 1 {
        text += &format!(
            ", {} initial states (seed {}) per point from x in {}, y in {}",
            settings.sampling.initial_states,
            settings.sampling.seed,
            range(settings.sampling.initial_box.x),
            range(settings.sampling.initial_box.y)
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

/// The stepping scheme, and how many steps it takes in a forcing period.
pub fn scheme(settings: &Settings) -> String {
    let scheme = match settings.integration.scheme {
        Scheme::Taylor => "Taylor series of order 8, steps ending at the friction layer’s boundaries",
        Scheme::Rk4 => "Runge–Kutta of order 4",
        Scheme::Radau => "Radau IIA of order 5, exact heat modes",
    };
    format!(
        "{scheme}, {} steps per forcing period",
        settings.integration.steps_per_period
    )
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

/// Where instances were integrated, and in which number type.
pub fn integrated_on(kinds: impl Iterator<Item = BackendKind>) -> String {
    let mut names: Vec<String> = kinds.filter_map(|kind| backend(kind.name())).collect();
    names.sort_unstable();
    names.dedup();
    format!("integrated on {}", names.join(" and "))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn devices_and_number_types_are_told_once() {
        use BackendKind::{CpuF64, GpuF32};
        assert_eq!(integrated_on([CpuF64, CpuF64].into_iter()), "integrated on CPU (f64)");
        assert_eq!(
            integrated_on([GpuF32, CpuF64, GpuF32].into_iter()),
            "integrated on CPU (f64) and GPU (f32)"
        );
    }

    #[test]
    fn rounding_errors_are_not_written() {
        assert_eq!(assignment(Parameter::X0, 0.1 + 0.2), "x₀\u{a0}=\u{a0}0.3");
    }
}
