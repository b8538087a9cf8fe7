//! Regularised dry friction, equations (3.1), (3.2) and (3.4).
//!
//! Owns the friction law; knows nothing of the rubbing bodies. Twin: `shaders/model/friction.wgsl`.

use crate::lanes::Real;

/// Least half-width of the friction layer, in spacings of the number type at the shaft's greatest speed: v is a difference of
/// speeds of that size, and the boundaries of a thinner layer are met too roughly for the tangent vector. A greatest speed of the
/// shaft below 1 counts as 1: forces of order 1 move the bush, whose angle is of order 1, and a creep much slower than a spacing
/// does not change this angle.
pub const LEAST_SPACINGS: f64 = 128.0;

/// The value that the half-width of the friction layer must exceed. `spacing` is the distance between 1 and the next number in
/// the number type, `speed` is the shaft's greatest speed.
pub fn thinnest_layer(spacing: f64, speed: f64) -> f64 {
    LEAST_SPACINGS * spacing * speed.max(1.0)
}

/// Kinetic friction F(v) = F0 s(v) - alpha v + beta v^3 times a constant scale, with s the C1 regularisation of sgn.
///
/// With c = v clamped to -eps0..eps0, s = c (2/eps0 - |c|/eps0^2) and s' = 2/eps0 - 2 |c|/eps0^2 hold on all three pieces
/// at once, so that no branch is needed.
#[derive(Clone, Copy, Debug)]
pub struct Friction<R> {
    epsilon_0: R,
    f_0: R,
    minus_alpha: R,
    beta: R,
    two_f_0_over_epsilon_0: R,
    minus_f_0_over_epsilon_0_squared: R,
    three_beta: R,
}

impl<R: Real> Friction<R> {
    /// The law `scale * F(v)`; the scale is the friction's strength epsilon times the contact pressure.
    pub fn new(scale: R, f_0: R, alpha: R, beta: R, epsilon_0: R) -> Self {
        let inverse_epsilon_0 = R::splat(1.0) / epsilon_0;
        Self {
            epsilon_0,
            f_0: scale * f_0,
            minus_alpha: -(scale * alpha),
            beta: scale * beta,
            two_f_0_over_epsilon_0: R::splat(2.0) * scale * f_0 * inverse_epsilon_0,
            minus_f_0_over_epsilon_0_squared: -(scale * f_0 * inverse_epsilon_0 * inverse_epsilon_0),
            three_beta: R::splat(3.0) * scale * beta,
        }
    }

    /// Sliding velocity, clamped to the layer.
    #[inline(always)]
    fn clamped(&self, v: R) -> R {
        v.max(-self.epsilon_0).min(self.epsilon_0)
    }

    /// `rest + scale * F(v)`, equations (3.1) and (3.2). The order of operations keeps the chain that waits for v short.
    #[inline(always)]
    pub fn plus_force(&self, rest: R, v: R) -> R {
        let c = self.clamped(v);
        let dry = self
            .minus_f_0_over_epsilon_0_squared
            .mul_add(c.abs(), self.two_f_0_over_epsilon_0);
        let polynomial = v.mul_add(self.beta.mul_add(v * v, self.minus_alpha), rest);
        c.mul_add(dry, polynomial)
    }

    /// `scale * F'(v)`, equation (3.4).
    #[inline(always)]
    pub fn slope(&self, v: R) -> R {
        let c = self.clamped(v);
        let dry = self
            .minus_f_0_over_epsilon_0_squared
            .mul_add(c.abs(), self.two_f_0_over_epsilon_0);
        let polynomial = self
            .three_beta
            .mul_add(v * v, self.minus_alpha - self.two_f_0_over_epsilon_0);
        R::splat(2.0).mul_add(dry, polynomial)
    }
}

/// The law between two neighbouring boundaries -eps0, 0, +eps0 of the layer, where it is a polynomial:
/// `scale * F(v) = a_0 + a_1 v + a_2 v^2 + cubic v^3` for `lower <= v <= upper`.
#[derive(Clone, Copy, Debug)]
pub struct Piece<R> {
    /// Constant coefficient.
    pub a_0: R,
    /// Coefficient of v.
    pub a_1: R,
    /// Coefficient of v^2.
    pub a_2: R,
    /// Least v of the piece; -[`NO_BOUNDARY`] on the first.
    pub lower: R,
    /// Greatest v of the piece; [`NO_BOUNDARY`] on the last.
    pub upper: R,
}

