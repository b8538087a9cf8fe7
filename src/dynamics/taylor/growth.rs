//! The growth of tangent vectors over a forcing period.
//!
//! Owns how the second vector stays apart from the first, and the logarithms of both; steps nothing. Twin:
//! `shaders/dynamics/taylor/growth.wgsl`.
//!
//! Of the second vector only the area matters that it spans with the first. From time to time it is replaced by the
//! vector across the first that spans the area 1, and the area it had spanned goes into a product: no root, no logarithm,
//! and the sum of the exponents comes from the vectors alone, for the mean divergence to be held against.

use crate::dynamics::tangent::{Growth, SMALLEST_SQUARE, Vector};
use crate::lanes::Real;

/// Steps between two renewals of the second vector: few enough for it to keep half of f32's digits in the layer, where it
/// turns towards the first fastest.
pub const RENEWAL_STEPS: u32 = 8;

/// The second vector, and the area that both have spanned since the period began.
#[derive(Clone, Copy, Debug)]
pub struct Area<R> {
    pub second: Vector<R>,
    product: R,
}

impl<R: Real> Area<R> {
    /// With a second vector that spans the area 1 with the first.
    #[inline(always)]
    pub fn new(first: Vector<R>) -> Self {
        Self {
            second: across(first),
            product: R::splat(1.0),
        }
    }

    /// Replaces the second vector, in lanes of which `left` is not 0: those at their period's end must not feel how many
    /// steps their neighbours still take.
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
    }

    /// Ends the period: the first vector at length 1, and the logarithms of both vectors' growth. Vectors have speeds in
    /// units of time, whose inverse is given, and the first had length 1 in units of tau when the period began.
    #[inline(always)]
    pub fn close(&self, first: Vector<R>, inverse_unit: R) -> (Vector<R>, Growth<R>) {
        let area = self.product * spanned(first, self.second);
        let smallest = R::splat(SMALLEST_SQUARE);
        let area = R::select(area.less(smallest), smallest, area);
        let (vector, growth) = close_first(first, inverse_unit);
        let second = area.ln() - growth;
        (vector, Growth { first: growth, second })
    }
}

/// The first vector at length 1 at the end of a period, and the logarithm of its growth.
#[inline(always)]
pub fn close_first<R: Real>(first: Vector<R>, inverse_unit: R) -> (Vector<R>, R) {
    let y = first.y * inverse_unit;
    let square = first.x.mul_add(first.x, y * y);
    // what has shrunk below the smallest number is taken as that small; what has overflowed shows
    let smallest = R::splat(SMALLEST_SQUARE);
    let square = R::select(square.less(smallest), smallest, square);
    let inverse = R::splat(1.0) / square.sqrt();
    let vector = Vector {
        x: first.x * inverse,
        y: y * inverse,
    };
    (vector, R::splat(0.5) * square.ln())
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
