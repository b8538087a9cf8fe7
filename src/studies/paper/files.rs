//! The files of the figures, and which of them are current.
//!
//! Owns names and the rule of what is current; computes nothing.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::json;

use super::table::{Row, markdown};
use super::{Effort, FIGURES, Figure, Outcome};
use crate::output::PROGRAM;
use crate::output::csv::write_rows;
use crate::output::whole::{WriteError, write_text};
use crate::picture::PictureError;
use crate::picture::drawing::{with_ending, write_drawing};
use crate::picture::png::PngError;

/// The folder of the figures.
pub struct Files {
    folder: PathBuf,
    effort: Effort,
}

/// The record of a figure, in a file beside its pictures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    pub figure: String,
    pub program: String,
    pub revision: u32,
    pub effort: Effort,
    /// The other files by their names, as they were written.
    pub files: BTreeMap<String, Digest>,
    pub rows: Vec<Row>,
}

/// Length and checksum, which tell a file from another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Digest {
    pub bytes: usize,
    pub crc32: u32,
}

impl Digest {
    fn of(path: &Path) -> io::Result<Self> {
        let content = fs::read(path)?;
        Ok(Self {
            bytes: content.len(),
            crc32: crc32fast::hash(&content),
        })
    }
}

impl Files {
    pub fn new(folder: &Path, effort: Effort) -> Self {
        Self {
            folder: folder.to_owned(),
            effort,
        }
    }

    fn name(&self, figure: &Figure) -> PathBuf {
        self.folder.join(format!("figure-{}", figure.id))
    }

    fn kept(&self, figure: &Figure) -> Option<Kept> {
        let text = fs::read_to_string(with_ending(&self.name(figure), ".json")).ok()?;
        serde_json::from_str(&text).ok()
    }

    /// The record of a figure, if the figure is current: its files have not changed, and this version of the program would
    /// compute the same.
    pub fn current(&self, figure: &Figure) -> Option<Kept> {
        let kept = self.kept(figure)?;
        let is_current = kept.figure == figure.id
            && kept.program == PROGRAM
            && kept.revision == figure.revision
            && kept.effort == self.effort
            && kept
                .files
                .iter()
                .all(|(name, digest)| Digest::of(&self.folder.join(name)).is_ok_and(|found| found == *digest));
        is_current.then_some(kept)
    }

    /// Whether the figure exists with another effort. Such a figure must not be replaced by accident.
    pub fn is_of_other_effort(&self, figure: &Figure) -> bool {
        self.kept(figure).is_some_and(|kept| kept.effort != self.effort)
    }

    /// Writes a figure's pictures, data and rows; returns the files. The file with the rows is written last: if it exists, all
    /// others do.
    ///
    /// # Errors
    /// If the figure cannot be drawn, or a file cannot be written.
    pub fn write(&self, figure: &Figure, outcome: &Outcome) -> Result<Vec<PathBuf>, FilesError> {
        let name = self.name(figure);
        let json_path = with_ending(&name, ".json");
        // a figure that is only partly replaced must not count as current
        if json_path.exists() {
            fs::remove_file(&json_path).map_err(|source| FilesError::Remove {
                path: json_path.clone(),
                source,
            })?;
        }
        let drawn = outcome.sheet.draw()?;
        let options = json!({ "figure": figure.id, "revision": figure.revision, "effort": self.effort });
        let recipe = toml::to_string(&json!({ "command": "reproduce", "options": options }));
        let recipe = recipe.expect("options have a TOML form");
        let mut files = write_drawing(&name, &drawn, figure.title, &recipe)?.to_vec();
        for data in &outcome.data {
            let path = with_ending(&name, &format!("{}.csv", data.panel));
            let comment = if data.panel.is_empty() {
                format!("figure {}", figure.id)
            } else {
                format!("figure {} ({})", figure.id, data.panel)
            };
            write_rows(&path, &[comment], &data.columns, data.rows.iter().map(Vec::as_slice))?;
            files.push(path);
        }
        let kept = Kept {
            figure: figure.id.to_owned(),
            program: PROGRAM.to_owned(),
            revision: figure.revision,
            effort: self.effort,
            files: files.iter().map(|path| digest(path)).collect::<Result<_, _>>()?,
            rows: outcome.rows.clone(),
        };
        let text = serde_json::to_string_pretty(&kept).expect("rows have a JSON form");
        write_text(&json_path, &(text + "\n"))?;
        files.push(json_path);
        Ok(files)
    }

    /// Writes the table of all current figures, in Markdown, to `table.md`; returns the table and its path.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write_table(&self) -> Result<(String, PathBuf), FilesError> {
        let kept: Vec<Kept> = FIGURES.iter().filter_map(|figure| self.current(figure)).collect();
        let rows = kept
            .iter()
            .flat_map(|kept| kept.rows.iter().map(|row| (kept.figure.as_str(), row)));
        let table = markdown(rows);
        let path = self.folder.join("table.md");
        write_text(&path, &table)?;
        Ok((table, path))
    }
}

/// A file's name with its digest.
fn digest(path: &Path) -> Result<(String, Digest), FilesError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let digest = Digest::of(path).map_err(|source| FilesError::Read {
        path: path.to_owned(),
        source,
    })?;
    Ok((name, digest))
}

#[derive(Debug, thiserror::Error)]
pub enum FilesError {
    #[error(transparent)]
    Figure(#[from] PictureError),
    #[error(transparent)]
    Drawing(#[from] PngError),
    #[error(transparent)]
    Table(#[from] WriteError),
    #[error("{} cannot be removed: {source}; check the folder's permissions", path.display())]
    Remove { path: PathBuf, source: io::Error },
    #[error("{} cannot be read again: {source}; check the disk", path.display())]
    Read { path: PathBuf, source: io::Error },
}
