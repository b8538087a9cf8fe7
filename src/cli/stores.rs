//! Stores before a run: gone on with, created, replaced or mended.
//!
//! Owns the rule that results of another experiment are not overwritten; the format is the library's.

use std::fs;
use std::path::Path;
use std::thread::sleep;
use std::time::Duration;

use crate::engine::{Backends, Cause, EngineError, Sink, estimate};
use crate::experiment::{Experiment, Request};
use crate::measure::Quantity;
use crate::output::PROGRAM;
use crate::store::{self, Lock, Store, StoreError, Use};
use anyhow::{Context, anyhow, bail};

use super::words::bytes;
use super::{Failure, request, with_causes, words};

/// How long to wait before a store that another process creates is looked for again.
const WAIT: Duration = Duration::from_millis(50);

/// What is to be stored, and how it is to be treated if something is there already.
pub struct Wanted<'a> {
    pub experiment: &'a Experiment,
    /// Quantities of a new store, or those that a store must have.
    pub quantities: &'a [Quantity],
    /// Points in a unit of a new store, about.
    pub unit: usize,
    /// Whether a store that is there is replaced.
    pub force: bool,
    /// Whether no other process uses the store, or writes units of this one's part, so that no locks are needed.
    pub alone: bool,
}

impl Wanted<'_> {
    /// Opens the store before a run: one of the same experiment, to go on with it, or a new one.
    ///
    /// # Errors
    /// If another process uses the store alone, it cannot be gone on with and `force` is not given, the place cannot be written, or the
    /// disk is too small.
    pub fn open(&self, path: &Path) -> anyhow::Result<Store> {
        let take = |used| match Lock::of_store(path, used) {
            Err(StoreError::NoLocks { .. }) if self.alone => Ok(None),
            lock => lock.map(Some),
        };
        if self.force {
            let lock = take(Use::Alone)?;
            check_replaceable(path)?;
            self.replace(path)?;
            return Ok(Store::open(path)?.writing(lock)?);
        }
        let mut patience = 40;
        loop {
            let lock = take(Use::Together);
            let lock = match lock {
                // another process creates it
                Err(StoreError::Busy { .. }) if patience > 0 => {
                    patience -= 1;
                    sleep(WAIT);
                    continue;
                }
                lock => lock?,
            };
            match self.resumable(path) {
                Ok(Some(store)) => return Ok(store.writing(lock)?),
                Ok(None) => {
                    drop(lock);
                    match take(Use::Alone) {
                        Err(StoreError::Busy { .. }) => sleep(WAIT),
                        lock => {
                            let lock = lock?;
                            self.create(path, lock.is_some())?;
                        }
                    }
                }
                Err(error) if matches!(error.downcast_ref(), Some(StoreError::Metadata { .. })) => {
                    drop(lock);
                    let lock = take(Use::Alone)?;
                    let store = Store::mend(path, self.experiment, self.quantities)
                        .with_context(|| format!("{error}; give another --out, or --force to replace it"))?;
                    eprintln!("note: {error}: it was written anew; the units that are sound are kept");
                    return Ok(store.writing(lock)?);
                }
                Err(error) => return Err(error),
            }
        }
    }

    /// Creates the store, unless another process was faster.
    fn create(&self, path: &Path, is_alone: bool) -> anyhow::Result<()> {
        if fs::symlink_metadata(path).is_ok() {
            return Ok(());
        }
        if is_alone {
            store::clean_beside(path);
        }
        self.check_room(path)?;
        match Store::create(path, self.experiment, self.quantities, self.unit) {
            Err(StoreError::Exists { .. }) => Ok(()),
            created => Ok(created.map(|_| ())?),
        }
    }

    /// The store to go on with; None if there is nothing.
    ///
    /// # Errors
    /// If what is there cannot be gone on with.
    pub fn resumable(&self, path: &Path) -> anyhow::Result<Option<Store>> {
        if fs::symlink_metadata(path).is_err() {
            return Ok(None);
        }
        let store = Store::open(path)?;
        if let Some(difference) = store.experiment().difference(self.experiment) {
            bail!(
                "{} holds the results of another experiment ({difference}): give another --out, or --force to replace them",
                path.display()
            );
        }
        if store.attribute("program").and_then(|program| program.as_str()) != Some(PROGRAM) {
            bail!(
                "{} was computed by another version of the program: give another --out, or --force to replace it",
                path.display()
            );
        }
        let is_missing = |quantity: &&Quantity| !store.quantities().contains(quantity);
        if let Some(quantity) = self.quantities.iter().find(is_missing) {
            bail!(
                "{} does not hold {}, which is asked for: give another --out, or --force to compute all anew",
                path.display(),
                quantity.info().name
            );
        }
        Ok(Some(store))
    }

    /// Says how much is left of the store at `path`, and how long that takes on so many devices such as this one.
    ///
    /// # Errors
    /// As [`Wanted::resumable`], or if the device fails.
    pub fn dry_run(&self, path: &Path, device: &mut Backends, devices: usize) -> Result<(), Failure> {
        let points = self.experiment.design.len();
        let store = if self.force {
            None
        } else {
            self.resumable(path).map_err(Failure::Input)?
        };
        let mut left = points;
        if let Some(store) = store {
            left = points_left(&store)?;
            print_line!("{left} of {points} points are left to compute");
        }
        if left > 0 {
            let seconds = estimate::seconds(device, self.experiment).map_err(Failure::backend)?;
            let seconds = seconds * left as f64 / points as f64 / devices as f64;
            print_line!("about {}", words::duration(Duration::from_secs_f64(seconds)));
        }
        print_line!("would write {}", path.display());
        Ok(())
    }

    /// Whether the disk has room for a new store.
    fn check_room(&self, path: &Path) -> anyhow::Result<()> {
        let size = store::size_bytes(self.experiment, self.quantities, self.unit);
        let free = store::free_space(path).with_context(|| format!("cannot write {}", path.display()))?;
        if size > free {
            bail!(
                "the store {} would take {}, and the disk has {} free: use fewer points or quantities, or another disk",
                path.display(),
                bytes(size),
                bytes(free)
            );
        }
        Ok(())
    }

    /// Puts a new store in place of what is there, which goes only once the new one is there.
    fn replace(&self, path: &Path) -> anyhow::Result<()> {
        self.check_room(path)?;
        let create = || Store::create(path, self.experiment, self.quantities, self.unit);
        if fs::symlink_metadata(path).is_err() {
            create()?;
            return Ok(());
        }
        let mut aside = path.to_owned().into_os_string();
        aside.push(".replaced");
        fs::rename(path, &aside).with_context(|| format!("cannot replace {}", path.display()))?;
        if let Err(error) = create() {
            fs::rename(&aside, path).with_context(|| format!("cannot put {} back", path.display()))?;
            return Err(error.into());
        }
        fs::remove_dir_all(&aside).with_context(|| format!("cannot remove {}", Path::new(&aside).display()))
    }
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

/// A store may be replaced, however damaged; nothing else.
///
/// # Errors
/// If there is something else.
pub fn check_replaceable(path: &Path) -> anyhow::Result<()> {
    if fs::symlink_metadata(path).is_err() || store::looks_like_a_store(path) {
        return Ok(());
    }
    bail!(
        "{} is no store of this program: it is not replaced, move it away",
        path.display()
    );
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
