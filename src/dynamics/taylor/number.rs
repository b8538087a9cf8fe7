//! The operations that the recurrences need from a number type.
//!
//! Owns the least arithmetic that serves scalars, lanes, dual numbers and the text of a shader alike; has no comparison, because
//! numbers in a text have no value yet.

use std::ops::{Add, Mul, Neg, Sub};

use crate::lanes::Real;

/// A number, or the text of one.
pub trait Number: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self> {
    fn constant(value: f64) -> Self;
    /// `self * factor + addend`, fused where that is fast.
    #[must_use]
    fn fused(self, factor: Self, addend: Self) -> Self;
}

impl<R: Real> Number for R {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        R::splat(value)
    }
    #[inline(always)]
    fn fused(self, factor: Self, addend: Self) -> Self {
        self.mul_add(factor, addend)
    }
}
