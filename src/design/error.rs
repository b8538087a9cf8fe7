//! Why something is no axis, or no design.

use std::convert::Infallible;

use crate::machine::{MachineError, SiQuantity};
use crate::parameters::{Parameter, ParameterError};

/// The most values of an axis.
pub const MOST_VALUES: usize = 1_000_000;

/// The most points over quantities of a machine, each of which is checked beforehand.
pub const MOST_MACHINES: usize = 200_000_000;

/// Why an axis is not valid.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages tell what each is")]
pub enum AxisError {
    #[error(
        "`{text}` is no axis: write NAME=START:STOP:COUNT, NAME=log:START:STOP:COUNT or NAME=V1,V2,..., for example zeta_k=0:12:300"
    )]
    Malformed { text: String },
    #[error("the axis of {name} needs start, stop and count, or values")]
    Incomplete { name: &'static str },
    #[error("the axis of {name} starts and stops at {value}: give it two different ends")]
    Empty { name: &'static str, value: f64 },
    #[error("the axis of {name} runs to infinity: give it finite values")]
    Infinite { name: &'static str },
    #[error("the axis of {name} has {count} values: it needs 2 to {max}", max = MOST_VALUES)]
    Count { name: &'static str, count: usize },
    #[error("the axis of {name} is logarithmic and has an end at {value}: both ends must be above 0")]
    NotPositive { name: &'static str, value: f64 },
    #[error("the axis of {name} has the value {value} twice: leave one out")]
    Twice { name: &'static str, value: f64 },
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    #[error(transparent)]
    Machine(#[from] MachineError),
}

impl From<Infallible> for AxisError {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}

/// Why a design is not valid.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages tell what each is")]
pub enum DesignError {
    #[error(
        "{parameter} follows from the machine: set {governing} ({}) instead, or make that an axis",
        governing.info().meaning
    )]
    Determined {
        parameter: Parameter,
        governing: SiQuantity,
    },
    #[error("{name} is a quantity of a machine, and there is none: give one by --machine, or in the table `machine`")]
    NoMachine { name: &'static str },
    #[error("{}{error}", if place.is_empty() { String::new() } else { format!("at {place}: ") })]
    Machine { place: String, error: MachineError },
    #[error("{count} points over quantities of a machine are too many (at most {max}): use fewer", max = MOST_MACHINES)]
    TooMany { count: usize },
}
