//! The limit epsilon_0 -> 0: friction as F0 sgn v, with sticking.
//!
//! Owns the events of the limit and what they do to tangent vectors (dx, dv), v = w(tau) - y:
//!
//! - **a crossing** of v = 0 with v' = g- before and g+ after: the saltation matrix of that surface, which leaves dx (x' is
//!   continuous) and takes dv to dv g+/g-;
//! - **sticking**, v = 0 as long as the friction that this takes, N = w' - x + b x^3 + epsilon h1 w, is at most epsilon F0: dv is 0
//!   from its beginning, and dx constant, since x' = w does not depend on the state. It ends where |N| = epsilon F0; there v' is 0,
//!   so that a shift of that moment moves nothing to first order.

use super::collocation::{Bush, RADAU, SAMPLES, Start, Step};
use super::motion::{End, Motion, Tangents};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    /// With that sign of v.
    Slip(f64),
    Stick,
}

/// The motion in the limit.
#[derive(Clone, Debug)]
pub struct Sharp {
    bush: Bush,
    x: f64,
    v: f64,
    mode: Mode,
    tangents: Tangents,
}

impl Sharp {
    /// From (x, y) at drive phase 0.
    pub fn new(bush: Bush, [x, y]: [f64; 2]) -> Self {
        let v = bush.omega_k - y;
        let mut sharp = Self {
            bush,
            x,
            v,
            mode: Mode::Slip(v.signum()),
            tangents: Tangents::UNIT,
        };
        if v == 0.0 {
            sharp.meet_shaft(0.0);
        }
        sharp
    }

    fn dry(&self) -> f64 {
        self.bush.epsilon * self.bush.f_0
    }

    /// v' at v = 0 without dry friction.
    fn needed(&self, tau: f64, x: f64) -> f64 {
        let law = Bush { f_0: 0.0, ..self.bush }.sliding(1.0);
        self.bush.sliding_rate(&law, tau, x, 0.0)[0]
    }

    /// What happens at v = 0: on it goes to the other side, or sticks.
    fn meet_shaft(&mut self, tau: f64) {
        self.v = 0.0;
        let needed = self.needed(tau, self.x);
        if needed.abs() <= self.dry() {
            self.tangents.map(|[dx, _]| [dx, 0.0], f64::NEG_INFINITY);
            self.mode = Mode::Stick;
            return;
        }
        let after = needed.signum();
        if let Mode::Slip(before) = self.mode
            && before != after
        {
            let jump = (needed - after * self.dry()) / (needed - before * self.dry());
            self.tangents.map(|[dx, dv]| [dx, dv * jump], jump.ln());
        }
        self.mode = Mode::Slip(after);
    }

    /// Sticks from `tau` on, at most until `end`; until when.
    fn stick(&mut self, tau: f64, end: f64) -> f64 {
        let Bush {
            zeta_k,
            omega_0,
            omega_k,
            ..
        } = self.bush;
        let from = self.x;
        let x = |at: f64| {
            omega_k.mul_add(at - tau, from) + zeta_k / omega_0 * ((omega_0 * tau).cos() - (omega_0 * at).cos())
        };
        let excess = |at: f64| self.needed(at, x(at)).abs() - self.dry();
        let step = (self.bush.period() / 4000.0).min(0.002);
        let (mut low, mut high) = (tau, (tau + step).min(end));
        while excess(high) <= 0.0 {
            if high == end {
                self.x = x(end);
                return end;
            }
            low = high;
            high = (high + step).min(end);
        }
        while high - low > 4e-16 * high {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if excess(middle) > 0.0 {
                high = middle;
            } else {
                low = middle;
            }
        }
        let at = x(high);
        self.mode = Mode::Slip(self.needed(high, at).signum());
        self.x = at;
        high
    }

    /// Slips from `tau` on, at most until `end`; until when, and whether v = 0 was met. None if there is no step.
    fn slip(&mut self, side: f64, tau: f64, end: f64) -> Option<(f64, bool)> {
        let start = Start {
            bush: &self.bush,
            law: self.bush.sliding(side),
            tau,
            x: self.x,
            v: self.v,
            scale: self.v.abs().max(1.0),
        };
        let [rate, ..] = self.bush.sliding_rate(&start.law, tau, self.x, self.v);
        let guess = |h: f64| RADAU.c.map(|c| self.v + 0.5 * c * h * rate);
        let mut h = (self.bush.period() / 64.0).min(0.05).min(end - tau);
        let mut step = None;
        for _ in 0..40 {
            step = start
                .step(h, guess(h))
                .filter(|step| RADAU.tail(&step.v) < 1e-7 * start.scale);
            if step.is_some() {
                break;
            }
            h *= 0.5;
        }
        let step = step?;
        let whole = step.h >= end - tau;
        let Some(fraction) = first_beyond(side, &step) else {
            self.take(&step);
            return Some((if whole { end } else { tau + step.h }, false));
        };
        let (mut inside, mut outside) = (0.0, fraction * step.h);
        let mut h = outside;
        let mut met = step;
        for _ in 0..100 {
            met = start.step(h, guess(h))?;
            let [x, v] = met.end();
            let [rate, ..] = self.bush.sliding_rate(&start.law, tau + h, x, v);
            if v.abs() <= 1e-15 || outside - inside <= 1e-15 * outside {
                break;
            }
            if side * v < 0.0 {
                outside = outside.min(h);
            } else {
                inside = h;
            }
            let newton = h - v / rate;
            h = if newton > inside && newton < outside {
                newton
            } else {
                0.5 * (inside + outside)
            };
        }
        self.take(&met);
        Some((tau + met.h, true))
    }

    fn take(&mut self, step: &Step) {
        [self.x, self.v] = step.end();
        self.tangents.map(|vector| step.tangent(vector), step.divergence);
    }
}

/// The first sample, or extreme between samples, in units of the step, at which v is beyond 0.
fn first_beyond(side: f64, step: &Step) -> Option<f64> {
    let inner = RADAU.sampled(&step.v);
    let at = |i: usize| side * if i == 0 { step.v[0] } else { inner[i - 1] };
    (1..=SAMPLES).find_map(|i| {
        if i >= 2 {
            let (a, b, c) = (at(i - 2), at(i - 1), at(i));
            if b < a && b < c {
                let least = (i as f64 - 1.0 + 0.5 * (a - c) / (a - 2.0 * b + c)) / SAMPLES as f64;
                if side * RADAU.interpolated(&step.v, least) < 0.0 {
                    return Some(least);
                }
            }
        }
        (at(i) < 0.0).then_some(i as f64 / SAMPLES as f64)
    })
}

impl Motion for Sharp {
    fn bush(&self) -> &Bush {
        &self.bush
    }

    fn state(&self) -> [f64; 2] {
        [self.x, self.bush.omega_k - self.v]
    }

    fn advance_period(&mut self) -> Result<(), End> {
        let period = self.bush.period();
        let mut tau = 0.0;
        while tau < period {
            match self.mode {
                Mode::Stick => tau = self.stick(tau, period),
                Mode::Slip(side) => {
                    let (until, met) = self.slip(side, tau, period).ok_or(End::GivenUp)?;
                    tau = until;
                    if met {
                        self.meet_shaft(tau);
                    }
                }
            }
        }
        Ok(())
    }

    fn tangents(&mut self) -> &mut Tangents {
        &mut self.tangents
    }

    fn sticks(&self) -> bool {
        self.mode == Mode::Stick
    }
}
