//! Shares of chaos over the coordinates of a design, one by one and in pairs.
//!
//! Owns what is drawn of them; neither counts points nor places panels.

use super::shared::colour_of;
use crate::analysis::overview::{Overview, Share};
use crate::design::{Axis, Fixed};
use crate::picture::axis_label::AxisLabel;
use crate::picture::axis_scale::AxisScale;
use crate::picture::colour::{self, ColourScale, Rgb};
use crate::picture::layer::{Layer, Stroke};
use crate::picture::panel::Panel;

/// A panel for each coordinate that varies: the share of chaos in each of its bins, with 95 % intervals.
pub fn shares(overview: &Overview<'_>, at: &Fixed) -> Vec<Panel> {
    let all = overview.extents().iter().zip(overview.shares());
    let drawn: Vec<(&Axis, Vec<Share>)> = all
        .filter_map(|(extent, shares)| Some((extent.axis.as_ref()?, shares)))
        .collect();
    // one scale for all, as high as it must be
    let filled = drawn
        .iter()
        .flat_map(|(_, shares)| shares)
        .filter(|share| share.all > 0);
    let top = filled.map(|share| share.interval()[1]).fold(0.0, f64::max);
    let top = (1.05 * top).min(1.0);
    let panels = drawn.iter().enumerate();
    panels
        .map(|(index, (axis, shares))| panel(axis, shares, at, top, index == 0))
        .collect()
}

fn panel(axis: &Axis, shares: &[Share], at: &Fixed, top: f64, is_first: bool) -> Panel {
    let label = AxisLabel::of(axis, at);
    let places: Vec<f64> = axis
        .rising()
        .into_iter()
        .map(|index| label.place(axis, axis.value(index)))
        .collect();
    let last = axis.count() as f64 - 1.0;
    let named = |name: &str| if is_first { name.to_owned() } else { String::new() };
    let points: Vec<[f64; 2]> = places
        .iter()
        .zip(shares)
        .map(|(&x, share)| [x, share.value()])
        .collect();
    let interval = |share: &Share| if share.all > 0 { share.interval() } else { [f64::NAN; 2] };
    Panel {
        title: String::new(),
        x: label.scale(axis, -0.02 * last, 1.02 * last),
        y: AxisScale::new("share of chaos", 0.0, top),
        layers: vec![
            Layer::Band {
                name: named("95 % interval for as many random points"),
                points: (places.iter().zip(shares))
                    .map(|(&x, share)| {
                        let [low, high] = interval(share);
                        [x, low, high]
                    })
                    .collect(),
                colour: colour_of(0),
            },
            Layer::Curve {
                name: named("share of chaotic points"),
                points: points.clone(),
                stroke: Stroke::solid(colour_of(0), 1.6),
            },
            Layer::Marks {
                name: String::new(),
                points,
                colour: colour_of(0),
                radius: 2.5,
            },
        ],
        nothing: "no point is computed".to_owned(),
    }
}

/// From nearly white to the red of chaos on maps.
fn colour_of_share(share: f64) -> Rgb {
    ColourScale::default().two_sided(share)
}

/// A panel for each pair of coordinates that vary: the share of chaos in each pair of bins. The last panel has the legend of all.
pub fn pairs(overview: &Overview<'_>, at: &Fixed) -> Vec<Panel> {
    let extents = overview.extents_of_pairs();
    let varying: Vec<(usize, &Axis)> = extents
        .iter()
        .enumerate()
        .filter_map(|(index, extent)| Some((index, extent.axis.as_ref()?)))
        .collect();
    let mut panels = Vec::new();
    for (place, &(up, y)) in varying.iter().enumerate() {
        for &(across, x) in &varying[..place] {
            let scale = |axis: &Axis| AxisLabel::of(axis, at).scale(axis, -0.5, axis.count() as f64 - 0.5);
            let shares = overview.shares_of_pair([across, up]);
            let colour = |share: &Share| {
                if share.all > 0 {
                    colour_of_share(share.value())
                } else {
                    colour::UNDECIDED
                }
            };
            panels.push(Panel {
                title: String::new(),
                x: scale(x),
                y: scale(y),
                layers: vec![Layer::Cells {
                    columns: x.count(),
                    colours: shares.iter().map(colour).collect(),
                }],
                nothing: String::new(),
            });
        }
    }
    let has_empty = panels.iter().any(|panel| {
        let is_empty =
            |layer: &Layer| matches!(layer, Layer::Cells { colours, .. } if colours.contains(&colour::UNDECIDED));
        panel.layers.iter().any(is_empty)
    });
    if let Some(last) = panels.last_mut() {
        last.layers.extend([0, 25, 50, 75, 100].map(|percent| Layer::MarkKey {
            name: format!("{percent} %"),
            colour: colour_of_share(f64::from(percent) / 100.0),
        }));
        last.layers.extend(has_empty.then(|| Layer::MarkKey {
            name: "no point".to_owned(),
            colour: colour::UNDECIDED,
        }));
    }
    panels
}
