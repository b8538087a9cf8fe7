//! Files that are on the disk when a function returns, not merely in the memory of the operating system.
//!
//! Owns the order of writing and syncing; knows no format.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

use crate::output::whole::replace;

/// Writes a file. After a crash in the middle a part of it may be there.
///
/// # Errors
/// If it cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = File::create(path)?;
    file.write_all(bytes)?;
    file.sync_all()
}

/// Writes a file whole or not at all, whatever was there before: first as `part`, in the same folder, which must be there.
///
/// # Errors
/// If it cannot be written.
pub fn write_whole(path: &Path, part: &Path, bytes: &[u8]) -> io::Result<()> {
    replace(path, part, |file| file.write_all(bytes))?;
    folder(path.parent().unwrap_or(".".as_ref()))
}

/// Removes what processes that were killed have left beside a file or a folder. No other process may write there.
pub fn clean_beside(path: &Path) {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let names = fs::read_dir(folder.unwrap_or(".".as_ref()))
        .into_iter()
        .flatten()
        .flatten();
    let begin = format!(".{}.", path.file_name().unwrap_or_default().to_string_lossy());
    for entry in names {
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_part = entry.path().extension().is_some_and(|extension| extension == "part");
        if name.starts_with(&begin) && is_part {
            // best effort: what is left is in nobody's way
            let _ = fs::remove_dir_all(entry.path());
        }
    }
}

/// Makes the names of the files in a folder last.
///
/// # Errors
/// If the folder cannot be opened.
pub fn folder(path: &Path) -> io::Result<()> {
    if cfg!(unix) {
        File::open(path)?.sync_all()
    } else {
        // there a folder is no file, and its names are written with its files
        Ok(())
    }
}
