//! The style of a map, as a user chooses it.
//!
//! Owns the defaults, and whether a map can be drawn in a style.

use super::layout::cell_size;
use super::plot::Overlay;
use crate::experiment::Experiment;
use crate::picture::colour::ColourScale;
use crate::picture::error::PictureError;

/// How a picture is drawn.
#[derive(Clone, Debug)]
pub struct Style {
    /// Values at the ends of the colour bar; by default they are taken from the data. If the bar is in SI units, these are SI units
    /// without a prefix. A two-sided scale is always centred at zero: its colours reach as far as the larger of the two.
    pub limits: Option<(f64, f64)>,
    /// The pair of scales; each quantity takes one of the two.
    pub colours: ColourScale,
    /// Whether the border of chaos is drawn on the map of the exponent.
    pub border: bool,
    /// A curve from theory that is drawn over every map.
    pub overlay: Option<Overlay>,
    /// A paragraph for the caption, on how the map came about.
    pub note: Option<String>,
    /// Width and height of the plotted map in pixels. They are approximate, because every point takes whole pixels.
    pub size: [u32; 2],
}

impl Default for Style {
    fn default() -> Self {
        Self {
            limits: None,
            colours: ColourScale::default(),
            border: true,
            overlay: None,
            note: None,
            size: [960, 640],
        }
    }
}

/// Checks, before anything is computed, that the map can be drawn.
///
/// # Errors
/// [`PictureError::TooLarge`].
///
/// # Panics
/// If the experiment does not have two axes.
pub fn check_size(experiment: &Experiment, style: &Style) -> Result<(), PictureError> {
    let [x, y] = experiment.design.axes() else {
        panic!("a map has two axes")
    };
    cell_size(x.count(), y.count(), style.size).map(|_| ())
}
