//! The output layer: maps as Zarr stores, pictures and tables; line drawings and densities of other analyses.
//!
//! Owns every file format; computes nothing but what a drawing needs, and draws maps only from a
//! [`ParameterMap`](crate::map::ParameterMap).

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::Path;

pub mod csv;
#[cfg(feature = "store")]
pub mod store;
pub mod table;

#[cfg(feature = "pictures")]
pub mod caption;
#[cfg(feature = "pictures")]
pub mod charts;
#[cfg(feature = "pictures")]
pub mod colour;
#[cfg(feature = "pictures")]
mod colour_bar;
#[cfg(feature = "pictures")]
pub mod density;
#[cfg(feature = "pictures")]
pub mod drawing;
#[cfg(feature = "pictures")]
pub mod figure;
#[cfg(feature = "pictures")]
pub mod histories;
#[cfg(feature = "pictures")]
pub mod panel;
#[cfg(feature = "pictures")]
pub mod picture;
#[cfg(feature = "pictures")]
mod plot;
#[cfg(feature = "pictures")]
pub mod png;
#[cfg(feature = "pictures")]
mod raster;
#[cfg(all(test, feature = "pictures"))]
mod samples;
#[cfg(feature = "pictures")]
pub mod sheet;
#[cfg(feature = "pictures")]
pub mod survival;
#[cfg(feature = "pictures")]
mod svg;
#[cfg(feature = "pictures")]
mod text;
#[cfg(feature = "pictures")]
mod ticks;

/// The program and its version, as outputs name it.
pub const PROGRAM: &str = concat!("tribochaos ", env!("CARGO_PKG_VERSION"));

/// Writes a file so that readers see it whole or not at all: beside its place first, then renamed. Creates the folders
/// that lead to it.
fn write_whole(path: &Path, write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> io::Result<()> {
    let name = path
        .file_name()
        .ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "the path names no file"))?;
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        fs::create_dir_all(folder)?;
    }
    // The process id keeps two programs that write the same file apart.
    let mut hidden = std::ffi::OsString::from(".");
    hidden.push(name);
    hidden.push(format!(".{}.part", std::process::id()));
    let part = path.with_file_name(hidden);
    let written = File::create(&part).and_then(|file| {
        let mut file = BufWriter::new(file);
        write(&mut file)?;
        file.flush()?;
        file.get_ref().sync_all()?;
        fs::rename(&part, path)
    });
    if written.is_err() {
        // Best effort: the error that is reported is the one that came first.
        let _ = fs::remove_file(&part);
    }
    written
}
