//! Experiments out of files that the program has written: TOML, pictures, drawings, tables and stores.
//!
//! Owns where each of them keeps its experiment; what an experiment means is the library's.

use std::path::Path;

use anyhow::{Context, anyhow};
use tribochaos::experiment::{Request, Sampling};
use tribochaos::output::csv;
use tribochaos::picture::{drawing, png};
use tribochaos::store::MapStore;

/// The experiment in a file, which is told by its ending, or in the folder of a store. What it leaves out of the sampling is that
/// of `defaults`.
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
        return Ok(MapStore::open(path)?.experiment().request());
    }
    let toml = match path.extension().and_then(|extension| extension.to_str()) {
        Some("png") => png::read_experiment(path)?,
        Some("svg") => drawing::experiment_in(&text()?).ok_or_else(|| none("drawing"))?,
        Some("csv") => csv::experiment_in(&text()?).ok_or_else(|| none("table"))?,
        _ => text()?,
    };
    Request::from_toml_over(&toml, defaults).with_context(|| format!("in {}", path.display()))
}
