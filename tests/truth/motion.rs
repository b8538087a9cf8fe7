//! The regularised motion over whole forcing periods: adaptive steps that end at the boundaries of the friction layer.
//!
//! Owns step control, events and runaway; what an orbit's exponents are is not known here. Steps are limited by
//!
//! - the part of x and of v (of u = v/epsilon_0 inside the layer) in the highest polynomial of the step: `tolerance`. The step's
//!   end is exact to about the square of that;
//! - the tangent dynamics: h |d v'/dv| <= 1.5, until a stiff phase has damped its fast direction by exp(40), and
//!   h sqrt(|d v'/dx|) <= 1.5;
//! - the drive: omega_0 h <= 1.5.
//!
//! Boundaries v = -epsilon_0, 0, epsilon_0 are located by repeating the step with another length until its end is on the boundary
//! to rounding. The law is C1, so that a tangent vector passes them unchanged.

use super::collocation::{Bush, Law, RADAU, S, SAMPLES, Start, Step};

/// A state with |x| + |y| at or above this has run away.
pub const RUNAWAY_BOUND: f64 = 1e4;

/// A swing that grows slowly reaches the bound at a crest, and by how little one crest fails to is a matter of rounding: when it
/// is within this of the bound, relatively, counts besides.
const CREST: f64 = 1e-3;

/// The levels of |x| + |y| that are watched for, in units of the bound.
const LEVELS: [f64; 3] = [1.0 - CREST, 1.0, 1.0 + CREST];

/// Damping, in exponents, after which nothing is left of a fast direction.
const COLLAPSED: f64 = 40.0;

/// Why an orbit ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// |x| + |y| reached [`RUNAWAY_BOUND`].
    Runaway(Runaway),
    /// Newton's method, or the step control, found no step, or the budget of steps is spent.
    GivenUp,
}

/// A runaway's times, since the start of the period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Runaway {
    /// When |x| + |y| was within a thousandth of the bound.
    pub earliest: f64,
    pub time: f64,
    /// When it was beyond the bound by a thousandth.
    pub latest: f64,
    /// |x'| + |y'| about then.
    pub speed: f64,
}

/// The tangent vectors of an orbit, and its divergence, since they were last begun anew.
#[derive(Clone, Copy, Debug)]
pub struct Tangents {
    /// (dx, dv), in units of exp(`log_scale`).
    pub vectors: [[f64; 2]; 2],
    pub log_scale: f64,
    /// Logarithm of the determinant: the integral of the divergence.
    pub divergence: f64,
}

impl Tangents {
    pub const UNIT: Self = Self {
        vectors: [[1.0, 0.0], [0.0, 1.0]],
        log_scale: 0.0,
        divergence: 0.0,
    };

    /// Takes the vectors on by a linear map, the logarithm of whose determinant is `divergence`.
    pub fn map(&mut self, map: impl Fn([f64; 2]) -> [f64; 2], divergence: f64) {
        let moved = self.vectors.map(map);
        let size = moved.iter().flatten().fold(0.0, |most: f64, t| most.max(t.abs()));
        self.vectors = moved.map(|vector| vector.map(|t| t / size));
        self.log_scale += size.ln();
        self.divergence += divergence;
    }
}

/// A motion that is carried on from one moment at drive phase 0 to the next.
pub trait Motion: Clone {
    fn bush(&self) -> &Bush;

    /// (x, y) at drive phase 0.
    fn state(&self) -> [f64; 2];

    /// Carries it on by a forcing period.
    ///
    /// # Errors
    /// If it ends before.
    fn advance_period(&mut self) -> Result<(), End>;

    fn tangents(&mut self) -> &mut Tangents;

    /// Whether the bush sticks to the shaft just now.
    fn sticks(&self) -> bool;
}

/// Pieces of the law: 0 below the layer, 1 and 2 in it, 3 above.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece(u8);

