//! Every sign change of the sliding velocity along the homoclinic orbit.
//!
//! Owns their isolation and refinement; does not know their use.
//!
//! An interval is discarded if a Lipschitz bound excludes a root. It is searched if the Lipschitz bound of the derivative proves
//! that the function is monotone on it. Else it is halved. So no pair of roots is missed, however close its two roots are. Near a
//! tangential root the number of intervals kept at each size stays bounded.

use super::{END, Melnikov};

/// Intervals are not halved below this width. A sign change that is left in one is taken near its middle.
const NARROWEST: f64 = 1e-13;

/// Bounds of |y0'| and |y0''| along the homoclinic orbit with amplitude 1: sech t |1 - 2 sech^2 t| and
/// sech t |tanh t| |1 - 6 sech^2 t|; the latter has its maximum, 1.53, near t = 0.5.
const GREATEST_ACCELERATION: f64 = 1.0;
const GREATEST_JERK: f64 = 1.6;

/// Calls `found(t, upward)` for every sign change of w with |t| < 40.
pub fn for_each_crossing(function: &Melnikov, tau_0: f64, found: &mut impl FnMut(f64, bool)) {
    let drive = function.zeta_k * function.omega_0;
    let search = Search {
        function,
        tau_0,
        slope_bound: drive + GREATEST_ACCELERATION * function.amplitude,
        curvature_bound: drive * function.omega_0 + GREATEST_JERK * function.amplitude,
    };
    // intervals of a quarter of the drive's period, or of the orbit's swing if the drive is slow
    let count = (2.0 * END * (function.omega_0 / 1.5).max(2.0)).ceil() as u32;
    let bound = |k: u32| END * (2.0 * f64::from(k) / f64::from(count) - 1.0);
    let mut low = Point::new(&search, bound(0));
    for k in 1..=count {
        let high = Point::new(&search, bound(k));
        search.within(low, high, found);
        low = high;
    }
}

struct Search<'a> {
    function: &'a Melnikov,
    tau_0: f64,
    slope_bound: f64,
    curvature_bound: f64,
}

/// A time with w and w' there.
#[derive(Clone, Copy)]
struct Point {
    t: f64,
    value: f64,
    rate: f64,
}

impl Point {
    fn new(search: &Search<'_>, t: f64) -> Self {
        let [value, rate] = search.function.sliding_and_rate(t, search.tau_0);
        Self { t, value, rate }
    }

    fn is_up(&self) -> bool {
        self.value >= 0.0
    }
}

impl Search<'_> {
    /// Calls `found` for the crossings between two points.
    fn within(&self, low: Point, high: Point, found: &mut impl FnMut(f64, bool)) {
        let width = high.t - low.t;
        let changes = low.is_up() != high.is_up();
        // a root at t would need |w(low)| <= bound (t - low) and |w(high)| <= bound (high - t)
        if !changes && low.value.abs() + high.value.abs() > self.slope_bound * width {
            return;
        }
        // a zero of w' would need the same of w'
        let is_monotone = low.rate * high.rate > 0.0 && low.rate.abs() + high.rate.abs() > self.curvature_bound * width;
        if is_monotone || width < NARROWEST {
            if changes {
                found(self.refined(low, high), high.is_up());
            }
            return;
        }
        let middle = Point::new(self, 0.5 * (low.t + high.t));
        self.within(low, middle, found);
        self.within(middle, high, found);
    }

    /// The one root between two points of different sign: by Newton's method, with bisection where a step leaves the bracket.
    fn refined(&self, mut low: Point, mut high: Point) -> f64 {
        let mut t = 0.5 * (low.t + high.t);
        for _ in 0..100 {
            let point = Point::new(self, t);
            if point.is_up() == low.is_up() {
                low = point;
            } else {
                high = point;
            }
            let newton = t - point.value / point.rate;
            // written so that NaN leads to bisection
            let next = if newton > low.t && newton < high.t {
                newton
            } else {
                0.5 * (low.t + high.t)
            };
            if (next - t).abs() < 1e-15 * (1.0 + t.abs()) || high.t - low.t < NARROWEST {
                return next;
            }
            t = next;
        }
        t
    }
}
