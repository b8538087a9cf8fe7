//! Tangent vectors of the (x, y) block, their orthonormalisation and growth, equations (3.5) and (3.6).
//!
//! Owns the bases and the sums of logarithms; the stepping of vectors is the scheme's. The third vector of the paper,
//! along the flow, never mixes into the first two (their z component stays 0), so that two suffice. Twin:
//! `shaders/dynamics/tangent.wgsl`.

use crate::lanes::Real;
use crate::model::motion::Linearised;

/// A tangent vector (X, Y), with Z = 0.
#[derive(Clone, Copy, Debug)]
pub struct Vector<R> {
    pub x: R,
    pub y: R,
}

/// The two tangent vectors that are carried along.
#[derive(Clone, Copy, Debug)]
pub struct Bases<R> {
    pub first: Vector<R>,
    pub second: Vector<R>,
}

/// Logarithms of the two vectors' growth.
#[derive(Clone, Copy, Debug)]
pub struct Growth<R> {
    pub first: R,
    pub second: R,
}

impl<R: Real> Bases<R> {
    /// The paper's start: (1, 0) and (0, 1).
    pub fn start() -> Self {
        Self::along(Vector {
            x: R::splat(1.0),
            y: R::splat(0.0),
        })
    }

    /// A vector of length 1, and the one perpendicular to it.
    pub fn along(first: Vector<R>) -> Self {
        let second = Vector {
            x: -first.y,
            y: first.x,
        };
        Self { first, second }
    }

    /// Orthonormalises by Gram and Schmidt (3.5); returns the norms' logarithms, the summands of (3.6).
    #[inline(always)]
    pub fn orthonormalise(&mut self) -> Growth<R> {
        let (first, first_norm) = self.first.normalised();
        let along = self.second.x.mul_add(first.x, self.second.y * first.y);
        let rest = Vector {
            x: self.second.x - along * first.x,
            y: self.second.y - along * first.y,
        };
        let (second, second_norm) = rest.normalised();
        *self = Self { first, second };
        Growth {
            first: first_norm.ln(),
            second: second_norm.ln(),
        }
    }
}

impl<R: Real> Vector<R> {
    /// The vector with (X, Y) in each lane.
    pub fn from_lanes(vector: impl Fn(usize) -> [f64; 2]) -> Self {
        Self {
            x: R::from_lanes(|lane| vector(lane)[0]),
            y: R::from_lanes(|lane| vector(lane)[1]),
        }
    }

    /// (X, Y) of a lane.
    pub fn lane(self, lane: usize) -> [f64; 2] {
        [self.x.lane(lane), self.y.lane(lane)]
    }

    /// Y', the second row of (3.3); X' is Y.
    #[inline(always)]
    pub fn rate(self, motion: &Linearised<R>) -> R {
        self.x.mul_add(motion.by_x, motion.by_y * self.y)
    }

    /// The vector at length 1, and its length.
    #[inline(always)]
    pub fn normalised(self) -> (Self, R) {
        // a vector that has shrunk below the smallest norm keeps no direction, and has this norm; one that has overflowed stays
        // NaN or infinite, so that the overflow is visible
        let (square, smallest) = (self.x.mul_add(self.x, self.y * self.y), R::splat(SMALLEST_SQUARE));
        let square = R::select(square.less(smallest), smallest, square);
        let norm = square.sqrt();
        let inverse = R::splat(1.0) / norm;
        (
            Self {
                x: self.x * inverse,
                y: self.y * inverse,
            },
            norm,
        )
    }
}

/// A length or an area above this, or below its inverse, is set to 1, and its logarithm is kept. Until the next check, its square
/// then stays within the range of f32.
pub const COMFORTABLE: f64 = 1e8;

/// Smallest squared norm, in the range of f32's normal numbers.
pub const SMALLEST_SQUARE: f64 = 1e-36;
