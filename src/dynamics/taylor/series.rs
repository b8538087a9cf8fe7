//! The Taylor series of the motion and of tangent vectors on one piece of the friction law.
//!
//! Owns the recurrences, written once for scalars, lanes and the shader's text; chooses no step and finds no event.
//!
//! The unit of time is U, the forcing period over [`UNITS_PER_PERIOD`], so that the drive's series has the same coefficients for
//! every omega_0. With w = U y, and all speeds multiplied by U, the motion on a piece is
//!
//! ```text
//! x' = w,   w' = U^2 (x - b x^3) + a_0 + a_1 v + a_2 v^2 + c v^3 - U eps h1 w,   v = U omega_k + U zeta_k sin z - w
//! ```
//!
//! The coefficients of its series follow from each other by convolutions. With q = v v, k = U^2 (1 - b x x) and
//! u = a_1 + a_2 v + c q they are
//!
//! ```text
//! (n+1) w[n+1] = (k x)[n] + (u v)[n] - U eps h1 w[n] + a_0 [n = 0],   (n+1) x[n+1] = w[n]
//! ```

use std::f64::consts::TAU;

use super::number::Number;
use crate::dynamics::tangent::Vector;
use crate::lanes::Real;

/// Units of time in a forcing period.
pub const UNITS_PER_PERIOD: u32 = 32;

/// The numbers at the start of a step from which the series of the motion is made; speeds are in units of 1/U.
#[derive(Clone, Copy, Debug)]
pub struct Local<T> {
    /// U^2.
    pub linear: T,
    /// -U^2 b.
    pub minus_b: T,
    /// -U eps h1.
    pub minus_damping: T,
    /// Coefficients of friction on the piece.
    pub a_0: T,
    pub a_1: T,
    pub a_2: T,
    pub cubic: T,
    /// U zeta_k sin z and U zeta_k cos z.
    pub drive: T,
    pub drive_slope: T,
    pub x: T,
    pub w: T,
    /// Sliding velocity.
    pub v: T,
}

/// Coefficients of a step's series, of order `L - 1`.
#[derive(Clone, Copy, Debug)]
pub struct Series<T, const L: usize> {
    pub x: [T; L],
    pub w: [T; L],
    pub v: [T; L],
    /// Derivatives of w' by x and by w, to order `L - 2`; the latter is the divergence.
    pub by_x: [T; L],
    pub by_w: [T; L],
}

/// Calls a method for every order below `L - 1`. The order is a constant in each call, so that the compiler unrolls every loop
/// over coefficients and keeps them in registers.
macro_rules! for_orders {
    ($L:ident, $target:ident.$method:ident $arguments:tt) => {
        for_orders!($L, $target.$method $arguments, 0 1 2 3 4 5 6 7 8 9 10 11);
    };
    ($L:ident, $target:ident.$method:ident $arguments:tt, $($n:literal)*) => {
        $(if $n + 1 < $L { $target.$method::<$n> $arguments; })*
    };
}

impl<T: Number, const L: usize> Series<T, L> {
    #[inline(always)]
    pub fn new(local: &Local<T>) -> Self {
        let zero = [T::constant(0.0); L];
        let mut series = Self {
            x: zero,
            w: zero,
            v: zero,
            by_x: zero,
            by_w: zero,
        };
        series.x[0] = local.x;
        series.w[0] = local.w;
        series.v[0] = local.v;
        let mut factors = series.begin(local);
        for_orders!(L, series.extend(local, &mut factors));
        series
    }

    /// Order 1 of the state, order 0 of the rest.
    #[inline(always)]
    fn begin(&mut self, local: &Local<T>) -> Factors<T, L> {
        let (x, v) = (self.x[0], self.v[0]);
        let mut stiffness = [T::constant(0.0); L];
        let mut friction = stiffness;
        let curved = local.a_2 * v;
        let bent = local.minus_b * x * x;
        let rough = local.cubic.fused(v * v, curved);
        self.by_x[0] = T::constant(3.0).fused(bent, local.linear);
        self.by_w[0] = T::constant(-3.0).fused(rough, curved) - local.a_1 + local.minus_damping;
        stiffness[0] = bent + local.linear;
        friction[0] = rough + local.a_1;
        let drive = drive_term(local, 1);
        let force = local.minus_damping.fused(self.w[0], local.a_0);
        let force = friction[0].fused(v, stiffness[0].fused(x, force));
        self.x[1] = self.w[0];
        self.w[1] = force;
        self.v[1] = drive - force;
        Factors {
            stiffness,
            friction,
            friction_by_v: (local.cubic + local.cubic).fused(v, local.a_2),
            drive,
        }
    }

