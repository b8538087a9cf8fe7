//! How large a store is, and how much room the disk has.
//!
//! Owns the count of bytes; writes nothing.

use std::io;
use std::path::Path;

use super::units::Units;
use crate::design::{Axis, Varied};
use crate::experiment::Experiment;
use crate::measure::Quantity;
use crate::results::labels;

/// Bytes that a mark takes, at most.
const MARK: u64 = 1024;

/// Bytes that the values of some quantities of one point take.
pub fn point_bytes(experiment: &Experiment, quantities: &[Quantity]) -> u64 {
    let bytes: u64 = Quantity::held(quantities).map(|info| info.values.bytes()).sum();
    bytes + 8 * labels::scales(experiment).len() as u64
}

/// Bytes that the store of some quantities of an experiment takes once it is complete, in units of about `unit` points.
pub fn size_bytes(experiment: &Experiment, quantities: &[Quantity], unit: usize) -> u64 {
    let design = &experiment.design;
    let units = Units::new(&labels::sides(design), unit);
    let values: usize = match &design.varied {
        Varied::Axes(axes) => axes.iter().map(Axis::count).sum(),
        Varied::Points(points) => points.len() * points.coordinates().len(),
    };
    let coordinates = 8 * values as u64;
    let unit_bytes = units.block_points() as u64 * point_bytes(experiment, quantities) + MARK;
    units.count() as u64 * unit_bytes + coordinates
}

/// Bytes that may still be written where `path` is, or would be created.
///
/// # Errors
/// If the file system does not tell.
pub fn free_space(path: &Path) -> io::Result<u64> {
    let existing = path
        .ancestors()
        .find(|ancestor| ancestor.exists())
        .unwrap_or(Path::new("."));
    fs4::available_space(existing)
}
