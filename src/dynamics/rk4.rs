//! The classical Runge-Kutta scheme of order 4 with a fixed step, written for x'' = f in Nystrom's form.
//!
//! Owns one step of the motion, with or without tangent vectors; the drive's clock is [`super::drive`]'s. Twin:
//! `shaders/dynamics/rk4.wgsl`.

use super::tangent::Vector;
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

impl<R: Real> StageSpeeds<R> {
    /// The shaft speeds less the speed of the bush at the start of the step.
    #[inline(always)]
    fn less(&self, y: R) -> Self {
        Self {
            start: self.start - y,
            middle: self.middle - y,
            end: self.end - y,
        }
    }
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
    let v = speed.less(y);
    let k1 = motion.acceleration(x, v.start, speed.start);
    let x2 = h.x2(x, y);
    let k2 = motion.acceleration(x2, k1.mul_add(-h.half, v.middle), speed.middle);
    let k3 = motion.acceleration(h.x3(x2, k1), k2.mul_add(-h.half, v.middle), speed.middle);
    let k4 = motion.acceleration(h.x4(x, y, k2), k3.mul_add(-h.whole, v.end), speed.end);
    State {
        x: h.x_end(x, y, k1, k2, k3),
        y: h.y_end(y, k1, k2, k3, k4),
    }
}

/// One step of the motion and of tangent vectors (3.3) along it; also the divergence integrated over the step.
#[allow(
    clippy::needless_range_loop,
    reason = "arrays are walked side by side; a closure would not inherit the caller's instruction set"
)]
#[inline(always)]
pub fn step_with_tangent<R: Real, const N: usize>(
    motion: &Motion<R>,
    h: &StepSize<R>,
    speed: StageSpeeds<R>,
    state: State<R>,
    vectors: [Vector<R>; N],
) -> (State<R>, [Vector<R>; N], R) {
    let State { x, y } = state;
    let [mut a1, mut a2, mut a3] = [[R::splat(0.0); N]; 3];
    let (mut at, mut end) = (vectors, vectors);

    // every stage is used as soon as it is known, so that few numbers have to be kept in registers
    let v = speed.less(y);
    let f1 = motion.linearised(x, v.start, speed.start);
    let x2 = h.x2(x, y);
    for n in 0..N {
        a1[n] = vectors[n].rate(&f1);
        at[n].x = h.x2(vectors[n].x, vectors[n].y);
        at[n].y = a1[n].mul_add(h.half, vectors[n].y);
    }
    let f2 = motion.linearised(x2, f1.acceleration.mul_add(-h.half, v.middle), speed.middle);
    let x3 = h.x3(x2, f1.acceleration);
    for n in 0..N {
        a2[n] = at[n].rate(&f2);
        at[n].x = h.x3(at[n].x, a1[n]);
        at[n].y = a2[n].mul_add(h.half, vectors[n].y);
    }
    let f3 = motion.linearised(x3, f2.acceleration.mul_add(-h.half, v.middle), speed.middle);
    let x4 = h.x4(x, y, f2.acceleration);
    for n in 0..N {
        a3[n] = at[n].rate(&f3);
        at[n].x = h.x4(vectors[n].x, vectors[n].y, a2[n]);
        at[n].y = a3[n].mul_add(h.whole, vectors[n].y);
    }
    let f4 = motion.linearised(x4, f3.acceleration.mul_add(-h.whole, v.end), speed.end);
    for n in 0..N {
        let a4 = at[n].rate(&f4);
        end[n].x = h.x_end(vectors[n].x, vectors[n].y, a1[n], a2[n], a3[n]);
        end[n].y = h.y_end(vectors[n].y, a1[n], a2[n], a3[n], a4);
    }
    let (k1, k2, k3, k4) = (f1.acceleration, f2.acceleration, f3.acceleration, f4.acceleration);
    let state = State {
        x: h.x_end(x, y, k1, k2, k3),
        y: h.y_end(y, k1, k2, k3, k4),
    };
    let divergence = h.y_end(R::splat(0.0), f1.by_y, f2.by_y, f3.by_y, f4.by_y);
    (state, end, divergence)
}
