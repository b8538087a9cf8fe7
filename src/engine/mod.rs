//! The engine: an experiment is divided into units of work, a backend measures them one by one, and a sink takes each unit when
//! it is complete.
//!
//! Owns the order of the work, which part of it is left, the fall-back to another backend, and cancellation; neither draws nor
//! prints, and knows no file.

pub mod audit;
mod backends;
pub mod choice;
pub mod estimate;
pub mod initial_states;
mod part;
mod sink;
mod table;

use std::iter;
use std::ops::ControlFlow;
use std::panic::resume_unwind;
use std::slice::from_mut;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::{ScopedJoinHandle, scope, sleep};
use std::time::{Duration, Instant};

use rayon::prelude::*;

pub use self::backends::Backends;
pub use self::part::{Part, PartError};
pub use self::sink::{Claim, Condition, Origin, Sink, SinkError};
pub use self::table::Table;
use crate::backend::BackendError;
use crate::experiment::{Experiment, Settings};
use crate::measure::Measurement;
use crate::results::{Results, Tally};

/// A message of a run to its observer.
pub enum Event<'a> {
    /// This number of instance-periods of a unit was done since the last event. A run that is decided early counts as one of full
    /// length.
    Advanced(u64),
    /// The sink has a unit already, from an earlier run or from another process.
    Found {
        /// Its points.
        tally: &'a Tally,
        /// Their work at full length.
        instance_periods: u64,
    },
    /// A unit in the sink is damaged, and is computed again.
    Damaged {
        /// Which unit.
        unit: usize,
        /// What is wrong, and where.
        what: &'a str,
    },
    /// A unit was computed, and the sink has it.
    Finished(&'a Tally),
    /// Nothing is left but units that other processes compute.
    Waiting,
    /// The backend failed; the fall-back goes on from the last finished batch.
    FellBack {
        /// Why the backend failed.
        error: &'a BackendError,
        /// The device of the fall-back, in words.
        device: &'a str,
    },
}

/// Receives the events of a run; may break the run off.
pub type Observer<'a> = dyn FnMut(Event<'_>) -> ControlFlow<()> + Send + 'a;

/// What a run did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Work {
    /// Points that it measured, without those of units that were finished before.
    pub points: usize,
    /// Forcing periods that it integrated, of all instances.
    pub instance_periods: u64,
}

impl Work {
    fn add(&mut self, more: &Self) {
        self.points += more.points;
        self.instance_periods += more.instance_periods;
    }
}

/// Runs an experiment on the device that it asks for, into memory, without an observer.
///
/// # Errors
/// If there is no such device, or it fails.
pub fn run(experiment: &Experiment) -> Result<Results, BackendError> {
    let mut backends = choice::choose(experiment)?.backends;
    let unit = backends.points_per_unit(experiment);
    let mut table = Table::new(experiment.clone(), unit);
    let units: Vec<usize> = (0..table.units()).collect();
    match run_on(from_mut(&mut backends), experiment, &mut table, &units, &mut |_| {
        ControlFlow::Continue(())
    }) {
        Ok(_) => Ok(table.into_results()),
        Err(error) => match error.cause {
            Cause::Backend(error) => Err(error),
            Cause::Sink(_) | Cause::Stopped | Cause::Lost { .. } => {
                unreachable!("a table takes and keeps all, and nothing breaks the run off")
            }
        },
    }
}

/// Runs an experiment on the device that it asks for, and gives the sink the units that it does not have yet.
///
/// # Errors
/// If there is no such device, or as [`run_on`].
pub fn run_into(
    experiment: &Experiment,
    sink: &mut (dyn Sink + Send),
    observer: &mut Observer<'_>,
) -> Result<Work, EngineError> {
    let choice = choice::choose(experiment).map_err(|error| EngineError::new(error.into(), sink))?;
    let mut backends = choice.backends;
    let units: Vec<usize> = (0..sink.units()).collect();
    run_on(from_mut(&mut backends), experiment, sink, &units, observer)
}

/// How long to wait before units of other processes are looked at again.
const WAIT: Duration = Duration::from_millis(500);