    /// Order N + 1 of the state, order N of the rest; N = 0 is [`Series::begin`]'s.
    ///
    /// v[N] is known last and enters linearly, with the factor -by_w[0]. This includes the factor of -U eps h1 w[N], as w is the
    /// drive less v. All other terms are summed up before, so that an order waits for only two operations of the order before.
    #[inline(always)]
    fn extend<const N: usize>(&mut self, local: &Local<T>, factors: &mut Factors<T, L>) {
        if N == 0 {
            return;
        }
        let Factors {
            stiffness,
            friction,
            friction_by_v,
            drive,
        } = factors;
        let (x, v) = (self.x[N], self.v[N]);
        stiffness[N] = local.minus_b * inner_square::<T, L, N>(&self.x).add(self.x[0] + self.x[0], x).total();
        let mut force = Sum(None)
            .inner::<L, N>(stiffness, &self.x)
            .inner::<L, N>(friction, &self.v)
            .add(stiffness[0], x)
            .add(stiffness[N], self.x[0])
            .add(local.minus_damping, *drive);
        if let Some(square) = inner_square::<T, L, N>(&self.v).0 {
            let rough = local.cubic * square;
            force = force.add(rough, self.v[0]);
            friction[N] = friction_by_v.fused(v, rough);
        } else {
            friction[N] = *friction_by_v * v;
        }
        let force = force.add(-self.by_w[0], v).total();
        self.by_x[N] = T::constant(3.0) * stiffness[N];
        // dF/dv = d(u v)/dv = 3 u - a_2 v - 2 a_1, and a_1 is in order 0 only
        self.by_w[N] = T::constant(-3.0).fused(friction[N], local.a_2 * v);
        *drive = drive_term(local, N + 1);
        let inverse = 1.0 / (N as f64 + 1.0);
        self.x[N + 1] = T::constant(inverse) * self.w[N];
        self.w[N + 1] = T::constant(inverse) * force;
        self.v[N + 1] = T::constant(-inverse).fused(force, *drive);
    }

    #[inline(always)]
    pub fn x_at(&self, s: T) -> T {
        polynomial(&self.x, s)
    }

    #[inline(always)]
    pub fn w_at(&self, s: T) -> T {
        polynomial(&self.w, s)
    }

    #[inline(always)]
    pub fn v_at(&self, s: T) -> T {
        polynomial(&self.v, s)
    }

    /// dv/ds at s.
    #[inline(always)]
    pub fn v_slope_at(&self, s: T) -> T {
        let mut value = T::constant((L - 1) as f64) * self.v[L - 1];
        for n in (1..L - 1).rev() {
            value = value.fused(s, T::constant(n as f64) * self.v[n]);
        }
        value
    }

    /// The divergence integrated from 0 to s.
    #[inline(always)]
    pub fn divergence_to(&self, s: T) -> T {
        let mut value = T::constant(1.0 / (L - 1) as f64) * self.by_w[L - 2];
        for n in (0..L - 2).rev() {
            value = value.fused(s, T::constant(1.0 / (n as f64 + 1.0)) * self.by_w[n]);
        }
        value * s
    }

    /// The tangent vector (X, W) at s that is `start` at 0: X' = W, W' = by_x X + by_w W. Its y is W.
    #[inline(always)]
    pub fn vector_at(&self, start: Vector<T>, s: T) -> Vector<T> {
        let zero = [T::constant(0.0); L];
        let mut vector = VectorSeries { x: zero, w: zero };
        vector.x[0] = start.x;
        vector.w[0] = start.y;
        for_orders!(L, vector.extend(self));
        Vector {
            x: polynomial(&vector.x, s),
            y: polynomial(&vector.w, s),
        }
    }
}