/// Stands for a boundary at infinity; finite, so that no difference with it is NaN.
pub const NO_BOUNDARY: f64 = 1e30;

impl<R: Real> Friction<R> {
    /// `scale * beta`, the coefficient of v^3 on every piece.
    #[inline(always)]
    pub fn cubic(&self) -> R {
        self.beta
    }

    /// Half-width of the layer.
    pub fn epsilon_0(&self) -> R {
        self.epsilon_0
    }

    /// Greatest decay rate of y that dry friction has in the layer, at v = 0: `scale * 2 F0/eps0`.
    pub fn layer_rate(&self) -> R {
        self.two_f_0_over_epsilon_0
    }

    /// Index of the piece that v lies on, from the left: 0 below -eps0, 1 and 2 in the layer, 3 above eps0.
    #[inline(always)]
    pub fn piece_index(&self, v: R) -> R {
        let left = R::select(v.less(-self.epsilon_0), R::splat(0.0), R::splat(1.0));
        let right = R::select(v.less(self.epsilon_0), R::splat(2.0), R::splat(3.0));
        R::select(v.less(R::splat(0.0)), left, right)
    }

    /// The piece that has this index. `epsilon_0` is [`Friction::epsilon_0`], which the caller keeps.
    ///
    /// | index | a_0 | a_1 | a_2 | from | to |
    /// | --- | --- | --- | --- | --- | --- |
    /// | 0 | -F0 | -alpha | 0 | | -eps0 |
    /// | 1 | 0 | 2 F0/eps0 - alpha | F0/eps0^2 | -eps0 | 0 |
    /// | 2 | 0 | 2 F0/eps0 - alpha | -F0/eps0^2 | 0 | eps0 |
    /// | 3 | F0 | -alpha | 0 | eps0 | |
    #[inline(always)]
    pub fn piece(&self, index: R, epsilon_0: R) -> Piece<R> {
        let zero = R::splat(0.0);
        let far = R::splat(NO_BOUNDARY);
        let left = index.less(R::splat(1.5));
        let signed = |value: R| R::select(left, -value, value);
        let inside = (index - R::splat(1.5)).abs().less(R::splat(1.0));
        let minus_curvature = self.minus_f_0_over_epsilon_0_squared;
        let near = R::select(inside, zero, epsilon_0);
        let other = R::select(inside, epsilon_0, far);
        Piece {
            a_0: R::select(inside, zero, signed(self.f_0)),
            a_1: self.minus_alpha + R::select(inside, self.two_f_0_over_epsilon_0, zero),
            a_2: R::select(inside, signed(minus_curvature), zero),
            lower: R::select(left, -other, near),
            upper: R::select(left, -near, other),
        }
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
            assert!((friction.plus_force(0.0, v) - 0.1 * force).abs() < 1e-15, "{v}");
            assert!((friction.slope(v) - 0.1 * slope).abs() < 1e-13, "{v}");
        }
    }

    #[test]
    fn every_piece_is_the_law_between_its_boundaries() {
        let friction = Friction::new(0.1, 0.3, 0.2, 0.4, 0.01);
        let indices: Vec<f64> = (0..4).map(f64::from).collect();
        for &index in &indices {
            let piece = friction.piece(index, friction.epsilon_0());
            let (from, to) = (piece.lower.max(-3.0), piece.upper.min(3.0));
            for i in 1..100 {
                let v = from + (to - from) * f64::from(i) / 100.0;
                assert_eq!(friction.piece_index(v), index);
                let value = piece.a_0 + v * (piece.a_1 + v * (piece.a_2 + v * friction.cubic()));
                assert!((value - friction.plus_force(0.0, v)).abs() < 1e-15, "{index} {v}");
                let slope = piece.a_1 + v * (2.0 * piece.a_2 + 3.0 * v * friction.cubic());
                assert!((slope - friction.slope(v)).abs() < 1e-13, "{index} {v}");
            }
        }
        assert!(indices.windows(2).all(|pair| {
            let [left, right] = [pair[0], pair[1]].map(|index| friction.piece(index, friction.epsilon_0()));
            left.upper == right.lower
        }));
    }
}
