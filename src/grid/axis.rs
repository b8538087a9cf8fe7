//! Axes: evenly spaced values, and how they are typed.

use serde::{Deserialize, Serialize};

use super::Coordinate;
use crate::machine::MachineError;
use crate::parameters::ParameterError;

/// Evenly spaced values of one coordinate, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    #[serde(rename = "parameter")]
    pub coordinate: Coordinate,
    pub start: f64,
    pub stop: f64,
    pub count: usize,
}

impl Axis {
    /// The most values an axis may have.
    pub const MAX_COUNT: usize = 1_000_000;

    /// # Errors
    /// If an end is out of the coordinate's range, the ends are equal, or the count is below 2 or above
    /// [`Axis::MAX_COUNT`].
    pub fn new(coordinate: impl Into<Coordinate>, start: f64, stop: f64, count: usize) -> Result<Self, AxisError> {
        let axis = Self {
            coordinate: coordinate.into(),
            start,
            stop,
            count,
        };
        axis.check()?;
        Ok(axis)
    }

    /// Checks what [`Axis::new`] checks, for axes that were read from a file.
    ///
    /// # Errors
    /// As [`Axis::new`].
    pub fn check(&self) -> Result<(), AxisError> {
        let name = self.coordinate.name();
        self.coordinate.check(self.start)?;
        self.coordinate.check(self.stop)?;
        if !(self.start.is_finite() && self.stop.is_finite()) {
            return Err(AxisError::Infinite { name });
        }
        if self.start == self.stop {
            return Err(AxisError::Empty {
                name,
                value: self.start,
            });
        }
        if self.count < 2 || self.count > Self::MAX_COUNT {
            return Err(AxisError::Count {
                name,
                count: self.count,
            });
        }
        Ok(())
    }

    /// The axis as it is typed: `NAME=START:STOP:COUNT`.
    ///
    /// # Errors
    /// If the text has another form, or as [`Axis::new`].
    pub fn parse(text: &str) -> Result<Self, AxisError> {
        let malformed = || AxisError::Malformed { text: text.to_owned() };
        let (name, range) = text.split_once('=').ok_or_else(malformed)?;
        let coordinate = Coordinate::from_name(name.trim())?;
        let fields: Vec<&str> = range.split(':').map(str::trim).collect();
        let [start, stop, count] = fields[..] else {
            return Err(malformed());
        };
        Self::new(
            coordinate,
            start.parse().map_err(|_| malformed())?,
            stop.parse().map_err(|_| malformed())?,
            count.parse().map_err(|_| malformed())?,
        )
    }

    /// The value at `index` in `0..count`; the ends are met exactly.
    pub fn value(&self, index: usize) -> f64 {
        let t = index as f64 / (self.count - 1) as f64;
        self.start * (1.0 - t) + self.stop * t
    }

    pub fn values(&self) -> Vec<f64> {
        (0..self.count).map(|index| self.value(index)).collect()
    }

    /// The distance between neighbouring values, negative on a falling axis.
    pub fn step(&self) -> f64 {
        (self.stop - self.start) / (self.count - 1) as f64
    }
}

#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AxisError {
    #[error("`{text}` is no axis: write NAME=START:STOP:COUNT, for example zeta_k=0:12:300")]
    Malformed { text: String },
    #[error("the axis of {name} starts and stops at {value}: give it two different ends")]
    Empty { name: &'static str, value: f64 },
    #[error("the axis of {name} runs to infinity: give it two finite ends")]
    Infinite { name: &'static str },
    #[error("the axis of {name} has {count} values: it needs 2 to {max}", max = Axis::MAX_COUNT)]
    Count { name: &'static str, count: usize },
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    #[error(transparent)]
    Machine(#[from] MachineError),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_axes_are_refused_with_a_reason() {
        for (text, reason) in [
            ("zeta_k", "NAME=START:STOP:COUNT"),
            ("zeta_k=0:1", "NAME=START:STOP:COUNT"),
            ("zeta_k=0:1:x", "NAME=START:STOP:COUNT"),
            ("zeta_k=0:1:-3", "NAME=START:STOP:COUNT"),
            ("zeta_k=1:1:5", "two different ends"),
            ("zeta_k=0:1:1", "needs 2"),
            ("zeta_k=0:NaN:5", "out of range"),
            ("zeta_k=0:inf:5", "out of range"),
            ("epsilon_0=0:1:5", "out of range"),
            ("zetta_k=0:1:5", "did you mean"),
            ("intereference=0:1:5", "did you mean `interference`"),
            (
                "interference=-1e-9:1e-9:5",
                "interference = -0.000000001 m is out of range",
            ),
        ] {
            let message = Axis::parse(text).unwrap_err().to_string();
            assert!(message.contains(reason), "{text}: {message}");
        }
    }
}
