//! The growth of tangent vectors over a forcing period.
//!
//! Owns how the second vector stays apart from the first, and the logarithms of both; steps nothing. Twin:
//! `shaders/dynamics/taylor/growth.wgsl`.
//!
//! Of the second vector only the area matters that it spans with the first. From time to time it is replaced by the
//! vector across the first that spans the area 1, and the area it had spanned goes into a product: no root, no logarithm,
//! and the sum of the exponents comes from the vectors alone, for the mean divergence to be held against.

use crate::dynamics::tangent::{COMFORTABLE, SMALLEST_SQUARE, Vector};
use crate::lanes::{Mask, Real};

/// Steps between two renewals of the second vector: few enough for it to keep half of f32's digits in the layer, where it
/// turns towards the first fastest. As often it is seen to that no length leaves the numbers.
pub const RENEWAL_STEPS: u32 = 8;

#[inline(always)]
fn is_comfortable<R: Real>(value: R) -> R::Mask {
    R::splat(1.0 / COMFORTABLE)
        .less(value)
        .and(value.less(R::splat(COMFORTABLE)))
}

/// By what to divide a length, or an area, that is not comfortable, in lanes that go on; by 1 in others, and where it is 0 or
/// no number.
fn divisor<R: Real>(value: R, left: R) -> R {
    let one = R::splat(1.0);
    let is_number = R::splat(0.0).less(value).and(value.less(R::splat(LARGEST)));
    let divided = R::select(is_number, value, one);
    let divided = R::select(R::splat(0.0).less(left), divided, one);
    R::select(is_comfortable(value), one, divided)
}

/// Less than the largest f32.
pub(super) const LARGEST: f64 = 1e38;

/// A tangent vector within a forcing period, with its speed in units of time; it began at length 1 in units of tau.
#[derive(Clone, Copy, Debug)]
pub struct Carried<R> {
    pub vector: Vector<R>,
    /// Logarithm of what its length was divided by on the way.
    log: R,
}

impl<R: Real> Carried<R> {
    #[inline(always)]
    pub fn new(vector: Vector<R>) -> Self {
        Self {
            vector,
            log: R::splat(0.0),
        }
    }

    /// Brings the vector to a length of about 1 where it is far from it, in lanes of which `left` is not 0: those at their
    /// period's end must not feel how many steps their neighbours still take. An area that it spans stays the same.
    #[inline(always)]
    pub fn settle(&mut self, area: Option<&mut Area<R>>, left: R) {
        let length = self.vector.x.abs() + self.vector.y.abs();
        if is_comfortable(length).all() {
            return;
        }
        // a copy, so that the vector need not lie in memory for the rare call
        let (mut carried, mut factor) = (*self, length);
        carried.divide(&mut factor, left);
        *self = carried;
        if let Some(area) = area {
            area.second.x = area.second.x * factor;
            area.second.y = area.second.y * factor;
        }
    }

    /// Divides by `length`, where that is called for; it becomes what was divided by.
    #[cold]
    #[inline(never)]
    fn divide(&mut self, length: &mut R, left: R) {
        *length = divisor(*length, left);
        let inverse = R::splat(1.0) / *length;
        self.vector = Vector {
            x: self.vector.x * inverse,
            y: self.vector.y * inverse,
        };
        self.log = self.log + length.ln();
    }

    /// Ends the period: the vector at length 1 in units of tau, and the logarithm of its growth. The inverse of the unit of
    /// time is given.
    #[inline(always)]
    pub fn close(&self, inverse_unit: R) -> (Vector<R>, R) {
        let y = self.vector.y * inverse_unit;
        let square = self.vector.x.mul_add(self.vector.x, y * y);
        // a vector of length 0 stays one, and what has overflowed shows
        let smallest = R::splat(SMALLEST_SQUARE);
        let square = R::select(square.less(smallest), smallest, square);
        let inverse = R::splat(1.0) / square.sqrt();
        let vector = Vector {
            x: self.vector.x * inverse,
            y: y * inverse,
        };
        (vector, R::splat(0.5).mul_add(square.ln(), self.log))
    }
}

/// The second vector, and the area that both have spanned since the period began.
#[derive(Clone, Copy, Debug)]
pub struct Area<R> {
    pub second: Vector<R>,
    product: R,
    /// Logarithm of what the product was divided by on the way.
    log: R,
}

impl<R: Real> Area<R> {
    /// With a second vector that spans the area 1 with the first.
    #[inline(always)]
    pub fn new(first: Vector<R>) -> Self {
        Self {
            second: across(first),
            product: R::splat(1.0),
            log: R::splat(0.0),
        }
    }

    /// Replaces the second vector, in lanes of which `left` is not 0, as [`Carried::settle`] does its work.
    #[inline(always)]
    pub fn renew(&mut self, first: Vector<R>, left: R) {
        let goes_on = R::splat(0.0).less(left);
        let across = across(first);
        let product = self.product * spanned(first, self.second);
        self.product = R::select(goes_on, product, self.product);
        self.second = Vector {
            x: R::select(goes_on, across.x, self.second.x),
            y: R::select(goes_on, across.y, self.second.y),
        };
        if !is_comfortable(self.product).all() {
            let mut area = *self;
            area.divide(left);
            *self = area;
        }
    }

    #[cold]
    #[inline(never)]
    fn divide(&mut self, left: R) {
        let divisor = divisor(self.product, left);
        self.product = self.product / divisor;
        self.log = self.log + divisor.ln();
    }

    /// The logarithm of the area that the vectors span at the period's end, over that at its beginning.
    #[inline(always)]
    pub fn close(&self, first: Vector<R>) -> R {
        let area = self.product * spanned(first, self.second);
        let smallest = R::splat(SMALLEST_SQUARE);
        self.log + R::select(area.less(smallest), smallest, area).ln()
    }
}

/// The area that two vectors span.
#[inline(always)]
fn spanned<R: Real>(first: Vector<R>, second: Vector<R>) -> R {
    first.x.mul_add(second.y, -(first.y * second.x))
}

/// The vector across `first` that spans the area 1 with it.
#[inline(always)]
fn across<R: Real>(first: Vector<R>) -> Vector<R> {
    let square = first.x.mul_add(first.x, first.y * first.y);
    let smallest = R::splat(SMALLEST_SQUARE);
    let inverse = R::splat(1.0) / R::select(square.less(smallest), smallest, square);
    Vector {
        x: -(first.y * inverse),
        y: first.x * inverse,
    }
}
