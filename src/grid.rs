//! Axes and grids: point index to named parameter values, in f64.
//!
//! Owns the order of points (the first axis varies fastest); knows nothing of how points are computed.

use serde::{Deserialize, Serialize};

use crate::parameters::{Parameter, ParameterError, ParameterSet};

/// Evenly spaced values of one parameter, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    pub parameter: Parameter,
    pub start: f64,
    pub stop: f64,
    pub count: usize,
}

impl Axis {
    /// The most values an axis may have.
    pub const MAX_COUNT: usize = 1_000_000;

    /// # Errors
    /// If an end is out of the parameter's range, the ends are equal, or the count is below 2 or above
    /// [`Axis::MAX_COUNT`].
    pub fn new(parameter: Parameter, start: f64, stop: f64, count: usize) -> Result<Self, AxisError> {
        let axis = Self {
            parameter,
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
        let name = self.parameter.name();
        self.parameter.check(self.start)?;
        self.parameter.check(self.stop)?;
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
        let parameter = Parameter::from_name(name.trim())?;
        let fields: Vec<&str> = range.split(':').map(str::trim).collect();
        let [start, stop, count] = fields[..] else {
            return Err(malformed());
        };
        Self::new(
            parameter,
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
}

/// Points of a scan: fixed parameters, and axes of which the first varies fastest. Without axes, one point.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    pub axes: Vec<Axis>,
    pub fixed: ParameterSet,
}

impl Grid {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.axes.iter().map(|axis| axis.count).product()
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The parameters of point `index`.
    pub fn point(&self, mut index: usize) -> ParameterSet {
        let mut values = self.fixed;
        for axis in &self.axes {
            values[axis.parameter] = axis.value(index % axis.count);
            index /= axis.count;
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_axis_varies_fastest_and_the_ends_are_met() {
        let axes = vec![
            Axis::parse("zeta_k=0:12:4").unwrap(),
            Axis::parse("h1=2:0.1:3").unwrap(),
        ];
        let grid = Grid {
            axes,
            fixed: ParameterSet::default(),
        };
        assert_eq!(grid.len(), 12);
        assert_eq!(
            (grid.point(3)[Parameter::ZetaK], grid.point(3)[Parameter::H1]),
            (12.0, 2.0)
        );
        assert_eq!(
            (grid.point(8)[Parameter::ZetaK], grid.point(11)[Parameter::H1]),
            (0.0, 0.1)
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
        ] {
            let message = Axis::parse(text).unwrap_err().to_string();
            assert!(message.contains(reason), "{text}: {message}");
        }
    }
}
