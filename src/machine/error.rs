//! What can be wrong with a machine.

use super::SiQuantity;
use super::materials::MATERIALS;
use crate::parameters::ParameterError;

/// Why a description is not a machine.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages tell what each is")]
pub enum MachineError {
    #[error(
        "the machine lacks {}; `tribochaos machine --template` prints a complete file{}",
        missing.iter().map(|quantity| named(*quantity)).collect::<Vec<_>>().join(", "),
        if missing.iter().any(|quantity| super::CONSTANTS.contains(quantity)) {
            ", and a `material` gives its constants"
        } else {
            ""
        }
    )]
    Missing { missing: Vec<SiQuantity> },
    #[error("there is no material `{name}`: there are {}; or give its constants", known())]
    Material { name: String },
    #[error(
        "unknown quantity `{name}`{}; `tribochaos machine --template` prints all of them",
        suggestion.map(|near| format!(": did you mean `{near}`?")).unwrap_or_default()
    )]
    Unknown {
        name: String,
        suggestion: Option<&'static str>,
    },
    #[error(
        "{name} = {value}{0} is out of range: it must be a number from {min} to {max}{0}",
        spaced(unit)
    )]
    Range {
        name: &'static str,
        value: f64,
        unit: &'static str,
        min: f64,
        max: f64,
    },
    #[error(
        "k* = {k_star:.4e} N/m² is not positive: the radial springs are not compressed enough for two wells; with \
         spring_length = {l1} m, spring_free_length = {l0} m must be above {least:.6} m, by {:.2e} m more than it is (or \
         make tangent_stiffness less)",
        least - l0
    )]
    Spring {
        /// In N/m^2.
        k_star: f64,
        /// Lengths of the springs in m: `l0` without load, `l1` at angle 0, and `least`, which `l0` must exceed.
        l0: f64,
        l1: f64,
        least: f64,
    },
    #[error(
        "{} = {} m must be below {} = {} m: the bush lies around the shaft, which is wider than its hole by the interference",
        names[0], values[0], names[1], values[1]
    )]
    Radii {
        names: [&'static str; 2],
        /// In m.
        values: [f64; 2],
    },
    #[error("{error}; it follows from the machine: change {governing} ({})", governing.info().meaning)]
    Group {
        error: ParameterError,
        governing: SiQuantity,
    },
    #[error("{0} belongs to whole parts: without it values are per metre of contact length, so give it in the file")]
    NoLength(SiQuantity),
    #[error("no machine in TOML: {0}")]
    Toml(#[from] toml::de::Error),
}

/// The unit after a value; nothing for pure numbers.
fn spaced(unit: &str) -> String {
    if unit == "1" { String::new() } else { format!(" {unit}") }
}

fn named(quantity: SiQuantity) -> String {
    let info = quantity.info();
    let unit = if info.unit == "1" { "a number" } else { info.unit };
    format!("{} ({}, {unit})", info.name, info.meaning)
}

fn known() -> String {
    MATERIALS
        .iter()
        .map(|material| material.name)
        .collect::<Vec<_>>()
        .join(", ")
}
