//! The mark of a unit, which is written when all of its values are on the disk.
//!
//! Owns the form of marks and their place: in the folder of the status, where readers of Zarr look for chunks only.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::checksum::checksum;
use super::sync;
use crate::measure::Quantity;
use crate::output::whole::hidden;
use crate::results::Tally;

/// What is known of a finished unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mark {
    /// The checksum of the text of the experiment, so that values of another one are not taken for its own.
    pub experiment: String,
    /// Number of values of each axis in a unit that no edge cuts off.
    pub block: Vec<usize>,
    /// The checksum of the unit's chunk of each array, by the name of the array.
    pub chunks: BTreeMap<String, String>,
    /// The device on which it was computed, in words.
    pub device: String,
    /// How long that took, in seconds.
    pub seconds: f64,
    /// Its points, by their kind of motion.
    pub tally: Tally,
}

/// What there is in the place of a mark.
#[derive(Clone, Debug, PartialEq)]
pub enum Found {
    Nothing,
    Mark(Mark),
    /// Not what was written.
    Damaged,
}

/// The folder of all marks.
pub fn folder(store: &Path) -> PathBuf {
    store.join(Quantity::Status.info().name).join("done")
}

fn path(store: &Path, unit: usize) -> PathBuf {
    folder(store).join(unit.to_string())
}

impl Mark {
    /// Names of the arrays that the unit has chunks of.
    pub fn names(&self) -> std::collections::BTreeSet<&str> {
        self.chunks.keys().map(String::as_str).collect()
    }

    /// Reads the mark of a unit.
    ///
    /// # Errors
    /// If the file system does not let it be read.
    pub fn read(store: &Path, unit: usize) -> io::Result<Found> {
        match fs::read(path(store, unit)) {
            Ok(bytes) => Ok(parse(&bytes).map_or(Found::Damaged, Found::Mark)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Found::Nothing),
            Err(error) => Err(error),
        }
    }

    /// Any mark of a store that is sound; None without one.
    pub fn any(store: &Path) -> Option<Self> {
        let names = fs::read_dir(folder(store)).ok()?.flatten();
        names.into_iter().find_map(|entry| parse(&fs::read(entry.path()).ok()?))
    }

    /// Writes the mark of a unit.
    ///
    /// # Errors
    /// If it cannot be written.
    #[expect(clippy::missing_panics_doc, reason = "a mark has a JSON form")]
    pub fn write(&self, store: &Path, unit: usize) -> io::Result<()> {
        let json = serde_json::to_string(self).expect("a mark has a JSON form");
        let text = format!("{json}\n{}\n", checksum(json.as_bytes()));
        let path = path(store, unit);
        // always under the same name: the next writer of the unit replaces what a crash has left
        sync::write_whole(&path, &hidden(&path, "part"), text.as_bytes())
    }

    /// Takes the mark of a unit away, if there is one: the unit is no longer finished.
    ///
    /// # Errors
    /// If it cannot be taken away.
    pub fn remove(store: &Path, unit: usize) -> io::Result<()> {
        match fs::remove_file(path(store, unit)) {
            Ok(()) => sync::folder(&folder(store)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
            Err(error) => Err(error),
        }
    }
}

/// A mark on the first line, its checksum on the second.
fn parse(bytes: &[u8]) -> Option<Mark> {
    let text = std::str::from_utf8(bytes).ok()?;
    let (json, sum) = text.strip_suffix('\n')?.split_once('\n')?;
    (checksum(json.as_bytes()) == sum).then_some(())?;
    serde_json::from_str(json).ok()
}
