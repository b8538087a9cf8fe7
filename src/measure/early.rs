//! Early decisions: the kind of an instance's motion, as soon as it is clear.
//!
//! Owns when instances are examined and what decides them. Without wear, a state and its tangent vectors describe an instance
//! completely. Undecided instances are therefore loaded again as a smaller batch, and decided ones cost nothing more. An
//! instance that is never decided here runs to its full length.
//!
//! - An orbit that has come near an attracting cycle is regular: the Floquet multipliers of the cycle are its exponents,
//!   without any average.
//! - An orbit whose mean growth stands many standard errors above zero is chaotic, if the error can be trusted. With heat, the shaft
//!   must have warmed up before growth counts.
//! - Runaways, and instances that the scheme has given up, are dropped.

use std::ops::{ControlFlow, Range};

use super::cycle::{self, Candidate};
use super::evaluation::{Ended, GrowthSums, runaway};
use super::whole_run;
use super::{CONSTANT_GROWTH, Class, Measurement, Status};
use crate::backend::{Backend, BackendError, BackendKind, Contact, EndState, Instance, Slice, Stage, Sums};
use crate::dynamics::statistics::Spread;
use crate::experiment::{Sampling, Settings};
use crate::model::rubbing::{has_ramp_ended, is_warm};

/// Forcing periods of each of the first legs. A leg is a part of the run; at its end, the undecided instances are examined. These legs
/// are the motion alone, and most cycles are reached within them.
const WATCHED_LEG: u32 = 4;

/// Forcing periods after which tangent vectors are carried...
const WATCHED: u32 = 40;

/// ...and after which their growth counts towards the exponent of a chaotic motion.
const SETTLING: u32 = 48;

/// Periods of a batch mean of that growth.
const BATCH: u32 = 8;

/// Forcing periods of the legs in which growth counts: those that begin before [`SHORT_UNTIL`], and the others.
const SHORT_LEG: u32 = 16;
const SHORT_UNTIL: u32 = 80;
const LEG: u32 = 32;

/// A cycle is looked for near an orbit whose stroboscopic states repeat within this distance throughout a leg. Newton's method mostly
/// finds the cycle from there.
const CLOSE: f64 = 0.02;

/// A search takes at least this many times the period of the cycle...
const SHORT_SEARCH: u32 = 4;

/// ...and all searches of an orbit together take at most this many forcing periods and this share of its run. Near some orbits
/// there is no cycle, and chaos comes close to many that do not attract.
const FREE: u32 = 8;
const SHARE: u32 = 4;

/// Until this period, growth is summed up period by period, for the scatter of single periods.
const SAMPLED_UNTIL: u32 = 112;

/// A motion is chaotic once its mean growth stands this many standard errors above zero...
const CERTAINTY: f64 = 6.0;

/// ...and this many standard errors of independent periods. Where growth alternates between bands, batch means give too small an
/// error until the orbit has left the order of the bands several times. An early decision would select the runs that have not
/// left it, and their growth is too large...
const BANDED_CERTAINTY: f64 = 5.0;

/// ...and once vectors have grown by more than exp of this. If an orbit leaves an unstable cycle, its distance from the cycle
/// grows steadily, too: from the distance at which it would have counted as on the cycle, exp(-8.5) with the default tolerance,
/// to that of other motion...
const GROWN: f64 = 9.0;

/// ...over at least this many periods, so that the errors are reliable, and over at least half of the periods that were asked
/// for, so that more periods give a smaller error.
const LEAST_PERIODS: u32 = 160;

/// Measures a batch of instances without wear. `progress` counts every instance with its full length, also if it
/// was decided early. None if `progress` stopped the run.
///
/// # Errors
/// If the backend fails.
pub(super) fn measure(
    backend: &mut dyn Backend,
    settings: &Settings,
    instances: &[Instance],
    progress: &mut dyn FnMut(u64) -> ControlFlow<()>,
) -> Result<Option<Vec<Measurement>>, BackendError> {
    let mut batch = Batch {
        settings,
        live: instances
            .iter()
            .enumerate()
            .map(|(index, instance)| Live::new(index, instance))
            .collect(),
        measured: vec![None; instances.len()],
    };
    let mut elapsed = 0;
    for leg in legs(settings.sampling.transient_periods) {
        if batch.carry_on(backend, leg.clone(), progress)?.is_break() {
            return Ok(None);
        }
        batch.find_cycles(backend, leg.end)?;
        batch.find_chaos(backend, leg.end);
        elapsed = leg.end;
        if batch.settle_up(elapsed, progress).is_break() {
            return Ok(None);
        }
        if batch.live.is_empty() {
            break;
        }
    }
    batch.run_out(backend, elapsed, progress)
}

/// The legs within the transient, as ranges of periods since the start of the run.
fn legs(transient: u32) -> Vec<Range<u32>> {
    let length = |start: u32| match start {
        ..WATCHED => WATCHED_LEG,
        WATCHED..SETTLING => SETTLING - start,
        SETTLING..SHORT_UNTIL => SHORT_LEG,
        _ => LEG,
    };
    std::iter::successors(Some(0..length(0)), |leg| Some(leg.end..leg.end + length(leg.end)))
        .take_while(|leg| leg.end <= transient)
        .collect()
}

