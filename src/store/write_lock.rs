//! The right to write a store, which one process has at a time.
//!
//! Owns the file that stands for it: beside the store, since whatever else is in a store's folder is taken for a part of it by readers.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use super::error::StoreError;

/// Held while a store is written; the operating system gives it back when its process ends, however that ends.
#[derive(Debug)]
pub struct WriteLock {
    path: PathBuf,
    /// Locked. None where the file system knows no locks: there nothing keeps processes apart.
    file: Option<File>,
}

impl WriteLock {
    /// Takes the lock of a store, which need not be there yet.
    ///
    /// # Errors
    /// [`StoreError::Busy`] if another process has it, [`StoreError::Write`] if no file can be made beside the store.
    pub fn take(store: &Path) -> Result<Self, StoreError> {
        Self::lock(store, |file, path| match file.try_lock() {
            Ok(()) => Ok(true),
            Err(TryLockError::WouldBlock) => Err(StoreError::Busy {
                path: store.to_owned(),
                process: process(path),
            }),
            Err(TryLockError::Error(_)) => Ok(false),
        })
    }

    /// Takes the lock of a store as soon as no other process has it.
    ///
    /// # Errors
    /// [`StoreError::Write`] if no file can be made beside the store.
    pub fn wait(store: &Path) -> Result<Self, StoreError> {
        Self::lock(store, |file, _| Ok(file.lock().is_ok()))
    }

    fn lock(store: &Path, locked: impl Fn(&File, &Path) -> Result<bool, StoreError>) -> Result<Self, StoreError> {
        let failed = |error: io::Error| StoreError::Write {
            path: store.to_owned(),
            reason: error.to_string(),
        };
        let mut name = std::ffi::OsString::from(".");
        name.push(store.file_name().unwrap_or_default());
        name.push(".lock");
        let path = store.with_file_name(name);
        if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            fs::create_dir_all(folder).map_err(failed)?;
        }
        loop {
            let mut options = OpenOptions::new();
            let mut file = options
                .read(true)
                .write(true)
                .create(true)
                .truncate(false)
                .open(&path)
                .map_err(failed)?;
            if !locked(&file, &path)? {
                return Ok(Self { path, file: None });
            }
            // the process that had it may have removed the file in the meantime
            if is_at(&file, &path) {
                let id = std::process::id().to_string();
                file.set_len(0)
                    .and_then(|()| file.write_all(id.as_bytes()))
                    .map_err(failed)?;
                return Ok(Self { path, file: Some(file) });
            }
        }
    }
}

impl Drop for WriteLock {
    fn drop(&mut self) {
        // best effort: a file that is left behind is locked by nobody; removed before it is unlocked, it is nobody else's
        if self.file.is_some() {
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// The id of the process that has a lock, if it has written it already.
fn process(lock: &Path) -> Option<u32> {
    let mut text = String::new();
    File::open(lock).ok()?.read_to_string(&mut text).ok()?;
    text.trim().parse().ok()
}

/// Whether an open file is the one at a path.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let identity = |metadata: fs::Metadata| (metadata.dev(), metadata.ino());
    let (open, named) = (file.metadata().map(identity), fs::metadata(path).map(identity));
    matches!((open, named), (Ok(open), Ok(named)) if open == named)
}

/// An open file cannot be removed there.
#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_at_a_time_has_the_lock() {
        let folder = tempfile::tempdir().unwrap();
        let store = folder.path().join("new/map.zarr");
        let lock = WriteLock::take(&store).unwrap();
        let busy = WriteLock::take(&store).unwrap_err().to_string();
        assert!(busy.contains(&format!("process {}", std::process::id())), "{busy}");
        // another store is another lock
        drop(WriteLock::take(&folder.path().join("new/other.zarr")).unwrap());
        let waiting = std::thread::spawn({
            let store = store.clone();
            move || drop(WriteLock::wait(&store).unwrap())
        });
        drop(lock);
        waiting.join().unwrap();
        drop(WriteLock::take(&store).unwrap());
        assert_eq!(fs::read_dir(folder.path().join("new")).unwrap().count(), 0);
    }
}
