//! A store as a whole: created, opened, and its attributes.
//!
//! Owns the format's version and the order in which a store comes to be; its values are [`super::values`]'.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::{Map, Value};
use zarrs::array::Array;
use zarrs::filesystem::FilesystemStore;
use zarrs::group::{Group, GroupBuilder};

use super::error::StoreError;
use super::layout::{FORMAT, FORMAT_VERSION, axes, coordinate, data_type, node, plain_metadata, variable};
use super::scales::ScaleArrays;
use crate::experiment::{Experiment, Request};
use crate::measure::{QUANTITIES, Quantity};
use crate::output::PROGRAM;
use crate::output::whole::write_whole;

/// A map on disk, open for reading and writing.
pub struct MapStore {
    pub(super) path: PathBuf,
    pub(super) experiment: Experiment,
    pub(super) tile: [usize; 2],
    group: Group<FilesystemStore>,
    /// In the order of [`QUANTITIES`].
    pub(super) arrays: Vec<Array<FilesystemStore>>,
    pub(super) scales: ScaleArrays,
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
    #[expect(
        clippy::missing_panics_doc,
        reason = "there are quantities, and each has a tile shape by then"
    )]
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

    /// The folder that holds the store.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What the map is computed for, as the store has it.
    pub fn experiment(&self) -> &Experiment {
        &self.experiment
    }

    /// Rows and columns of a tile that no edge cuts.
    pub fn tile(&self) -> [usize; 2] {
        self.tile
    }

    /// Sets an attribute of the map, such as the outcome of an audit.
    ///
    /// # Errors
    /// [`StoreError::Write`].
    pub fn set_attribute(&mut self, name: &str, value: Value) -> Result<(), StoreError> {
        self.group.attributes_mut().insert(name.to_owned(), value);
        self.write_group()
    }

    /// What [`MapStore::set_attribute`] set, by this process or an earlier one.
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
        let failed = |source: io::Error| StoreError::Write {
            path: self.path.clone(),
            reason: source.to_string(),
        };
        let json = serde_json::to_vec_pretty(self.group.metadata()).map_err(|error| failed(error.into()))?;
        write_whole(&self.path.join("zarr.json"), |file| file.write_all(&json)).map_err(|error| failed(error.source))
    }
}

/// Whether the folder is, or was before it was damaged, a store of this program: `open` need not succeed on it.
pub fn looks_like_a_store(path: &Path) -> bool {
    let group = std::fs::read(path.join("zarr.json")).unwrap_or_default();
    let status = path.join(Quantity::Status.info().name).join("zarr.json");
    String::from_utf8_lossy(&group).contains(FORMAT) || status.is_file()
}
