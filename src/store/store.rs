//! A store as a whole: created, opened, mended, and its attributes.
//!
//! Owns the order in which a store comes to be; its values are [`super::values`]'.

use std::collections::BTreeSet;
use std::error::Error;
use std::fmt::Display;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use serde_json::{Map, Value};
use zarrs::array::Array;
use zarrs::filesystem::FilesystemStore;

use super::checksum::checksum;
use super::chunk;
use super::error::StoreError;
use super::group::{FORMAT_VERSION, Group, METADATA};
use super::layout;
use super::layout::{coordinates, data_type, node, plain_metadata, variable};
use super::lock::Lock;
use super::mark::{self, Mark};
use super::root::Root;
use super::sync;
use super::units::Units;
use crate::experiment::{Experiment, ExperimentError, Outline};
use crate::measure::{QUANTITIES, Quantity};
use crate::output::whole::own_part;
use crate::results::{Column, labels};

/// Results on disk, open for reading and writing.
pub struct Store {
    pub(super) root: Root,
    pub(super) experiment: Experiment,
    /// The checksum of the experiment's text.
    pub(super) experiment_sum: String,
    pub(super) units: Units,
    pub(super) group: Group,
    /// The arrays over the design: those of the quantities first, in the order of [`QUANTITIES`], then those of the scales.
    pub(super) arrays: Vec<StoredArray>,
    /// Held while the store is written together with other processes, which then claim units.
    pub(super) lock: Option<Lock>,
}

/// An array of a store.
pub(super) struct StoredArray {
    pub content: Content,
    pub array: Array<FilesystemStore>,
}

/// What an array holds.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Content {
    Quantity(Quantity),
    /// What leads to SI units, for other readers: this program computes it.
    Scale(crate::machine::Scale),
}

impl Content {
    pub fn name(self) -> &'static str {
        match self {
            Self::Quantity(quantity) => quantity.info().name,
            Self::Scale(scale) => scale.name(),
        }
    }
}

impl Store {
    /// Creates the store of some quantities of an experiment, in units of about `unit` points. Nothing is computed in it. Folders that
    /// lead to `path` are created.
    ///
    /// # Errors
    /// [`StoreError::Exists`] if there is something at `path`, [`StoreError::Write`] if it cannot be written.
    pub fn create(
        path: &Path,
        experiment: &Experiment,
        quantities: &[Quantity],
        unit: usize,
    ) -> Result<Self, StoreError> {
        let units = Units::new(&labels::sides(&experiment.design), unit);
        if fs::symlink_metadata(path).is_ok() {
            return Err(StoreError::Exists { path: path.to_owned() });
        }
        // whole or not at all
        let aside = own_part(path);
        let moved = build(&aside, experiment, quantities, &units).and_then(|()| {
            fs::rename(&aside, path).map_err(|error| {
                if path.exists() {
                    StoreError::Exists { path: path.to_owned() }
                } else {
                    StoreError::write(path, &error)
                }
            })
        });
        if moved.is_err() {
            let _ = fs::remove_dir_all(&aside);
        }
        moved?;
        let _ = path.parent().map(sync::folder);
        Self::open(path)
    }

