//! Steps of the rubbed bush: their length, where they end, and what is taken from them.
//!
//! Owns what a run is controlled by and what an instance is, apart from its state; the equations of a step are
//! [`super::radau`]'s. From the bottom to the top: [`events`] ends steps at boundaries, [`accepted`] takes their ends as the new
//! state, [`tangent`] carries perturbations over them, [`pass`] tries one, [`orbit`] is the state and follows it over
//! forcing periods. Twin: `shaders/dynamics/adaptive.wgsl`, as each of these has its own.
//!
//! Every lane has its own clock and its own step: a pass tries one step in each, and keeps it where it is good.

pub mod accepted;
pub mod events;
pub mod orbit;
pub mod pass;
pub mod tangent;

use std::f64::consts::{PI, TAU};

pub use self::accepted::Peaks;
pub use self::orbit::{Orbit, Scratch};
pub use self::tangent::Tangent;
use crate::experiment::Integration;
use crate::lanes::Real;
use crate::model::rubbing::{HeatModes, Rubbing};
use crate::parameters::Parameter;

/// A contact whose thermal pressure reaches this has run away: expansion feeds the friction that heats.
pub const PRESSURE_BOUND: f64 = 1e9;

/// Units of time of the linear growth of y in the longest step, times the least number of steps in a period.
const REPULSION_STEPS: f64 = 6.4;

/// [`Control::swing`] at the usual tolerance.
const SWING: f64 = 0.8;
const USUAL_TOLERANCE: f64 = 2e-4;

/// Least of [`Control::reach`]: nearer to a boundary, v changes too little over a step to be told apart in f32.
const LEAST_REACH: f64 = 5e-4;

/// What all instances of a batch share.
#[derive(Clone, Copy, Debug)]
pub struct Control<R> {
    /// Error of a step: of v in units of 1 outside the friction layer and of its half-width inside, of p relative.
    pub tolerance: R,
    /// Newton's last correction, relative to the larger of |v| and the friction layer's half-width: what is left after it
    /// is of the order of its square, a hundredth of the tolerance.
    pub newton: R,
    /// How near to a boundary of the friction layer a step must end, in half-widths of the layer. On the wrong piece of
    /// the law for so long, friction errs by the square of it, a tenth of the tolerance.
    pub reach: R,
    /// Longest step, in forcing periods: a sixteenth at most, for which the drive's series is made.
    pub longest_step_periods: R,
    /// Longest step in tau, times the slower of the two rates of the bush's motion: what it rests on may be smooth where the tangent
    /// is not.
    pub swing: R,
}

impl<R: Real> Control<R> {
    pub fn new(integration: &Integration) -> Self {
        Self {
            tolerance: R::splat(integration.tolerance),
            newton: R::splat((0.01 * integration.tolerance).sqrt()),
            reach: R::splat((0.1 * integration.tolerance).sqrt().max(LEAST_REACH)),
            longest_step_periods: R::splat(1.0 / f64::from(integration.steps_per_period)),
            // the scheme is of order 5
            swing: R::splat(SWING * (integration.tolerance / USUAL_TOLERANCE).powf(0.2)),
        }
    }
}

/// What one instance is, apart from its state.
#[derive(Clone, Debug)]
pub struct System<R> {
    pub rubbing: Rubbing<R>,
    /// Forcing period in units of tau, and ticks to tau.
    period: R,
    tick: R,
    /// By so much more than the usual steps a period is divided into where it is longer than pi, the paper's, or damping is
    /// negative. A step that the motion's error allows may be too long for the tangent, which swings in the wells, or grows,
    /// where the motion rests.
    long: R,
    /// 1 in lanes in which there is heat or wear, else 0: there the pressure is constant.
    pub is_rubbed: R,
    rates: Vec<R>,
    inverse_rates: Vec<R>,
    weights: Vec<R>,
    surface_temperature: R,
    /// Whether any lane's fit is a ramp.
    ramps: bool,
    /// 0 in lanes that wear, else 1: there the tangent vector lives until contact is lost, and no longer.
    lasts: R,
}

impl<R: Real> System<R> {
    /// The system with the parameters that `value` gives, and each lane's heat modes, all of the same number.
    pub fn new<'a>(value: impl Fn(Parameter) -> R, modes: impl Fn(usize) -> &'a HeatModes) -> Self {
        let rubbing = Rubbing::new(&value);
        let period = R::splat(TAU) / value(Parameter::Omega0);
        let count = modes(0).rates.len();
        let repulsion = value(Parameter::Epsilon) * value(Parameter::Alpha) - rubbing.damping;
        let each = |of: &dyn Fn(&HeatModes) -> f64| R::from_lanes(|lane| of(modes(lane)));
        Self {
            ramps: (0..R::LANES).any(|lane| rubbing.ramp_rate.lane(lane).is_finite()),
            lasts: R::select(R::splat(0.0).less(rubbing.k_w), R::splat(0.0), R::splat(1.0)),
            rubbing,
            period,
            tick: period * R::splat(1.0 / R::PERIOD_TICKS),
            long: (period * R::splat(1.0 / PI))
                .max(period * repulsion * R::splat(1.0 / REPULSION_STEPS))
                .max(R::splat(1.0)),
            is_rubbed: R::select(
                R::splat(0.0).less(rubbing.k_w + rubbing.two_gamma),
                R::splat(1.0),
                R::splat(0.0),
            ),
            rates: (0..count).map(|m| each(&|modes| modes.rates[m])).collect(),
            inverse_rates: (0..count).map(|m| each(&|modes| 1.0 / modes.rates[m])).collect(),
            weights: (0..count).map(|m| each(&|modes| modes.weights[m])).collect(),
            surface_temperature: each(&|modes| modes.surface_temperature),
        }
    }

    /// h_U at a time: 1 - exp(-delta tau^2), to rounding also where it is small.
    #[inline(always)]
    fn fit(&self, time: R) -> R {
        if !self.ramps {
            return R::splat(1.0);
        }
        // ramps are rare: lane by lane is fast enough
        R::from_lanes(|lane| {
            let (rate, time) = (self.rubbing.ramp_rate.lane(lane), time.lane(lane));
            if rate.is_finite() {
                -(-rate * time * time).exp_m1()
            } else {
                1.0
            }
        })
    }
}
