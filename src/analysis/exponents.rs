//! Lyapunov exponents over one parameter.
//!
//! Owns the line of points and its initial states; what is measured of a point is [`crate::sweep`]'s.

use crate::backend::BackendError;
use crate::experiment::Settings;
use crate::grid::{Axis, Fixed, Grid};
use crate::measure::Measurement;
use crate::parameters::{Parameter, ParameterSet};
use crate::sweep::{Backends, Observer};

/// Measurements over an axis from one initial state.
#[derive(Clone, Debug)]
pub struct Line {
    pub axis: Axis,
    /// All else.
    pub fixed: Fixed,
    /// Initial state (x, y).
    pub start: [f64; 2],
    /// In the order of the axis.
    pub measurements: Vec<Measurement>,
}

/// Measures the points of `axis` from each of the initial states, all else being that of `at`; None if the
/// observer broke it off.
///
/// # Errors
/// If the backend fails and no fall-back is left.
pub fn lines(
    backends: &mut Backends,
    settings: &Settings,
    at: &Fixed,
    axis: &Axis,
    starts: &[[f64; 2]],
    observer: &mut Observer<'_>,
) -> Result<Option<Vec<Line>>, BackendError> {
    let mut lines = Vec::with_capacity(starts.len());
    for &start in starts {
        let grid = Grid {
            axes: vec![*axis],
            fixed: at.from_state(start),
        };
        let indices: Vec<usize> = (0..axis.count).collect();
        let Some(measurements) = backends.measure(&grid, settings, &indices, observer)? else {
            return Ok(None);
        };
        lines.push(Line {
            axis: *axis,
            fixed: grid.fixed,
            start,
            measurements,
        });
    }
    Ok(Some(lines))
}

/// The point, started from (x, y).
pub fn from(at: &ParameterSet, [x, y]: [f64; 2]) -> ParameterSet {
    at.with(Parameter::X0, x).with(Parameter::Y0, y)
}
