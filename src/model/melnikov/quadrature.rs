//! M(tau0) by plain adaptive quadrature of (4.1).
//!
//! Owns nothing but the integration: neither roots nor closed forms are used, so that it checks both.

use std::sync::LazyLock;

use gauss_quad::legendre::GaussLegendre;

use super::{END, Melnikov};

/// An interval is halved until its two halves agree with the whole to `TOLERANCE`, or until it is narrower than `NARROWEST`. So a
/// jump of the integrand costs no more accuracy than this width.
const TOLERANCE: f64 = 1e-13;
const NARROWEST: f64 = 1e-12;

static RULE: LazyLock<GaussLegendre> = LazyLock::new(|| GaussLegendre::new(16.try_into().expect("16 is not 0")));

impl Melnikov {
    /// M(tau0) by adaptive Gauss-Legendre quadrature of (4.1) over |t| < 40: slow, and independent of
    /// [`Melnikov::closed_form`], with which it agrees to better than 1e-8.
    pub fn quadrature(&self, tau_0: f64) -> f64 {
        let integrand = |t: f64| {
            let y = self.orbit_speed(t);
            let w = self.sliding(t, tau_0);
            let sign = if w >= 0.0 { 1.0 } else { -1.0 };
            -y * (self.f_0 * sign + w * (self.beta * w * w - self.alpha) - self.h1 * y)
        };
        let rubs_forward = |t: f64| self.sliding(t, tau_0) >= 0.0;
        // intervals short enough for the rule to resolve every swing of the drive, and of the orbit
        let count = (2.0 * END * (4.0 * self.omega_0).max(8.0)).ceil() as u32;
        let bound = |k: u32| END * (2.0 * f64::from(k) / f64::from(count) - 1.0);
        (0..count)
            .map(|k| {
                let (low, high) = (bound(k), bound(k + 1));
                halved(
                    &integrand,
                    &rubs_forward,
                    [low, high],
                    RULE.integrate(low, high, integrand),
                )
            })
            .sum()
    }
}

/// The integral over an interval, for which the rule gave the value `whole`. A jump close to an end may lie outside all nodes of
/// the rule; it is found by the direction of sliding at the ends and in the middle.
fn halved(f: &impl Fn(f64) -> f64, forward: &impl Fn(f64) -> bool, [low, high]: [f64; 2], whole: f64) -> f64 {
    let middle = 0.5 * (low + high);
    let left = RULE.integrate(low, middle, f);
    let right = RULE.integrate(middle, high, f);
    let is_continuous = forward(low) == forward(middle) && forward(middle) == forward(high);
    let agree = (left + right - whole).abs() < TOLERANCE * (1.0 + whole.abs());
    if is_continuous && agree || high - low < NARROWEST {
        return left + right;
    }
    halved(f, forward, [low, middle], left) + halved(f, forward, [middle, high], right)
}
