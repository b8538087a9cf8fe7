//! The number types that the model and the schemes are written over: scalars, and vectors of lanes.
//!
//! Owns arithmetic, masks and the conversion between lanes and f64; knows nothing of the model. The model's source is
//! written once over [`Real`] and serves f64 (the reference), dual numbers (in tests), and lanes of f64 and f32.

/// Implements [`Real::Half`], [`Real::half`] and [`Real::join`] for a number that is not divided.
macro_rules! undivided {
    () => {
        type Half = Self;

        #[inline(always)]
        fn half(self, _: usize) -> Self {
            self
        }
        #[inline(always)]
        fn join([whole, _]: [Self; 2]) -> Self {
            whole
        }
    };
}

mod instructions;
mod pair;
mod wide;
#[cfg(all(target_arch = "x86_64", not(test)))]
pub(crate) mod x86;

use std::ops::{Add, Div, Mul, Neg, Sub};

pub(crate) use instructions::{Held, Instructions, Portable};
pub use pair::Pair;
pub use wide::Wide;

/// A real number, or several side by side in lanes.
///
/// Every method of an implementation for speed must be `#[inline(always)]`, so that it is compiled for the instruction set of
/// the function at the top of the call tree.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// One truth value for each lane.
    type Mask: Mask;
    /// One clock for each lane.
    type Ticks: Ticks;
    /// The type of one lane.
    type Scalar: Copy + Send + Sync;
    /// Half of the vectors, for work that is faster on fewer at a time; for a single vector, the vector itself.
    type Half: Real;
    const LANES: usize;
    /// Number of vectors side by side; 0 for scalars, also for several of them, and for [`Wide`], which is not divided.
    const VECTORS: usize = 0;
    /// Ticks of a clock in a forcing period: a power of two, so that the length of a tick is exact.
    const PERIOD_TICKS: f64;

    /// Rounds an f64 to the lane's type.
    fn scalar(value: f64) -> Self::Scalar;
    /// The same value in every lane.
    fn broadcast(value: Self::Scalar) -> Self;
    /// `values(lane)` in each lane.
    fn from_lanes(values: impl FnMut(usize) -> f64) -> Self;
    fn lane(self, lane: usize) -> f64;
    /// `self * factor + addend`, fused where the target does that fast.
    #[must_use]
    fn mul_add(self, factor: Self, addend: Self) -> Self;
    #[must_use]
    fn abs(self) -> Self;
    #[must_use]
    fn min(self, other: Self) -> Self;
    #[must_use]
    fn max(self, other: Self) -> Self;
    #[must_use]
    fn sqrt(self) -> Self;
    /// `self < other`; false where either is NaN.
    fn less(self, other: Self) -> Self::Mask;
    /// `yes` where the mask is true, else `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// A whole number of ticks that differs from `self` by at most one. `self` is from 0 to [`Real::PERIOD_TICKS`].
    fn to_ticks(self) -> Self::Ticks;
    fn from_ticks(ticks: Self::Ticks) -> Self;
    /// The first half (0) or the second (1).
    fn half(self, index: usize) -> Self::Half;
    /// The number with these halves; if it is not divided, the first of them.
    fn join(halves: [Self::Half; 2]) -> Self;

    /// Returns both unchanged. Nothing that depends on one is computed before the other is known: see [`Real::in_step`].
    #[inline(always)]
    fn together(self, other: Self) -> (Self, Self) {
        (self, other)
    }

    /// Returns the number unchanged. Nothing that depends on one of its vectors is computed before all of them are known.
    ///
    /// A vector whose operations wait for each other leaves most of a core idle. Other vectors can use this time, if the program
    /// has the operations of all vectors in turn. Where that saves registers, compilers place all operations of one vector before
    /// those of the next; this function prevents that, and costs no instruction.
    #[inline(always)]
    #[must_use]
    fn in_step(self) -> Self {
        self
    }

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self::broadcast(Self::scalar(value))
    }

    /// Natural logarithm, lane by lane: slow, for use once in many steps.
    #[inline(always)]
    #[must_use]
    fn ln(self) -> Self {
        Self::from_lanes(|lane| self.lane(lane).ln())
    }
}

