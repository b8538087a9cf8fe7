//! What a backend carries on: a system in a state.
//!
//! Owns where an instance begins; carries nothing on.

use crate::parameters::ParameterSet;

/// The system at a point, and the motion from which it is carried on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// With the initial state of the point, from which the motion may have come a long way.
    pub parameters: ParameterSet,
    /// (x, y), at drive phase 0.
    pub state: [f64; 2],
    /// The first tangent vector (X, Y), of length 1; the second one stands across.
    pub tangent: [f64; 2],
}

/// The tangent vector of a run that goes on from no other: the paper's first one.
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

    /// Points at the beginnings of their motion.
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
