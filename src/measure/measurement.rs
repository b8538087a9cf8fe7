//! What is measured of one point, and how its integration ended.
//!
//! Owns the meaning of these numbers; knows nothing of how they come about.

use super::Class;
use crate::backend::{BackendKind, Contact};

/// How the integration of an instance ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Status {
    /// Integrated to the end, or until the motion had shown what it is.
    Ok,
    /// The state was no longer finite, or left |x| + |y| < [`RUNAWAY_BOUND`](crate::model::motion::RUNAWAY_BOUND), or the thermal
    /// pressure reached [`PRESSURE_BOUND`](crate::dynamics::adaptive::PRESSURE_BOUND).
    Runaway {
        /// When, in units of tau from the start of the run.
        time: f64,
    },
    /// The sum of the exponents misses the mean divergence by more than [`DEFECT_BOUND`], a number overflowed, or the
    /// scheme gave up: the step, or the interval between renormalisations, is too long for the stiffness met.
    UnderResolved,
}

/// Largest difference between the sum of the exponents and the mean divergence, relative to the divergence...
pub const DEFECT_BOUND: f64 = 1e-2;

/// ...or, where the divergence is almost zero, per unit of tau: rounding in f32 causes as much.
pub const DEFECT_FLOOR: f64 = 1e-3;

/// A scheme's share in an error is not reported if it is below this, per unit of tau.
const SCHEME_FLOOR: f64 = 1e-3;

/// Whether most of an exponent's error is the scheme's, and more than `SCHEME_FLOOR`.
pub fn is_scheme_to_blame(scheme_error: f64, error: f64) -> bool {
    scheme_error > SCHEME_FLOOR.max(0.5 * error)
}

impl Status {
    /// In the order of [`Status::code`].
    pub const NAMES: &[&str] = &["ok", "runaway", "under_resolved"];

    /// The name in files and commands.
    pub fn name(self) -> &'static str {
        Self::NAMES[self.code() as usize]
    }

    /// The code in stores.
    pub fn code(self) -> u8 {
        match self {
            Self::Ok => 0,
            Self::Runaway { .. } => 1,
            Self::UnderResolved => 2,
        }
    }
}

/// What is measured of one point. Numbers are NaN where they do not apply: if the orbit ran away; and, except for those of the
/// contact, if it is under-resolved.
#[derive(Clone, Copy, Debug)]
pub struct Measurement {
    /// Tells which of the numbers apply.
    pub status: Status,
    /// None unless the status is ok and the motion lasts: where the contact wears, all motion is transient.
    pub class: Option<Class>,
    /// Maximal exponent, the larger of the two non-trivial ones, per unit of tau. With wear it is an exponent of finite time: the
    /// growth of sqrt(X^2 + Y^2) from (X, Y, rest) = (1, 0, 0), from the start until contact is lost, or to the end.
    pub lyapunov: f64,
    /// Standard error of `lyapunov`: that of the batch means plus the scheme's share; NaN for an exponent of finite time.
    pub lyapunov_error: f64,
    /// The scheme's share in `lyapunov_error`. It is the sum of ten times the difference between the sum of the exponents and the
    /// divergence, of rounding, and of the difference from the exponent of a finer scheme. NaN where it is unknown: with heat if
    /// the motion is on no cycle that was found, and with wear.
    pub scheme_error: f64,
    /// The second largest exponent, which at constant contact pressure is the smaller of the two non-trivial ones; equal to the
    /// maximal one where the tangent vectors rotate. NaN with wear. NaN also on a limit cycle without a drive and heat: there, one
    /// of the two exponents is the trivial zero along the flow, which is left out. NaN by radau on a GPU, which carries one vector
    /// only, except on a cycle with heat, which is found on the CPU.
    pub lyapunov_second: f64,
    /// Standard error of `lyapunov_second`: as that of `lyapunov`.
    pub lyapunov_second_error: f64,
    /// Mean divergence of the flow, which the sum of the two exponents equals. NaN with heat or wear, and by radau on a GPU.
    pub divergence: f64,
    /// Weighted Birkhoff average of the maximal exponent; NaN for an exponent of finite time.
    pub lyapunov_birkhoff: f64,
    /// Length of the interval over which the exponent is taken, in tau.
    pub lyapunov_interval: f64,
    /// Least number of forcing periods after which the motion repeats; None unless settled on a cycle that attracts
    /// strongly enough for the run to have reached it.
    pub period: Option<u32>,
    /// Last stroboscopic state, at drive phase 0.
    pub x: f64,
    /// The angular speed of the same state.
    pub y: f64,
    /// Least x over the measured periods.
    pub x_min: f64,
    /// Greatest x over the measured periods.
    pub x_max: f64,
    /// Fraction of the initial states whose motion is chaotic.
    pub chaotic_fraction: f64,
    /// Number of distinct attractors on which initial states have settled.
    pub attractors: u32,
    /// Fraction of the initial states whose motion is bounded but has settled on no attractor.
    pub unsettled_fraction: f64,
    /// Contact pressure, wear and temperature over the run, and whether contact is lost.
    pub contact: Contact,
    /// Where the orbit was integrated.
    pub backend: BackendKind,
    /// Where the orbit began: (x0, y0).
    pub initial_state: [f64; 2],
    /// Forcing periods that were integrated for the point, of all its initial states.
    pub integrated_periods: u32,
}

impl Measurement {
    /// The measurement of an orbit that ran away at `time`.
    pub fn runaway(time: f64, backend: BackendKind) -> Self {
        Self::unmeasured(Status::Runaway { time }, backend)
    }

    /// The measurement of an orbit of which nothing is known.
    pub fn unmeasured(status: Status, backend: BackendKind) -> Self {
        Self {
            status,
            class: None,
            lyapunov: f64::NAN,
            lyapunov_error: f64::NAN,
            scheme_error: f64::NAN,
            lyapunov_second: f64::NAN,
            lyapunov_second_error: f64::NAN,
            divergence: f64::NAN,
            lyapunov_birkhoff: f64::NAN,
            lyapunov_interval: f64::NAN,
            period: None,
            x: f64::NAN,
            y: f64::NAN,
            x_min: f64::NAN,
            x_max: f64::NAN,
            chaotic_fraction: 0.0,
            attractors: 0,
            unsettled_fraction: 0.0,
            contact: Contact::UNKNOWN,
            backend,
            initial_state: [f64::NAN; 2],
            integrated_periods: 0,
        }
    }

    /// Whether this is the measurement of a limit cycle without a drive: its only exponent is the mean divergence.
    pub fn is_on_limit_cycle(&self) -> bool {
        self.lyapunov_second.is_nan() && self.lyapunov == self.divergence
    }

    /// Whether the orbit has shown where it ends: on a cycle that was found, or on chaos or a torus for as long as it was
    /// measured. Without a found cycle a regular orbit is still on its way.
    pub fn has_settled(&self) -> bool {
        match self.class {
            Some(Class::Regular) => self.period.is_some() || self.is_on_limit_cycle(),
            Some(Class::Chaotic | Class::QuasiPeriodic) => true,
            Some(Class::Undecided | Class::Unstable) | None => false,
        }
    }

    /// Difference between the sum of the exponents and the mean divergence: the program's check of itself. NaN with heat
    /// or wear.
    pub fn divergence_defect(&self) -> f64 {
        self.lyapunov + self.lyapunov_second - self.divergence
    }
}
