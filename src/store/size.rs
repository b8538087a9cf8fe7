//! How large a store is, and how much room the disk has.
//!
//! Owns the count of bytes; writes nothing.

use std::io;
use std::path::Path;

use super::layout::axes;
use super::scales::ScaleArrays;
use crate::experiment::Experiment;
use crate::measure::{QUANTITIES, Values};

/// Bytes that a map's values take on disk once it is complete, in tiles of `tile` rows and columns.
///
/// # Panics
/// If the experiment has not two axes.
pub fn size_bytes(experiment: &Experiment, tile: [usize; 2]) -> u64 {
    let [x, y] = axes(experiment);
    let padded = |count: usize, tile: usize| count.next_multiple_of(tile.min(count)) as u64;
    let point: u64 = QUANTITIES
        .iter()
        .map(|info| if info.values == Values::Number { 8 } else { 1 })
        .sum::<u64>()
        + ScaleArrays::size(experiment);
    padded(y.count(), tile[0]) * padded(x.count(), tile[1]) * point + 8 * (x.count() + y.count()) as u64
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
