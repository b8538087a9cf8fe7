//! The paper's figures and numbers, computed anew.
//!
//! Owns the list of figures, with the paper's axes, parameters and statements; computes through [`crate::analysis`] and draws
//! through [`crate::picture`]. The paper's statements are kept beside the computed results, and never enter them.

mod files;
mod melnikov;
mod reduced;
mod rubbed;
pub mod table;

use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

pub use self::files::{Digest, Files, FilesError, Kept};
use self::table::Row;
use crate::analysis::melnikov::CurveError;
use crate::backend::BackendError;
use crate::model::melnikov::MelnikovError;
use crate::picture::PictureError;
use crate::picture::sheet::Sheet;

/// How much is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Effort {
    /// Figures for print: a minute or two.
    Full,
    /// The same rows and pictures from coarse scans: seconds.
    Quick,
}

/// A figure of the paper.
pub struct Figure {
    /// Its number in the paper.
    pub id: &'static str,
    pub title: &'static str,
    /// Raised when the computation changes, so that older results do not count as current.
    revision: u32,
    compute: fn(Effort, &mut Breaker<'_>) -> Result<Option<Outcome>, PaperError>,
}

/// Called after each piece of work; may stop the computation.
pub type Breaker<'a> = dyn FnMut() -> ControlFlow<()> + Send + 'a;

/// The result of a figure.
pub struct Outcome {
    pub sheet: Sheet,
    /// Rows of the table that compares the paper with the program.
    pub rows: Vec<Row>,
    /// The data of each panel.
    pub data: Vec<Data>,
}

/// The data of a panel, for a table of comma-separated values.
pub struct Data {
    /// The panel's letter; empty where there is one panel alone.
    pub panel: String,
    pub columns: Vec<String>,
    pub rows: Vec<Vec<f64>>,
}

/// The paper's figures, in the order of the paper. A new figure needs an entry here.
pub const FIGURES: &[Figure] = &[
    Figure {
        id: "3.1",
        title: "Bifurcation diagrams and Lyapunov exponents without damping",
        revision: 2,
        compute: reduced::figure_3_1,
    },
    Figure {
        id: "3.2",
        title: "Bifurcation diagrams and Lyapunov exponents with damping",
        revision: 2,
        compute: reduced::figure_3_2,
    },
    Figure {
        id: "4.1",
        title: "Mel'nikov's function",
        revision: 2,
        compute: melnikov::figure_4_1,
    },
    Figure {
        id: "5.1",
        title: "Phase plane without and with frictional heat",
        revision: 2,
        compute: rubbed::figure_5_1,
    },
    Figure {
        id: "5.2",
        title: "Contact pressure and wear without frictional heat",
        revision: 2,
        compute: rubbed::figure_5_2,
    },
    Figure {
        id: "5.3",
        title: "Contact pressure with frictional heat and wear",
        revision: 2,
        compute: rubbed::figure_5_3,
    },
    Figure {
        id: "5.4",
        title: "Wear without and with frictional heat",
        revision: 2,
        compute: rubbed::figure_5_4,
    },
];

impl Figure {
    /// # Errors
    /// [`PaperError::Unknown`] with the figures that there are.
    pub fn from_id(id: &str) -> Result<&'static Self, PaperError> {
        FIGURES
            .iter()
            .find(|figure| figure.id == id)
            .ok_or_else(|| PaperError::Unknown { id: id.to_owned() })
    }

    /// Computes the figure; None if the observer broke it off.
    ///
    /// # Errors
    /// If the CPU backend fails, or the figure cannot be drawn.
    pub fn compute(&self, effort: Effort, observer: &mut Breaker<'_>) -> Result<Option<Outcome>, PaperError> {
        (self.compute)(effort, observer)
    }
}

#[derive(Debug, thiserror::Error)]
pub enum PaperError {
    #[error("there is no figure `{id}`: {} can be computed", FIGURES.iter().map(|figure| figure.id).collect::<Vec<_>>().join(", "))]
    Unknown { id: String },
    #[error(transparent)]
    Backend(#[from] BackendError),
    #[error(transparent)]
    Melnikov(#[from] MelnikovError),
    #[error(transparent)]
    Curve(#[from] CurveError),
    #[error(transparent)]
    Figure(#[from] PictureError),
}

#[cfg(test)]
mod tests;
