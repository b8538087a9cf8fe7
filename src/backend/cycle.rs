//! An attracting cycle, from some turns of an orbit along it.
//!
//! Owns what makes a cycle certain, and its measurement; carries nothing on.

use super::EndState;
use super::evaluation::{checked, is_resolved};
use crate::dynamics::floquet::{Multipliers, Turn};
use crate::measurement::{BackendKind, Class, Contact, Measurement, Status};

/// Turns that are watched: two for the multipliers, one more for how sure they are.
pub(super) const TURNS: u32 = 3;

/// An orbit is on a cycle once it is this near, by what the multipliers make of its last turns. They are then good to about
/// as much.
const NEAR: f64 = 1e-5;

/// An attracting cycle that an orbit is on.
pub(super) struct AttractingCycle {
    /// In forcing periods.
    period: u32,
    /// Length of a turn in tau.
    turn_time: f64,
    exponents: [f64; 2],
    /// By how much further turns may change the exponents.
    errors: [f64; 2],
}

impl AttractingCycle {
    /// The cycle of `period` forcing periods along which an orbit has made [`TURNS`] turns of `turn_time`, the last of which
    /// moved it by `moved`; None where the orbit is too far from it, or it does not surely attract.
    pub fn new(period: u32, turn_time: f64, moved: f64, turns: &[Turn]) -> Option<Self> {
        let [before, last] = [0, 1].map(|i| Multipliers::new(&turns[i], &turns[i + 1]));
        let exponents = last.log_moduli().map(|log| log / turn_time);
        // an orbit's approach, and what it still changes, shrink by the multiplier in every turn
        let approach = -(exponents[0] * turn_time).exp_m1();
        let errors = [0, 1].map(|i| (before.log_moduli()[i] / turn_time - exponents[i]).abs() / approach);
        let is_near = moved / last.distance_from_one() < NEAR;
        let attracts = exponents[0] < 0.0 && exponents[0] + 3.0 * errors[0] < 0.0;
        (is_near && attracts).then_some(Self {
            period,
            turn_time,
            exponents,
            errors,
        })
    }

    /// The measurement of the orbit, which has ended as given; `divergence` is its integral over the turns.
    pub fn measurement(&self, divergence: f64, end: &EndState, backend: BackendKind) -> Measurement {
        let measurement = Measurement {
            class: Some(Class::Regular),
            lyapunov: self.exponents[0],
            lyapunov_error: self.errors[0],
            lyapunov_second: self.exponents[1],
            lyapunov_second_error: self.errors[1],
            divergence: divergence / (f64::from(TURNS) * self.turn_time),
            lyapunov_birkhoff: self.exponents[0],
            lyapunov_interval: self.turn_time,
            period: Some(self.period),
            x: end.x,
            y: end.y,
            x_min: end.x_min,
            x_max: end.x_max,
            contact: Contact::CONSTANT,
            attractors: 1,
            ..Measurement::unmeasured(Status::Ok, backend)
        };
        let resolved = is_resolved(&measurement);
        checked(measurement, resolved)
    }
}
