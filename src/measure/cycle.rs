//! The measurement of a cycle from some turns of an orbit along it.
//!
//! Owns what makes a cycle certain, and its measurement.

use std::collections::BTreeMap;

use super::evaluation::{checked, is_resolved, missed_by_scheme};
use super::{Class, Measurement, Status};
use crate::backend::{Backend, BackendError, BackendKind, Contact, EndState, Instance, Slice, Stage, Sums};
use crate::dynamics::divergence_check::CHECKED_EVERY;
use crate::dynamics::floquet::{Multipliers, Turn};
use crate::experiment::{Sampling, Settings};

/// Turns that are watched: two for the multipliers, and one more for their errors.
const TURNS: u32 = 3;

/// An orbit counts as on a cycle if its distance from the cycle is below this, estimated from the last turn and the multipliers.
/// The multipliers then have about the same accuracy.
const NEAR: f64 = 1e-5;

/// Two states of a turn are the same if their distance is at most this many times the sum of their distances from the cycle. The
/// triangle inequality gives a factor of 1; more is needed where directions are stretched unequally.
const APART: f64 = 4.0;

/// Without a drive, the only cycle of forcing periods is a state of rest: x then varies by less than this.
const REST: f64 = 1e-4;

/// Rounding error of one forcing period, in units of the number type's last place. Over several periods it grows like a random
/// walk.
const ROUNDING: f64 = 100.0;

/// An orbit that may be on a cycle.
pub(super) struct Candidate {
    pub instance: Instance,
    /// The period of the cycle or a multiple of it, in forcing periods.
    pub period: u32,
}

/// A candidate after it has been watched.
pub(super) struct Turned {
    pub end: EndState,
    /// For how many forcing periods it was watched.
    pub periods: u32,
    /// The measurement of its cycle, attracting or not; None if it is not certain to be on one.
    pub measurement: Option<Measurement>,
}

/// Watches candidates along their cycles.
///
/// # Errors
/// If the backend fails.
pub(super) fn turn(
    backend: &mut dyn Backend,
    settings: &Settings,
    candidates: &[Candidate],
) -> Result<Vec<Turned>, BackendError> {
    let mut by_period: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (index, candidate) in candidates.iter().enumerate() {
        by_period.entry(candidate.period).or_default().push(index);
    }
    let mut turned: Vec<Option<Turned>> = candidates.iter().map(|_| None).collect();
    for (period, indices) in by_period {
        let alike: Vec<&Candidate> = indices.iter().map(|&index| &candidates[index]).collect();
        for (index, result) in indices.into_iter().zip(turn_alike(backend, settings, period, &alike)?) {
            turned[index] = Some(result);
        }
    }
    Ok(turned.into_iter().flatten().collect())
}

/// Watches candidates for cycles of the same period.
fn turn_alike(
    backend: &mut dyn Backend,
    settings: &Settings,
    period: u32,
    candidates: &[&Candidate],
) -> Result<Vec<Turned>, BackendError> {
    let settings = Settings {
        sampling: Sampling {
            transient_periods: 0,
            align_periods: 0,
            periods: TURNS * period,
            ..settings.sampling
        },
        ..*settings
    };
    let instances: Vec<Instance> = candidates.iter().map(|candidate| candidate.instance).collect();
    backend.load(&settings, &instances)?;
    let mut tracks: Vec<Track> = candidates.iter().map(|candidate| Track::new(candidate)).collect();
    let mut ends = Vec::new();
    for turn in 0..TURNS {
        // every state of the last two turns is needed
        let periods = if turn == 0 { period } else { 1 };
        for done in (0..period).step_by(periods as usize) {
            let first = turn * period + done;
            backend.advance(&Slice {
                // in the last turn, the sum of the exponents is checked
                stage: if turn + 1 == TURNS {
                    Stage::Check
                } else {
                    Stage::Measure
                },
                first,
                periods,
                elapsed: first,
            })?;
            ends = backend.end_states()?;
            for (track, end) in tracks.iter_mut().zip(&ends) {
                track.states.push([end.x, end.y]);
            }
        }
        let sums = backend.collect()?;
        for ((track, end), sums) in tracks.iter_mut().zip(&ends).zip(&sums) {
            track.end_turn(end, sums, turn + 1 == TURNS);
        }
    }
    let kind = backend.kind();
    Ok(candidates
        .iter()
        .zip(tracks.iter().zip(ends))
        .map(|(candidate, (track, end))| Turned {
            measurement: track.measurement(candidate, &end, kind),
            periods: settings.sampling.periods,
            end,
        })
        .collect())
}

