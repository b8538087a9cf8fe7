//! The reference integrator: slow, simple, and exact to rounding almost everywhere.
//!
//! Owns the solution that accuracy is measured against: extrapolated midpoint steps (Gragg, Bulirsch, Stoer) of order 10. They
//! end where v crosses a boundary of the friction layer, located to rounding. The code shares neither the friction law nor the
//! steps of the fast schemes, because it checks them.

use crate::parameters::{Parameter, ParameterSet};

/// Steps of a forcing period, besides those that end at boundaries.
const STEPS_PER_PERIOD: u32 = 160;

/// Numbers of midpoint substeps whose results are extrapolated. The order is twice the number of entries.
const SUBSTEPS: [u32; 5] = [2, 4, 6, 8, 10];

/// x, y, the tangent vector (X, Y), the logarithm of its growth so far, and the integrated divergence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reference {
    pub x: f64,
    pub y: f64,
    pub vector: [f64; 2],
    pub growth: f64,
    pub divergence: f64,
    pub x_min: f64,
    pub x_max: f64,
}

/// An orbit of one instance.
#[derive(Clone, Debug)]
pub struct ReferenceOrbit {
    parameters: ParameterSet,
    state: Reference,
    /// Where v lies: its sign, and whether it is within the layer.
    side: f64,
    is_in_layer: bool,
}

/// What is integrated: x, y, X, Y, and the divergence.
type Vector = [f64; 5];

impl ReferenceOrbit {
    /// The orbit at the beginning of its run, with the tangent vector (1, 0).
    pub fn new(parameters: &ParameterSet) -> Self {
        let [x, y] = parameters.initial_state();
        let v = parameters[Parameter::OmegaK] - y;
        Self {
            parameters: *parameters,
            state: Reference {
                x,
                y,
                vector: [1.0, 0.0],
                growth: 0.0,
                divergence: 0.0,
                x_min: x,
                x_max: x,
            },
            side: if v < 0.0 { -1.0 } else { 1.0 },
            is_in_layer: v.abs() < parameters[Parameter::Epsilon0],
        }
    }

    pub fn state(&self) -> &Reference {
        &self.state
    }

    /// Carries the orbit over one forcing period.
    pub fn period(&mut self) {
        let period = self.parameters.forcing_period();
        let whole = period / f64::from(STEPS_PER_PERIOD);
        let s = &self.state;
        let mut at: Vector = [s.x, s.y, s.vector[0], s.vector[1], s.divergence];
        let mut tau = 0.0;
        while tau < period {
            let rest = period - tau;
            let h = if rest < 1.5 * whole { rest } else { whole };
            let (h, end, event) = self.step(tau, h, &at);
            self.note_extremes(&at, &end, h, tau);
            at = end;
            if let Some((side, is_in_layer)) = event {
                (self.side, self.is_in_layer) = (side, is_in_layer);
            }
            // the last step ends on the period, whatever rounding says
            tau = if h == rest { period } else { tau + h };
        }
        let norm = at[2].hypot(at[3]);
        self.state = Reference {
            x: at[0],
            y: at[1],
            vector: [at[2] / norm, at[3] / norm],
            growth: self.state.growth + norm.ln(),
            divergence: at[4],
            ..self.state
        };
    }

    /// One step of at most `h`: its length, its end, and the piece that begins there if a boundary was met.
    fn step(&self, tau: f64, h: f64, at: &Vector) -> (f64, Vector, Option<(f64, bool)>) {
        // in the layer, steps are short enough for its decay rate
        let p = &self.parameters;
        let rate = 2.0 * p[Parameter::Epsilon] * p[Parameter::F0] / p[Parameter::Epsilon0];
        let mut h = if self.is_in_layer { h.min(0.4 / rate) } else { h };
        let mut end = self.extrapolated(tau, h, at);
        // a step may leave the piece and come back: the cubic through both ends shows this
        for part in [0.25, 0.5, 0.75] {
            if self.boundary_beyond(self.between(tau, h, at, &end, part)).is_some() {
                h *= part;
                end = self.extrapolated(tau, h, at);
                break;
            }
        }
        let Some(boundary) = self.boundary_beyond(self.sliding_speed(tau + h, &end)) else {
            return (h, end, None);
        };
        let distance = |s: f64| {
            let end = if s > 0.0 { self.extrapolated(tau, s, at) } else { *at };
            self.sliding_speed(tau + s, &end) - boundary
        };
        let s = root(distance, h);
        // a step of length 0 would leave a start on the boundary there
        let s = s.max(1e-12);
        let end = self.extrapolated(tau, s, at);
        (s, end, Some(self.beyond(boundary)))
    }

    /// The piece on the other side of a boundary of the present one.
    fn beyond(&self, boundary: f64) -> (f64, bool) {
        if boundary == 0.0 {
            (-self.side, true)
        } else {
            (self.side, !self.is_in_layer)
        }
    }

    /// The boundary that v lies beyond, if it is outside the present piece.
    fn boundary_beyond(&self, v: f64) -> Option<f64> {
        let epsilon_0 = self.parameters[Parameter::Epsilon0];
        let along = self.side * v;
        if self.is_in_layer {
            if along < 0.0 {
                Some(0.0)
            } else {
                (along > epsilon_0).then_some(self.side * epsilon_0)
            }
        } else {
            (along < epsilon_0).then_some(self.side * epsilon_0)
        }
    }

    fn sliding_speed(&self, tau: f64, at: &Vector) -> f64 {
        let p = &self.parameters;
        p[Parameter::OmegaK] + p[Parameter::ZetaK] * (p[Parameter::Omega0] * tau).sin() - at[1]
    }

