//! The kinds of motion.
//!
//! Owns their definition, and the bounds that it rests on.

use serde::{Deserialize, Serialize};

/// The kind of motion; [`Class::of`] defines it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Class {
    /// Neighbouring orbits part exponentially.
    Chaotic,
    /// Settles on a cycle, or comes to rest.
    Regular,
    /// Stays on a torus: neighbouring orbits neither part nor meet.
    QuasiPeriodic,
    /// The error of the exponent is too large to decide which of these it is.
    Undecided,
    /// Stays on a cycle, or at rest, although disturbances grow: no attractor.
    Unstable,
}

/// The weighted Birkhoff average of a quasi-periodic orbit's exponent lies within this of zero...
pub const QUASI_PERIODIC_BOUND: f64 = 1e-3;

/// ...and its standard error below this. The growth along such an orbit only oscillates, so that its mean converges fast. If the
/// mean does not converge, an average near zero is a coincidence.
pub const QUASI_PERIODIC_ERROR: f64 = 5e-3;

/// A standard error below this means the same growth in every period: the orbit is on its cycle. If the growth is positive, the
/// orbit began on an unstable cycle and never left it. This is neither chaos nor an attractor.
pub const CONSTANT_GROWTH: f64 = 1e-6;

/// Over the measurement of a chaotic orbit, a disturbance grows at least by e to this power. Less growth, however steady, cannot
/// be distinguished from the slow convergence of an orbit at a bifurcation.
pub const CHAOTIC_GROWTH: f64 = 1.0;

/// The cycle on which an orbit was found at the end of its run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cycle {
    /// In forcing periods.
    pub period: u32,
    /// Growth rate of the tangent vector along the cycle: negative if it attracts.
    pub growth_rate: f64,
}

impl Class {
    /// In the order of their codes in stores.
    pub const ALL: [Self; 5] = [
        Self::Chaotic,
        Self::Regular,
        Self::QuasiPeriodic,
        Self::Undecided,
        Self::Unstable,
    ];

    /// Classifies an orbit by its maximal exponent `lyapunov` with standard error `error`, taken over `interval`, the cycle
    /// found at its end, and the weighted Birkhoff average of the exponent. In this order:
    ///
    /// - regular: settled on a cycle that attracts (a chaotic transient may have come before);
    /// - unstable: on a cycle along which disturbances grow, at the same rate in every period;
    /// - chaotic: `lyapunov - 3 error > 0`, and `lyapunov interval >` [`CHAOTIC_GROWTH`];
    /// - regular: `lyapunov + 3 error < 0`, or on a cycle with `lyapunov` not above 0;
    /// - quasi-periodic: `|birkhoff| <` [`QUASI_PERIODIC_BOUND`] and `error <` [`QUASI_PERIODIC_ERROR`];
    /// - undecided: all else.
    pub fn of(lyapunov: f64, error: f64, interval: f64, cycle: Option<Cycle>, birkhoff: f64) -> Self {
        // a laminar phase of chaos can look like a cycle, but it does not attract
        let is_constant = error < CONSTANT_GROWTH;
        if cycle.is_some_and(|cycle| cycle.growth_rate < 0.0) {
            Self::Regular
        } else if cycle.is_some_and(|cycle| is_constant && cycle.growth_rate > QUASI_PERIODIC_BOUND) {
            Self::Unstable
        } else if lyapunov - 3.0 * error > 0.0 && lyapunov * interval > CHAOTIC_GROWTH {
            Self::Chaotic
        } else if lyapunov + 3.0 * error < 0.0 || (cycle.is_some() && lyapunov <= 0.0) {
            Self::Regular
        } else if cycle.is_none() && birkhoff.abs() < QUASI_PERIODIC_BOUND && error < QUASI_PERIODIC_ERROR {
            Self::QuasiPeriodic
        } else {
            Self::Undecided
        }
    }

    /// In the order of [`Class::ALL`].
    pub const NAMES: &[&str] = &["chaotic", "regular", "quasi_periodic", "undecided", "unstable"];

    /// The name in files and commands.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_in_files() {
        for class in Class::ALL {
            assert_eq!(serde_json::to_value(class).unwrap(), class.name());
        }
    }

    #[test]
    fn classes_follow_their_definition() {
        let cycle = |growth_rate| Some(Cycle { period: 3, growth_rate });
        assert_eq!(Class::of(0.1, 0.01, 800.0, None, 0.1), Class::Chaotic);
        assert_eq!(
            Class::of(0.1, 0.01, 800.0, cycle(0.02), 0.1),
            Class::Chaotic,
            "laminar phase"
        );
        assert_eq!(
            Class::of(0.1, 0.01, 800.0, cycle(-0.2), 0.1),
            Class::Regular,
            "after a chaotic transient"
        );
        assert_eq!(
            Class::of(1.0, 0.0, 800.0, cycle(1.0), 1.0),
            Class::Unstable,
            "equilibrium that is never left"
        );
        assert_eq!(Class::of(-0.1, 0.01, 800.0, None, -0.1), Class::Regular);
        assert_eq!(Class::of(-0.001, 0.01, 800.0, cycle(0.001), -0.001), Class::Regular);
        assert_eq!(Class::of(1e-4, 1e-3, 800.0, None, 9e-4), Class::QuasiPeriodic);
        assert_eq!(
            Class::of(1e-4, 1e-2, 800.0, None, 9e-4),
            Class::Undecided,
            "an average near zero by chance"
        );
        assert_eq!(Class::of(0.01, 0.01, 800.0, None, 0.01), Class::Undecided);
        assert_eq!(
            Class::of(5e-4, 1e-5, 800.0, cycle(5e-4), 5e-4),
            Class::Undecided,
            "no regular motion has a positive exponent"
        );
    }
}
