//! Experiments out of files that the program has written: TOML, pictures, drawings, tables and stores.
//!
//! Owns the place of the experiment in each kind of file; the library defines what an experiment means.

use std::path::Path;

use anyhow::{Context, anyhow};

use crate::experiment::{Request, Sampling};
use crate::output::csv;
use crate::picture::{drawing, png};
use crate::store::Store;

/// Reads the experiment from a file, whose kind is known from its ending, or from the folder of a store. Sampling settings that
/// the file leaves out are those of `defaults`.
///
/// # Errors
/// If the file cannot be read, or has no experiment that this version knows.
pub fn read(path: &Path, defaults: Sampling) -> anyhow::Result<Request> {
    let text = || std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()));
    let none = |kind: &str| {
        anyhow!(
            "{} holds no experiment: give a {kind} as `tribochaos` wrote it",
            path.display()
        )
    };
    if path.is_dir() {
        return Ok(Store::open(path)?.experiment().request());
    }
    let toml = match path.extension().and_then(|extension| extension.to_str()) {
        Some("png") => png::read_experiment(path)?,
        Some("svg") => drawing::experiment_in(&text()?).ok_or_else(|| none("drawing"))?,
        Some("csv") => csv::experiment_in(&text()?).ok_or_else(|| none("table"))?,
        _ => text()?,
    };
    Request::from_toml_over(&toml, defaults).with_context(|| format!("in {}", path.display()))
}