/// The motion between two moments at drive phase 0.
#[derive(Clone, Debug)]
pub struct Orbit {
    pub bush: Bush,
    pub tolerance: f64,
    pub x: f64,
    pub v: f64,
    pub tangents: Tangents,
    /// Steps that may still be taken.
    pub budget: u64,
    piece: Piece,
    /// The next step's length.
    h: f64,
    /// Damping of v since this stiff phase began.
    damped: f64,
    /// The last step, if the next one goes on from it.
    last: Option<(f64, [f64; S + 1])>,
}

impl Orbit {
    /// From (x, y) at drive phase 0, with the unit vectors as tangent vectors.
    pub fn new(bush: Bush, [x, y]: [f64; 2], tolerance: f64, budget: u64) -> Self {
        let v = bush.omega_k - y;
        Self {
            bush,
            tolerance,
            x,
            v,
            tangents: Tangents::UNIT,
            budget,
            piece: Piece(2),
            h: 1e-3 * bush.period().min(1.0),
            damped: 0.0,
            last: None,
        }
        .on_its_piece(0.0)
    }

    fn on_its_piece(mut self, tau: f64) -> Self {
        self.choose_piece(tau);
        self
    }

    /// The boundaries of the present piece.
    fn boundaries(&self) -> [f64; 2] {
        let width = self.bush.epsilon_0;
        if self.bush.f_0 == 0.0 {
            return [f64::NEG_INFINITY, f64::INFINITY];
        }
        match self.piece.0 {
            0 => [f64::NEG_INFINITY, -width],
            1 => [-width, 0.0],
            2 => [0.0, width],
            _ => [width, f64::INFINITY],
        }
    }

    fn law(&self) -> Law {
        match self.piece.0 {
            0 => self.bush.sliding(-1.0),
            1 => self.bush.layer(-1.0),
            2 => self.bush.layer(1.0),
            _ => self.bush.sliding(1.0),
        }
    }

    /// The size of v that counts.
    fn scale(&self) -> f64 {
        if self.is_in_layer() {
            self.bush.epsilon_0
        } else {
            self.v.abs().max(1.0)
        }
    }

    fn is_in_layer(&self) -> bool {
        self.bush.f_0 != 0.0 && matches!(self.piece.0, 1 | 2)
    }

    /// By v, and on a boundary by the way v goes.
    fn choose_piece(&mut self, tau: f64) {
        if self.bush.f_0 == 0.0 {
            self.piece = Piece(3);
            return;
        }
        let width = self.bush.epsilon_0;
        let outward = |piece| {
            let law = Orbit { piece, ..self.clone() }.law();
            self.bush.sliding_rate(&law, tau, self.x, self.v)[0] > 0.0
        };
        self.piece = match self.v {
            v if v < -width => Piece(0),
            v if v == -width => Piece(u8::from(outward(Piece(0)))),
            v if v < 0.0 => Piece(1),
            0.0 => Piece(1 + u8::from(outward(Piece(1)))),
            v if v < width => Piece(2),
            v if v == width => Piece(2 + u8::from(outward(Piece(3)))),
            _ => Piece(3),
        };
    }

    /// A first step's length on a new piece: by when the motion, going on as it does, would be at the other boundary.
    fn first_length(&self, tau: f64) -> f64 {
        let [rate, _, damping] = self.bush.sliding_rate(&self.law(), tau, self.x, self.v);
        if self.is_in_layer() {
            (0.3 * self.bush.epsilon_0 / rate.abs()).min(0.5 / damping.abs())
        } else {
            (0.05 / (1.0 + damping.abs() + rate.abs())).min(0.05 / self.bush.omega_0)
        }
    }

    fn take(&mut self, step: &Step) {
        [self.x, self.v] = step.end();
        self.tangents.map(|vector| step.tangent(vector), step.divergence);
        self.damped = if step.h * step.rate < 0.5 {
            0.0
        } else {
            self.damped - step.divergence
        };
        self.last = Some((step.h, step.v));
    }

