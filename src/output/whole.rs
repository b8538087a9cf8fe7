//! Files that are written completely or not at all.
//!
//! Owns how a file is put in its place; knows no format.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A file that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{} cannot be written: {source}; check the folder's permissions and the free space", path.display())]
pub struct WriteError {
    pub path: PathBuf,
    pub source: io::Error,
}

/// Writes a file so that readers see it whole or not at all. Creates the folders that lead to it.
///
/// # Errors
/// [`WriteError`] if the file cannot be written.
pub fn write_whole(path: &Path, write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> Result<(), WriteError> {
    write_aside(path, write).map_err(|source| WriteError {
        path: path.to_owned(),
        source,
    })
}

/// Writes a text file whole.
///
/// # Errors
/// [`WriteError`] if the file cannot be written.
pub fn write_text(path: &Path, text: &str) -> Result<(), WriteError> {
    write_whole(path, |file| file.write_all(text.as_bytes()))
}

/// Creates the folders that lead to the file, and writes it.
fn write_aside(path: &Path, write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> io::Result<()> {
    if path.file_name().is_none() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "the path names no file"));
    }
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        fs::create_dir_all(folder)?;
    }
    replace(path, &own_part(path), write)
}

/// Writes a file as `part`, in the same folder, and renames it when it is on the disk.
///
/// # Errors
/// If it cannot be written; nothing is left then.
pub fn replace(path: &Path, part: &Path, write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> io::Result<()> {
    let written = File::create(part).and_then(|file| {
        let mut file = BufWriter::new(file);
        write(&mut file)?;
        file.flush()?;
        file.get_ref().sync_all()?;
        fs::rename(part, path)
    });
    if written.is_err() {
        // Best effort: the error that is reported is the one that came first.
        let _ = fs::remove_file(part);
    }
    written
}

/// A name beside a file or a folder that belongs to it and that lists leave out: `.NAME.end`.
pub fn hidden(path: &Path, end: &str) -> PathBuf {
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(".");
    name.push(end);
    path.with_file_name(name)
}

/// The name under which a process writes what is to take the place of a file or a folder. Its id keeps two that do the same apart.
pub fn own_part(path: &Path) -> PathBuf {
    hidden(path, &format!("{}.part", std::process::id()))
}
