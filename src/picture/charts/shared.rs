//! What all charts share: colours of curves, and ends of axes.
//!
//! Owns no chart.

use crate::picture::axis_scale::AxisScale;
use crate::picture::colour;

/// Ends of an axis that are given beforehand; None takes them from the data.
pub type Ends = Option<[f64; 2]>;

/// The scale of an axis.
pub fn scale(label: &str, limits: Ends, values: impl Iterator<Item = f64>) -> AxisScale {
    match limits {
        Some([low, high]) => AxisScale::new(label, low, high),
        None => AxisScale::around(label, values),
    }
}

/// Colour of the curve with an index.
pub fn colour_of(index: usize) -> colour::Rgb {
    colour::PERIODS[index % colour::PERIODS.len()]
}

/// Curves that can be told apart in one picture: each colour solid and dashed.
pub const MOST_CURVES: usize = 2 * colour::PERIODS.len();

/// Grey, for zero lines.
pub const FAINT: colour::Rgb = [0x80, 0x80, 0x80];

/// Half-width of a band, in standard errors.
pub const BAND: f64 = 2.0;

/// The message if no orbit is left.
pub const ALL_LEFT: &str = "every orbit ran away or was given up as under-resolved";