/// Number of vectors whose series are computed side by side. With one, operations wait for each other; with three, the
/// coefficients no longer fit close to the registers.
const VECTORS_AT_ONCE: usize = 2;

impl<R: Real> Local<R> {
    #[inline(always)]
    fn half(&self, index: usize) -> Local<R::Half> {
        Local {
            linear: self.linear.half(index),
            minus_b: self.minus_b.half(index),
            minus_damping: self.minus_damping.half(index),
            a_0: self.a_0.half(index),
            a_1: self.a_1.half(index),
            a_2: self.a_2.half(index),
            cubic: self.cubic.half(index),
            drive: self.drive.half(index),
            drive_slope: self.drive_slope.half(index),
            x: self.x.half(index),
            w: self.w.half(index),
            v: self.v.half(index),
        }
    }
}

impl<R: Real> Vector<R> {
    #[inline(always)]
    fn half(self, index: usize) -> Vector<R::Half> {
        Vector {
            x: self.x.half(index),
            y: self.y.half(index),
        }
    }
}

impl<R: Real, const L: usize> Series<R, L> {
    /// [`Series::new`]; if there are many vectors, first for one half of them and then for the other.
    #[inline(always)]
    pub fn of(local: &Local<R>) -> Self {
        if R::VECTORS <= VECTORS_AT_ONCE {
            return Self::new(local);
        }
        let first = Series::of(&local.half(0));
        let second = Series::of(&local.half(1));
        Self {
            x: join(&first.x, &second.x),
            w: join(&first.w, &second.w),
            v: join(&first.v, &second.v),
            by_x: join(&first.by_x, &second.by_x),
            by_w: join(&first.by_w, &second.by_w),
        }
    }

    /// [`Series::vector_at`]; if there are many vectors, first for one half of them and then for the other.
    #[inline(always)]
    pub fn carried(&self, start: Vector<R>, s: R) -> Vector<R> {
        if R::VECTORS <= VECTORS_AT_ONCE {
            return self.vector_at(start, s);
        }
        let first = self.half(0).carried(start.half(0), s.half(0));
        let second = self.half(1).carried(start.half(1), s.half(1));
        Vector {
            x: R::join([first.x, second.x]),
            y: R::join([first.y, second.y]),
        }
    }

    #[inline(always)]
    fn half(&self, index: usize) -> Series<R::Half, L> {
        Series {
            x: half(&self.x, index),
            w: half(&self.w, index),
            v: half(&self.v, index),
            by_x: half(&self.by_x, index),
            by_w: half(&self.by_w, index),
        }
    }
}

/// Every coefficient in one half of the lanes.
#[inline(always)]
fn half<R: Real, const L: usize>(a: &[R; L], index: usize) -> [R::Half; L] {
    let mut halves = [a[0].half(index); L];
    for n in 1..L {
        halves[n] = a[n].half(index);
    }
    halves
}

/// Every coefficient from its halves.
#[inline(always)]
fn join<R: Real, const L: usize>(first: &[R::Half; L], second: &[R::Half; L]) -> [R; L] {
    let mut whole = [R::join([first[0], second[0]]); L];
    for n in 1..L {
        whole[n] = R::join([first[n], second[n]]);
    }
    whole
}

/// Auxiliary series from which the series of the motion is computed.
struct Factors<T, const L: usize> {
    /// k and u of the module's equations.
    stiffness: [T; L],
    friction: [T; L],
    /// d u[N]/d v[N], the same for every N above 0.
    friction_by_v: T,
    /// The latest term of the series of U zeta_k sin z.
    drive: T,
}

struct VectorSeries<T, const L: usize> {
    x: [T; L],
    w: [T; L],
}

impl<T: Number, const L: usize> VectorSeries<T, L> {
    #[inline(always)]
    fn extend<const N: usize>(&mut self, along: &Series<T, L>) {
        let inverse = T::constant(1.0 / (N as f64 + 1.0));
        let force = Sum(None)
            .inner::<L, N>(&along.by_x, &self.x)
            .inner::<L, N>(&along.by_w, &self.w)
            .outer::<L, N>(&along.by_x, &self.x)
            .outer::<L, N>(&along.by_w, &self.w)
            .total();
        self.x[N + 1] = inverse * self.w[N];
        self.w[N + 1] = inverse * force;
    }
}