    /// v after a part of the step, by Hermite's cubic.
    fn between(&self, tau: f64, h: f64, at: &Vector, end: &Vector, part: f64) -> f64 {
        let p = &self.parameters;
        let slope = |tau: f64, at: &Vector| {
            let shaft = p[Parameter::ZetaK] * p[Parameter::Omega0] * (p[Parameter::Omega0] * tau).cos();
            shaft - self.slope(tau, at)[1]
        };
        let (v_0, v_1) = (self.sliding_speed(tau, at), self.sliding_speed(tau + h, end));
        let (d_0, d_1) = (h * slope(tau, at), h * slope(tau + h, end));
        let t = part;
        (1.0 + 2.0 * t) * (1.0 - t).powi(2) * v_0
            + t * (1.0 - t).powi(2) * d_0
            + t * t * (3.0 - 2.0 * t) * v_1
            + t * t * (t - 1.0) * d_1
    }

    /// Right-hand sides of equations (3.2) and (3.3) with the friction law of the present piece, even if v is outside of it.
    fn slope(&self, tau: f64, &[x, y, vector_x, vector_y, _]: &Vector) -> Vector {
        let p = &self.parameters;
        let (epsilon, epsilon_0) = (p[Parameter::Epsilon], p[Parameter::Epsilon0]);
        let v = self.sliding_speed(tau, &[x, y, 0.0, 0.0, 0.0]);
        let (sign, sign_slope) = if self.is_in_layer {
            let u = v / epsilon_0;
            ((2.0 - self.side * u) * u, (2.0 - 2.0 * self.side * u) / epsilon_0)
        } else {
            (self.side, 0.0)
        };
        let force = p[Parameter::F0] * sign - p[Parameter::Alpha] * v + p[Parameter::Beta] * v.powi(3);
        let force_slope = p[Parameter::F0] * sign_slope - p[Parameter::Alpha] + 3.0 * p[Parameter::Beta] * v * v;
        let by_x = 1.0 - 3.0 * p[Parameter::B] * x * x;
        let by_y = -epsilon * force_slope - epsilon * p[Parameter::H1];
        [
            y,
            x - p[Parameter::B] * x.powi(3) + epsilon * force - epsilon * p[Parameter::H1] * y,
            vector_y,
            by_x * vector_x + by_y * vector_y,
            by_y,
        ]
    }

    /// The state `h` after `at`: modified midpoint rules, extrapolated to substeps of length 0 (Hairer, Norsett and Wanner,
    /// Solving Ordinary Differential Equations I, section II.9).
    fn extrapolated(&self, tau: f64, h: f64, at: &Vector) -> Vector {
        let mut columns = SUBSTEPS.map(|substeps| self.midpoint(tau, h, at, substeps));
        for k in 1..SUBSTEPS.len() {
            for j in (k..SUBSTEPS.len()).rev() {
                let ratio = f64::from(SUBSTEPS[j]) / f64::from(SUBSTEPS[j - k]);
                let (finer, coarser) = (columns[j], columns[j - 1]);
                columns[j] = std::array::from_fn(|i| finer[i] + (finer[i] - coarser[i]) / (ratio * ratio - 1.0));
            }
        }
        columns[SUBSTEPS.len() - 1]
    }

    /// Gragg's modified midpoint rule without the smoothing step, which an even number of substeps does not need.
    fn midpoint(&self, tau: f64, h: f64, at: &Vector, substeps: u32) -> Vector {
        let part = h / f64::from(substeps);
        let ahead =
            |from: &Vector, by: f64, slope: &Vector| -> Vector { std::array::from_fn(|i| from[i] + by * slope[i]) };
        let mut before = *at;
        let mut now = ahead(at, part, &self.slope(tau, at));
        for n in 1..substeps {
            let next = ahead(&before, 2.0 * part, &self.slope(tau + f64::from(n) * part, &now));
            (before, now) = (now, next);
        }
        now
    }

    /// Updates the extremes with x at the step's end and, if x turns within the step, with x at the turn, found by Newton's
    /// method on y.
    fn note_extremes(&mut self, at: &Vector, end: &Vector, h: f64, tau: f64) {
        let mut note = |x: f64| {
            self.state.x_min = self.state.x_min.min(x);
            self.state.x_max = self.state.x_max.max(x);
        };
        note(end[0]);
        if at[1] * end[1] < 0.0 {
            let mut s = h * at[1] / (at[1] - end[1]);
            let mut turn = *at;
            for _ in 0..3 {
                turn = self.extrapolated(tau, s, at);
                s = (s - turn[1] / self.slope(tau + s, &turn)[1]).clamp(0.0, h);
            }
            let x = turn[0];
            self.state.x_min = self.state.x_min.min(x);
            self.state.x_max = self.state.x_max.max(x);
        }
    }
}

/// The zero of `f` between 0 and `h`, where `h` lies beyond it: by the Illinois variant of false position, to rounding.
fn root(f: impl Fn(f64) -> f64, h: f64) -> f64 {
    let (mut a, mut b) = (0.0, h);
    let (mut f_a, mut f_b) = (f(a), f(b));
    // rounding may put a start on the boundary on its wrong side: the bracket then begins later
    for part in [64.0, 16.0, 4.0, 2.0] {
        if f_a * f_b < 0.0 {
            break;
        }
        a = h / part;
        f_a = f(a);
    }
    if f_a * f_b >= 0.0 {
        return 0.0;
    }
    for _ in 0..60 {
        let c = (a * f_b - b * f_a) / (f_b - f_a);
        let f_c = f(c);
        if f_c * f_b < 0.0 {
            (a, f_a) = (b, f_b);
        } else {
            f_a *= 0.5;
        }
        (b, f_b) = (c, f_c);
        if f_b.abs() < 1e-14 || (b - a).abs() < 1e-15 * h {
            break;
        }
    }
    b
}
