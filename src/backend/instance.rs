//! What a backend advances in time: a system in a state.
//!
//! Owns the start of an instance; advances nothing.

use crate::parameters::ParameterSet;

/// The parameters of a point, and the state from which its motion goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// They include the initial state (x0, y0) of the point; the present state may be far from it.
    pub parameters: ParameterSet,
    /// (x, y), at drive phase 0.
    pub state: [f64; 2],
    /// The first tangent vector (X, Y), of length 1; the second one is perpendicular to it.
    pub tangent: [f64; 2],
}

/// The tangent vector of a run that does not continue another run: the paper's first one.
const FIRST_TANGENT: [f64; 2] = [1.0, 0.0];

impl Instance {
    /// The system in a state (x, y), with the tangent vector (1, 0).
    pub fn new(parameters: ParameterSet, state: [f64; 2]) -> Self {
        Self {
            parameters,
            state,
            tangent: FIRST_TANGENT,
        }
    }

    /// One instance for each point, at the beginning of its motion.
    pub fn starts(points: &[ParameterSet]) -> Vec<Self> {
        points.iter().copied().map(Self::from).collect()
    }

    /// Whether the tangent vector is (1, 0).
    pub fn has_first_tangent(&self) -> bool {
        self.tangent == FIRST_TANGENT
    }
}

impl From<ParameterSet> for Instance {
    /// The point at the beginning of its motion: at (x0, y0), with the tangent vector (1, 0).
    fn from(point: ParameterSet) -> Self {
        Self::new(point, point.initial_state())
    }
}
