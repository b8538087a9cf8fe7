//! A quantity within a collocation step: the cubic through its values at the step's start and three nodes.
//!
//! Owns crossings and maxima of such cubics. Twin: `shaders/dynamics/dense.wgsl`.

use super::radau::NODES;
use crate::lanes::{Mask, Real};

/// value(s) = c0 + c1 s + c2 s^2 + c3 s^3 for s from 0 to 1, the step's start and end.
#[derive(Clone, Copy, Debug)]
pub struct Cubic<R> {
    coefficients: [R; 4],
}

impl<R: Real> Cubic<R> {
    /// The cubic through `start` and the values at the nodes.
    #[inline(always)]
    pub fn new(start: R, values: [R; 3]) -> Self {
        let constant = R::splat;
        let [c1, c2, _] = NODES;
        // divided differences over 0, c1, c2, 1
        let first = (values[0] - start) * constant(1.0 / c1);
        let second = ((values[1] - values[0]) * constant(1.0 / (c2 - c1)) - first) * constant(1.0 / c2);
        let last = ((values[2] - values[1]) * constant(1.0 / (1.0 - c2))
            - (values[1] - values[0]) * constant(1.0 / (c2 - c1)))
            * constant(1.0 / (1.0 - c1));
        let third = last - second;
        Self {
            coefficients: [
                start,
                third.mul_add(constant(c1 * c2), second.mul_add(constant(-c1), first)),
                third.mul_add(constant(-(c1 + c2)), second),
                third,
            ],
        }
    }

    #[inline(always)]
    pub fn at(&self, s: R) -> R {
        let [c0, c1, c2, c3] = self.coefficients;
        c3.mul_add(s, c2).mul_add(s, c1).mul_add(s, c0)
    }

    #[inline(always)]
    fn slope(&self, s: R) -> R {
        let [_, c1, c2, c3] = self.coefficients;
        (R::splat(3.0) * c3).mul_add(s, R::splat(2.0) * c2).mul_add(s, c1)
    }

    /// Where the cubic takes the value `level`. The crossing must lie between s = `from` and s = `to`. Newton's method starts
    /// from the secant and is kept inside this interval.
    #[inline(always)]
    pub fn crossing(&self, level: R, from: R, to: R) -> R {
        let (before, beyond) = (self.at(from) - level, self.at(to) - level);
        let mut s = from + (to - from) * (before / (before - beyond));
        for _ in 0..4 {
            s = (s - (self.at(s) - level) / self.slope(s)).max(from).min(to);
        }
        s
    }

    /// Whether the cubic surely stays below `level` between s = 0 and 1: true if its Bezier points do.
    #[inline(always)]
    pub fn stays_below(&self, level: R) -> R::Mask {
        let [c0, c1, c2, c3] = self.coefficients;
        let third = R::splat(1.0 / 3.0);
        let first = third.mul_add(c1, c0);
        let second = third.mul_add(c1 + c2, first);
        let last = c0 + c1 + c2 + c3;
        first.max(second).max(last.max(c0)).less(level)
    }

    /// Greatest value between s = 0 and 1 and where it is, if there is a maximum inside; else the value at 1 (that at 0
    /// was the end of the step before).
    #[inline(always)]
    pub fn maximum(&self) -> (R, R) {
        let [_, c1, c2, c3] = self.coefficients;
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        // the root of 3 c3 s^2 + 2 c2 s + c1 at which the slope falls, in the form without cancellation for c2 < 0
        let discriminant = c2.mul_add(c2, R::splat(-3.0) * c3 * c1).max(zero).sqrt();
        let s = R::select(
            c2.less(zero),
            c1 / (discriminant - c2),
            -(c2 + discriminant) / (R::splat(3.0) * c3),
        );
        // written so that NaN gives the end
        let s = R::select(zero.less(s), R::select(s.less(one), s, one), one);
        let (inside, end) = (self.at(s), self.at(one));
        let better = end.less(inside).and(self.coefficients[0].less(inside));
        (R::select(better, inside, end), R::select(better, s, one))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cubic(f: impl Fn(f64) -> f64) -> Cubic<f64> {
        Cubic::new(f(0.0), NODES.map(f))
    }

    #[test]
    fn a_cubic_is_met_exactly() {
        let f = |s: f64| 0.3 - 1.7 * s + 4.0 * s * s - 2.5 * s.powi(3);
        let dense = cubic(f);
        for i in 0..=10 {
            let s = f64::from(i) / 10.0;
            assert!((dense.at(s) - f(s)).abs() < 1e-14);
        }
    }

    #[test]
    fn crossings_are_found_inside_their_bracket() {
        let dense = cubic(|s: f64| (3.0 * s).sin());
        for level in [0.05, 0.3, 0.7, 0.8] {
            let s = dense.crossing(level, 0.0, 0.55);
            assert!((dense.at(s) - level).abs() < 1e-4, "{level}");
        }
    }

    #[test]
    fn the_maximum_is_inside_or_at_the_end() {
        let close = |(a, b): (f64, f64), (c, d): (f64, f64)| (a - c).abs() < 1e-12 && (b - d).abs() < 1e-12;
        assert!(close(cubic(|s| 2.0 - (s - 0.3).powi(2)).maximum(), (2.0, 0.3)));
        assert!(close(cubic(|s| s * s).maximum(), (1.0, 1.0)));
        assert!(close(cubic(|s| -s).maximum(), (-1.0, 1.0)));
        assert!(close(cubic(|_| 5.0).maximum(), (5.0, 1.0)));
        // a maximum at 0.2 and a minimum at 0.9
        let f = |s: f64| 10.0 * (s.powi(3) / 3.0 - 0.55 * s * s + 0.18 * s);
        assert!(close(cubic(f).maximum(), (f(0.2), 0.2)));
    }
}
