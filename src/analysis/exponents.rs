//! Lyapunov exponents over one parameter.
//!
//! Owns the line of points and its initial states; what is measured of a point is [`crate::engine`]'s.

use crate::backend::BackendError;
use crate::design::{Axis, Design, Fixed};
use crate::engine::{Backends, Observer};
use crate::experiment::Settings;
use crate::measure::Measurement;

/// Measurements over an axis from one initial state.
#[derive(Clone, Debug)]
pub struct Line {
    /// The axis; there is one measurement for each of its values.
    pub axis: Axis,
    /// The values of everything that is not on the axis.
    pub fixed: Fixed,
    /// Initial state (x, y).
    pub start: [f64; 2],
    /// In the order of the axis.
    pub measurements: Vec<Measurement>,
}

/// Measures the points of `axis` from each of the initial states; `at` gives everything else. None if the observer broke it off.
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
        let design = Design::product(vec![axis.clone()], at.from_state(start));
        let indices: Vec<usize> = (0..axis.count()).collect();
        let Some(measurements) = backends.measure(&design, settings, &indices, observer)? else {
            return Ok(None);
        };
        lines.push(Line {
            axis: axis.clone(),
            fixed: design.fixed,
            start,
            measurements,
        });
    }
    Ok(Some(lines))
}