/// The term of order n of U zeta_k sin(z + s TAU/UNITS_PER_PERIOD).
#[inline(always)]
fn drive_term<T: Number>(local: &Local<T>, n: usize) -> T {
    let mut factor = 1.0;
    for i in 1..=n {
        factor *= TAU / f64::from(UNITS_PER_PERIOD) / i as f64;
    }
    match n % 4 {
        0 => T::constant(factor) * local.drive,
        1 => T::constant(factor) * local.drive_slope,
        2 => T::constant(-factor) * local.drive,
        _ => T::constant(-factor) * local.drive_slope,
    }
}

/// sin z and cos z, both times any factor, after s more units of time.
#[inline(always)]
pub fn rotated<T: Number>(sin: T, cos: T, s: T) -> (T, T) {
    // orders 1 to 9 of sin and of 1 - cos; the latter is small, so that the sums below are rounded only once
    let mut terms = [T::constant(0.0); 10];
    let mut factor = -1.0;
    for (n, term) in terms.iter_mut().enumerate().skip(1) {
        factor *= TAU / f64::from(UNITS_PER_PERIOD) / n as f64;
        if n % 2 == 1 {
            factor = -factor;
        }
        *term = T::constant(factor);
    }
    let square = s * s;
    let sine = every_second(&terms, 9, square) * s;
    let versine = every_second(&terms, 8, square);
    (
        sin + cos.fused(sine, -(sin * versine)),
        cos - sin.fused(sine, cos * versine),
    )
}

/// A growing sum of products; None as long as it has no term.
///
/// The term of order N of a product of two series a and b has two parts: the outer part is the products with a[N] and b[N], the
/// inner part is all others.
struct Sum<T>(Option<T>);

impl<T: Number> Sum<T> {
    #[inline(always)]
    fn add(self, a: T, b: T) -> Self {
        Self(Some(match self.0 {
            Some(sum) => a.fused(b, sum),
            None => a * b,
        }))
    }

    #[inline(always)]
    fn inner<const L: usize, const N: usize>(mut self, a: &[T; L], b: &[T; L]) -> Self {
        for i in 1..N {
            self = self.add(a[i], b[N - i]);
        }
        self
    }

    #[inline(always)]
    fn outer<const L: usize, const N: usize>(mut self, a: &[T; L], b: &[T; L]) -> Self {
        if N > 0 {
            self = self.add(a[0], b[N]);
        }
        self.add(a[N], b[0])
    }

    #[inline(always)]
    fn total(self) -> T {
        match self.0 {
            Some(sum) => sum,
            None => T::constant(0.0),
        }
    }
}

/// The term of order N of the square of a series, without the products with a[N]; None for N below 2.
#[inline(always)]
fn inner_square<T: Number, const L: usize, const N: usize>(a: &[T; L]) -> Sum<T> {
    let mut half = Sum(None);
    for i in 1..N.div_ceil(2) {
        half = half.add(a[i], a[N - i]);
    }
    let whole = Sum(half.0.map(|half| half + half));
    if N.is_multiple_of(2) {
        whole.add(a[N / 2], a[N / 2])
    } else {
        whole
    }
}

/// The polynomial at s. Horner's rule in s^2 gives its even and its odd part; so only half as many operations wait for each other
/// as in Horner's rule for the whole.
#[inline(always)]
fn polynomial<T: Number, const L: usize>(a: &[T; L], s: T) -> T {
    let square = s * s;
    let (last, other) = (every_second(a, L - 1, square), every_second(a, L - 2, square));
    let (even, odd) = if L % 2 == 1 { (last, other) } else { (other, last) };
    odd.fused(s, even)
}

/// The polynomial in s^2, given as `square`, whose coefficients are every second one of `a`, from order `top` down.
#[inline(always)]
fn every_second<T: Number, const L: usize>(a: &[T; L], top: usize, square: T) -> T {
    let mut value = a[top];
    let mut n = top;
    while n >= 2 {
        n -= 2;
        value = value.fused(square, a[n]);
    }
    value
}
