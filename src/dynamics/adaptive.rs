//! Steps of the motion under changing pressure: their length, their ends, and the results taken from them.
//!
//! Owns the settings of a run and the constants of an instance; the equations of a step are in [`super::radau`]. The modules,
//! each built on those before it: [`events`] ends steps at boundaries, [`accepted`] takes their ends as the new state,
//! [`tangent`] carries tangent vectors over them, [`pass`] tries one step, [`period`] follows an instance over forcing periods.
//! [`orbit`] is the state, which all of them use. Twin: `shaders/dynamics/adaptive.wgsl`; each of these modules but [`period`] has its own
//! twin.
//!
//! Every lane has its own clock and its own step. A pass tries one step in every lane, and accepts it in lanes where it is good.

pub mod accepted;
pub mod events;
pub mod orbit;
pub mod pass;
pub mod period;
pub mod tangent;

use std::f64::consts::{PI, TAU};

pub use self::accepted::Peaks;
pub use self::orbit::{Orbit, Scratch};
pub use self::tangent::Tangent;
use crate::dynamics::radau::Heat;
use crate::experiment::Integration;
use crate::lanes::Real;
use crate::model::rubbing::{HeatModes, Rubbing};
use crate::parameters::Parameter;

/// A contact whose thermal pressure reaches this has run away: thermal expansion increases the friction, and friction the heat.
pub const PRESSURE_BOUND: f64 = 1e9;

/// Limit of the longest step where the linear terms make y grow: growth rate times longest step times steps per period.
const REPULSION_STEPS: f64 = 6.4;

/// [`Control::swing`] at the usual tolerance.
const SWING: f64 = 0.8;
const USUAL_TOLERANCE: f64 = 2e-4;

/// Lower bound of [`Control::reach`]. Nearer to a boundary, the change of v over a step is too small for f32 to resolve.
const LEAST_REACH: f64 = 5e-4;

/// The settings that all instances of a batch share.
#[derive(Clone, Copy, Debug)]
pub struct Control<R> {
    /// Error that a step may have. The error of v is measured in units of 1 outside the friction layer, and in units of the
    /// layer's width inside it. The error of p is relative.
    pub tolerance: R,
    /// Largest last correction of Newton's method, relative to the larger of |v| and the friction layer's width. The error
    /// that remains is of the order of its square, a thousandth of the tolerance.
    pub newton: R,
    /// How near to a boundary of the friction layer a step must end, in half-widths of the layer. If the step uses the wrong
    /// piece of the law over this distance, the error of friction is its square, a tenth of the tolerance.
    pub reach: R,
    /// Longest step, in forcing periods. It is at most a sixteenth, the range of the drive's series.
    pub longest_step_periods: R,
    /// Longest step in tau, times the slower of the two rates of the linearised motion. The error control sees only the motion,
    /// which may be smooth where the tangent vector is not.
    pub swing: R,
}

impl<R: Real> Control<R> {
    pub fn new(integration: &Integration) -> Self {
        Self {
            tolerance: R::splat(integration.tolerance),
            newton: R::splat((0.001 * integration.tolerance).sqrt()),
            reach: R::splat((0.1 * integration.tolerance).sqrt().max(LEAST_REACH)),
            longest_step_periods: R::splat(1.0 / f64::from(integration.steps_per_period)),
            // the scheme is of order 5
            swing: R::splat(SWING * (integration.tolerance / USUAL_TOLERANCE).powf(0.2)),
        }
    }
}

/// The constants of one instance.
#[derive(Clone, Debug)]
pub struct System<R> {
    pub rubbing: Rubbing<R>,
    /// The forcing period and a tick, in units of tau.
    period: R,
    tick: R,
    /// Factor, at least 1, by which a period is divided into more steps than usual if it is longer than pi (the period of the
    /// paper) or if damping is negative. A step that the error of the motion allows may be too long for the tangent vector: where
    /// the motion rests, the tangent vector swings in the wells, or grows.
    long: R,
    /// 1 in lanes with heat or wear; 0 in the others, where the pressure is constant.
    pub has_heat_or_wear: R,
    rates: Vec<R>,
    inverse_rates: Vec<R>,
    weights: Vec<R>,
    surface_temperature: R,
    /// Whether any lane's fit is a ramp.
    ramps: bool,
    /// 0 in lanes with wear, else 1. With wear, the tangent vector is followed only until contact is lost.
    pub lasts: R,
}

impl<R: Real> System<R> {
    /// The system with the parameters that `value` gives and the heat modes of each lane. All lanes have the same number of
    /// modes.
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
            has_heat_or_wear: R::select(
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

    /// Number of heat modes.
    pub fn mode_count(&self) -> usize {
        self.rates.len()
    }

    /// The sums over the heat modes, given the pressure that each causes.
    pub(super) fn heat(&self, pressures: impl Iterator<Item = R>) -> Heat<R> {
        let zero = R::splat(0.0);
        let none = Heat {
            pressure: zero,
            falloff: zero,
        };
        pressures.zip(&self.rates).fold(none, |sum, (pressure, rate)| Heat {
            pressure: sum.pressure + pressure,
            falloff: rate.mul_add(pressure, sum.falloff),
        })
    }

    /// The heat mode `m` that causes this pressure; 0 where the mode causes none.
    pub fn mode(&self, m: usize, pressure: R) -> R {
        let (zero, weight) = (R::splat(0.0), self.weights[m]);
        R::select(zero.less(weight), pressure / weight, zero)
    }

    /// h_U at a time: 1 - exp(-delta tau^2), accurate to rounding even if it is small.
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
