//! `--overlay`: a curve from theory over pictures of maps.
//!
//! Owns what can be asked for; the curve is the library's.

use serde::Deserialize;

use super::Failure;
use crate::analysis::melnikov::curve_over_map;
use crate::experiment::Experiment;
use crate::picture::Overlay;

/// A theory that gives a curve over a map.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Theory {
    Melnikov,
}

/// The curve that is asked for, computed before any long work.
///
/// # Errors
/// If the theory has no curve over the map's axes.
pub fn curve(theory: Option<Theory>, experiment: &Experiment) -> Result<Option<Overlay>, Failure> {
    let Some(Theory::Melnikov) = theory else {
        return Ok(None);
    };
    Ok(Some(Overlay {
        name: "Mel'nikov's threshold".to_owned(),
        points: curve_over_map(experiment).map_err(Failure::input)?,
    }))
}