    fn start(&self, tau: f64) -> Start<'_> {
        Start {
            bush: &self.bush,
            law: self.law(),
            tau,
            x: self.x,
            v: self.v,
            scale: self.scale(),
        }
    }

    fn guess(&self, tau: f64, h: f64) -> [f64; S] {
        let c = &RADAU.c;
        if let Some((last, values)) = &self.last
            && h < 2.5 * last
        {
            return c.map(|c| RADAU.interpolated(values, 1.0 + c * h / last));
        }
        let [rate, ..] = self.bush.sliding_rate(&self.law(), tau, self.x, self.v);
        let [low, high] = self.boundaries();
        c.map(|c| (self.v + c * h * rate).clamp(low, high))
    }

    /// The longest good step from `tau`, at most of `left`, and the boundary it ends on, if any.
    fn next_step(&mut self, tau: f64, left: f64) -> Option<(Step, Option<f64>)> {
        let start = self.start(tau);
        let [_, stiffness, damping] = self.bush.sliding_rate(&start.law, tau, self.x, self.v);
        let collapsed = self.damped > COLLAPSED;
        let mut h = self.h.min(1.5 / self.bush.omega_0).min(1.5 / stiffness.abs().sqrt());
        if !collapsed {
            h = h.min(1.5 / damping.abs());
        }
        if h > left {
            h = left;
        } else if h > 0.5 * left {
            h = 0.5 * left;
        }
        let mut spent = 0;
        let result = loop {
            spent += 1;
            if spent > 200 {
                break None;
            }
            let Some(step) = start.step(h, self.guess(tau, h)) else {
                h *= 0.25;
                continue;
            };
            let x_scale = self.x.abs().max(1.0);
            let error = (RADAU.tail(&step.v) / start.scale).max(RADAU.tail(&step.x) / x_scale);
            if error > self.tolerance {
                h *= (0.8 * (self.tolerance / error).powf(1.0 / S as f64)).max(0.1);
                continue;
            }
            if !collapsed && h * step.rate > 3.0 {
                h *= 1.4 / (h * step.rate);
                continue;
            }
            let longer = (0.85 * (self.tolerance / error.max(1e-300)).powf(1.0 / S as f64)).clamp(0.2, 4.0);
            let next = h * longer;
            let located = match self.first_beyond(&step) {
                None => Some((step, None)),
                Some((fraction, boundary)) => self.locate(&start, h, fraction, boundary),
            };
            break located.map(|located| (located, next));
        };
        let ((step, event), next) = result?;
        self.budget = self.budget.checked_sub(spent)?;
        // what the end of the period cut short goes on at the old length
        self.h = if step.h == left && event.is_none() {
            self.h.max(next)
        } else {
            next
        };
        Some((step, event))
    }

    /// When, in units of the step, the motion is first seen outside its piece, and the boundary it has passed.
    fn first_beyond(&self, step: &Step) -> Option<(f64, f64)> {
        let [low, high] = self.boundaries();
        let inner = RADAU.sampled(&step.v);
        let at = |i: usize| if i == 0 { step.v[0] } else { inner[i - 1] };
        let beyond = |v: f64| {
            if v < low {
                Some(low)
            } else if v > high {
                Some(high)
            } else {
                None
            }
        };
        for i in 1..=SAMPLES {
            // an extreme between three samples may be outside where they are not
            if i >= 2 {
                let (a, b, c) = (at(i - 2), at(i - 1), at(i));
                if (b - a) * (c - b) < 0.0 {
                    let shift = 0.5 * (a - c) / (a - 2.0 * b + c);
                    let extreme = (i as f64 - 1.0 + shift) / SAMPLES as f64;
                    if let Some(boundary) = beyond(RADAU.interpolated(&step.v, extreme)) {
                        return Some((extreme, boundary));
                    }
                }
            }
            if let Some(boundary) = beyond(at(i)) {
                return Some((i as f64 / SAMPLES as f64, boundary));
            }
        }
        None
    }

    /// The step that ends on a boundary which the motion has passed by `fraction` of a step of `whole`.
    fn locate(&self, start: &Start<'_>, whole: f64, fraction: f64, boundary: f64) -> Option<(Step, Option<f64>)> {
        let rising = if boundary == self.boundaries()[1] { 1.0 } else { -1.0 };
        let (mut inside, mut outside) = (0.0, fraction * whole);
        let mut h = outside;
        let mut step = None;
        for _ in 0..100 {
            let taken = start.step(h, self.guess(start.tau, h));
            let Some(taken) = taken else {
                h = 0.5 * (inside + h);
                continue;
            };
            let [x, v] = taken.end();
            let beyond = rising * (v - boundary);
            let [rate, ..] = self.bush.sliding_rate(&start.law, start.tau + h, x, v);
            step = Some(taken);
            let rounding = 4e-16 * self.v.abs().max(h * rate.abs());
            if beyond.abs() <= rounding.max(1e-13 * self.bush.epsilon_0) || outside - inside <= 1e-15 * outside {
                break;
            }
            if beyond > 0.0 {
                outside = outside.min(h);
            } else {
                inside = h;
            }
            let newton = h - beyond / (rising * rate);
            h = if newton > inside && newton < outside {
                newton
            } else {
                0.5 * (inside + outside)
            };
        }
        step.map(|step| (step, Some(boundary)))
    }

    /// |x'| + |y'|.
    fn speed(&self, tau: f64, [x, v]: [f64; 2]) -> f64 {
        let [w, dw] = self.bush.shaft(tau);
        let [rate, ..] = self.bush.sliding_rate(&self.law(), tau, x, v);
        (w - v).abs() + (dw - rate).abs()
    }

    /// When |x| + |y| reaches a level within a step that begins at `tau`, if it is beyond it at its end.
    fn reaches(&self, level: f64, tau: f64, step: &Step) -> Option<f64> {
        let size = |h: f64, [x, v]: [f64; 2]| x.abs() + (self.bush.shaft(tau + h)[0] - v).abs();
        if size(step.h, step.end()) < level {
            return None;
        }
        let start = self.start(tau);
        let (mut low, mut high) = (0.0, step.h);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            let taken = start.step(middle, self.guess(tau, middle))?;
            if size(middle, taken.end()) < level {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some(tau + high)
    }
}