/// An orbit's turns.
struct Track {
    turns: Vec<Turn>,
    tangent: [f64; 2],
    /// Integral of the divergence over all turns.
    divergence: f64,
    /// Difference between the growth of both vectors over the last turn and the divergence.
    defect: f64,
    /// States of the last two turns; the first one is the state in which these turns began.
    states: Vec<[f64; 2]>,
}

impl Track {
    fn new(candidate: &Candidate) -> Self {
        Self {
            turns: Vec::with_capacity(TURNS as usize),
            tangent: candidate.instance.tangent,
            divergence: 0.0,
            defect: 0.0,
            states: Vec::new(),
        }
    }

    fn end_turn(&mut self, end: &EndState, sums: &Sums, is_checked: bool) {
        let [first, second] = sums.growth;
        if is_checked {
            self.defect = (first + second - sums.divergence) / f64::from(CHECKED_EVERY);
        }
        self.turns.push(Turn {
            from: self.tangent,
            to: end.tangent,
            growth: [first, sums.divergence - first],
        });
        self.tangent = end.tangent;
        self.divergence += sums.divergence;
    }

    /// How far the last turn moved the orbit.
    fn moved(&self) -> f64 {
        self.moved_at(self.states.len() - 1)
    }

    /// Distance between state `n` and the state one turn before.
    fn moved_at(&self, n: usize) -> f64 {
        distance(self.states[n], self.states[n - self.states.len() / 2])
    }

    /// The least divisor of the number of periods in a turn after which the states repeat. Two states are the same if their
    /// distance is at most `reach`, a function of how far the last turn has moved each of them.
    fn least_period(&self, reach: impl Fn(f64, f64) -> f64) -> usize {
        let turn = self.states.len() / 2;
        let is_same =
            |n: usize, m: usize| distance(self.states[n], self.states[m]) <= reach(self.moved_at(n), self.moved_at(m));
        let repeats = |d: usize| (turn + d..=2 * turn).all(|n| is_same(n, n - d));
        (1..turn)
            .find(|&d| turn.is_multiple_of(d) && repeats(d))
            .unwrap_or(turn)
    }

    /// The measurement of the orbit, given the state at its end. None if the orbit is too far from a cycle, or if it is not
    /// certain whether the cycle attracts.
    fn measurement(&self, candidate: &Candidate, end: &EndState, backend: BackendKind) -> Option<Measurement> {
        let parameters = &candidate.instance.parameters;
        let may_be_cycle = parameters.is_driven() || end.x_max - end.x_min < REST;
        if end.runaway_periods.is_some() || end.under_resolved || !may_be_cycle {
            return None;
        }
        let turn_time = f64::from(candidate.period) * parameters.forcing_period();
        let [before, last] = [0, 1].map(|i| Multipliers::new(&self.turns[i], &self.turns[i + 1]));
        let moduli = last.log_moduli();
        // in every turn, the distance from the cycle and the change of the results shrink by the leading multiplier
        let to_come = match last.leading() {
            leading if leading < 1.0 => leading / (1.0 - leading),
            _ => 0.0,
        };
        let exponents = [0, 1].map(|i| (moduli[i] + to_come * (moduli[i] - before.log_moduli()[i])) / turn_time);
        let approach = (exponents[0] * turn_time).exp_m1().abs();
        let changes = [0, 1].map(|i| (before.log_moduli()[i] - moduli[i]).abs() / turn_time / approach);
        let defect = self.defect / turn_time;
        let missed = missed_by_scheme(parameters, backend, exponents[0], defect);
        let errors = changes.map(|change| change + missed);
        let distance_from_one = last.distance_from_one();
        let left_to_go = self.moved() / distance_from_one;
        let class = if exponents[0] + 3.0 * errors[0] < 0.0 && left_to_go < NEAR {
            Class::Regular
        } else if exponents[0] - 3.0 * errors[0] > 0.0 && self.moved() == 0.0 {
            // an orbit that returns to exactly the same numbers never leaves
            Class::Unstable
        } else {
            return None;
        };
        let rounding =
            ROUNDING * f64::from(candidate.period).sqrt() * backend.epsilon() * (1.0 + end.x.abs() + end.y.abs());
        let reach = |moved: f64, other: f64| (APART * (moved + other) + rounding) / distance_from_one;
        let measurement = Measurement {
            class: Some(class),
            lyapunov: exponents[0],
            lyapunov_error: errors[0],
            scheme_error: missed,
            lyapunov_second: exponents[1] + defect,
            lyapunov_second_error: errors[1],
            divergence: self.divergence / (f64::from(TURNS) * turn_time),
            lyapunov_birkhoff: exponents[0],
            lyapunov_interval: turn_time,
            period: Some(self.least_period(reach) as u32),
            x: end.x,
            y: end.y,
            x_min: end.x_min,
            x_max: end.x_max,
            contact: Contact::CONSTANT,
            attractors: u32::from(class == Class::Regular),
            initial_state: parameters.initial_state(),
            ..Measurement::unmeasured(Status::Ok, backend)
        };
        let resolved = is_resolved(&measurement);
        Some(checked(measurement, resolved))
    }
}