/// One truth value for each lane.
pub trait Mask: Copy {
    const LANES: usize;
    fn all(self) -> bool;
    fn lane(self, lane: usize) -> bool;
    #[must_use]
    fn and(self, other: Self) -> Self;
    #[must_use]
    fn or(self, other: Self) -> Self;
}

/// One whole number for each lane, up to [`Real::PERIOD_TICKS`]. It is a clock, and must add up exactly in every number type. An
/// f64 can hold such a number itself; an f32 has too few digits, and has an integer beside it.
pub trait Ticks: Copy + Send + Sync {
    /// The whole number `ticks` in every lane.
    fn splat(ticks: f64) -> Self;
    /// `self - other`, which must not be negative.
    #[must_use]
    fn minus(self, other: Self) -> Self;
    #[must_use]
    fn least(self, other: Self) -> Self;
    /// Whether every lane is 0.
    fn all_zero(self) -> bool;
}

impl Mask for bool {
    const LANES: usize = 1;

    #[inline(always)]
    fn all(self) -> bool {
        self
    }
    #[inline(always)]
    fn lane(self, _: usize) -> bool {
        self
    }
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        self & other
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        self | other
    }
}

/// Ticks in a period where an integer clock stands beside an f32: a 32-bit integer holds them with room to spare.
pub const SHORT_PERIOD_TICKS: f64 = (1u64 << 28) as f64;

/// Ticks in a period where an f64 is the clock: few enough for it to be rounded to a whole number by adding `ROUNDING`.
pub const LONG_PERIOD_TICKS: f64 = (1u64 << 50) as f64;

/// Adding this to an f64 of up to half of it, and subtracting it again, rounds the f64 to the nearest whole number.
pub(crate) const ROUNDING: f64 = (1u64 << 52) as f64;

impl Ticks for u32 {
    #[inline(always)]
    fn splat(ticks: f64) -> Self {
        ticks as u32
    }
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self - other
    }
    #[inline(always)]
    fn least(self, other: Self) -> Self {
        self.min(other)
    }
    #[inline(always)]
    fn all_zero(self) -> bool {
        self == 0
    }
}

impl Ticks for f64 {
    #[inline(always)]
    fn splat(ticks: f64) -> Self {
        ticks
    }
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self - other
    }
    #[inline(always)]
    fn least(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn all_zero(self) -> bool {
        self == 0.0
    }
}

macro_rules! scalar_real {
    ($scalar:ident, $ticks:ident of $period_ticks:ident, |$value:ident| $to_ticks:expr) => {
        impl Real for $scalar {
            type Mask = bool;
            type Ticks = $ticks;
            type Scalar = $scalar;
            const LANES: usize = 1;
            const PERIOD_TICKS: f64 = $period_ticks;
            undivided!();

            #[inline(always)]
            fn scalar(value: f64) -> $scalar {
                value as $scalar
            }
            #[inline(always)]
            fn broadcast(value: $scalar) -> Self {
                value
            }
            #[inline(always)]
            fn from_lanes(mut values: impl FnMut(usize) -> f64) -> Self {
                values(0) as $scalar
            }
            #[inline(always)]
            fn lane(self, _: usize) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            fn mul_add(self, factor: Self, addend: Self) -> Self {
                // without the instruction, a fused operation is a slow library call
                if cfg!(any(target_feature = "fma", target_arch = "aarch64")) {
                    $scalar::mul_add(self, factor, addend)
                } else {
                    self * factor + addend
                }
            }
            #[inline(always)]
            fn abs(self) -> Self {
                $scalar::abs(self)
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                if self < other { self } else { other }
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                if self > other { self } else { other }
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $scalar::sqrt(self)
            }
            #[inline(always)]
            fn less(self, other: Self) -> bool {
                self < other
            }
            #[inline(always)]
            fn select(mask: bool, yes: Self, no: Self) -> Self {
                if mask { yes } else { no }
            }
            #[inline(always)]
            fn to_ticks(self) -> $ticks {
                let $value = self;
                $to_ticks
            }
            #[inline(always)]
            fn from_ticks(ticks: $ticks) -> Self {
                ticks as $scalar
            }
        }
    };
}

scalar_real!(f64, f64 of LONG_PERIOD_TICKS, |value| (value + ROUNDING) - ROUNDING);
scalar_real!(f32, u32 of SHORT_PERIOD_TICKS, |value| value as u32);