/// The settings of a run over some periods, all of which are measured.
fn over(settings: &Settings, periods: u32) -> Settings {
    Settings {
        sampling: Sampling {
            transient_periods: 0,
            align_periods: 0,
            periods,
            period_tolerance: CLOSE,
            ..settings.sampling
        },
        ..*settings
    }
}

/// An instance that is not decided.
struct Live {
    /// Index in the batch as it was at first.
    index: usize,
    /// The instance in its present state.
    instance: Instance,
    /// Least and greatest x, since growth counts.
    extremes: [f64; 2],
    growth: GrowthSums,
    /// Scatter of the growth of single periods.
    spread: Spread,
    /// The period of the cycle that it may be on.
    candidate: Option<u32>,
    /// Periods that were spent on examining cycles, besides those of the run.
    turned: u32,
}

impl Live {
    fn new(index: usize, instance: &Instance) -> Self {
        Self {
            index,
            instance: instance.clone(),
            extremes: [f64::INFINITY, f64::NEG_INFINITY],
            growth: GrowthSums::default(),
            spread: Spread::default(),
            candidate: None,
            turned: 0,
        }
    }

    /// The instance as a candidate for a cycle, if it may be on one.
    fn on_cycle(&self) -> Option<Candidate> {
        Some(Candidate {
            instance: self.instance.clone(),
            period: self.candidate?,
        })
    }

    /// Its present state, as the end state of a motion on no cycle.
    fn passing(&self) -> EndState {
        EndState {
            x: self.instance.state[0],
            y: self.instance.state[1],
            tangent: self.instance.tangent,
            x_min: self.extremes[0],
            x_max: self.extremes[1],
            period: None,
            runaway_periods: None,
            under_resolved: false,
            heated: self.instance.heated.clone(),
            contact: self
                .instance
                .heated
                .as_ref()
                .map_or(Contact::CONSTANT, |heated| heated.contact),
        }
    }

    /// Its measurement if it is chaotic beyond doubt.
    fn if_chaotic(&self, settings: &Settings, elapsed: u32, backend: BackendKind) -> Option<Measurement> {
        let periods = elapsed.saturating_sub(SETTLING);
        let parameters = &self.instance.parameters;
        let start = f64::from(SETTLING) * parameters.forcing_period();
        let may_count =
            !parameters.has_heat_or_wear() || (has_ramp_ended(parameters, start) && is_warm(parameters, start));
        if !may_count || periods < LEAST_PERIODS.max(settings.sampling.periods / 2) {
            return None;
        }
        let measurement = self.growth.measurement(&Ended {
            parameters,
            settings: &over(settings, periods),
            elapsed,
            state: &self.passing(),
            backend,
        });
        let lyapunov = measurement.lyapunov;
        let is_certain = lyapunov > CERTAINTY * measurement.lyapunov_error
            && lyapunov > BANDED_CERTAINTY * self.spread.independent_error(periods) / parameters.forcing_period()
            && lyapunov * measurement.lyapunov_interval > GROWN
            && measurement.lyapunov_error > CONSTANT_GROWTH;
        (measurement.class == Some(Class::Chaotic) && is_certain).then(|| Measurement {
            // the Birkhoff weights of single legs are not those of the whole run
            lyapunov_birkhoff: self.growth.weighted_rate() / parameters.forcing_period(),
            ..measurement
        })
    }

    /// Its measurement if it has run away or been given up.
    fn given_up(&self, end: &EndState, kind: BackendKind) -> Option<Measurement> {
        let unresolved = || Measurement {
            contact: if self.instance.parameters.has_heat_or_wear() {
                end.contact
            } else {
                Contact::UNKNOWN
            },
            ..Measurement::unmeasured(Status::UnderResolved, kind)
        };
        runaway(&self.instance.parameters, end, kind).or_else(|| end.under_resolved.then(unresolved))
    }

    /// Its measurement after `periods` periods of the run, with the initial state of its point.
    fn own(&self, measurement: Measurement, periods: u32) -> Measurement {
        Measurement {
            integrated_periods: periods + self.turned,
            initial_state: self.instance.parameters.initial_state(),
            ..measurement
        }
    }
}

struct Batch<'a> {
    settings: &'a Settings,
    live: Vec<Live>,
    /// In the order of the batch as it was at first.
    measured: Vec<Option<Measurement>>,
}

