//! What can be set and varied: a dimensionless parameter or a quantity of a machine.
//!
//! Owns the conversion from names; the ranges are in the tables of parameters and of quantities.

use std::fmt;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{AxisError, DesignError};
use crate::machine::{self, SI_QUANTITIES, SiQuantity};
use crate::parameters::{self, PARAMETERS, Parameter, ParameterError};

/// A dimensionless parameter, or a quantity of a machine in SI units. Either can be set or be an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Coordinate {
    /// Dimensionless.
    Parameter(Parameter),
    /// In the unit that [`Fixed::unit`](super::Fixed::unit) gives; only if there is a machine.
    Si(SiQuantity),
}

impl From<Parameter> for Coordinate {
    fn from(parameter: Parameter) -> Self {
        Self::Parameter(parameter)
    }
}

impl From<SiQuantity> for Coordinate {
    fn from(quantity: SiQuantity) -> Self {
        Self::Si(quantity)
    }
}

impl TryFrom<&str> for Coordinate {
    type Error = ParameterError;
    fn try_from(name: &str) -> Result<Self, ParameterError> {
        Self::from_name(name)
    }
}

impl Coordinate {
    /// The name used in commands, files and data.
    pub fn name(self) -> &'static str {
        match self {
            Self::Parameter(parameter) => parameter.name(),
            Self::Si(quantity) => quantity.name(),
        }
    }

    /// The symbol used in pictures.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Parameter(parameter) => parameter.info().symbol,
            Self::Si(quantity) => quantity.info().symbol,
        }
    }

    /// Its meaning in a few words, from its table.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Parameter(parameter) => parameter.info().meaning,
            Self::Si(quantity) => quantity.info().meaning,
        }
    }

    /// Finds a parameter or a quantity by its name.
    ///
    /// # Errors
    /// [`ParameterError::Unknown`] with the nearest known name, if one is near.
    pub fn from_name(name: &str) -> Result<Self, ParameterError> {
        if let Some(quantity) = SiQuantity::from_name(name) {
            return Ok(Self::Si(quantity));
        }
        if let Ok(parameter) = Parameter::from_name(name) {
            return Ok(Self::Parameter(parameter));
        }
        let quantities = SI_QUANTITIES.iter().map(|info| info.name);
        Err(ParameterError::Unknown {
            name: name.to_owned(),
            suggestion: parameters::nearest(name, PARAMETERS.iter().map(|info| info.name).chain(quantities)),
        })
    }

    /// Checks that the coordinate can be set or be an axis, with a machine (`has_machine`) or without one.
    ///
    /// # Errors
    /// [`DesignError::Determined`] or [`DesignError::NoMachine`].
    pub fn check_free(self, has_machine: bool) -> Result<(), DesignError> {
        match self {
            Self::Parameter(parameter) => match machine::governing(parameter) {
                Some(governing) if has_machine => Err(DesignError::Determined { parameter, governing }),
                _ => Ok(()),
            },
            Self::Si(_) if has_machine => Ok(()),
            Self::Si(quantity) => Err(DesignError::NoMachine { name: quantity.name() }),
        }
    }

    /// Checks that it may take `value`.
    ///
    /// # Errors
    /// If the value is out of range, or not a number.
    pub fn check(self, value: f64) -> Result<(), AxisError> {
        match self {
            Self::Parameter(parameter) => Ok(parameter.check(value)?),
            Self::Si(quantity) => Ok(machine::check_range(quantity, value, quantity.info().unit)?),
        }
    }
}

impl fmt::Display for Coordinate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Serialize for Coordinate {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for Coordinate {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        Self::from_name(&name).map_err(serde::de::Error::custom)
    }
}
