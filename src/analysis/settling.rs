//! When orbits settle on a regular attractor.
//!
//! Owns what "still chaotic" means for an orbit that is followed to its end; makes no statistics of it.

use rayon::prelude::*;

use super::Progress;
use super::orbits::is_bounded;
use crate::backend::cpu::CpuBackend;
use crate::backend::{Backend, BackendError, BackendKind, EndState, Instance, Slice, Stage, Sums, check_model};
use crate::dynamics::stroboscope::{most_states, period_of, span_of};
use crate::experiment::{Precision, Sampling, Scheme, Settings};
use crate::measure::fallback;
use crate::parameters::ParameterSet;

/// An orbit has settled on its final cycle from the time on at which x and y stay within this distance of the cycle's values,
/// phase by phase. Cycles and chaos are of size 1. With a smaller distance, the lifetime would include the approach to the cycle.
pub const NEAR: f64 = 1e-2;

/// An orbit that ends on no cycle is still chaotic while a disturbance will later grow by more than e to this power. On a torus
/// the growth oscillates by less; in chaos a disturbance grows by more within some tens of periods.
pub const SWING: f64 = 3.0;

/// Periods in which the first vector turns to its direction; its growth does not count there.
const ALIGNING: usize = 16;

/// Most states that are kept at a time: 24 bytes each.
const MOST_KEPT: usize = 1 << 23;

/// Least number of orbits in a batch: they fill the lanes of some cores.
const LEAST_BATCH: usize = 64;

/// How an orbit ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// Settled on a regular attractor, or ran away, after this many whole forcing periods, and not before.
    Settled(u32),
    /// Had not settled after all periods.
    Lasting,
    /// The scheme gave it up as under-resolved: nothing is known of it.
    GivenUp,
}

/// The result of following one orbit.
#[derive(Clone, Copy, Debug)]
pub struct Fate {
    /// Whether it settled, and when.
    pub end: End,
    /// Logarithm of the growth of a tangent vector before the orbit settled, and the forcing periods over which it grew.
    pub growth: [f64; 2],
}

/// Forcing periods over which orbits are followed beyond the longest time, to see on what they have settled.
pub fn confirming(settings: &Settings) -> u32 {
    2 * most_states(settings.sampling.max_period)
}

/// Follows the orbits of the instance `at` from the states `starts`, each (x, y), over `longest` forcing periods, and as many
/// more as [`confirming`] tells. Orbits that the scheme gives up are followed by the schemes that [`fallback`] names. None if
/// `progress` broke the work off.
///
/// # Errors
/// If the backend fails, or the scheme that was asked for does not carry the heat of the instance.
pub fn follow(
    backend: &mut dyn Backend,
    settings: &Settings,
    at: &ParameterSet,
    starts: &[[f64; 2]],
    longest: u32,
    progress: &mut Progress<'_>,
) -> Result<Option<Vec<Fate>>, BackendError> {
    let instances: Vec<Instance> = starts.iter().map(|&start| Instance::new(*at, start)).collect();
    check_model(&settings.integration, &instances)?;
    let Some(mut fates) = follow_by_one(backend, settings, &instances, longest, progress)? else {
        return Ok(None);
    };
    let (mut scheme, mut kind) = (settings.integration.scheme, backend.kind());
    let is_last = |scheme, kind| match scheme {
        Scheme::Taylor => false,
        // under heat and wear there is no other scheme
        Scheme::Radau => at.has_heat_or_wear() || kind == BackendKind::CpuF64,
        // the user chose its steps
        Scheme::Rk4 => true,
    };
    while !is_last(scheme, kind) {
        let given_up: Vec<usize> = (0..fates.len())
            .filter(|&index| fates[index].end == End::GivenUp)
            .collect();
        if given_up.is_empty() {
            break;
        }
        (scheme, kind) = (fallback::next(scheme, kind), BackendKind::CpuF64);
        let settings = fallback::in_place(settings, scheme);
        let again: Vec<Instance> = given_up.iter().map(|&index| instances[index].clone()).collect();
        // they were reported as done before
        let progress = &mut |_| progress(0);
        let cpu = &mut CpuBackend::new(Precision::F64);
        let Some(anew) = follow_by_one(cpu, &settings, &again, longest, progress)? else {
            return Ok(None);
        };
        for (index, fate) in given_up.into_iter().zip(anew) {
            fates[index] = fate;
        }
    }
    Ok(Some(fates))
}