fn distance([ax, ay]: [f64; 2], [bx, by]: [f64; 2]) -> f64 {
    (ax - bx).hypot(ay - by)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::ParameterSet;

    /// The measurement of an orbit that approaches `cycle` from the distance `off`, if vectors grow by the same factors in every
    /// turn.
    fn watched(cycle: &[[f64; 2]], off: f64, growth: [f64; 2]) -> Option<Measurement> {
        let period = cycle.len() as u32;
        let end = EndState {
            x: cycle[0][0],
            y: cycle[0][1],
            tangent: [1.0, 0.0],
            x_min: -1.0,
            x_max: 1.0,
            period: Some(period),
            runaway_periods: None,
            under_resolved: false,
            contact: Contact::CONSTANT,
        };
        let candidate = Candidate {
            instance: ParameterSet::default().into(),
            period,
        };
        let mut track = Track::new(&candidate);
        for turn in 0..TURNS {
            let sums = Sums {
                growth,
                divergence: growth.iter().sum(),
                ..Sums::default()
            };
            track.end_turn(&end, &sums, turn + 1 == TURNS);
        }
        // the distance shrinks by the first multiplier in a turn
        let left = |n: u32| off * (growth[0] * f64::from(n) / f64::from(period)).exp();
        track.states = (0..=2 * period)
            .map(|n| {
                let [x, y] = cycle[n as usize % cycle.len()];
                [x + left(n), y]
            })
            .collect();
        track.measurement(&candidate, &end, BackendKind::CpuF64)
    }

    #[test]
    fn the_period_of_an_orbit_on_its_way_is_that_of_its_cycle() {
        let [a, b, c, d] = [[0.5, 0.1], [0.9, -0.2], [0.5, 0.1 + 1e-4], [0.9, -0.2 + 1e-4]];
        for off in [0.0, 1e-12, 1e-8, 1e-6] {
            for (cycle, period) in [([a; 4], 1), ([a, b, a, b], 2), ([a, b, c, d], 4), ([a, b, c, b], 4)] {
                let m = watched(&cycle, off, [-2.0, -3.0]).unwrap();
                assert_eq!(
                    (m.class, m.period),
                    (Some(Class::Regular), Some(period)),
                    "{off}: {m:?}"
                );
                let time = 4.0 * ParameterSet::default().forcing_period();
                assert!((m.lyapunov * time + 2.0).abs() < 1e-9 && (m.lyapunov_second * time + 3.0).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn only_what_stands_still_is_on_an_unstable_cycle() {
        let cycle = [[0.5, 0.1], [0.9, -0.2]];
        assert_eq!(watched(&cycle, 0.0, [2.0, -3.0]).unwrap().class, Some(Class::Unstable));
        // the orbit may be leaving the cycle
        assert!(watched(&cycle, 1e-9, [2.0, -3.0]).is_none());
        // too far off to tell
        assert!(watched(&cycle, 1e-2, [-2.0, -3.0]).is_none());
    }
}