/// Runs units of an experiment on some backends, each of which takes the next unit of the given order when it has finished one. Units that
/// the sink has are left as they are. Units that another process computes are waited for, and computed here if that process ends
/// without them.
///
/// # Errors
/// With the number of finished units, all of which the sink has: if a backend fails and no fall-back is left, the sink fails, or
/// the observer broke the run off.
pub fn run_on(
    backends: &mut [Backends],
    experiment: &Experiment,
    sink: &mut (dyn Sink + Send),
    units: &[usize],
    observer: &mut Observer<'_>,
) -> Result<Work, EngineError> {
    let mut work = Work::default();
    let mut left = units.to_vec();
    loop {
        let round = Round {
            experiment,
            units: &left,
            next: AtomicUsize::new(0),
            is_over: AtomicBool::new(false),
            sink: Mutex::new(&mut *sink),
            observer: Mutex::new(&mut *observer),
        };
        let busy = match round.run(backends) {
            Ok((done, busy)) => {
                work.add(&done);
                busy
            }
            Err(cause) => return Err(EngineError::new(cause, sink)),
        };
        if busy.is_empty() {
            break;
        }
        if observer(Event::Waiting).is_break() {
            return Err(EngineError::new(Cause::Stopped, sink));
        }
        left = busy;
        sleep(WAIT);
    }
    // what was found or written may have been taken away in the meantime
    let is_lost = |unit: &&usize| !sink.is_finished(**unit).is_ok_and(|is_finished| is_finished);
    match units.iter().find(is_lost) {
        None => Ok(work),
        Some(&unit) => Err(EngineError::new(Cause::Lost { unit }, sink)),
    }
}

/// One pass over the units that are left.
struct Round<'a, 'o> {
    experiment: &'a Experiment,
    units: &'a [usize],
    /// How many of them have been taken.
    next: AtomicUsize,
    /// Whether a backend has failed, or the run was broken off.
    is_over: AtomicBool,
    sink: Mutex<&'a mut (dyn Sink + Send)>,
    observer: Mutex<&'a mut Observer<'o>>,
}