    /// Opens a store and checks all of it but its values.
    ///
    /// # Errors
    /// [`StoreError::Missing`], [`StoreError::Foreign`], [`StoreError::Version`] or [`StoreError::Metadata`].
    pub fn open(path: &Path) -> Result<Self, StoreError> {
        if !path.is_dir() {
            return Err(StoreError::Missing { path: path.to_owned() });
        }
        let damaged = |what: String| StoreError::Metadata {
            path: path.to_owned(),
            what,
        };
        let group = Group::read(path)?;
        for (file, sum) in group.files() {
            let found = fs::read(path.join(file)).map(|bytes| checksum(&bytes));
            if found.as_deref().ok() != Some(sum) {
                return Err(damaged(format!("its file {file}")));
            }
        }
        let toml = group.text("experiment");
        let toml = toml.ok_or_else(|| damaged("the attribute `experiment` is missing".into()))?;
        let storage = Arc::new(FilesystemStore::new(path).map_err(|error| damaged(error.to_string()))?);
        let of_experiment = |error: ExperimentError| damaged(format!("the attribute `experiment`: {error}"));
        let outline = Outline::from_toml(toml).map_err(of_experiment)?;
        let columns = outline.columns().iter().map(|coordinate| coordinate.name());
        let values: Vec<Vec<f64>> = columns
            .map(|name| {
                let values = read_coordinate(path, &storage, name);
                values.map_err(|error| damaged(format!("the array `{name}`: {error}")))
            })
            .collect::<Result<_, _>>()?;
        let experiment_sum = identity(toml, values.iter().map(Vec::as_slice));
        let experiment = outline.complete(&values).map_err(of_experiment)?;

        let mut arrays = Vec::new();
        let mut units = None;
        let quantities = QUANTITIES.iter().map(|info| Content::Quantity(info.quantity));
        let scales = labels::scales(&experiment).iter().copied().map(Content::Scale);
        for content in quantities.chain(scales) {
            let name = content.name();
            if !path.join(name).is_dir() {
                continue;
            }
            let array = Array::open(storage.clone(), &node(name))
                .map_err(|error| damaged(format!("the array `{name}`: {error}")))?;
            let fastest_first = |counts: &[u64]| -> Vec<usize> { counts.iter().rev().map(|&n| n as usize).collect() };
            let sides = labels::sides(&experiment.design);
            let block = array.chunk_shape(&vec![0; sides.len()]);
            let block = block.map(|shape| fastest_first(&shape.iter().map(|count| count.get()).collect::<Vec<_>>()));
            let of_array = block.ok().and_then(|block| Units::of_block(&sides, &block));
            let expected = units.get_or_insert_with(|| of_array.clone());
            if fastest_first(array.shape()) != sides || of_array.is_none() || of_array != *expected {
                return Err(damaged(format!(
                    "the array `{name}` does not have the shape of the experiment"
                )));
            }
            if let Content::Quantity(quantity) = content
                && group.version() == Some(FORMAT_VERSION)
                && array.data_type() != &data_type(quantity.info().values)
            {
                return Err(damaged(format!("the array `{name}` does not have its type")));
            }
            arrays.push(StoredArray { content, array });
        }
        let has_status = arrays
            .iter()
            .any(|array| array.content == Content::Quantity(Quantity::Status));
        let units = units.flatten().filter(|_| has_status);
        Ok(Self {
            root: Root::open(path).map_err(|error| StoreError::read(path, &error))?,
            units: units.ok_or_else(|| damaged("the array `status` is missing".into()))?,
            experiment,
            experiment_sum,
            group,
            arrays,
            lock: None,
        })
    }

    /// Writes the metadata of a damaged store anew, for the experiment and the quantities that it was created for. Units that are sound
    /// stay. Nobody else may use the store.
    ///
    /// # Errors
    /// [`StoreError::Lost`] if no unit tells that the store belongs to this experiment, [`StoreError::Write`].
    pub fn mend(path: &Path, experiment: &Experiment, quantities: &[Quantity]) -> Result<Self, StoreError> {
        let known = Mark::any(path).filter(|mark| {
            let names = Quantity::held(quantities).map(|info| info.name);
            let scales = labels::scales(experiment).iter().map(|scale| scale.name());
            mark.experiment == identity_of(experiment) && names.chain(scales).collect::<BTreeSet<_>>() == mark.names()
        });
        let sides = labels::sides(&experiment.design);
        let units = known.and_then(|mark| Units::of_block(&sides, &mark.block));
        let units = units.ok_or_else(|| StoreError::Lost {
            path: path.to_owned(),
            what: "its metadata, and no unit tells that it holds this experiment".to_owned(),
        })?;
        let aside = own_part(path);
        let mended = build(&aside, experiment, quantities, &units).and_then(|()| {
            let group = Group::read(&aside)?;
            let files = group.files().map(|(file, _)| file).chain([METADATA]);
            for file in files {
                let place = path.join(file);
                place
                    .parent()
                    .map_or(Ok(()), fs::create_dir_all)
                    .map_err(|error| StoreError::write(path, &error))?;
                fs::rename(aside.join(file), place).map_err(|error| StoreError::write(path, &error))?;
            }
            Ok(())
        });
        let _ = fs::remove_dir_all(&aside);
        mended?;
        Self::open(path)
    }

    /// The store, ready to be written. With a lock, processes share it, and each unit is claimed before it is written. Without a lock, no
    /// other process may use the store: this is for file systems that have no locks.
    ///
    /// # Errors
    /// [`StoreError::Older`] for a store of an earlier version.
    pub fn writing(mut self, lock: Option<Lock>) -> Result<Self, StoreError> {
        if self.version() != FORMAT_VERSION {
            return Err(StoreError::Older {
                path: self.path().to_owned(),
            });
        }
        self.lock = lock;
        Ok(self)
    }

    /// The folder that holds the store.
    pub fn path(&self) -> &Path {
        self.root.path()
    }

    /// The experiment, as the store has it.
    pub fn experiment(&self) -> &Experiment {
        &self.experiment
    }

    /// The checksum of the experiment, with the values of a list of points: stores of the same experiment have the same.
    pub fn identity(&self) -> &str {
        &self.experiment_sum
    }

    /// The quantities that are stored.
    pub fn quantities(&self) -> Vec<Quantity> {
        let quantities = self.arrays.iter().filter_map(|array| match array.content {
            Content::Quantity(quantity) => Some(quantity),
            Content::Scale(_) => None,
        });
        quantities.collect()
    }

