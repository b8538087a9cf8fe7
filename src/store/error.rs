//! What can be wrong with a store.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use crate::output::{PROGRAM, words};

/// Why a store cannot be created, opened, read or written.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages tell what each is")]
pub enum StoreError {
    #[error("{} exists already: resume it, remove it, or choose another name", path.display())]
    Exists { path: PathBuf },
    #[error("there is no store at {}: give the path of a folder NAME.zarr", path.display())]
    Missing { path: PathBuf },
    #[error("{} is not a store of tribochaos: give another path, or move it away", path.display())]
    Foreign { path: PathBuf },
    #[error(
        "{} has format version {found}, and {PROGRAM} reads versions up to {newest}: use the version of the program \
         that wrote it",
        path.display()
    )]
    Version { path: PathBuf, found: String, newest: u64 },
    #[error(
        "{} was written by an earlier version, whose stores are read and not gone on with: give another --out, or --force to \
         compute it anew",
        path.display()
    )]
    Older { path: PathBuf },
    #[error(
        "{0} is damaged: {what}; `tribochaos verify {0} --repair`, or the command that computed it, mends it",
        path.display()
    )]
    Damaged { path: PathBuf, what: String },
    #[error("{} is damaged: {what}; the command that computed it writes it anew", path.display())]
    Metadata { path: PathBuf, what: String },
    #[error("{} is damaged: {what}; restore it from a copy, or remove it and compute it again", path.display())]
    Lost { path: PathBuf, what: String },
    #[error(
        "{} is in use by another process{}: wait for its end, or give another --out",
        path.display(),
        process.map(|id| format!(" (process {id})")).unwrap_or_default()
    )]
    Busy { path: PathBuf, process: Option<u32> },
    #[error(
        "the file system of {} has no locks, by which processes are kept apart: give each process its own --part I/N, or say \
         --alone where no other process writes the store",
        path.display()
    )]
    NoLocks { path: PathBuf },
    #[error(
        "{} holds the results of another experiment ({difference}): give another --out, or --force to replace them",
        path.display()
    )]
    OtherExperiment { path: PathBuf, difference: String },
    #[error(
        "{} was computed by another version of the program: give another --out, or --force to replace it",
        path.display()
    )]
    OtherProgram { path: PathBuf },
    #[error(
        "{} does not hold {quantity}, which is asked for: give another --out, or --force to compute all anew",
        path.display()
    )]
    Lacks { path: PathBuf, quantity: &'static str },
    #[error("{damage}; give another --out, or --force to replace it: {reason}")]
    NotMended { damage: String, reason: Box<StoreError> },
    #[error("{} is no store of this program: it is not replaced, move it away", path.display())]
    NotReplaced { path: PathBuf },
    #[error(
        "the store {} would take {}, and the disk has {} free: use fewer points or quantities, or another disk",
        path.display(),
        words::bytes(*needed),
        words::bytes(*free)
    )]
    NoRoom { path: PathBuf, needed: u64, free: u64 },
    #[error("{} was removed or replaced while it was written: the same command begins anew", path.display())]
    TakenAway { path: PathBuf },
    #[error("{} cannot be written: {reason}; check the folder's permissions and the free space", path.display())]
    Write { path: PathBuf, reason: String },
    #[error("{} cannot be read: {reason}", path.display())]
    Read { path: PathBuf, reason: String },
}

impl StoreError {
    /// A store at `path` that cannot be written.
    pub(super) fn write(path: &Path, reason: &dyn Display) -> Self {
        Self::Write {
            path: path.to_owned(),
            reason: reason.to_string(),
        }
    }

    /// A store or a file at `path` that cannot be read.
    pub(super) fn read(path: &Path, reason: &dyn Display) -> Self {
        Self::Read {
            path: path.to_owned(),
            reason: reason.to_string(),
        }
    }
}
