//! The border of chaos in three parameters: maps of the kinds of motion in planes of the third.
//!
//! Owns what is drawn of it; neither finds it nor places panels.

use crate::design::Coordinate;
use crate::machine::units::rounded;
use crate::map::ParameterMap;
use crate::measure::Class;
use crate::picture::axis_label::AxisLabel;
use crate::picture::caption::assigned;
use crate::picture::colour::{self, Rgb, class_colour};
use crate::picture::layer::Layer;
use crate::picture::panel::Panel;

/// The kinds of motion of a point, with the colour of each.
const KINDS: [(&str, Rgb); 7] = [
    ("chaotic", class_colour(Class::Chaotic)),
    ("regular", class_colour(Class::Regular)),
    ("quasi-periodic", class_colour(Class::QuasiPeriodic)),
    ("undecided", class_colour(Class::Undecided)),
    ("unstable", class_colour(Class::Unstable)),
    ("runaway", colour::RUNAWAY),
    ("under-resolved", colour::UNDER_RESOLVED),
];

/// The index of a point's kind.
fn kind(map: &ParameterMap, index: usize) -> usize {
    match map.class(index) {
        Some(class) => class as usize,
        None if map.is_runaway(index) => 5,
        None => 6,
    }
}

/// A panel for each map, whose plane has a value of a third coordinate, in rows of `columns`. The last panel has the legend of all.
pub fn border_planes(planes: &[(f64, ParameterMap)], third: Coordinate, columns: usize) -> Vec<Panel> {
    let occurs = |of: usize| {
        planes
            .iter()
            .any(|(_, map)| (0..map.experiment.design.len()).any(|index| kind(map, index) == of))
    };
    let keys: Vec<Layer> = KINDS
        .iter()
        .enumerate()
        .filter(|(index, _)| occurs(*index))
        .map(|(_, (name, colour))| Layer::MarkKey {
            name: (*name).to_owned(),
            colour: *colour,
        })
        .collect();
    let panel = |(index, (value, map)): (usize, &(f64, ParameterMap))| {
        let at = &map.experiment.design.fixed;
        let [x, y] = [map.x_axis(), map.y_axis()].map(|axis| {
            let scale = AxisLabel::of(axis, at).scale(axis, -0.5, axis.count() as f64 - 0.5);
            (axis.rising(), scale)
        });
        let (across, up) = (&x.0, &y.0);
        let points = up
            .iter()
            .flat_map(|row| across.iter().map(move |column| row * across.len() + column));
        let colours = points.map(|index| KINDS[kind(map, index)].1);
        let mut y_scale = y.1;
        if index % columns > 0 {
            y_scale.label.clear();
        }
        let is_lowest = index + columns >= planes.len();
        let is_last = index + 1 == planes.len();
        let cells = Layer::Cells {
            columns: across.len(),
            colours: colours.collect(),
        };
        Panel {
            title: assigned(at, third, rounded(*value)),
            x: if is_lowest { x.1 } else { x.1.bare() },
            y: y_scale,
            layers: [cells]
                .into_iter()
                .chain(if is_last { keys.clone() } else { Vec::new() })
                .collect(),
            nothing: String::new(),
        }
    };
    planes.iter().enumerate().map(panel).collect()
}
