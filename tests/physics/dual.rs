//! Numbers with derivatives: they check what was derived by hand.

use std::ops::{Add, Div, Mul, Neg, Sub};

use tribochaos::lanes::Real;

/// A number with its derivatives in two directions: arithmetic carries them along exactly.
#[derive(Clone, Copy, Debug)]
pub struct Dual {
    pub value: f64,
    pub derivatives: [f64; 2],
}

impl Dual {
    /// f(self), given f and f' at the value.
    fn chain(self, value: f64, slope: f64) -> Self {
        let derivatives = self.derivatives.map(|derivative| slope * derivative);
        Self { value, derivatives }
    }

    /// f(self, other), given f and its partial derivatives at the values.
    fn chain_2(self, other: Self, value: f64, by_self: f64, by_other: f64) -> Self {
        let [a, b] = [0, 1].map(|i| by_self * self.derivatives[i] + by_other * other.derivatives[i]);
        let derivatives = [a, b];
        Self { value, derivatives }
    }
}

impl Add for Dual {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.chain_2(other, self.value + other.value, 1.0, 1.0)
    }
}

impl Sub for Dual {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.chain_2(other, self.value - other.value, 1.0, -1.0)
    }
}

impl Mul for Dual {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        self.chain_2(other, self.value * other.value, other.value, self.value)
    }
}

impl Div for Dual {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let quotient = self.value / other.value;
        self.chain_2(other, quotient, 1.0 / other.value, -quotient / other.value)
    }
}

impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        self.chain(-self.value, -1.0)
    }
}

impl Real for Dual {
    type Mask = bool;
    type Ticks = u32;
    type Scalar = f64;
    type Half = Self;
    const LANES: usize = 1;
    const PERIOD_TICKS: f64 = f32::PERIOD_TICKS;

    fn half(self, _: usize) -> Self {
        self
    }
    fn join([number, _]: [Self; 2]) -> Self {
        number
    }
    fn scalar(value: f64) -> f64 {
        value
    }
    fn to_ticks(self) -> u32 {
        self.value as u32
    }
    fn from_ticks(ticks: u32) -> Self {
        Self::broadcast(f64::from(ticks))
    }
    fn broadcast(value: f64) -> Self {
        let derivatives = [0.0; 2];
        Self { value, derivatives }
    }
    fn from_lanes(mut values: impl FnMut(usize) -> f64) -> Self {
        Self::broadcast(values(0))
    }
    fn lane(self, _: usize) -> f64 {
        self.value
    }
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        self * factor + addend
    }
    fn abs(self) -> Self {
        self.chain(self.value.abs(), self.value.signum())
    }
    fn min(self, other: Self) -> Self {
        if self.value < other.value { self } else { other }
    }
    fn max(self, other: Self) -> Self {
        if self.value > other.value { self } else { other }
    }
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root)
    }
    fn less(self, other: Self) -> bool {
        self.value < other.value
    }
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
}