    pub(super) fn version(&self) -> u64 {
        self.group.version().unwrap_or(0)
    }

    /// Sets an attribute of the store, such as the outcome of an audit.
    ///
    /// # Errors
    /// [`StoreError::Write`].
    pub fn set_attribute(&mut self, name: &str, value: Value) -> Result<(), StoreError> {
        self.group.set(name, value);
        self.group.write(self.root.path())
    }

    /// All attributes of the store.
    pub fn attributes(&self) -> &Map<String, Value> {
        self.group.attributes()
    }

    /// An attribute that [`Store::set_attribute`] set, in this process or in an earlier one.
    pub fn attribute(&self, name: &str) -> Option<&Value> {
        self.group.attribute(name)
    }
}

/// Builds a store in which nothing is computed.
fn build(path: &Path, experiment: &Experiment, quantities: &[Quantity], units: &Units) -> Result<(), StoreError> {
    let failed = |error: &dyn Display| StoreError::write(path, error);
    fs::create_dir_all(mark::folder(path)).map_err(|error| failed(&error))?;
    let storage = Arc::new(FilesystemStore::new(path).map_err(|error| failed(&error))?);
    let design = &experiment.design;
    let coordinates = coordinates(design);
    let names: Vec<&str> = coordinates.iter().map(|(name, ..)| *name).collect();
    let coordinates = coordinates
        .into_iter()
        .map(|(name, array, values)| (name, array, Some(values)));
    let quantities = Quantity::held(quantities).map(|info| (info.name, variable(info, design, units), None));
    let scales = labels::scales(experiment)
        .iter()
        .map(|&scale| (scale.name(), layout::scale(scale, design, units), None));
    let (mut metadata, mut sums) = (Map::new(), Vec::new());
    for (name, array, values) in coordinates.chain(quantities).chain(scales) {
        let array = array
            .build(storage.clone(), &node(name))
            .map_err(|error| failed(&error))?;
        array
            .store_metadata_opt(&plain_metadata())
            .map_err(|error| failed(&error))?;
        let file = format!("{name}/{METADATA}");
        let text = synced(path, &file)?;
        metadata.insert(
            name.to_owned(),
            serde_json::from_slice(&text).map_err(|error| failed(&error))?,
        );
        sums.push((file, checksum(&text)));
        if let Some(values) = values {
            array.store_chunk(&[0], values).map_err(|error| failed(&error))?;
            let file = array.chunk_key(&[0]).as_str().to_owned();
            let sum = checksum(&synced(path, &file)?);
            sums.push((file, sum));
        }
    }
    Group::new(experiment, &names, metadata, sums).write(path)
}

/// The values of a coordinate.
fn read_coordinate(path: &Path, storage: &Arc<FilesystemStore>, name: &str) -> Result<Vec<f64>, Box<dyn Error>> {
    let array = Array::open(storage.clone(), &node(name))?;
    let bytes = fs::read(chunk::path(path, &array, &[0]))?;
    let count = array.shape().iter().product::<u64>() as usize;
    match chunk::decode(&array, &[0], bytes, count)? {
        Column::F64(values) if values.len() == count => Ok(values),
        _ => Err("it does not have its type or its length".into()),
    }
}

/// What identifies the experiment of a store: the checksum of its outline, followed by the values that this leaves out.
fn identity<'a>(outline: &str, columns: impl Iterator<Item = &'a [f64]>) -> String {
    let mut text = outline.as_bytes().to_vec();
    for column in columns {
        text.extend(column.iter().flat_map(|value| value.to_le_bytes()));
    }
    checksum(&text)
}

fn identity_of(experiment: &Experiment) -> String {
    let text = experiment.outline();
    let has_all = Outline::from_toml(&text).is_ok_and(|outline| outline.columns().is_empty());
    let columns = if has_all {
        Vec::new()
    } else {
        coordinates(&experiment.design)
    };
    identity(&text, columns.iter().map(|(.., values)| values.as_slice()))
}

/// Reads a file that zarrs has written, and makes sure that it is on the disk: zarrs leaves this to the operating system.
fn synced(store: &Path, file: &str) -> Result<Vec<u8>, StoreError> {
    let path = store.join(file);
    let bytes = fs::read(&path).and_then(|bytes| sync::write(&path, &bytes).map(|()| bytes));
    bytes.map_err(|error| StoreError::write(store, &error))
}

/// Whether the folder is a store of this program, or was one before it was damaged: `open` may fail on it.
pub fn looks_like_a_store(path: &Path) -> bool {
    let status = path.join(Quantity::Status.info().name).join(METADATA);
    status.is_file() || mark::folder(path).is_dir() || Group::read(path).is_ok()
}
