//! Regularised dry friction, equations (3.1), (3.2) and (3.4).
//!
//! Owns the friction law; does not know who rubs on whom. Twin: `shaders/model/friction.wgsl`.

use crate::lanes::Real;

/// Kinetic friction F(v) = F0 s(v) - alpha v + beta v^3 times a constant scale, with s the C1 regularisation of sgn.
///
/// With u = v/eps0 clamped to -1..1, s = u (2 - |u|) and s' = (2/eps0)(1 - |u|) hold on all three pieces at once, so
/// that no branch is needed.
#[derive(Clone, Copy, Debug)]
pub struct Friction<R> {
    inverse_epsilon_0: R,
    f_0: R,
    minus_alpha: R,
    beta: R,
    two_f_0_over_epsilon_0: R,
    three_beta: R,
}

impl<R: Real> Friction<R> {
    /// The law `scale * F(v)`; the scale is the friction's strength epsilon times the contact pressure.
    pub fn new(scale: R, f_0: R, alpha: R, beta: R, epsilon_0: R) -> Self {
        let inverse_epsilon_0 = R::splat(1.0) / epsilon_0;
        Self {
            inverse_epsilon_0,
            f_0: scale * f_0,
            minus_alpha: -(scale * alpha),
            beta: scale * beta,
            two_f_0_over_epsilon_0: R::splat(2.0) * scale * f_0 * inverse_epsilon_0,
            three_beta: R::splat(3.0) * scale * beta,
        }
    }

    /// Sliding velocity in units of the layer's half-width, clamped to -1..1.
    #[inline(always)]
    fn clamped(&self, v: R) -> R {
        (v * self.inverse_epsilon_0).max(R::splat(-1.0)).min(R::splat(1.0))
    }

    /// `scale * F(v)`, equations (3.1) and (3.2).
    #[inline(always)]
    pub fn force(&self, v: R) -> R {
        let u = self.clamped(v);
        let polynomial = v * self.beta.mul_add(v * v, self.minus_alpha);
        self.f_0.mul_add(u * (R::splat(2.0) - u.abs()), polynomial)
    }

    /// `scale * F'(v)`, equation (3.4).
    #[inline(always)]
    pub fn slope(&self, v: R) -> R {
        let inside = R::splat(1.0) - self.clamped(v).abs();
        let polynomial = self.three_beta.mul_add(v * v, self.minus_alpha);
        self.two_f_0_over_epsilon_0.mul_add(inside, polynomial)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The law as it stands in the paper, by cases.
    fn paper(v: f64, epsilon_0: f64) -> (f64, f64) {
        let (s, ds) = if v.abs() >= epsilon_0 {
            (v.signum(), 0.0)
        } else {
            (
                (2.0 - v.abs() / epsilon_0) * v / epsilon_0,
                2.0 / epsilon_0 * (1.0 - v.abs() / epsilon_0),
            )
        };
        (0.3 * s - 0.2 * v + 0.4 * v.powi(3), 0.3 * ds - 0.2 + 1.2 * v * v)
    }

    #[test]
    fn the_clamped_form_is_the_paper_s_law_on_every_piece() {
        let friction = Friction::new(0.1, 0.3, 0.2, 0.4, 0.01);
        for i in -300..=300 {
            let v = f64::from(i) * 1e-4 * if i % 7 == 0 { 100.0 } else { 1.0 };
            let (force, slope) = paper(v, 0.01);
            assert!((friction.force(v) - 0.1 * force).abs() < 1e-15, "{v}");
            assert!((friction.slope(v) - 0.1 * slope).abs() < 1e-13, "{v}");
        }
    }
}