/// As [`follow`], by the scheme of the settings alone.
fn follow_by_one(
    backend: &mut dyn Backend,
    settings: &Settings,
    instances: &[Instance],
    longest: u32,
    progress: &mut Progress<'_>,
) -> Result<Option<Vec<Fate>>, BackendError> {
    let periods = longest + confirming(settings);
    let settings = &Settings {
        sampling: Sampling {
            transient_periods: 0,
            align_periods: 0,
            periods,
            ..settings.sampling
        },
        ..*settings
    };
    let kept = (MOST_KEPT / periods as usize).max(LEAST_BATCH);
    let mut fates = Vec::with_capacity(instances.len());
    for batch in instances.chunks(backend.batch_size(settings).min(kept)) {
        backend.load(settings, batch)?;
        let tracks = batch.iter().map(|instance| Track::new(instance.state, periods));
        let mut tracks: Vec<Track> = tracks.collect();
        for first in 0..periods {
            backend.advance(&Slice {
                stage: Stage::Measure,
                first,
                periods: 1,
                elapsed: first,
            })?;
            let (sums, ends) = (backend.collect()?, backend.end_states()?);
            for (track, (sums, end)) in tracks.iter_mut().zip(sums.iter().zip(&ends)) {
                track.add(sums, end);
            }
            if progress(batch.len() as u64).is_break() {
                return Ok(None);
            }
        }
        fates.par_extend(tracks.par_iter().map(|track| track.fate(settings, longest)));
    }
    Ok(Some(fates))
}

/// What was recorded of an orbit at drive phase 0, from its start.
struct Track {
    states: Vec<[f64; 2]>,
    /// Logarithm of the growth of a tangent vector since the start.
    growth: Vec<f64>,
    /// How it ended, if it ran away or was given up.
    lost: Option<End>,
}

impl Track {
    fn new(start: [f64; 2], periods: u32) -> Self {
        let with = |capacity: u32| capacity as usize + 1;
        let (mut states, mut growth) = (Vec::with_capacity(with(periods)), Vec::with_capacity(with(periods)));
        states.push(start);
        growth.push(0.0);
        Self {
            states,
            growth,
            lost: None,
        }
    }

    fn add(&mut self, sums: &Sums, end: &EndState) {
        if self.lost.is_some() {
            return;
        }
        if is_bounded(end) {
            self.states.push([end.x, end.y]);
            self.growth.push(self.growth[self.growth.len() - 1] + sums.growth[0]);
        } else if end.under_resolved {
            self.lost = Some(End::GivenUp);
        } else {
            self.lost = Some(End::Settled(self.states.len() as u32));
        }
    }

    fn fate(&self, settings: &Settings, longest: u32) -> Fate {
        let end = self.lost.unwrap_or_else(|| End::Settled(self.settled(settings)));
        let end = match end {
            End::Settled(periods) if periods > longest => End::Lasting,
            end => end,
        };
        let last = match end {
            End::Settled(periods) => periods,
            End::Lasting => longest,
            End::GivenUp => 0,
        };
        let last = (last as usize).min(self.growth.len() - 1);
        let growth = if last > ALIGNING {
            [self.growth[last] - self.growth[ALIGNING], (last - ALIGNING) as f64]
        } else {
            [0.0; 2]
        };
        Fate { end, growth }
    }