impl<'a> Round<'a, '_> {
    /// Returns what was done, and the units that other processes have.
    fn run(&self, backends: &mut [Backends]) -> Result<(Work, Vec<usize>), Cause> {
        let results: Vec<Result<(Work, Vec<usize>), Cause>> = match backends {
            [backends] => self.run_beside(backends),
            several => scope(|scope| {
                let threads: Vec<_> = several
                    .iter_mut()
                    .map(|backends| scope.spawn(|| self.run_on(&mut [backends])))
                    .collect();
                let joined = threads.into_iter().map(ScopedJoinHandle::join);
                joined
                    .map(|result| result.unwrap_or_else(|panic| resume_unwind(panic)))
                    .collect()
            }),
        };
        let (mut work, mut busy, mut stopped) = (Work::default(), Vec::new(), false);
        for result in results {
            match result {
                Ok((done, left)) => {
                    work.add(&done);
                    busy.extend(left);
                }
                // whoever failed has stopped the others
                Err(Cause::Stopped) => stopped = true,
                Err(cause) => return Err(cause),
            }
        }
        if stopped {
            return Err(Cause::Stopped);
        }
        busy.sort_unstable();
        Ok((work, busy))
    }

    /// Takes units for one backend and for others that can work beside it, each in a thread of the pool that the backends themselves
    /// use: a unit for each, or the points of one unit after the other if there are fewer units than backends.
    fn run_beside(&self, backends: &mut Backends) -> Vec<Result<(Work, Vec<usize>), Cause>> {
        let mut others = backends.others();
        let mut workers: Vec<&mut Backends> = iter::once(backends).chain(&mut others).collect();
        if self.units.len() < workers.len() {
            return vec![self.run_on(&mut workers)];
        }
        workers
            .into_par_iter()
            .map(|worker| self.run_on(&mut [worker]))
            .collect()
    }

    /// Takes unit after unit for some backends, which share its points.
    fn run_on(&self, backends: &mut [&mut Backends]) -> Result<(Work, Vec<usize>), Cause> {
        let (mut work, mut busy) = (Work::default(), Vec::new());
        while let Some(&unit) = self.units.get(self.next.fetch_add(1, Ordering::Relaxed))
            && !self.is_over.load(Ordering::Relaxed)
        {
            match self.run_unit(unit, backends) {
                Ok(Some(done)) => work.add(&done),
                Ok(None) => busy.push(unit),
                Err(cause) => {
                    self.is_over.store(true, Ordering::Relaxed);
                    return Err(cause);
                }
            }
        }
        Ok((work, busy))
    }

    /// Measures points on some backends; None if the run was broken off.
    fn measure(
        &self,
        backends: &mut [&mut Backends],
        points: &[usize],
    ) -> Result<Option<Vec<Measurement>>, BackendError> {
        let (design, settings) = (&self.experiment.design, &self.experiment.settings);
        let share = points.len().div_ceil(backends.len()).max(1);
        let shares = backends.par_iter_mut().zip(points.par_chunks(share));
        let measured: Vec<_> = shares
            .map(|(backends, points)| {
                backends.measure(design, settings, points, &mut |event| {
                    // what another backend has ended ends here as well
                    if self.is_over.load(Ordering::Relaxed) {
                        return ControlFlow::Break(());
                    }
                    self.tell(event)
                })
            })
            .collect::<Result<_, _>>()?;
        Ok(measured
            .into_iter()
            .collect::<Option<Vec<_>>>()
            .map(|measured| measured.concat()))
    }

    /// Computes a unit that the sink lacks; None if another process is doing so.
    fn run_unit(&self, unit: usize, backends: &mut [&mut Backends]) -> Result<Option<Work>, Cause> {
        let settings = &self.experiment.settings;
        let points: Vec<usize> = self.sink().points(unit).collect();
        let found = |tally: &Tally| {
            let instance_periods = instance_periods(settings, points.len());
            go_on(self.tell(Event::Found {
                tally,
                instance_periods,
            }))
            .map(|()| Some(Work::default()))
        };
        let condition = self.sink().condition(unit)?;
        match condition {
            Condition::Missing => {}
            Condition::Whole(tally) => return found(&tally),
            Condition::Damaged { what } => go_on(self.tell(Event::Damaged { unit, what: &what }))?,
        }
        let claim = self.sink().claim(unit)?;
        let Some(_claim) = claim else {
            return Ok(None);
        };
        // another process may have finished it before the claim
        let condition = self.sink().condition(unit)?;
        if let Condition::Whole(tally) = condition {
            return found(&tally);
        }
        let started = Instant::now();
        let measured = self.measure(backends, &points)?;
        let measured = measured.ok_or(Cause::Stopped)?;
        let origin = Origin {
            device: backends[0].active().device(),
            elapsed: started.elapsed(),
        };
        self.sink().write(unit, &measured, &origin)?;
        go_on(self.tell(Event::Finished(&Tally::of(&measured))))?;
        Ok(Some(Work {
            points: points.len(),
            instance_periods: measured.iter().map(|m| u64::from(m.integrated_periods)).sum(),
        }))
    }

    fn sink(&self) -> MutexGuard<'_, &'a mut (dyn Sink + Send)> {
        self.sink.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn tell(&self, event: Event<'_>) -> ControlFlow<()> {
        let mut observer = self.observer.lock().unwrap_or_else(PoisonError::into_inner);
        observer(event)
    }
}

fn go_on(answer: ControlFlow<()>) -> Result<(), Cause> {
    match answer {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Cause::Stopped),
    }
}

/// Why a run ended before all units were finished.
#[derive(Debug, thiserror::Error)]
#[error("{cause}")]
pub struct EngineError {
    /// The backend failed, the sink failed, or the observer broke the run off.
    pub cause: Cause,
    /// Units that are complete in the sink.
    pub finished: usize,
    /// Units of the experiment.
    pub units: usize,
}

impl EngineError {
    fn new(cause: Cause, sink: &dyn Sink) -> Self {
        let is_finished = |&unit: &usize| sink.is_finished(unit).unwrap_or(false);
        Self {
            cause,
            finished: (0..sink.units()).filter(is_finished).count(),
            units: sink.units(),
        }
    }
}

/// What ended a run.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages tell what each is")]
pub enum Cause {
    #[error(transparent)]
    Backend(#[from] BackendError),
    #[error(transparent)]
    Sink(#[from] SinkError),
    #[error("the run was broken off")]
    Stopped,
    #[error(
        "unit {unit} was finished and is gone: something else has changed the results while they were computed; the same command \
         computes again what is missing"
    )]
    Lost { unit: usize },
}

/// The work of a run over `points` points at full length, in instance-periods.
pub fn instance_periods(settings: &Settings, points: usize) -> u64 {
    points as u64
        * u64::from(settings.sampling.initial_states)
        * (u64::from(settings.sampling.transient_periods) + u64::from(settings.sampling.periods))
}
