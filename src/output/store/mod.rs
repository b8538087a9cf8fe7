//! The Zarr store of a map: created before the run, written tile by tile, read back as a map.
//!
//! Owns the names, types and attributes on disk; decides neither what is computed nor in which order.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::{Map, Value};
use zarrs::array::Array;
use zarrs::filesystem::FilesystemStore;
use zarrs::group::{Group, GroupBuilder};

use self::layout::{FORMAT, FORMAT_VERSION, NO_CODE, coordinate, data_type, node, plain_metadata, variable};
use self::scales::ScaleArrays;
use super::{PROGRAM, write_whole};
use crate::design::Axis;
use crate::engine::{Sink, SinkError};
use crate::experiment::{Experiment, Request};
use crate::map::ParameterMap;
use crate::measure::{Measurement, QUANTITIES, Quantity, QuantityInfo, Values};

mod error;
mod layout;
mod scales;
mod tile;

pub use error::StoreError;
pub use tile::{Tile, shape};

/// Quantities that have a value at every point whose status is ok.
const NEVER_NAN: [Quantity; 8] = [
    Quantity::Lyapunov,
    Quantity::LyapunovInterval,
    Quantity::X,
    Quantity::Y,
    Quantity::XMin,
    Quantity::XMax,
    Quantity::ContactStatus,
    Quantity::Backend,
];

/// Quantities that have one besides if the contact pressure is constant.
const NEVER_NAN_REDUCED: [Quantity; 2] = [Quantity::LyapunovSecond, Quantity::Divergence];

/// Quantities that have one besides if nothing wears.
const NEVER_NAN_LASTING: [Quantity; 3] = [Quantity::LyapunovError, Quantity::LyapunovBirkhoff, Quantity::Class];

/// A map on disk, open for reading and writing.
pub struct MapStore {
    path: PathBuf,
    experiment: Experiment,
    tile: [usize; 2],
    group: Group<FilesystemStore>,
    /// In the order of [`QUANTITIES`].
    arrays: Vec<Array<FilesystemStore>>,
    scales: ScaleArrays,
}

impl MapStore {
    /// Creates the store of a map of which nothing is computed, to be written in tiles of `tile` rows and columns.
    /// Folders that lead to `path` are created.
    ///
    /// # Errors
    /// [`StoreError::Exists`] if there is something at `path`, [`StoreError::Write`] if it cannot be written.
    ///
    /// # Panics
    /// If the experiment has not two axes, or the tile has no points.
    pub fn create(path: &Path, experiment: &Experiment, tile: [usize; 2]) -> Result<Self, StoreError> {
        let [x, y] = axes(experiment);
        let tile = [tile[0].min(y.count()), tile[1].min(x.count())];
        assert!(tile[0] > 0 && tile[1] > 0, "a tile has points");
        if fs::symlink_metadata(path).is_ok() {
            return Err(StoreError::Exists { path: path.to_owned() });
        }
        let failed = |reason: String| StoreError::Write {
            path: path.to_owned(),
            reason,
        };
        fs::create_dir_all(path).map_err(|error| failed(error.to_string()))?;
        let storage = Arc::new(FilesystemStore::new(path).map_err(|error| failed(error.to_string()))?);

        let mut arrays = Vec::new();
        for axis in [x, y] {
            let array =
                coordinate(axis, &experiment.design.fixed).build(storage.clone(), &node(axis.coordinate.name()));
            let array = array.map_err(|error| failed(error.to_string()))?;
            array
                .store_metadata_opt(&plain_metadata())
                .map_err(|error| failed(error.to_string()))?;
            array
                .store_chunk(&[0], axis.values())
                .map_err(|error| failed(error.to_string()))?;
        }
        for info in QUANTITIES {
            let array = variable(info, x, y, tile).build(storage.clone(), &node(info.name));
            let array = array.map_err(|error| failed(error.to_string()))?;
            array
                .store_metadata_opt(&plain_metadata())
                .map_err(|error| failed(error.to_string()))?;
            arrays.push(array);
        }
        let scales = ScaleArrays::create(&storage, experiment, tile).map_err(|error| failed(error.to_string()))?;
        let mut attributes = Map::new();
        attributes.insert("format".into(), FORMAT.into());
        attributes.insert("format_version".into(), FORMAT_VERSION.into());
        attributes.insert("program".into(), PROGRAM.into());
        attributes.insert("experiment".into(), experiment.to_toml().into());
        let group = GroupBuilder::new().attributes(attributes).build(storage, "/");
        let group = group.map_err(|error| failed(error.to_string()))?;
        let store = Self {
            path: path.to_owned(),
            experiment: experiment.clone(),
            tile,
            group,
            arrays,
            scales,
        };
        // Last: what has no group metadata is no store, so a creation that was cut short is recognised.
        store.write_group()?;
        Ok(store)
    }

