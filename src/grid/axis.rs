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

    /// The value at `index` in `0..count`; the ends are met exactly. A value that is a short decimal is the number that typing
    /// it gives, bit for bit, so that it is found by its value.
    pub fn value(&self, index: usize) -> f64 {
        if index == 0 || index + 1 == self.count {
            return if index == 0 { self.start } else { self.stop };
        }
        let t = index as f64 / (self.count - 1) as f64;
        let value = self.start * (1.0 - t) + self.stop * t;
        let scale = self.start.abs().max(self.stop.abs());
        if !scale.is_normal() {
            return value;
        }
        let decimals = (DIGITS - 1.0 - scale.log10().floor()).max(0.0) as usize;
        let decimal: f64 = format!("{value:.decimals$}").parse().expect("it was a number");
        // by adding up, rounding to a few spacings of the larger end
        if (decimal - value).abs() <= 4.0 * f64::EPSILON * scale {
            decimal
        } else {
            value
        }
    }

    pub fn values(&self) -> Vec<f64> {
        (0..self.count).map(|index| self.value(index)).collect()
    }

    /// The distance between neighbouring values, negative on a falling axis.
    pub fn step(&self) -> f64 {
        (self.stop - self.start) / (self.count - 1) as f64
    }
}

/// Digits of a short decimal, counted from the first of an axis's larger end.
const DIGITS: f64 = 13.0;

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
    fn every_value_that_is_a_short_decimal_is_what_typing_it_gives() {
        // start, stop, count, and the values as whole multiples of a power of ten
        for (text, first, step, decimals) in [
            ("h1=0:1.5:301", 0, 5, 3),
            ("zeta_k=0:12:2401", 0, 5, 3),
            ("x0=-1:1:201", -100, 1, 2),
            ("h1=0.1:0.7:7", 1, 1, 1),
            ("zeta_k=5:3:201", 500, -1, 2),
            ("gamma=0:0.06:121", 0, 5, 4),
            ("zeta_k=3.5:4:5001", 35_000, 1, 4),
            ("epsilon_0=1e-9:1e-6:1000", 1, 1, 9),
            ("omega_tilde=100:1000:181", 100, 5, 0),
        ] {
            let axis = Axis::parse(text).unwrap();
            for (index, value) in axis.values().into_iter().enumerate() {
                let whole: i64 = first + step * index as i64;
                let typed: f64 = format!("{whole}e-{decimals}").parse().unwrap();
                assert_eq!(value.to_bits(), (typed + 0.0).to_bits(), "{text}: {typed} at {index}");
            }
        }
    }

    #[test]
    fn other_values_are_left_as_they_are_and_ends_are_met() {
        let axis = Axis::parse("zeta_k=3:5:600").unwrap();
        for (index, value) in axis.values().into_iter().enumerate() {
            assert!((value - (3.0 + 2.0 * index as f64 / 599.0)).abs() <= 5e-15, "{index}");
        }
        let axis = Axis::parse("h1=0.12345678901234567:1.0000000000000002:7").unwrap();
        assert_eq!(
            (axis.value(0), axis.value(6)),
            (0.123_456_789_012_345_67, 1.000_000_000_000_000_2)
        );
    }

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
