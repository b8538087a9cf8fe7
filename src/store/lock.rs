//! Locks, by which processes that use one store are kept apart.
//!
//! Owns the files that stand for locks. The operating system gives a lock back when its process ends, however that ends.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use super::error::StoreError;
use super::mark;
#[cfg(unix)]
use super::root::identity;
use crate::output::whole::hidden;

/// A lock that is held.
#[derive(Debug)]
pub struct Lock {
    path: PathBuf,
    file: File,
}

/// How a store is used while a lock is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// Units are written, each by the process that has claimed it.
    Together,
    /// Nobody else uses the store, which is replaced or mended.
    Alone,
}

impl Lock {
    /// Takes the lock of a store, which need not be there yet: beside the store, since it must outlive one that is replaced.
    ///
    /// # Errors
    /// [`StoreError::Busy`] if another process uses the store in a way that does not go with this one, [`StoreError::NoLocks`] if the
    /// file system has no locks, [`StoreError::Write`] if no file can be made beside the store.
    pub fn of_store(store: &Path, used: Use) -> Result<Self, StoreError> {
        let path = hidden(store, "lock");
        if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            fs::create_dir_all(folder).map_err(|error| StoreError::write(store, &error))?;
        }
        let busy = |path: &Path| StoreError::Busy {
            path: store.to_owned(),
            process: process(path),
        };
        Self::take(store, &path, used)?.ok_or_else(|| busy(&path))
    }

    /// The right to write a unit; None while another process has it.
    ///
    /// # Errors
    /// [`StoreError::NoLocks`] or [`StoreError::Write`].
    pub fn of_unit(store: &Path, unit: usize) -> Result<Option<Self>, StoreError> {
        Self::take(store, &claim(store, unit), Use::Alone)
    }

    /// Removes the file of a claim that a process has left that was killed.
    pub fn clear_unit(store: &Path, unit: usize) {
        let path = claim(store, unit);
        if path.exists() {
            // what is dropped removes its file, if no other process has it
            let _ = Self::take(store, &path, Use::Alone);
        }
    }

    fn take(store: &Path, path: &Path, used: Use) -> Result<Option<Self>, StoreError> {
        loop {
            let mut options = OpenOptions::new();
            options.read(true).write(true).create(true).truncate(false);
            let mut file = options.open(path).map_err(|error| StoreError::write(store, &error))?;
            let locked = match used {
                Use::Together => file.try_lock_shared(),
                Use::Alone => file.try_lock(),
            };
            match locked {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Ok(None),
                Err(TryLockError::Error(_)) => {
                    let _ = fs::remove_file(path);
                    return Err(StoreError::NoLocks { path: store.to_owned() });
                }
            }
            // the process that had it may have removed the file in the meantime
            if is_at(&file, path) {
                let id = std::process::id().to_string();
                file.set_len(0)
                    .and_then(|()| file.write_all(id.as_bytes()))
                    .map_err(|error| StoreError::write(store, &error))?;
                return Ok(Some(Self {
                    path: path.to_owned(),
                    file,
                }));
            }
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // best effort: a file that is left behind is locked by nobody. Only the last user of a store may remove the file, and holds
        // the lock alone while it does so.
        if self.file.try_lock().is_ok() && is_at(&self.file, &self.path) {
            let _ = fs::remove_file(&self.path);
        }
    }
}

fn claim(store: &Path, unit: usize) -> PathBuf {
    mark::folder(store).join(format!("{unit}.claim"))
}

/// The id of a process that has a lock, if it has written it already.
fn process(lock: &Path) -> Option<u32> {
    let mut text = String::new();
    File::open(lock).ok()?.read_to_string(&mut text).ok()?;
    text.trim().parse().ok()
}

/// Whether an open file is the one at a path.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    identity(file.metadata()).is_some_and(|open| identity(fs::metadata(path)) == Some(open))
}

/// Files have no identity there that the standard library tells.
#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stores_are_used_together_or_alone() {
        let folder = tempfile::tempdir().unwrap();
        let store = folder.path().join("new/map.zarr");
        let take = |used| Lock::of_store(&store, used);
        let (one, other) = (take(Use::Together).unwrap(), take(Use::Together).unwrap());
        let busy = take(Use::Alone).unwrap_err().to_string();
        assert!(busy.contains(&format!("process {}", std::process::id())), "{busy}");
        drop(one);
        assert!(matches!(take(Use::Alone), Err(StoreError::Busy { .. })));
        drop(other);
        let alone = take(Use::Alone).unwrap();
        assert!(matches!(take(Use::Together), Err(StoreError::Busy { .. })));
        // another store is another lock
        drop(Lock::of_store(&folder.path().join("new/other.zarr"), Use::Alone).unwrap());
        drop(alone);
        assert_eq!(fs::read_dir(folder.path().join("new")).unwrap().count(), 0);
    }
}
