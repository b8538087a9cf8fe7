//! The texts that captions of all computations share: parameters, scheme and device.
//!
//! Owns the wording; breaks no lines.

use super::ticks::number;
use crate::backend::BackendKind;
use crate::design::{Coordinate, Fixed};
use crate::experiment::{Scheme, Settings};
use crate::machine::units::{Unit, five_digits, rounded};
use crate::parameters::{PARAMETERS, Parameter};

/// `symbol = value` with non-breaking spaces.
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

/// The initial state for captions, to five digits; the experiment in the picture's file has all digits.
pub fn start(state: [f64; 2]) -> String {
    let [x, y] = state.map(|value| number(five_digits(value)));
    format!("({x}, {y})")
}

/// The fixed values in words, without those in `shown`, which the picture shows elsewhere: the parameters, or the machine's
/// quantities and the parameters that it gives. Parameters of heat and wear appear only if there is heat or wear.
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
    let has_heat_or_wear = [Gamma, KW].iter().any(|rubbing| !all.contains(&(*rubbing, 0.0)));
    let fixed: Vec<String> = all
        .into_iter()
        .filter(|(parameter, _)| has_heat_or_wear || ![Gamma, KW, Biot, OmegaTilde, RampRate].contains(parameter))
        // an infinite rate means that there is no ramp
        .filter(|(_, value)| value.is_finite())
        .map(|(parameter, value)| match at.governing(parameter) {
            // a derived value has more digits than the values from which it follows
            Some(_) => assignment(parameter, five_digits(value)),
            None => assignment(parameter, value),
        })
        .collect();
    fixed.join(", ")
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

    #[test]
    fn initial_states_have_the_digits_that_people_read() {
        assert_eq!(start([0.30000000000000004, -1.0]), "(0.3, \u{2212}1)");
        assert_eq!(start([0.374_540_118_847_362_5, 0.0]), "(0.37454, 0)");
    }
}
