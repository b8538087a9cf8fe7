//! Stores before a run: gone on with, created, replaced or mended.
//!
//! Owns the rule that results of another experiment are not overwritten.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::Duration;

use super::{Lock, Store, StoreError, Use, clean_beside, free_space, looks_like_a_store, size_bytes};
use crate::experiment::Experiment;
use crate::measure::Quantity;
use crate::output::PROGRAM;

/// How long to wait before a store that another process creates is looked for again.
const WAIT: Duration = Duration::from_millis(50);

/// What is to be stored, and how it is to be treated if something is there already.
pub struct Wanted<'a> {
    /// What is to be computed.
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

/// A store that is ready to be written.
pub struct Opened {
    /// The store.
    pub store: Store,
    /// What was done to it, for the user: it was damaged, and is mended.
    pub note: Option<String>,
}

impl Opened {
    fn new(store: Store, lock: Option<Lock>) -> Result<Self, StoreError> {
        Ok(Self {
            store: store.writing(lock)?,
            note: None,
        })
    }
}

impl Wanted<'_> {
    /// Opens the store before a run: one of the same experiment, to go on with it, or a new one.
    ///
    /// # Errors
    /// If another process uses the store alone, it cannot be gone on with and `force` is not given, the place cannot be written, or the
    /// disk is too small.
    pub fn open(&self, path: &Path) -> Result<Opened, StoreError> {
        let take = |used| match Lock::of_store(path, used) {
            Err(StoreError::NoLocks { .. }) if self.alone => Ok(None),
            lock => lock.map(Some),
        };
        if self.force {
            let lock = take(Use::Alone)?;
            check_replaceable(path)?;
            self.replace(path)?;
            return Opened::new(Store::open(path)?, lock);
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
                Ok(Some(store)) => return Opened::new(store, lock),
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
                Err(error @ StoreError::Metadata { .. }) => {
                    drop(lock);
                    let lock = take(Use::Alone)?;
                    let mended = Store::mend(path, self.experiment, self.quantities);
                    let mended = mended.map_err(|reason| StoreError::NotMended {
                        damage: error.to_string(),
                        reason: Box::new(reason),
                    })?;
                    return Ok(Opened {
                        store: mended.writing(lock)?,
                        note: Some(format!(
                            "{error}: it was written anew; the units that are sound are kept"
                        )),
                    });
                }
                Err(error) => return Err(error),
            }
        }
    }

    /// Creates the store, unless another process was faster.
    fn create(&self, path: &Path, is_alone: bool) -> Result<(), StoreError> {
        if fs::symlink_metadata(path).is_ok() {
            return Ok(());
        }
        if is_alone {
            clean_beside(path);
        }
        self.check_room(path)?;
        match Store::create(path, self.experiment, self.quantities, self.unit) {
            Err(StoreError::Exists { .. }) => Ok(()),
            created => created.map(|_| ()),
        }
    }

    /// The store to go on with; None if there is nothing.
    ///
    /// # Errors
    /// If what is there cannot be gone on with.
    pub fn resumable(&self, path: &Path) -> Result<Option<Store>, StoreError> {
        if fs::symlink_metadata(path).is_err() {
            return Ok(None);
        }
        let store = Store::open(path)?;
        let path = || path.to_owned();
        if let Some(difference) = store.experiment().difference(self.experiment) {
            return Err(StoreError::OtherExperiment {
                path: path(),
                difference,
            });
        }
        if store.attribute("program").and_then(|program| program.as_str()) != Some(PROGRAM) {
            return Err(StoreError::OtherProgram { path: path() });
        }
        let is_missing = |quantity: &&Quantity| !store.quantities().contains(quantity);
        if let Some(quantity) = self.quantities.iter().find(is_missing) {
            return Err(StoreError::Lacks {
                path: path(),
                quantity: quantity.info().name,
            });
        }
        Ok(Some(store))
    }

    /// Whether the disk has room for a new store.
    fn check_room(&self, path: &Path) -> Result<(), StoreError> {
        let needed = size_bytes(self.experiment, self.quantities, self.unit);
        let free = free_space(path).map_err(|error| StoreError::write(path, &error))?;
        if needed > free {
            return Err(StoreError::NoRoom {
                path: path.to_owned(),
                needed,
                free,
            });
        }
        Ok(())
    }

    /// Puts a new store in place of what is there, which goes only once the new one is there.
    fn replace(&self, path: &Path) -> Result<(), StoreError> {
        self.check_room(path)?;
        let create = || Store::create(path, self.experiment, self.quantities, self.unit);
        if fs::symlink_metadata(path).is_err() {
            return create().map(|_| ());
        }
        let cannot = |error: std::io::Error| StoreError::write(path, &error);
        let mut aside = path.to_owned().into_os_string();
        aside.push(".replaced");
        let aside = PathBuf::from(aside);
        fs::rename(path, &aside).map_err(cannot)?;
        if let Err(error) = create() {
            fs::rename(&aside, path).map_err(cannot)?;
            return Err(error);
        }
        fs::remove_dir_all(&aside).map_err(|error| StoreError::write(&aside, &error))
    }
}

/// A store may be replaced, however damaged; nothing else.
///
/// # Errors
/// [`StoreError::NotReplaced`] if there is something else.
pub fn check_replaceable(path: &Path) -> Result<(), StoreError> {
    if fs::symlink_metadata(path).is_err() || looks_like_a_store(path) {
        return Ok(());
    }
    Err(StoreError::NotReplaced { path: path.to_owned() })
}
