//! The values that all points of a design have in common.
//!
//! Owns the agreement of the parameters with the machine from which they follow.

use std::ops::Index;

use super::Coordinate;
use crate::machine::{self, Machine, SiQuantity};
use crate::parameters::{Parameter, ParameterSet};

/// The values that all points of a design have in common, except for the coordinates that vary: a value for every parameter
/// and, if there is a machine, the machine from which most of them follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fixed {
    parameters: ParameterSet,
    machine: Option<Machine>,
}

impl From<ParameterSet> for Fixed {
    fn from(parameters: ParameterSet) -> Self {
        Self::new(parameters, None)
    }
}

impl Index<Parameter> for Fixed {
    type Output = f64;
    fn index(&self, parameter: Parameter) -> &f64 {
        &self.parameters[parameter]
    }
}

impl Fixed {
    /// A parameter that the machine determines replaces its value in `parameters`.
    pub fn new(parameters: ParameterSet, machine: Option<Machine>) -> Self {
        Self {
            parameters: machine.map_or(parameters, |machine| machine.parameters(&parameters)),
            machine,
        }
    }

    /// A value for every parameter; those that a machine determines follow from it.
    pub fn parameters(&self) -> &ParameterSet {
        &self.parameters
    }

    /// The machine; None if the parameters are set one by one.
    pub fn machine(&self) -> Option<&Machine> {
        self.machine.as_ref()
    }

    /// A copy with other values of some coordinates (not checked). Without a machine, a quantity of a machine changes nothing.
    #[must_use]
    pub fn at(&self, values: impl IntoIterator<Item = (Coordinate, f64)>) -> Self {
        let Self {
            mut parameters,
            mut machine,
        } = *self;
        for (coordinate, value) in values {
            match coordinate {
                Coordinate::Parameter(parameter) => parameters[parameter] = value,
                Coordinate::Si(quantity) => machine = machine.map(|machine| machine.with(quantity, value)),
            }
        }
        if machine == self.machine {
            return Self { parameters, machine };
        }
        Self::new(parameters, machine)
    }

    /// A copy with the initial state (x, y).
    #[must_use]
    pub fn from_state(&self, [x, y]: [f64; 2]) -> Self {
        self.at([(Parameter::X0.into(), x), (Parameter::Y0.into(), y)])
    }

    /// The quantity of the machine that governs a parameter; None where the parameter is free.
    pub fn governing(&self, parameter: Parameter) -> Option<SiQuantity> {
        self.machine.and_then(|_| machine::governing(parameter))
    }

    /// The unit of a coordinate's values; `1` for pure numbers.
    pub fn unit(&self, coordinate: Coordinate) -> &'static str {
        match (coordinate, &self.machine) {
            (Coordinate::Parameter(_), _) => "1",
            (Coordinate::Si(quantity), Some(machine)) => machine.unit(quantity),
            (Coordinate::Si(quantity), None) => quantity.info().unit,
        }
    }

    /// Whether a parameter changes if a coordinate changes.
    pub fn moves(&self, coordinate: Coordinate, parameter: Parameter) -> bool {
        match (coordinate, &self.machine) {
            (Coordinate::Parameter(own), _) => own == parameter,
            (Coordinate::Si(quantity), Some(machine)) => machine.moves(quantity, parameter),
            (Coordinate::Si(_), None) => false,
        }
    }
}
