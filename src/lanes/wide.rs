//! Several numbers (scalars or vectors) worked on together.
//!
//! Owns nothing but the repetition: the operations of one vector wait for each other; with four vectors, those of the others
//! fill the time.

#![allow(
    clippy::needless_range_loop,
    reason = "several arrays are indexed together: an index shows this best"
)]

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Mask, Real, Ticks};

/// `K` numbers side by side; the first `R::LANES` lanes belong to the first number.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Wide<R, const K: usize>([R; K]);

impl<R: Copy, const K: usize> Wide<R, K> {
    #[inline(always)]
    pub fn from_parts(part: impl FnMut(usize) -> R) -> Self {
        Self(std::array::from_fn(part))
    }

    #[inline(always)]
    pub fn parts(self) -> [R; K] {
        self.0
    }
}

// Loops over arrays rather than `array::from_fn`: a closure would not inherit the caller's instruction set unless it
// is inlined, which nothing guarantees.
macro_rules! wide_operator {
    ($trait:ident $method:ident) => {
        impl<R: Real, const K: usize> $trait for Wide<R, K> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                for k in 0..K {
                    self.0[k] = self.0[k].$method(other.0[k]);
                }
                self
            }
        }
    };
}

wide_operator!(Add add);
wide_operator!(Sub sub);
wide_operator!(Mul mul);
wide_operator!(Div div);

impl<R: Real, const K: usize> Neg for Wide<R, K> {
    type Output = Self;
    #[inline(always)]
    fn neg(mut self) -> Self {
        for k in 0..K {
            self.0[k] = -self.0[k];
        }
        self
    }
}

impl<M: Mask, const K: usize> Mask for [M; K] {
    const LANES: usize = M::LANES * K;

    #[inline(always)]
    fn all(self) -> bool {
        let mut all = true;
        for mask in self {
            all &= mask.all();
        }
        all
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> bool {
        self[lane / M::LANES].lane(lane % M::LANES)
    }
    #[inline(always)]
    fn and(mut self, other: Self) -> Self {
        for k in 0..K {
            self[k] = self[k].and(other[k]);
        }
        self
    }
    #[inline(always)]
    fn or(mut self, other: Self) -> Self {
        for k in 0..K {
            self[k] = self[k].or(other[k]);
        }
        self
    }
}

impl<T: Ticks, const K: usize> Ticks for [T; K] {
    #[inline(always)]
    fn splat(ticks: f64) -> Self {
        [T::splat(ticks); K]
    }
    #[inline(always)]
    fn minus(mut self, other: Self) -> Self {
        for k in 0..K {
            self[k] = self[k].minus(other[k]);
        }
        self
    }
    #[inline(always)]
    fn least(mut self, other: Self) -> Self {
        for k in 0..K {
            self[k] = self[k].least(other[k]);
        }
        self
    }
    #[inline(always)]
    fn all_zero(self) -> bool {
        let mut zero = true;
        for ticks in self {
            zero &= ticks.all_zero();
        }
        zero
    }
}

impl<R: Real, const K: usize> Real for Wide<R, K> {
    type Mask = [R::Mask; K];
    type Ticks = [R::Ticks; K];
    type Scalar = R::Scalar;
    const LANES: usize = R::LANES * K;
    const PERIOD_TICKS: f64 = R::PERIOD_TICKS;
    undivided!();

    #[inline(always)]
    fn scalar(value: f64) -> R::Scalar {
        R::scalar(value)
    }
    #[inline(always)]
    fn broadcast(value: R::Scalar) -> Self {
        Self([R::broadcast(value); K])
    }
    #[inline(always)]
    fn from_lanes(mut values: impl FnMut(usize) -> f64) -> Self {
        let mut out = Self([R::broadcast(R::scalar(0.0)); K]);
        for k in 0..K {
            out.0[k] = R::from_lanes(|lane| values(k * R::LANES + lane));
        }
        out
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> f64 {
        self.0[lane / R::LANES].lane(lane % R::LANES)
    }
    #[inline(always)]
    fn mul_add(mut self, factor: Self, addend: Self) -> Self {
        for k in 0..K {
            self.0[k] = self.0[k].mul_add(factor.0[k], addend.0[k]);
        }
        self
    }
    #[inline(always)]
    fn abs(mut self) -> Self {
        for k in 0..K {
            self.0[k] = self.0[k].abs();
        }
        self
    }
    #[inline(always)]
    fn min(mut self, other: Self) -> Self {
        for k in 0..K {
            self.0[k] = self.0[k].min(other.0[k]);
        }
        self
    }
    #[inline(always)]
    fn max(mut self, other: Self) -> Self {
        for k in 0..K {
            self.0[k] = self.0[k].max(other.0[k]);
        }
        self
    }
    #[inline(always)]
    fn sqrt(mut self) -> Self {
        for k in 0..K {
            self.0[k] = self.0[k].sqrt();
        }
        self
    }
    #[inline(always)]
    fn less(self, other: Self) -> Self::Mask {
        let mut mask = [self.0[0].less(other.0[0]); K];
        for k in 1..K {
            mask[k] = self.0[k].less(other.0[k]);
        }
        mask
    }
    #[inline(always)]
    fn select(mask: Self::Mask, mut yes: Self, no: Self) -> Self {
        for k in 0..K {
            yes.0[k] = R::select(mask[k], yes.0[k], no.0[k]);
        }
        yes
    }
    #[inline(always)]
    fn to_ticks(self) -> Self::Ticks {
        let mut ticks = [self.0[0].to_ticks(); K];
        for k in 1..K {
            ticks[k] = self.0[k].to_ticks();
        }
        ticks
    }
    #[inline(always)]
    fn from_ticks(ticks: Self::Ticks) -> Self {
        let mut out = Self([R::from_ticks(ticks[0]); K]);
        for k in 1..K {
            out.0[k] = R::from_ticks(ticks[k]);
        }
        out
    }
}
