//! What the exponent of a point is: Floquet multipliers of the cycle it ends on, a mean growth with its error, or the time of
//! its runaway.
//!
//! Owns the detection of cycles and the error of a mean. A cycle is found when stroboscopic states repeat to 1e-9 after up to
//! [`MOST_PERIODS`] forcing periods, and its multipliers attract; they come from its monodromy matrix, carried with a common scale
//! in logarithms, its determinant from the integral of the divergence. Without a drive the trivial zero along a limit cycle is
//! left out.

use super::collocation::Bush;
use super::motion::{End, Motion, Orbit, Runaway, Tangents};

/// Longest cycle that is looked for, in forcing periods.
pub const MOST_PERIODS: usize = 64;

/// Distance, relative to 1 + |state|, at which two stroboscopic states are the same.
const SAME: f64 = 1e-9;

/// A mean is taken over no more than so much tau, if that is 250 periods.
const LONG_ENOUGH: f64 = 3e4;

/// How long is looked.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    pub tolerance: f64,
    /// Forcing periods before growth is averaged.
    pub transient: usize,
    /// Forcing periods over which it is averaged, as far as no cycle is found in them.
    pub window: usize,
    /// Steps.
    pub budget: u64,
}

impl Effort {
    pub const USUAL: Self = Self {
        tolerance: 1e-6,
        transient: 300,
        window: 1700,
        budget: 4_000_000,
    };
}

/// What the reference found of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Truth {
    /// It ends on an attracting cycle, after `settled` periods.
    Cycle {
        period: usize,
        settled: usize,
        lyapunov: f64,
        divergence: f64,
        error: f64,
    },
    /// It ends on none that was found: means over `periods`.
    Mean {
        periods: usize,
        lyapunov: f64,
        divergence: f64,
        error: f64,
    },
    /// |x| + |y| reached 1e4; a change of 1 at the start moves the time by `sensitivity`.
    Runaway { times: Runaway, sensitivity: f64 },
    /// The reference could not follow it.
    GivenUp,
}

/// Follows the motion from (x, y) at drive phase 0.
pub fn follow(bush: &Bush, start: [f64; 2], effort: &Effort) -> Truth {
    follow_motion(Orbit::new(*bush, start, effort.tolerance, effort.budget), effort)
}

/// Follows a motion from a moment at drive phase 0.
pub fn follow_motion(mut orbit: impl Motion, effort: &Effort) -> Truth {
    let bush = *orbit.bush();
    let mut states = vec![orbit.state()];
    let mut growth = Means {
        sticks: true,
        ..Means::default()
    };
    let last = effort.transient + effort.window;
    let mut n = 0;
    while n < last && growth.wants_more(&bush) {
        let before = *orbit.tangents();
        match orbit.advance_period() {
            Err(End::Runaway(runaway)) => {
                let start = n as f64 * bush.period();
                return Truth::Runaway {
                    times: Runaway {
                        earliest: start + runaway.earliest,
                        time: start + runaway.time,
                        latest: start + runaway.latest,
                        ..runaway
                    },
                    sensitivity: orbit.tangents().log_scale.exp() / runaway.speed,
                };
            }
            Err(End::GivenUp) => break,
            Ok(()) => {}
        }
        n += 1;
        states.push(orbit.state());
        if n > effort.transient {
            let after = *orbit.tangents();
            growth.add(after.log_scale - before.log_scale, after.divergence - before.divergence);
            growth.sticks &= orbit.sticks();
        }
        if let Some(period) = repeated(&states) {
            match turn(&orbit, period) {
                Some((cycle, moved)) if !attracts(&cycle, period, &bush, moved) => {}
                Some((
                    Cycle {
                        lyapunov, divergence, ..
                    },
                    moved,
                )) => {
                    return Truth::Cycle {
                        period,
                        settled: n,
                        lyapunov,
                        divergence,
                        error: moved,
                    };
                }
                None => {}
            }
        }
    }
    growth.truth(&bush)
}

/// The least period after which the last state, and the one before it, repeats.
fn repeated(states: &[[f64; 2]]) -> Option<usize> {
    let n = states.len() - 1;
    let same = |i: usize, j: usize| {
        let [a, b] = [states[i], states[j]];
        (a[0] - b[0]).hypot(a[1] - b[1]) < SAME * (1.0 + a[0].hypot(a[1]))
    };
    (1..=MOST_PERIODS.min(n.saturating_sub(1))).find(|&p| same(n, n - p) && same(n - 1, n - 1 - p))
}

