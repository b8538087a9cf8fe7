//! The metadata of a store as a whole: what it holds, and the checksums of its small files.
//!
//! Owns the format's versions and the attributes of the group; arrays are others'.

use std::fs;
use std::path::Path;

use serde_json::{Map, Value, json};

use super::checksum::checksum;
use super::error::StoreError;
use super::{mark, sync};
use crate::experiment::Experiment;
use crate::output::PROGRAM;
use crate::output::whole::own_part;

/// Marks a group as results of this program, and as a map of its first version.
const FORMAT: &str = "tribochaos results";
const FORMAT_1: &str = "tribochaos map";
pub const FORMAT_VERSION: u64 = 2;

/// The metadata file of a group or an array.
pub const METADATA: &str = "zarr.json";

/// The attribute that holds the checksum of this very file. To take the checksum, the attribute is set to zeros.
const OWN_CHECKSUM: &str = "crc32";
const NO_CHECKSUM: &str = "00000000";

/// The attributes of a store.
#[derive(Clone, Debug)]
pub struct Group {
    attributes: Map<String, Value>,
    /// The metadata of all arrays by their names, as readers of Zarr look for it first; empty in the first version.
    arrays: Map<String, Value>,
}

impl Group {
    /// The metadata of a new store of an experiment, from that of its arrays by their names, and from the checksums of its small files
    /// by their paths.
    pub fn new(
        experiment: &Experiment,
        coordinates: &[&str],
        arrays: Map<String, Value>,
        files: Vec<(String, String)>,
    ) -> Self {
        let mut attributes = Map::new();
        attributes.insert("format".into(), FORMAT.into());
        attributes.insert("format_version".into(), FORMAT_VERSION.into());
        attributes.insert("program".into(), PROGRAM.into());
        attributes.insert("experiment".into(), experiment.outline().into());
        attributes.insert("coordinates".into(), coordinates.join(" ").into());
        let files = files.into_iter().map(|(path, sum)| (path, sum.into())).collect();
        attributes.insert("files_crc32".into(), Value::Object(files));
        attributes.insert(OWN_CHECKSUM.into(), NO_CHECKSUM.into());
        Self { attributes, arrays }
    }

    /// Reads the metadata of a store of any version that is known.
    ///
    /// # Errors
    /// [`StoreError::Foreign`], [`StoreError::Version`] or [`StoreError::Metadata`].
    pub fn read(store: &Path) -> Result<Self, StoreError> {
        let foreign = || StoreError::Foreign { path: store.to_owned() };
        let text = fs::read(store.join(METADATA)).map_err(|_| foreign())?;
        let is_ours = contains(&text, FORMAT) || contains(&text, FORMAT_1) || mark::folder(store).is_dir();
        let damaged = || StoreError::Metadata {
            path: store.to_owned(),
            what: format!("its file {METADATA}"),
        };
        let Some(group) = parse(&text) else {
            return Err(if is_ours { damaged() } else { foreign() });
        };
        match group.text("format") {
            Some(FORMAT) if !group.has_checksum_of(&text) && group.version() == Some(FORMAT_VERSION) => Err(damaged()),
            Some(FORMAT | FORMAT_1) if (1..=FORMAT_VERSION).contains(&group.version().unwrap_or(0)) => Ok(group),
            Some(FORMAT | FORMAT_1) => Err(StoreError::Version {
                path: store.to_owned(),
                found: group.attribute("format_version").unwrap_or(&Value::Null).to_string(),
                newest: FORMAT_VERSION,
            }),
            _ if is_ours => Err(damaged()),
            _ => Err(foreign()),
        }
    }

    /// Writes the metadata, whole or not at all.
    ///
    /// # Errors
    /// [`StoreError::Write`].
    pub fn write(&mut self, store: &Path) -> Result<(), StoreError> {
        self.attributes.insert(OWN_CHECKSUM.into(), NO_CHECKSUM.into());
        let own = checksum(&self.to_json());
        self.attributes.insert(OWN_CHECKSUM.into(), own.into());
        let file = store.join(METADATA);
        sync::write_whole(&file, &own_part(&file), &self.to_json()).map_err(|error| StoreError::write(store, &error))
    }

    fn to_json(&self) -> Vec<u8> {
        let metadata = json!({
            "zarr_format": 3,
            "node_type": "group",
            "attributes": self.attributes,
            "consolidated_metadata": {"kind": "inline", "must_understand": false, "metadata": self.arrays},
        });
        serde_json::to_vec_pretty(&metadata).expect("JSON values can be written")
    }

    /// Whether the text, with zeros for its checksum, has that checksum.
    fn has_checksum_of(&self, text: &[u8]) -> bool {
        let Some(own) = self.text(OWN_CHECKSUM) else {
            return false;
        };
        let entry = |sum: &str| format!("\"{OWN_CHECKSUM}\": \"{sum}\"");
        let text = String::from_utf8_lossy(text).replacen(&entry(own), &entry(NO_CHECKSUM), 1);
        checksum(text.as_bytes()) == own
    }

    /// The version of the format.
    pub fn version(&self) -> Option<u64> {
        self.attribute("format_version").and_then(Value::as_u64)
    }

    /// Paths of the small files within the store, with their checksums; none in the first version.
    pub fn files(&self) -> impl Iterator<Item = (&str, &str)> {
        let files = self.attribute("files_crc32").and_then(Value::as_object);
        files
            .into_iter()
            .flatten()
            .filter_map(|(path, sum)| Some((path.as_str(), sum.as_str()?)))
    }

    pub fn attributes(&self) -> &Map<String, Value> {
        &self.attributes
    }

    /// An attribute.
    pub fn attribute(&self, name: &str) -> Option<&Value> {
        self.attributes.get(name)
    }

    /// An attribute that is a text.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.attribute(name).and_then(Value::as_str)
    }

    /// Sets an attribute.
    pub fn set(&mut self, name: &str, value: Value) {
        self.attributes.insert(name.to_owned(), value);
    }
}

fn parse(text: &[u8]) -> Option<Group> {
    let mut metadata: Value = serde_json::from_slice(text).ok()?;
    let arrays = metadata
        .get_mut("consolidated_metadata")
        .and_then(|all| all.get_mut("metadata"));
    let arrays = arrays.and_then(Value::as_object_mut).map(std::mem::take);
    match metadata.get_mut("attributes")?.take() {
        Value::Object(attributes) => Some(Group {
            attributes,
            arrays: arrays.unwrap_or_default(),
        }),
        _ => None,
    }
}

fn contains(text: &[u8], part: &str) -> bool {
    text.windows(part.len()).any(|window| window == part.as_bytes())
}
