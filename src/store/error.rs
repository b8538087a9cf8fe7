//! What can be wrong with a store.

use std::path::PathBuf;

use super::layout::FORMAT_VERSION;
use crate::output::PROGRAM;

/// Why a store cannot be created, opened, read or written.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages tell what each is")]
pub enum StoreError {
    #[error("{} exists already: resume it, remove it, or choose another name", path.display())]
    Exists { path: PathBuf },
    #[error("there is no store at {}: give the path of a folder NAME.zarr", path.display())]
    Missing { path: PathBuf },
    #[error(
        "{} is not a map of tribochaos, or its creation was cut short: give another path, or remove it",
        path.display()
    )]
    Foreign { path: PathBuf },
    #[error(
        "{} has format version {found}, and {PROGRAM} reads version {FORMAT_VERSION}: use the version of the program \
         that wrote it",
        path.display()
    )]
    Version { path: PathBuf, found: String },
    #[error("{} is damaged: {what}; restore it from a copy, or remove it and compute it again", path.display())]
    Damaged { path: PathBuf, what: String },
    #[error(
        "{} is being written by another process{}: wait for it by --wait, or give another --out",
        path.display(),
        process.map(|id| format!(" (process {id})")).unwrap_or_default()
    )]
    Busy { path: PathBuf, process: Option<u32> },
    #[error("{} cannot be written: {reason}; check the folder's permissions and the free space", path.display())]
    Write { path: PathBuf, reason: String },
}
