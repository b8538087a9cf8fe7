//! The files of the figures, and which of them are current.
//!
//! Owns names and the rule of what is current; computes nothing.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::json;

use super::table::{Row, markdown};
use super::{Effort, FIGURES, Figure, Outcome};
use crate::output::PROGRAM;
use crate::output::drawing::{with_ending, write_drawing};
use crate::output::figure::FigureError;
use crate::output::png::PngError;
use crate::output::table::{TableError, write_rows, write_text};

/// The folder of the figures.
pub struct Files {
    folder: PathBuf,
    effort: Effort,
}

/// What is kept of a figure beside its pictures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    pub figure: String,
    pub program: String,
    pub revision: u32,
    pub effort: Effort,
    pub rows: Vec<Row>,
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

    /// What is kept of a figure if its files are there and are what this version of the program would compute.
    pub fn current(&self, figure: &Figure) -> Option<Kept> {
        let name = self.name(figure);
        let text = fs::read_to_string(with_ending(&name, ".json")).ok()?;
        let kept: Kept = serde_json::from_str(&text).ok()?;
        let is_current = kept.figure == figure.id
            && kept.program == PROGRAM
            && kept.revision == figure.revision
            && kept.effort == self.effort
            && [".png", ".svg"]
                .iter()
                .all(|ending| with_ending(&name, ending).is_file());
        is_current.then_some(kept)
    }

    /// Writes a figure's pictures, data and rows; returns the files. The rows come last: where they are, all is.
    ///
    /// # Errors
    /// If the figure cannot be drawn, or a file cannot be written.
    pub fn write(&self, figure: &Figure, outcome: &Outcome) -> Result<Vec<PathBuf>, FilesError> {
        let name = self.name(figure);
        let kept = Kept {
            figure: figure.id.to_owned(),
            program: PROGRAM.to_owned(),
            revision: figure.revision,
            effort: self.effort,
            rows: outcome.rows.clone(),
        };
        let json_path = with_ending(&name, ".json");
        // what is half replaced must not pass for current
        if json_path.exists() {
            fs::remove_file(&json_path).map_err(|source| FilesError::Remove {
                path: json_path.clone(),
                source,
            })?;
        }
        let drawn = outcome.sheet.draw()?;
        let recipe = toml::to_string(&json!({
            "command": "reproduce",
            "figure": figure.id,
            "revision": figure.revision,
            "effort": self.effort,
            "program": PROGRAM,
        }))
        .expect("a recipe has a TOML form");
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
        let text = serde_json::to_string_pretty(&kept).expect("rows have a JSON form");
        write_text(&json_path, &(text + "\n"))?;
        files.push(json_path);
        Ok(files)
    }

    /// The table of all figures that are current, in Markdown, and writes it to `table.md`; returns it with its path.
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

#[derive(Debug, thiserror::Error)]
pub enum FilesError {
    #[error(transparent)]
    Figure(#[from] FigureError),
    #[error(transparent)]
    Drawing(#[from] PngError),
    #[error(transparent)]
    Table(#[from] TableError),
    #[error("{} cannot be removed: {source}; check the folder's permissions", path.display())]
    Remove { path: PathBuf, source: std::io::Error },
}
