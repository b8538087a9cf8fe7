//! Stores before and after a run, in words.
//!
//! Owns what a dry run and a run that is not finished tell; what becomes of a store is the library's.

use std::path::Path;
use std::time::Duration;

use anyhow::anyhow;

use super::{Failure, request, with_causes, words};
use crate::engine::{Backends, Cause, EngineError, Sink, estimate};
use crate::experiment::{Experiment, Request};
use crate::measure::Quantity;
use crate::store::{Store, Wanted};

/// Says how much is left of the store at `path`, and how long that takes on so many devices such as this one.
///
/// # Errors
/// As [`Wanted::resumable`], or if the device fails.
pub fn dry_run(wanted: &Wanted<'_>, path: &Path, device: &mut Backends, devices: usize) -> Result<(), Failure> {
    let points = wanted.experiment.design.len();
    let store = if wanted.force {
        None
    } else {
        wanted.resumable(path).map_err(Failure::input)?
    };
    let mut left = points;
    if let Some(store) = store {
        left = points_left(&store)?;
        print_line!("{left} of {points} points are left to compute");
    }
    if left > 0 {
        let seconds = estimate::seconds(device, wanted.experiment).map_err(Failure::backend)?;
        let seconds = seconds * left as f64 / points as f64 / devices as f64;
        print_line!("about {}", words::duration(Duration::from_secs_f64(seconds)));
    }
    print_line!("would write {}", path.display());
    Ok(())
}
/// The quantities that are typed, else those of the file; None if neither has any.
///
/// # Errors
/// If the file has the name of no quantity.
pub fn quantities(typed: &[Quantity], request: &Request) -> Result<Option<Vec<Quantity>>, Failure> {
    if !typed.is_empty() {
        return Ok(Some(typed.to_vec()));
    }
    let names = request.quantities.as_ref();
    let of_file = names.map(|names| names.iter().map(|name| request::named(name)).collect());
    of_file
        .transpose()
        .map_err(|reason: String| Failure::Input(anyhow!("the file's quantities: {reason}")))
}

/// The experiment with where its results go and what is stored of them, as --print-experiment shows it.
pub fn written(request: &Request, experiment: &Experiment, quantities: &[Quantity]) -> Request {
    Request {
        out: request.out.clone(),
        quantities: Some(
            quantities
                .iter()
                .map(|quantity| quantity.info().name.to_owned())
                .collect(),
        ),
        ..experiment.request()
    }
}

/// The store that is wanted, ready to be written.
///
/// # Errors
/// As [`Wanted::open`].
pub fn open(wanted: &Wanted<'_>, path: &Path) -> Result<Store, Failure> {
    let opened = wanted.open(path).map_err(Failure::input)?;
    if let Some(note) = opened.note {
        eprintln!("note: {note}");
    }
    Ok(opened.store)
}

/// The failure for an unfinished store: the reason, the units that it has, and how to continue.
pub fn unfinished(EngineError { cause, finished, units }: EngineError, store: &Path) -> Failure {
    let kept = |reason: &str| {
        format!(
            "{reason}; {finished} of {units} units are finished and kept in {path}: the same command goes on from there",
            path = store.display()
        )
    };
    match cause {
        Cause::Stopped => Failure::Interrupted(kept("the run is not finished")),
        cause @ (Cause::Sink(_) | Cause::Lost { .. }) => Failure::run(cause),
        Cause::Backend(error) => match Failure::backend(error) {
            Failure::Run(error) => Failure::Run(anyhow!(kept(&with_causes(&error)))),
            other => other,
        },
    }
}

/// The failure for a run in memory.
pub fn not_kept(cause: Cause) -> Failure {
    match cause {
        Cause::Stopped => Failure::Interrupted("nothing is kept without --out".to_owned()),
        Cause::Backend(error) => Failure::backend(error),
        cause @ (Cause::Sink(_) | Cause::Lost { .. }) => Failure::run(cause),
    }
}

/// Number of points that are not finished.
fn points_left(store: &Store) -> Result<usize, Failure> {
    let mut left = 0;
    for unit in 0..store.units() {
        if !store.is_finished(unit).map_err(|error| Failure::Run(anyhow!(error)))? {
            left += store.points(unit).len();
        }
    }
    Ok(left)
}