impl Batch<'_> {
    /// The live instances in their present states.
    fn present(&self) -> Vec<Instance> {
        self.live.iter().map(|live| live.instance.clone()).collect()
    }

    /// Integrates all live instances over a leg; those that run away or are given up are measured.
    fn carry_on(
        &mut self,
        backend: &mut dyn Backend,
        leg: Range<u32>,
        progress: &mut dyn FnMut(u64) -> ControlFlow<()>,
    ) -> Result<ControlFlow<()>, BackendError> {
        let stage = if leg.start < WATCHED {
            Stage::Watch
        } else {
            Stage::Measure
        };
        backend.load(&over(self.settings, leg.end - leg.start), &self.present())?;
        let length = leg.end - leg.start;
        for first in (0..length).step_by(BATCH as usize) {
            let until = (first + BATCH).min(length);
            let stride = if (SETTLING..SAMPLED_UNTIL).contains(&leg.start) {
                1
            } else {
                until - first
            };
            let mut batch = vec![Sums::default(); self.live.len()];
            for first in (first..until).step_by(stride as usize) {
                backend.advance(&Slice {
                    stage,
                    first,
                    periods: stride,
                    elapsed: leg.start + first,
                })?;
                if leg.start < SETTLING {
                    continue;
                }
                for ((live, batch), sums) in self.live.iter_mut().zip(&mut batch).zip(backend.collect()?) {
                    batch.add(&sums);
                    if stride == 1 {
                        live.spread.add(sums.growth[0]);
                    }
                }
            }
            if leg.start >= SETTLING {
                for (live, sums) in self.live.iter_mut().zip(&batch) {
                    live.growth.add(BATCH.into(), sums);
                }
            }
            if progress(u64::from(until - first) * self.live.len() as u64).is_break() {
                return Ok(ControlFlow::Break(()));
            }
        }
        let kind = backend.kind();
        for (live, end) in self.live.iter_mut().zip(backend.end_states()?) {
            live.instance = live.instance.at(&end);
            live.candidate = end.period;
            if leg.start >= SETTLING {
                live.extremes = [live.extremes[0].min(end.x_min), live.extremes[1].max(end.x_max)];
            }
            self.measured[live.index] = live.given_up(&end, kind);
        }
        Ok(ControlFlow::Continue(()))
    }

    /// Measures the instances near whose state there is the cycle to which they go.
    fn find_cycles(&mut self, backend: &mut dyn Backend, elapsed: u32) -> Result<(), BackendError> {
        let measured = &mut self.measured;
        let near_cycle = |live: &&mut Live| {
            measured[live.index].is_none()
                && live
                    .candidate
                    .is_some_and(|period| live.turned + SHORT_SEARCH * period <= FREE + elapsed / SHARE)
        };
        let mut watched: Vec<&mut Live> = self.live.iter_mut().filter(near_cycle).collect();
        let candidates: Vec<Candidate> = watched.iter().filter_map(|live| live.on_cycle()).collect();
        for (live, found) in watched
            .iter_mut()
            .zip(cycle::find(backend, self.settings, &candidates)?)
        {
            live.turned += found.periods;
            if found.moved > self.settings.sampling.period_tolerance {
                live.candidate = None;
            }
            measured[live.index] = found.measurement;
        }
        Ok(())
    }

    /// Measures the instances that are chaotic beyond doubt.
    fn find_chaos(&mut self, backend: &dyn Backend, elapsed: u32) {
        let kind = backend.kind();
        for live in &self.live {
            // a candidate may be in a laminar phase of chaos, or on the way to a cycle
            if live.candidate.is_none() && self.measured[live.index].is_none() {
                self.measured[live.index] = live.if_chaotic(self.settings, elapsed, kind);
            }
        }
    }

    /// Drops the instances that have been measured, and reports their full length as done.
    fn settle_up(&mut self, elapsed: u32, progress: &mut dyn FnMut(u64) -> ControlFlow<()>) -> ControlFlow<()> {
        let full = self.settings.sampling.transient_periods + self.settings.sampling.periods;
        let measured = &mut self.measured;
        let mut dropped = 0;
        self.live.retain(|live| {
            let Some(measurement) = measured[live.index] else {
                return true;
            };
            measured[live.index] = Some(live.own(measurement, elapsed));
            dropped += 1;
            false
        });
        progress(dropped * u64::from(full - elapsed))
    }

    /// Runs the instances that are undecided after `elapsed` periods to their full length.
    fn run_out(
        mut self,
        backend: &mut dyn Backend,
        elapsed: u32,
        progress: &mut dyn FnMut(u64) -> ControlFlow<()>,
    ) -> Result<Option<Vec<Measurement>>, BackendError> {
        if self.live.is_empty() {
            return Ok(self.measured.into_iter().collect());
        }
        let transient_periods = self.settings.sampling.transient_periods - elapsed;
        let settings = Settings {
            sampling: Sampling {
                transient_periods,
                align_periods: self.settings.sampling.align_periods.min(transient_periods),
                ..self.settings.sampling
            },
            ..*self.settings
        };
        let Some(measured) = whole_run::measure(backend, &settings, &self.present(), elapsed, progress)? else {
            return Ok(None);
        };
        for (live, measurement) in self.live.iter().zip(measured) {
            self.measured[live.index] = Some(live.own(measurement, measurement.integrated_periods));
        }
        Ok(self.measured.into_iter().collect())
    }
}