    /// Forcing periods after which the orbit has settled on its final attractor.
    fn settled(&self, settings: &Settings) -> u32 {
        let last = self.states.len() - 1;
        let away = if let Some(period) = self.cycle(settings) {
            // `settled` is the state at the same phase of the last turn
            (0..last).rev().find(|n| {
                let (state, settled) = (self.states[*n], self.states[last - (last - n) % period]);
                (0..2).any(|i| (state[i] - settled[i]).abs() > NEAR)
            })
        } else {
            let mut most = f64::NEG_INFINITY;
            (0..=last).rev().find(|n| {
                most = most.max(self.growth[*n]);
                most - self.growth[*n] > SWING
            })
        };
        away.map_or(0, |n| n as u32 + 1)
    }

    /// The period of the attracting cycle on which the orbit ends, by the same criterion as in measurements.
    fn cycle(&self, settings: &Settings) -> Option<usize> {
        let window = most_states(settings.sampling.max_period);
        let last = self.states.len() - 1;
        let tail = &self.states[last + 1 - window as usize..];
        let period = period_of(window, settings.sampling.max_period, |n, before| {
            let (state, earlier) = (tail[n as usize], tail[before as usize]);
            (0..2).all(|i| (state[i] - earlier[i]).abs() < settings.sampling.period_tolerance)
        })?;
        // a laminar phase of chaos can look like a cycle, but it does not attract
        let turns = span_of(period, window) / period;
        let attracts = self.growth[last] < self.growth[last - (turns * period) as usize];
        attracts.then_some(period as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The fate of an orbit whose state and growth after n periods are given.
    fn fate(longest: u32, of: impl Fn(u32) -> ([f64; 2], f64)) -> End {
        let settings = Settings::default();
        let mut track = Track::new(of(0).0, 0);
        for n in 1..=longest + confirming(&settings) {
            let (state, growth) = of(n);
            track.states.push(state);
            track.growth.push(growth);
        }
        track.fate(&settings, longest).end
    }

    /// States that never repeat, within 1 of the origin.
    fn wandering(n: u32) -> [f64; 2] {
        [(1.7 * f64::from(n * n)).sin(), f64::from(n).sin()]
    }

    #[test]
    fn a_cycle_is_dated_to_the_period() {
        let cycle = |n: u32| [0.3 * f64::from(n % 3), 0.5];
        let chaos_until = |at: u32| {
            move |n: u32| {
                if n < at {
                    (wandering(n), 0.3 * f64::from(n))
                } else {
                    (cycle(n), -0.2 * f64::from(n))
                }
            }
        };
        for at in [1, 2, 17, 400, 490] {
            assert_eq!(fate(500, chaos_until(at)), End::Settled(at));
        }
        for at in [501, 560, 10_000] {
            assert_eq!(fate(500, chaos_until(at)), End::Lasting);
        }
        // the approach to the cycle, 0.9^n, counts until it is near
        let approach = |n: u32| ([0.9f64.powi(n as i32), 0.0], -0.1 * f64::from(n));
        assert_eq!(
            fate(500, approach),
            End::Settled((NEAR.ln() / 0.9f64.ln()).ceil() as u32)
        );
        // the same states in another order of phases are not yet those of the cycle
        let shifted = |n: u32| (cycle(if n < 100 { n + 1 } else { n }), -0.2 * f64::from(n));
        assert_eq!(fate(500, shifted), End::Settled(100));
    }

    #[test]
    fn what_repeats_but_repels_is_no_end() {
        assert_eq!(fate(500, |n| ([0.5; 2], 0.1 * f64::from(n))), End::Lasting);
    }

    #[test]
    fn a_torus_is_dated_by_growth() {
        let torus = |n: u32| [f64::from(n).sin(), f64::from(n).cos()];
        let swing = |n: u32| (0.7 * f64::from(n)).sin();
        let End::Settled(at) = fate(500, |n| {
            let growth = 0.2 * f64::from(n.min(300)) + swing(n);
            (if n < 300 { wandering(n) } else { torus(n) }, growth)
        }) else {
            panic!("a torus is an end")
        };
        // earlier by the time in which a disturbance grows by SWING
        assert!((270..=300).contains(&at), "{at}");
        assert_eq!(fate(500, |n| (torus(n), swing(n))), End::Settled(0));
        assert_eq!(fate(500, |n| (torus(n), 0.05 * f64::from(n))), End::Lasting);
    }
}