    /// Opens a store and checks that all of it is there.
    ///
    /// # Errors
    /// [`StoreError::Missing`], [`StoreError::Foreign`], [`StoreError::Version`] or [`StoreError::Damaged`].
    pub fn open(path: &Path) -> Result<Self, StoreError> {
        if !path.is_dir() {
            return Err(StoreError::Missing { path: path.to_owned() });
        }
        let damaged = |what: String| StoreError::Damaged {
            path: path.to_owned(),
            what,
        };
        let foreign = || StoreError::Foreign { path: path.to_owned() };
        if !path.join("zarr.json").is_file() {
            return Err(foreign());
        }
        let storage = Arc::new(FilesystemStore::new(path).map_err(|error| damaged(error.to_string()))?);
        let group = Group::open(storage.clone(), "/").map_err(|error| damaged(error.to_string()))?;
        let attributes = group.attributes();
        if attributes.get("format").and_then(Value::as_str) != Some(FORMAT) {
            return Err(foreign());
        }
        let version = attributes.get("format_version").unwrap_or(&Value::Null);
        if version.as_u64() != Some(FORMAT_VERSION) {
            return Err(StoreError::Version {
                path: path.to_owned(),
                found: version.to_string(),
            });
        }
        let toml = attributes.get("experiment").and_then(Value::as_str);
        let toml = toml.ok_or_else(|| damaged("the attribute `experiment` is missing".into()))?;
        let experiment = Request::from_toml(toml)
            .and_then(|request| request.resolve())
            .map_err(|error| damaged(format!("the attribute `experiment`: {error}")))?;

        let [x, y] = axes(&experiment);
        for axis in [x, y] {
            let name = axis.coordinate.name();
            let values = Array::open(storage.clone(), &node(name))
                .map_err(|error| error.to_string())
                .and_then(|array| {
                    array
                        .retrieve_chunk::<Vec<f64>>(&[0])
                        .map_err(|error| error.to_string())
                })
                .map_err(|reason| damaged(format!("the array `{name}`: {reason}")))?;
            if values != axis.values() {
                return Err(damaged(format!(
                    "the array `{name}` does not hold the values of its axis"
                )));
            }
        }
        let mut arrays = Vec::new();
        let mut tile = None;
        for info in QUANTITIES {
            let name = info.name;
            let array = Array::open(storage.clone(), &node(name))
                .map_err(|error| damaged(format!("the array `{name}`: {error}")))?;
            let shape = array
                .chunk_shape_usize(&[0, 0])
                .ok()
                .and_then(|shape| <[usize; 2]>::try_from(shape).ok());
            let expected = *tile.get_or_insert(shape);
            let same_type = array.data_type() == &data_type(info.values);
            if array.shape() != [y.count() as u64, x.count() as u64]
                || shape != expected
                || shape.is_none()
                || !same_type
            {
                return Err(damaged(format!(
                    "the array `{name}` has not the shape, tiles or type of the map's"
                )));
            }
            arrays.push(array);
        }
        let scales = ScaleArrays::open(&storage, &experiment).map_err(damaged)?;
        let tile = tile
            .flatten()
            .expect("there are quantities, and each was checked to have a tile shape");
        Ok(Self {
            path: path.to_owned(),
            experiment,
            tile,
            group,
            arrays,
            scales,
        })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    pub fn experiment(&self) -> &Experiment {
        &self.experiment
    }

    /// Rows and columns of a tile that no edge cuts.
    pub fn tile(&self) -> [usize; 2] {
        self.tile
    }

    /// All tiles, row by row; those at the far edges are cut to the map.
    pub fn tiles(&self) -> impl Iterator<Item = Tile> + '_ {
        (0..self.units()).map(|unit| self.unit(unit))
    }

    fn unit(&self, unit: usize) -> Tile {
        tile::tile(axes(&self.experiment).map(Axis::count), self.tile, unit)
    }

