//! The folder of a store while it is used.
//!
//! Owns the knowledge of whether the folder at a path is still the one that was opened.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// A folder that is kept open, so that its identity is given to no other folder.
#[derive(Debug)]
pub struct Root {
    path: PathBuf,
    /// None where folders cannot be opened.
    open: Option<File>,
}

impl Root {
    /// # Errors
    /// If the folder cannot be opened.
    pub fn open(path: &Path) -> io::Result<Self> {
        let open = if cfg!(unix) { Some(File::open(path)?) } else { None };
        Ok(Self {
            path: path.to_owned(),
            open,
        })
    }

    /// The path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether the same folder is still at its path.
    pub fn is_there(&self) -> bool {
        match &self.open {
            Some(open) => {
                let now = identity(fs::metadata(&self.path));
                now.is_some() && now == identity(open.metadata())
            }
            None => self.path.is_dir(),
        }
    }
}

/// What tells files apart that have had the same path; None where there is no file.
#[cfg(unix)]
pub fn identity(metadata: io::Result<fs::Metadata>) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    metadata.ok().map(|metadata| (metadata.dev(), metadata.ino()))
}

/// Not told there by the standard library: any file stands for any other.
#[cfg(not(unix))]
pub fn identity(metadata: io::Result<fs::Metadata>) -> Option<(u64, u64)> {
    metadata.ok().map(|_| (0, 0))
}
