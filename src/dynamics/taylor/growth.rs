//! The growth of tangent vectors over a forcing period.
//!
//! Owns how the second vector is kept apart from the first, and the logarithms of both; takes no steps. Twin:
//! `shaders/dynamics/taylor/growth.wgsl`.
//!
//! Only the area matters that the second vector spans with the first. From time to time the second vector is replaced by the one
//! perpendicular to the first that spans the area 1, and the old area is multiplied into a product. This needs no root and no
//! logarithm. The sum of the exponents then comes from the vectors alone, so that it can be compared with the mean divergence.

use crate::dynamics::tangent::{COMFORTABLE, SMALLEST_SQUARE, Vector};
use crate::lanes::{Mask, Real};

/// Steps between two renewals of the second vector. They are few enough for it to keep half of f32's digits in the layer, where
/// it turns towards the first fastest. Lengths are checked for overflow and underflow as often.
pub const RENEWAL_STEPS: u32 = 8;

#[inline(always)]
fn is_comfortable<R: Real>(value: R) -> R::Mask {
    R::splat(1.0 / COMFORTABLE)
        .less(value)
        .and(value.less(R::splat(COMFORTABLE)))
}

/// The divisor for a length, or an area, that is not between 1/[`COMFORTABLE`] and [`COMFORTABLE`]. It is 1 in lanes whose period
/// is over, and where the value is 0, infinite or NaN.
fn divisor<R: Real>(value: R, left: R) -> R {
    let one = R::splat(1.0);
    let is_number = R::splat(0.0).less(value).and(value.less(R::splat(LARGEST)));
    let divided = R::select(is_number, value, one);
    let divided = R::select(R::splat(0.0).less(left), divided, one);
    R::select(is_comfortable(value), one, divided)
}

/// Lengths and areas above this count as infinite. It is less than the largest f32.
pub(super) const LARGEST: f64 = 1e38;

/// A tangent vector within a forcing period. Its speed is measured per unit of time of the instance; at the period's start it had
/// the length 1 with speeds per unit of tau.
#[derive(Clone, Copy, Debug)]
pub struct Carried<R> {
    pub vector: Vector<R>,
    /// Logarithm of the product of all divisors of its length in this period.
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

    /// Brings the vector to a length of about 1 if its length is far from 1, in lanes whose `left` is not 0. In lanes at their
    /// period's end the result must not depend on the number of steps that other lanes still take. The area that the vector spans
    /// with the second one stays the same.
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

    /// Divides the vector by `length` where this is necessary. On return, `length` is the divisor that was used.
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

    /// Ends the period: the vector at length 1, with its speed per unit of tau, and the logarithm of its growth. `inverse_unit`
    /// is the inverse of the unit of time.
    #[inline(always)]
    pub fn close(&self, inverse_unit: R) -> (Vector<R>, R) {
        let y = self.vector.y * inverse_unit;
        let square = self.vector.x.mul_add(self.vector.x, y * y);
        // a vector of length 0 stays 0, and an overflow remains visible as infinity or NaN
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

/// The second vector, and the product of the areas that both have spanned at its renewals since the period began.
#[derive(Clone, Copy, Debug)]
pub struct Area<R> {
    pub second: Vector<R>,
    product: R,
    /// Logarithm of the product of all divisors of `product` in this period.
    log: R,
}

impl<R: Real> Area<R> {
    /// The area at a period's start: the second vector spans the area 1 with the first.
    #[inline(always)]
    pub fn new(first: Vector<R>) -> Self {
        Self {
            second: across(first),
            product: R::splat(1.0),
            log: R::splat(0.0),
        }
    }

    /// Replaces the second vector in lanes whose `left` is not 0, for the same reason as in [`Carried::settle`].
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

    /// The logarithm of the ratio of the areas that the vectors span at the period's end and at its beginning.
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

/// The vector perpendicular to `first` that spans the area 1 with it.
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