impl Motion for Orbit {
    fn bush(&self) -> &Bush {
        &self.bush
    }

    fn state(&self) -> [f64; 2] {
        [self.x, self.bush.omega_k - self.v]
    }

    fn advance_period(&mut self) -> Result<(), End> {
        let period = self.bush.period();
        let (mut tau, mut lost) = (0.0, 0.0);
        let mut reached = [None; LEVELS.len()];
        while tau < period || reached[1].is_some() {
            let left = (period - tau) - lost;
            if left <= 1e-15 * period && reached[1].is_none() {
                break;
            }
            // what has run away is followed for the last of its times
            let left = if reached[1].is_some() { f64::INFINITY } else { left };
            let (step, event) = self.next_step(tau, left).ok_or(End::GivenUp)?;
            for (level, time) in LEVELS.iter().zip(&mut reached) {
                *time = time.or_else(|| self.reaches(level * RUNAWAY_BOUND, tau, &step));
            }
            if let [Some(earliest), Some(time), Some(latest)] = reached {
                return Err(End::Runaway(Runaway {
                    earliest,
                    time,
                    latest,
                    speed: self.speed(tau + step.h, step.end()),
                }));
            }
            self.take(&step);
            // compensated: a step may be shorter than the spacing of numbers at tau
            let sum = tau + (step.h + lost);
            lost += step.h - (sum - tau);
            tau = sum;
            if let Some(boundary) = event {
                self.v = boundary;
                self.choose_piece(tau);
                self.damped = 0.0;
                self.last = None;
                self.h = self.first_length(tau);
            }
        }
        self.last = None;
        Ok(())
    }

    fn tangents(&mut self) -> &mut Tangents {
        &mut self.tangents
    }

    fn sticks(&self) -> bool {
        self.is_in_layer()
    }
}
