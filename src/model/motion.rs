//! The bush's motion under constant contact pressure p = 1, equation (3.2), and its linearisation (3.3).
//!
//! Owns the right-hand side; neither steps nor knows the drive's clock. Twin: `shaders/model/motion.wgsl`.

use super::friction::Friction;
use crate::lanes::Real;
use crate::parameters::Parameter;

/// A state with |x| + |y| at or above this has run away: bounded motion of the system is O(1).
pub const RUNAWAY_BOUND: f64 = 1e4;

/// The oscillator x'' = x - b x^3 + eps F(v) - eps h1 y with y = x' and v = (shaft speed) - y.
///
/// The damping goes into the friction's linear term: -eps h1 y = eps h1 v - eps h1 (shaft speed).
#[derive(Clone, Copy, Debug)]
pub struct Motion<R> {
    minus_b: R,
    minus_three_b: R,
    minus_damping: R,
    omega_k: R,
    zeta_k: R,
    friction: Friction<R>,
}

/// The acceleration and its derivatives at one state.
#[derive(Clone, Copy, Debug)]
pub struct Linearised<R> {
    /// x'' = x - b x^3 + eps F(v) - eps h1 y.
    pub acceleration: R,
    /// d(acceleration)/dx = 1 - 3 b x^2.
    pub by_x: R,
    /// d(acceleration)/dy = -eps F'(v) - eps h1, which is also the divergence of the flow.
    pub by_y: R,
}

impl<R: Real> Motion<R> {
    /// The oscillator with the parameters that `value` gives.
    pub fn new(value: impl Fn(Parameter) -> R) -> Self {
        use Parameter::{Alpha, B, Beta, Epsilon, Epsilon0, F0, H1, OmegaK, ZetaK};
        let epsilon = value(Epsilon);
        Self {
            minus_b: -value(B),
            minus_three_b: R::splat(-3.0) * value(B),
            minus_damping: -(epsilon * value(H1)),
            omega_k: value(OmegaK),
            zeta_k: value(ZetaK),
            friction: Friction::new(
                epsilon,
                value(F0),
                value(Alpha) - value(H1),
                value(Beta),
                value(Epsilon0),
            ),
        }
    }

    /// Speed of the shaft omega_k + zeta_k sin z, given sin z.
    #[inline(always)]
    pub fn shaft_speed(&self, sin_z: R) -> R {
        self.zeta_k.mul_add(sin_z, self.omega_k)
    }

    /// Acceleration of the bush at angle x and sliding velocity v.
    #[inline(always)]
    pub fn acceleration(&self, x: R, v: R, shaft_speed: R) -> R {
        let restoring = self.minus_b.mul_add(x * x, R::splat(1.0));
        let rest = x.mul_add(restoring, self.minus_damping * shaft_speed);
        self.friction.plus_force(rest, v)
    }

    /// Acceleration with its derivatives, for the tangent equations (3.3).
    #[inline(always)]
    pub fn linearised(&self, x: R, v: R, shaft_speed: R) -> Linearised<R> {
        Linearised {
            acceleration: self.acceleration(x, v, shaft_speed),
            by_x: self.minus_three_b.mul_add(x * x, R::splat(1.0)),
            by_y: -self.friction.slope(v),
        }
    }

    /// d(acceleration)/dz at drive phase z, for tangent vectors with a component along the flow.
    pub fn by_phase(&self, v: R, cos_z: R) -> R {
        (self.friction.slope(v) + self.minus_damping) * self.zeta_k * cos_z
    }
}
