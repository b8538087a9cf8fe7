//! The engine: an experiment is cut into units of work, a backend measures them one by one, and a sink takes each when it is whole.
//!
//! Owns the order of the work, what is left of it, the fall-back to another backend, and cancellation; neither draws nor prints, and
//! knows no file.

pub mod audit;
mod backends;
pub mod choice;
pub mod estimate;
pub mod initial_states;
mod sink;
mod table;

use std::ops::ControlFlow;

pub use self::backends::Backends;
pub use self::sink::{Sink, SinkError};
pub use self::table::Table;
use crate::backend::BackendError;
use crate::experiment::{Experiment, Settings};
use crate::results::Results;

/// What a run tells while it goes on.
pub enum Event<'a> {
    /// So many instance-periods of a unit were done since the last event.
    Advanced(u64),
    /// A unit of so many instance-periods was finished by an earlier run.
    Found(u64),
    /// The backend failed; the fall-back goes on from the last finished batch.
    FellBack {
        /// Why the backend failed.
        error: &'a BackendError,
        /// The device of the fall-back, in words.
        device: &'a str,
    },
}

/// Hears events; may break the run off.
pub type Observer<'a> = dyn FnMut(Event<'_>) -> ControlFlow<()> + 'a;

/// What a run did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Work {
    /// Points that it measured; those of units that were finished before are not among them.
    pub points: usize,
    /// Forcing periods that it integrated, of all instances.
    pub instance_periods: u64,
}

/// Runs an experiment on the device that it asks for, into memory, and hears nothing of it.
///
/// # Errors
/// If there is no such device, or it fails.
pub fn run(experiment: &Experiment) -> Result<Results, BackendError> {
    let mut backends = choice::choose(experiment)?.backends;
    let unit = backends.points_per_unit(experiment);
    let mut table = Table::new(experiment.clone(), unit);
    match run_on(
        &mut backends,
        experiment,
        &mut table,
        &mut |_| ControlFlow::Continue(()),
    ) {
        Ok(_) => Ok(table.into_results()),
        Err(error) => match error.cause {
            Cause::Backend(error) => Err(error),
            Cause::Sink(_) | Cause::Stopped => unreachable!("a table takes all, and nothing breaks the run off"),
        },
    }
}

/// Runs an experiment on the device that it asks for, and gives the sink what it lacks.
///
/// # Errors
/// If there is no such device, or as [`run_on`].
pub fn run_into(
    experiment: &Experiment,
    sink: &mut dyn Sink,
    observer: &mut Observer<'_>,
) -> Result<Work, EngineError> {
    let choice = choice::choose(experiment).map_err(|error| EngineError {
        cause: error.into(),
        finished: 0,
        units: sink.units(),
    })?;
    let mut backends = choice.backends;
    run_on(&mut backends, experiment, sink, observer)
}

/// Runs an experiment on a backend, unit by unit in the order of the sink; finished units are left as they are.
///
/// # Errors
/// With the number of finished units, all of which the sink has: if the backend fails and no fall-back is left, the sink fails, or
/// the observer broke the run off.
pub fn run_on(
    backends: &mut Backends,
    experiment: &Experiment,
    sink: &mut dyn Sink,
    observer: &mut Observer<'_>,
) -> Result<Work, EngineError> {
    let (design, settings) = (&experiment.design, &experiment.settings);
    let units = sink.units();
    let mut work = Work::default();
    for unit in 0..units {
        let failed = |cause: Cause| EngineError {
            cause,
            finished: unit,
            units,
        };
        let points = sink.points(unit);
        if sink.is_finished(unit).map_err(|error| failed(error.into()))? {
            if observer(Event::Found(instance_periods(settings, points.len()))).is_break() {
                return Err(failed(Cause::Stopped));
            }
            continue;
        }
        let measured = backends.measure(design, settings, &points, observer);
        let Some(measured) = measured.map_err(|error| failed(error.into()))? else {
            return Err(failed(Cause::Stopped));
        };
        sink.write(unit, &measured, &backends.active().device())
            .map_err(|error| failed(error.into()))?;
        work.points += points.len();
        work.instance_periods += measured.iter().map(|m| u64::from(m.integrated_periods)).sum::<u64>();
    }
    Ok(work)
}

/// Why a run ended before its end.
#[derive(Debug, thiserror::Error)]
#[error("{cause}")]
pub struct EngineError {
    /// A failure of the backend or of the sink, or the observer.
    pub cause: Cause,
    /// Units that the sink has whole.
    pub finished: usize,
    /// Units of the experiment.
    pub units: usize,
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
}

/// Instance-periods of `points` points: the work of a run.
pub fn instance_periods(settings: &Settings, points: usize) -> u64 {
    points as u64
        * u64::from(settings.sampling.initial_states)
        * (u64::from(settings.sampling.transient_periods) + u64::from(settings.sampling.periods))
}