    /// Writes the measurements of a tile, x fastest. A tile counts as finished only once all of it is on disk.
    ///
    /// # Errors
    /// [`StoreError::Write`].
    ///
    /// # Panics
    /// If the number of measurements is not that of the tile's points.
    pub fn write_tile(&self, tile: &Tile, measurements: &[Measurement]) -> Result<(), StoreError> {
        assert_eq!(
            measurements.len(),
            tile.len(),
            "one measurement for each point of the tile"
        );
        let failed = |error: zarrs::array::ArrayError| StoreError::Write {
            path: self.path.clone(),
            reason: error.to_string(),
        };
        let [x, _] = axes(&self.experiment);
        let padded = |scale: &dyn Fn(usize) -> f64| self.padded(tile, tile.indices(x.count()).map(scale), f64::NAN);
        let chunk = self.chunk(tile);
        self.scales.write(&self.experiment, &chunk, padded).map_err(failed)?;
        // The status goes last, since it is what tells a finished tile.
        let others = QUANTITIES.iter().filter(|info| info.quantity != Quantity::Status);
        for info in others.chain([Quantity::Status.info()]) {
            let values = measurements.iter().map(|measurement| info.quantity.of(measurement));
            let array = &self.arrays[info.quantity as usize];
            let stored = match info.values {
                Values::Number => array.store_chunk(&self.chunk(tile), self.padded(tile, values, f64::NAN)),
                Values::Code(_) => {
                    let codes = values.map(|code| if code.is_nan() { NO_CODE } else { code as u8 });
                    array.store_chunk(&self.chunk(tile), self.padded(tile, codes, NO_CODE))
                }
            };
            stored.map_err(failed)?;
        }
        Ok(())
    }

    /// Whether every point of a tile is on disk.
    ///
    /// # Errors
    /// [`StoreError::Damaged`] if the file system does not let the tile be read.
    pub fn is_finished(&self, tile: &Tile) -> Result<bool, StoreError> {
        match self.arrays[Quantity::Status as usize].retrieve_chunk::<Vec<u8>>(&self.chunk(tile)) {
            Ok(chunk) => Ok(self.unpadded(tile, &chunk).all(|code| code != NO_CODE)),
            Err(zarrs::array::ArrayError::StorageError(error)) => Err(self.damaged(Quantity::Status, tile, error)),
            // A write that was cut short leaves a chunk that cannot be decoded: the tile is to be computed again.
            Err(_) => Ok(false),
        }
    }

    /// The map, with NaN at the points of tiles that are not finished.
    ///
    /// # Errors
    /// [`StoreError::Damaged`] if values of a finished tile cannot be read.
    pub fn read_map(&self) -> Result<ParameterMap, StoreError> {
        let mut map = ParameterMap::new(self.experiment.clone()).expect("a store has two axes");
        let columns = map.x_axis().count();
        for tile in self.tiles() {
            // what is there but cannot be decoded is damage here, though a resumed run may compute it again
            self.read_tile(Quantity::Status.info(), &tile)?;
            if !self.is_finished(&tile)? {
                continue;
            }
            for info in QUANTITIES {
                let values = self.read_tile(info, &tile)?;
                let column = map.column_mut(info.quantity);
                for (index, value) in tile.indices(columns).zip(values) {
                    column[index] = value;
                }
            }
            // every point whose status is ok has numbers: a chunk that is missing reads as NaN
            // but for the second exponent of a limit cycle, whose one exponent is the divergence
            let lost = |quantity: Quantity| {
                let [status, lyapunov, divergence, values] =
                    [Quantity::Status, Quantity::Lyapunov, Quantity::Divergence, quantity].map(|of| map.column(of));
                let has_it = |index| quantity != Quantity::LyapunovSecond || lyapunov[index] != divergence[index];
                tile.indices(columns)
                    .any(|index| status[index] == 0.0 && values[index].is_nan() && has_it(index))
            };
            let reduced = !self.experiment.settings.integration.scheme.carries_heat();
            let mut numbers = NEVER_NAN
                .into_iter()
                .chain(NEVER_NAN_REDUCED.into_iter().filter(|_| reduced))
                .chain(NEVER_NAN_LASTING.into_iter().filter(|_| !self.experiment.wears()));
            if let Some(quantity) = numbers.find(|quantity| lost(*quantity)) {
                return Err(self.damaged(quantity, &tile, "values of finished points are missing"));
            }
        }
        Ok(map)
    }

    fn read_tile(&self, info: &QuantityInfo, tile: &Tile) -> Result<Vec<f64>, StoreError> {
        let (array, chunk) = (&self.arrays[info.quantity as usize], self.chunk(tile));
        match info.values {
            Values::Number => {
                let values: Vec<f64> = array
                    .retrieve_chunk(&chunk)
                    .map_err(|error| self.damaged(info.quantity, tile, error))?;
                Ok(self.unpadded(tile, &values).collect())
            }
            Values::Code(names) => {
                let codes: Vec<u8> = array
                    .retrieve_chunk(&chunk)
                    .map_err(|error| self.damaged(info.quantity, tile, error))?;
                self.unpadded(tile, &codes)
                    .map(|code| match code {
                        NO_CODE => Ok(f64::NAN),
                        code if usize::from(code) < names.len() => Ok(code.into()),
                        code => Err(self.damaged(info.quantity, tile, format!("{code} is no code"))),
                    })
                    .collect()
            }
        }
    }