struct Cycle {
    lyapunov: f64,
    divergence: f64,
}

/// The exponents of the cycle of `period` that the orbit is on, from two turns along it, and by how much they differ.
fn turn(orbit: &impl Motion, period: usize) -> Option<(Cycle, f64)> {
    let mut orbit = orbit.clone();
    let time = period as f64 * orbit.bush().period();
    let mut turns = Vec::new();
    for _ in 0..2 {
        *orbit.tangents() = Tangents::UNIT;
        for _ in 0..period {
            orbit.advance_period().ok()?;
        }
        turns.push(exponents(orbit.tangents(), time));
    }
    let [first, second] = turns.try_into().ok()?;
    let moved = (first[0] - second[0]).abs();
    let [lyapunov, divergence] = second;
    Some((Cycle { lyapunov, divergence }, moved))
}

/// Real part of the leading Floquet exponent, and the mean divergence, from the monodromy matrix that the tangent vectors are.
fn exponents(tangents: &Tangents, time: f64) -> [f64; 2] {
    let [[a, b], [c, d]] = tangents.vectors;
    let half_trace = 0.5 * (a + d);
    let determinant = (tangents.divergence - 2.0 * tangents.log_scale).exp();
    let discriminant = half_trace * half_trace - determinant;
    // without the determinant, which may have no digits where both are large
    let by_matrix = 0.25 * (a - d) * (a - d) + b * c;
    let discriminant = if determinant > 1e-6 * half_trace * half_trace {
        by_matrix
    } else {
        discriminant
    };
    let growth = if discriminant < 0.0 {
        0.5 * tangents.divergence
    } else {
        tangents.log_scale + (half_trace.abs() + discriminant.sqrt()).ln()
    };
    [growth / time, tangents.divergence / time]
}

/// Whether a cycle is attracting by enough for the orbit to be on it: within 1e-6 of it.
fn attracts(cycle: &Cycle, period: usize, bush: &Bush, moved: f64) -> bool {
    let multiplier = (cycle.lyapunov * period as f64 * bush.period()).exp();
    multiplier < 1.0 - 1e-3 && moved < 1e-5
}

/// Growth and divergence, period by period.
#[derive(Default)]
struct Means {
    growth: Vec<f64>,
    divergence: Vec<f64>,
    /// Whether the bush stuck to the shaft whenever it was looked at.
    sticks: bool,
}

impl Means {
    fn add(&mut self, growth: f64, divergence: f64) {
        self.growth.push(growth);
        self.divergence.push(divergence);
    }

    /// Slow drives take long for a period, and are known well enough after fewer.
    fn wants_more(&self, bush: &Bush) -> bool {
        self.growth.len() < 250 || self.growth.len() as f64 * bush.period() < LONG_ENOUGH
    }

    fn truth(&self, bush: &Bush) -> Truth {
        if self.growth.len() < 64 {
            return Truth::GivenUp;
        }
        let [growth, divergence] =
            [&self.growth, &self.divergence].map(|series| mean(series).map(|m| m / bush.period()));
        // the trivial zero along a limit cycle; a bush that sticks to a shaft at rest creeps, and is on none
        let on_limit_cycle =
            bush.zeta_k == 0.0 && !self.sticks && growth[0].abs() < 1e-3 + 3.0 * growth[1] && divergence[0] < -2e-3;
        let [lyapunov, error] = if on_limit_cycle { divergence } else { growth };
        Truth::Mean {
            periods: self.growth.len(),
            lyapunov,
            divergence: divergence[0],
            error,
        }
    }
}

/// Mean and standard error, by blocks whose length doubles while 24 are left: the greatest error of any length, so that slow
/// correlation is seen.
fn mean(series: &[f64]) -> [f64; 2] {
    let mut blocks = series.to_vec();
    let mean = series.iter().sum::<f64>() / series.len() as f64;
    let mut error: f64 = 0.0;
    while blocks.len() >= 24 {
        let n = blocks.len() as f64;
        let average = blocks.iter().sum::<f64>() / n;
        let scatter: f64 = blocks.iter().map(|b| (b - average).powi(2)).sum();
        error = error.max((scatter / (n * (n - 1.0))).sqrt());
        blocks = blocks.chunks_exact(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    }
    [mean, error]
}
