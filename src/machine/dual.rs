//! Numbers for the formulas: f64, and dual numbers, which carry all first derivatives along exactly.

use std::ops::{Add, Div, Mul, Sub};

use super::quantities::SiQuantity;

/// What the formulas of the groups need of a number.
pub(super) trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    fn constant(value: f64) -> Self;
    fn sqrt(self) -> Self;
}

impl Number for f64 {
    fn constant(value: f64) -> Self {
        value
    }
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
}

/// A number with its derivatives with respect to every quantity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dual {
    pub value: f64,
    pub slopes: [f64; SiQuantity::COUNT],
}

impl Dual {
    /// The quantity itself, as a variable: its derivative with respect to itself is 1.
    pub fn variable(quantity: SiQuantity, value: f64) -> Self {
        let mut slopes = [0.0; SiQuantity::COUNT];
        slopes[quantity as usize] = 1.0;
        Self { value, slopes }
    }

    /// f(self, other), given f and its partial derivatives at the values.
    fn chain(self, other: Self, value: f64, by_self: f64, by_other: f64) -> Self {
        let slopes = std::array::from_fn(|i| by_self * self.slopes[i] + by_other * other.slopes[i]);
        Self { value, slopes }
    }
}

impl Add for Dual {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.chain(other, self.value + other.value, 1.0, 1.0)
    }
}

impl Sub for Dual {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.chain(other, self.value - other.value, 1.0, -1.0)
    }
}

impl Mul for Dual {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        self.chain(other, self.value * other.value, other.value, self.value)
    }
}

impl Div for Dual {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let quotient = self.value / other.value;
        self.chain(other, quotient, 1.0 / other.value, -quotient / other.value)
    }
}

impl Number for Dual {
    fn constant(value: f64) -> Self {
        let slopes = [0.0; SiQuantity::COUNT];
        Self { value, slopes }
    }
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(Self::constant(0.0), root, 0.5 / root, 0.0)
    }
}
