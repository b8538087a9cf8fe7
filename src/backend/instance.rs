//! What a backend advances in time: a system in a state.
//!
//! Owns the start of an instance; advances nothing.

use nalgebra::DMatrix;

use super::{Contact, EndState};
use crate::parameters::ParameterSet;

/// The parameters of a point, and the state from which its motion goes on.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// They include the initial state (x0, y0) of the point; the present state may be far from it.
    pub parameters: ParameterSet,
    /// (x, y), at drive phase 0.
    pub state: [f64; 2],
    /// The first tangent vector (X, Y), of length 1; the second one is perpendicular to it.
    pub tangent: [f64; 2],
    /// The rest of the state of a motion with heat that goes on. None at the beginning of a motion and at constant contact pressure.
    pub heated: Option<Box<HeatedState>>,
}

/// What the state of a motion with heat and without wear has besides (x, y), and what the motion has shown so far.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatedState {
    /// The pressure that each heat mode causes, 2 gamma c_m q_m; that of the lumped mode last.
    pub pressures: Vec<f64>,
    /// Tangent vectors, one in each column. Their components are X, Y, and the perturbations of the pressures.
    pub vectors: DMatrix<f64>,
    /// Forcing periods since the start of the motion.
    pub periods: f64,
    /// Whether bush and shaft touch.
    pub is_in_contact: bool,
    /// The contact since the start of the motion.
    pub contact: Contact,
    /// Length of the next step of the scheme, as a part of the period.
    pub step: f64,
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
            heated: None,
        }
    }

    /// One instance for each point, at the beginning of its motion.
    pub fn starts(points: &[ParameterSet]) -> Vec<Self> {
        points.iter().copied().map(Self::from).collect()
    }

    /// The instance in the state in which a run has ended, from which it goes on.
    #[must_use]
    pub fn at(&self, end: &EndState) -> Self {
        Self {
            parameters: self.parameters,
            state: [end.x, end.y],
            tangent: if self.parameters.has_heat_or_wear() {
                self.tangent
            } else {
                end.tangent
            },
            heated: end.heated.clone(),
        }
    }

    /// Number of its tangent vectors in the full state:
    ///
    /// - all that were given, where a motion goes on with heat;
    /// - two where such a motion begins;
    /// - one with wear, where the growth is that of (X, Y);
    /// - one at constant pressure, where the divergence tells how another one grows.
    pub fn vectors(&self) -> usize {
        match &self.heated {
            Some(heated) => heated.vectors.ncols(),
            None => 1 + usize::from(self.parameters.is_heated()),
        }
    }

    /// Component `n` of the tangent vector `vector` in the full state.
    pub fn component(&self, vector: usize, n: usize) -> f64 {
        let given = self.heated.as_ref().and_then(|heated| heated.vectors.get((n, vector)));
        match given {
            Some(&component) => component,
            None if vector == 0 && n < 2 => self.tangent[n],
            None => f64::from(u8::from(vector == n)),
        }
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
