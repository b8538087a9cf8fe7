//! Two numbers (scalars or vectors) worked on together.
//!
//! Owns nothing but the repetition, as [`super::Wide`], but without loops: with `Wide`, a step of many hundred operations has a
//! loop for each of them, and compilers take minutes for that. A pair of plain scalars is also the portable lane type, which the
//! compiler vectorises for the machine's baseline.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Mask, Real, Ticks};

/// Two numbers, masks or clocks side by side; the first lanes belong to the first one.
#[derive(Clone, Copy, Debug)]
pub struct Pair<T>(pub T, pub T);

impl<R: Real> Add for Pair<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0.add(other.0), self.1.add(other.1))
    }
}

impl<R: Real> Sub for Pair<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.0.sub(other.0), self.1.sub(other.1))
    }
}

impl<R: Real> Mul for Pair<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(self.0.mul(other.0), self.1.mul(other.1))
    }
}

impl<R: Real> Div for Pair<R> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self(self.0.div(other.0), self.1.div(other.1))
    }
}

impl<R: Real> Neg for Pair<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl<M: Mask> Mask for Pair<M> {
    const LANES: usize = 2 * M::LANES;

    #[inline(always)]
    fn all(self) -> bool {
        self.0.all() & self.1.all()
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> bool {
        if lane < M::LANES {
            self.0.lane(lane)
        } else {
            self.1.lane(lane - M::LANES)
        }
    }
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Self(self.0.and(other.0), self.1.and(other.1))
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        Self(self.0.or(other.0), self.1.or(other.1))
    }
}

impl<T: Ticks> Ticks for Pair<T> {
    #[inline(always)]
    fn splat(ticks: f64) -> Self {
        Self(T::splat(ticks), T::splat(ticks))
    }
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        Self(self.0.minus(other.0), self.1.minus(other.1))
    }
    #[inline(always)]
    fn least(self, other: Self) -> Self {
        Self(self.0.least(other.0), self.1.least(other.1))
    }
    #[inline(always)]
    fn all_zero(self) -> bool {
        self.0.all_zero() & self.1.all_zero()
    }
}

impl<R: Real> Real for Pair<R> {
    type Mask = Pair<R::Mask>;
    type Ticks = Pair<R::Ticks>;
    type Scalar = R::Scalar;
    type Half = R;
    const LANES: usize = 2 * R::LANES;
    const VECTORS: usize = 2 * R::VECTORS;
    const PERIOD_TICKS: f64 = R::PERIOD_TICKS;

    #[inline(always)]
    fn scalar(value: f64) -> R::Scalar {
        R::scalar(value)
    }
    #[inline(always)]
    fn broadcast(value: R::Scalar) -> Self {
        Self(R::broadcast(value), R::broadcast(value))
    }
    #[inline(always)]
    fn from_lanes(mut values: impl FnMut(usize) -> f64) -> Self {
        let first = R::from_lanes(&mut values);
        Self(first, R::from_lanes(|lane| values(R::LANES + lane)))
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> f64 {
        if lane < R::LANES {
            self.0.lane(lane)
        } else {
            self.1.lane(lane - R::LANES)
        }
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        Self(self.0.mul_add(factor.0, addend.0), self.1.mul_add(factor.1, addend.1))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs(), self.1.abs())
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0), self.1.min(other.1))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0), self.1.max(other.1))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt(), self.1.sqrt())
    }
    #[inline(always)]
    fn less(self, other: Self) -> Self::Mask {
        Pair(self.0.less(other.0), self.1.less(other.1))
    }
    #[inline(always)]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
        Self(R::select(mask.0, yes.0, no.0), R::select(mask.1, yes.1, no.1))
    }
    #[inline(always)]
    fn to_ticks(self) -> Self::Ticks {
        Pair(self.0.to_ticks(), self.1.to_ticks())
    }
    #[inline(always)]
    fn from_ticks(ticks: Self::Ticks) -> Self {
        Self(R::from_ticks(ticks.0), R::from_ticks(ticks.1))
    }
    #[inline(always)]
    fn half(self, index: usize) -> R {
        if index == 0 { self.0 } else { self.1 }
    }
    #[inline(always)]
    fn join([first, second]: [R; 2]) -> Self {
        Self(first, second)
    }
    #[inline(always)]
    fn together(self, other: Self) -> (Self, Self) {
        let (first, other_first) = self.0.together(other.0);
        let (second, other_second) = self.1.together(other.1);
        (Self(first, second), Self(other_first, other_second))
    }
    #[inline(always)]
    fn in_step(self) -> Self {
        let (first, second) = self.0.together(self.1);
        Self(first.in_step(), second.in_step())
    }
}