    /// Sets an attribute of the map, such as the outcome of an audit.
    ///
    /// # Errors
    /// [`StoreError::Write`].
    pub fn set_attribute(&mut self, name: &str, value: Value) -> Result<(), StoreError> {
        self.group.attributes_mut().insert(name.to_owned(), value);
        self.write_group()
    }

    pub fn attribute(&self, name: &str) -> Option<&Value> {
        self.group.attributes().get(name)
    }

    /// The devices on which the map was computed, in the order in which they came.
    pub fn devices(&self) -> Vec<String> {
        let stored = self.attribute("devices").cloned().unwrap_or_default();
        serde_json::from_value(stored).unwrap_or_default()
    }

    /// Not through zarrs, which would write over the file in place: a kill in between would cost the whole store.
    fn write_group(&self) -> Result<(), StoreError> {
        let json = serde_json::to_vec_pretty(self.group.metadata()).map_err(io::Error::from);
        json.and_then(|json| write_whole(&self.path.join("zarr.json"), |file| file.write_all(&json)))
            .map_err(|error| StoreError::Write {
                path: self.path.clone(),
                reason: error.to_string(),
            })
    }

    fn chunk(&self, tile: &Tile) -> [u64; 2] {
        [(tile.row0 / self.tile[0]) as u64, (tile.col0 / self.tile[1]) as u64]
    }

    /// A tile's values as a whole chunk: Zarr stores the chunks at the far edges in full.
    fn padded<T: Copy>(&self, tile: &Tile, values: impl Iterator<Item = T>, fill: T) -> Vec<T> {
        let mut chunk = vec![fill; self.tile[0] * self.tile[1]];
        for (index, value) in self.chunk_indices(tile).zip(values) {
            chunk[index] = value;
        }
        chunk
    }

    fn unpadded<'a, T: Copy>(&self, tile: &Tile, chunk: &'a [T]) -> impl Iterator<Item = T> + 'a {
        self.chunk_indices(tile).map(|index| chunk[index])
    }

    fn chunk_indices(&self, tile: &Tile) -> impl Iterator<Item = usize> + use<> {
        Tile {
            row0: 0,
            col0: 0,
            ..*tile
        }
        .indices(self.tile[1])
    }

    fn damaged(&self, quantity: Quantity, tile: &Tile, reason: impl ToString) -> StoreError {
        let (name, [row, col]) = (quantity.info().name, self.chunk(tile));
        let what = format!("the array `{name}`, chunk c/{row}/{col}: {}", reason.to_string());
        StoreError::Damaged {
            path: self.path.clone(),
            what,
        }
    }
}

impl Sink for MapStore {
    fn units(&self) -> usize {
        tile::count(axes(&self.experiment).map(Axis::count), self.tile)
    }

    fn points(&self, unit: usize) -> Vec<usize> {
        let [x, _] = axes(&self.experiment);
        self.unit(unit).indices(x.count()).collect()
    }

    fn is_finished(&self, unit: usize) -> Result<bool, SinkError> {
        Ok(Self::is_finished(self, &self.unit(unit))?)
    }

    fn write(&mut self, unit: usize, measurements: &[Measurement], device: &str) -> Result<(), SinkError> {
        self.write_tile(&self.unit(unit), measurements)?;
        let mut devices = self.devices();
        if !devices.iter().any(|known| known == device) {
            devices.push(device.to_owned());
            self.set_attribute("devices", devices.into())?;
        }
        Ok(())
    }
}

/// Whether the folder is, or was before it was damaged, a store of this program: `open` need not succeed on it.
pub fn looks_like_a_store(path: &Path) -> bool {
    let group = std::fs::read(path.join("zarr.json")).unwrap_or_default();
    let status = path.join(Quantity::Status.info().name).join("zarr.json");
    String::from_utf8_lossy(&group).contains(FORMAT) || status.is_file()
}

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

fn axes(experiment: &Experiment) -> [&Axis; 2] {
    let [x, y] = experiment.design.axes() else {
        panic!("a map has two axes")
    };
    [x, y]
}

#[cfg(test)]
mod tests;
