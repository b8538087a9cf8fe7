//! The colours of a map and their meaning, for others who draw.
//!
//! Owns nothing but the form; the choice of colours is [`super::quantity`]'s.

use super::plot::{Cell, Plot};
use crate::picture::colour::Rgb;

/// How a map shows a quantity.
#[derive(Clone, Debug)]
pub struct Shades {
    /// The colour of each point, in the order of the map; None where it is not computed.
    pub colours: Vec<Option<Rgb>>,
    /// What the legend begins with; may be empty.
    pub heading: String,
    /// Colours that stand for a kind of points, and its name: those that occur.
    pub legend: Vec<(Rgb, String)>,
    /// The colour bar, if a point has a value on it.
    pub bar: Option<Ramp>,
}

/// A colour bar.
#[derive(Clone, Debug)]
pub struct Ramp {
    /// Words, with the unit.
    pub label: String,
    /// The value at the lower end.
    pub low: f64,
    /// The value at the upper end.
    pub high: f64,
    /// Whether there are values below `low`.
    pub below: bool,
    /// Whether there are values above `high`.
    pub above: bool,
    /// Colours at equal distances from `low` to `high`.
    pub colours: Vec<Rgb>,
}

/// Colours of a ramp.
const STOPS: u32 = 256;

impl Shades {
    pub(super) fn of(plot: &Plot) -> Self {
        let colours = plot.cells.iter().map(|cell| match *cell {
            Cell::NotComputed => None,
            Cell::Kind(kind) => Some(plot.kinds[kind].colour),
            Cell::Value(value) => plot.bar.as_ref().map(|bar| (bar.colour)(value)),
        });
        let legend = plot.kinds.iter().enumerate();
        let legend = legend.filter(|(index, _)| plot.cells.contains(&Cell::Kind(*index)));
        Self {
            colours: colours.collect(),
            heading: plot.heading.clone(),
            legend: legend.map(|(_, kind)| (kind.colour, kind.name.clone())).collect(),
            bar: plot.bar.as_ref().map(|bar| Ramp {
                label: bar.label.clone(),
                low: bar.low,
                high: bar.high,
                below: bar.below,
                above: bar.above,
                colours: (0..STOPS)
                    .map(|stop| {
                        let part = f64::from(stop) / f64::from(STOPS - 1);
                        (bar.colour)(bar.low + (bar.high - bar.low) * part)
                    })
                    .collect(),
            }),
        }
    }
}
