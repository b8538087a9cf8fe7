//! The classical Runge-Kutta scheme of order 4 with a fixed step, written for x'' = f in Nystrom's form.
//!
//! Owns one step of the motion, with or without tangent vectors; the drive's clock is [`super::drive`]'s. Twin:
//! `shaders/dynamics/rk4.wgsl`.

use super::tangent::{Bases, Vector};
use crate::lanes::Real;
use crate::model::motion::Motion;

/// Angle and angular speed of the bush.
#[derive(Clone, Copy, Debug)]
pub struct State<R> {
    pub x: R,
    pub y: R,
}

/// Multiples of the step size h that the scheme uses.
#[derive(Clone, Copy, Debug)]
pub struct StepSize<R> {
    half: R,
    quarter_square: R,
    whole: R,
    half_square: R,
    sixth_square: R,
    sixth: R,
}

/// Shaft speed at the start, the middle and the end of a step.
#[derive(Clone, Copy, Debug)]
pub struct StageSpeeds<R> {
    pub start: R,
    pub middle: R,
    pub end: R,
}

impl<R: Real> StepSize<R> {
    /// `h` in units of tau, in each lane.
    pub fn new(h: impl Fn(usize) -> f64) -> Self {
        let multiple = |f: fn(f64) -> f64| R::from_lanes(|lane| f(h(lane)));
        Self {
            half: multiple(|h| h / 2.0),
            quarter_square: multiple(|h| h * h / 4.0),
            whole: multiple(|h| h),
            half_square: multiple(|h| h * h / 2.0),
            sixth_square: multiple(|h| h * h / 6.0),
            sixth: multiple(|h| h / 6.0),
        }
    }

    /// Angle at the second stage, or a vector's x component there.
    #[inline(always)]
    fn x2(&self, x: R, y: R) -> R {
        y.mul_add(self.half, x)
    }
    #[inline(always)]
    fn x3(&self, x2: R, k1: R) -> R {
        k1.mul_add(self.quarter_square, x2)
    }
    #[inline(always)]
    fn x4(&self, x: R, y: R, k2: R) -> R {
        k2.mul_add(self.half_square, y.mul_add(self.whole, x))
    }
    #[inline(always)]
    fn x_end(&self, x: R, y: R, k1: R, k2: R, k3: R) -> R {
        (k1 + k2 + k3).mul_add(self.sixth_square, y.mul_add(self.whole, x))
    }
    /// Simpson's weights: h (k1 + 2 k2 + 2 k3 + k4)/6 added to `y`.
    #[inline(always)]
    fn y_end(&self, y: R, k1: R, k2: R, k3: R, k4: R) -> R {
        R::splat(2.0).mul_add(k2 + k3, k1 + k4).mul_add(self.sixth, y)
    }
}

/// One step of the motion.
#[inline(always)]
pub fn step<R: Real>(motion: &Motion<R>, h: &StepSize<R>, speed: StageSpeeds<R>, state: State<R>) -> State<R> {
    let State { x, y } = state;
    let k1 = motion.acceleration(x, y, speed.start);
    let x2 = h.x2(x, y);
    let k2 = motion.acceleration(x2, k1.mul_add(h.half, y), speed.middle);
    let k3 = motion.acceleration(h.x3(x2, k1), k2.mul_add(h.half, y), speed.middle);
    let k4 = motion.acceleration(h.x4(x, y, k2), k3.mul_add(h.whole, y), speed.end);
    State {
        x: h.x_end(x, y, k1, k2, k3),
        y: h.y_end(y, k1, k2, k3, k4),
    }
}

/// One step of the motion and of the tangent vectors (3.3) along it; also the divergence integrated over the step.
#[inline(always)]
pub fn step_with_tangent<R: Real>(
    motion: &Motion<R>,
    h: &StepSize<R>,
    speed: StageSpeeds<R>,
    state: State<R>,
    bases: Bases<R>,
) -> (State<R>, Bases<R>, R) {
    let State { x, y } = state;
    let Bases { first, second } = bases;

    // every stage is used up as soon as it is known, so that little has to be held in registers
    let f1 = motion.linearised(x, y, speed.start);
    let (a1, b1) = (first.rate(&f1), second.rate(&f1));
    let x2 = h.x2(x, y);
    let first_2 = Vector {
        x: h.x2(first.x, first.y),
        y: a1.mul_add(h.half, first.y),
    };
    let second_2 = Vector {
        x: h.x2(second.x, second.y),
        y: b1.mul_add(h.half, second.y),
    };

    let f2 = motion.linearised(x2, f1.acceleration.mul_add(h.half, y), speed.middle);
    let (a2, b2) = (first_2.rate(&f2), second_2.rate(&f2));
    let x3 = h.x3(x2, f1.acceleration);
    let first_3 = Vector {
        x: h.x3(first_2.x, a1),
        y: a2.mul_add(h.half, first.y),
    };
    let second_3 = Vector {
        x: h.x3(second_2.x, b1),
        y: b2.mul_add(h.half, second.y),
    };

    let f3 = motion.linearised(x3, f2.acceleration.mul_add(h.half, y), speed.middle);
    let (a3, b3) = (first_3.rate(&f3), second_3.rate(&f3));
    let x4 = h.x4(x, y, f2.acceleration);
    let first_4 = Vector {
        x: h.x4(first.x, first.y, a2),
        y: a3.mul_add(h.whole, first.y),
    };
    let second_4 = Vector {
        x: h.x4(second.x, second.y, b2),
        y: b3.mul_add(h.whole, second.y),
    };

    let f4 = motion.linearised(x4, f3.acceleration.mul_add(h.whole, y), speed.end);
    let (a4, b4) = (first_4.rate(&f4), second_4.rate(&f4));
    let (k1, k2, k3, k4) = (f1.acceleration, f2.acceleration, f3.acceleration, f4.acceleration);
    let end = State {
        x: h.x_end(x, y, k1, k2, k3),
        y: h.y_end(y, k1, k2, k3, k4),
    };
    let bases = Bases {
        first: Vector {
            x: h.x_end(first.x, first.y, a1, a2, a3),
            y: h.y_end(first.y, a1, a2, a3, a4),
        },
        second: Vector {
            x: h.x_end(second.x, second.y, b1, b2, b3),
            y: h.y_end(second.y, b1, b2, b3, b4),
        },
    };
    let divergence = h.y_end(R::splat(0.0), f1.by_y, f2.by_y, f3.by_y, f4.by_y);
    (end, bases, divergence)
}
