//! A quantity within a collocation step: the cubic through its values at the step's start and three nodes.
//!
//! Owns crossings and maxima of such cubics. Twin: `shaders/dynamics/dense.wgsl`.

use super::radau::NODES;
use crate::lanes::{Mask, Real};

/// Stands for a time that does not come.
const NEVER: f64 = 1e30;

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

    /// The cubic with all values negated.
    #[inline(always)]
    #[must_use]
    pub fn negative(&self) -> Self {
        Self {
            coefficients: self.coefficients.map(|coefficient| -coefficient),
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

    /// The coefficients of its powers, from the constant on.
    #[inline(always)]
    pub fn coefficients(&self) -> [R; 4] {
        self.coefficients
    }

    /// The time from s = 1 until the cubic comes to `low` or to `high`. At s = 1 its value must be between them. The time is that of
    /// the parabola that touches the cubic there, corrected by one step of Newton's method. The result is very large, mostly 1e30, if
    /// the value is not between them or moves to neither.
    #[inline(always)]
    pub fn beyond(&self, [low, high]: [R; 2]) -> R {
        let [c0, c1, c2, c3] = self.coefficients;
        let (zero, two, three) = (R::splat(0.0), R::splat(2.0), R::splat(3.0));
        let value = c0 + c1 + c2 + c3;
        let rate = three.mul_add(c3, two.mul_add(c2, c1));
        let four_bend = R::splat(4.0) * three.mul_add(c3, c2);
        let discriminant = |distance: R| rate.mul_add(rate, four_bend * distance);
        // ahead, or behind if the parabola turns before
        let rises = zero.less(rate);
        let ahead = R::select(rises, high, low) - value;
        let behind = R::select(rises, low, high) - value;
        let turns = discriminant(ahead).less(zero);
        let distance = R::select(turns, behind, ahead);
        // the first root after 1, without cancellation; the parabola has this slope there
        let steepness = discriminant(distance).max(zero).sqrt();
        let slope = R::select(distance.less(zero), -steepness, steepness);
        let time = two * distance / (rate + slope);
        let comes = zero.less(steepness).and(zero.less(time));
        let third = c3 * time * time;
        let corrected = time - third * time / three.mul_add(third, slope);
        let half = R::splat(0.5) * time;
        R::select(comes, corrected.max(half).min(time + half), R::splat(NEVER))
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
    fn what_comes_after_the_step_is_foreseen() {
        // parabolas are met exactly; those that move away from the level, or have left it behind, never come to it (or, by rounding,
        // far in the future)
        let parabola = |v: f64, slope: f64, bend: f64| {
            let value = move |s: f64| v + (s - 1.0) * (slope + (s - 1.0) * bend);
            move |low, high| cubic(value).beyond([low, high])
        };
        let far = 1e30;
        for (time, slope, bend) in [
            (0.3, 2.0, 0.0),
            (0.3, 2.0, -1.5),
            (4.0, 0.0, 0.7),
            (2.5, -1.0, 0.9),
            (9.0, 0.1, 0.0),
        ] {
            let level = 0.4 + time * (slope + time * bend);
            let rising = parabola(0.4, slope, bend)(-far, level);
            let falling = parabola(-0.4, -slope, -bend)(-level, far);
            for found in [rising, falling] {
                assert!((found - time).abs() < 1e-9 * time, "{time}: {found}");
            }
        }
        assert!(parabola(0.4, -1.0, 0.0)(-far, 0.7) > 1e9);
        assert!(parabola(0.4, 1.0, 0.0)(-far, 0.3) > 1e9);
        // 0.4 + t - t^2 comes to 0.6, or turns before 0.7 and falls to 0.1
        let turning = parabola(0.4, 1.0, -1.0);
        for (high, time) in [(0.6, 0.5 - 0.05_f64.sqrt()), (0.7, 0.5 + 0.55_f64.sqrt())] {
            assert!((turning(0.1, high) - time).abs() < 1e-9, "{high}");
        }
        // a cubic term moves the time: Newton's step finds most of this
        let cubic = cubic(|s| s + 0.1 * (s - 1.0).powi(3));
        let level = 1.5 + 0.1 * 0.125;
        assert!((cubic.beyond([-far, level]) - 0.5).abs() < 1e-3);
        assert!((cubic.negative().beyond([-level, far]) - 0.5).abs() < 1e-3);
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
