//! States in the phase plane and over a parameter: orbits, stroboscopic sections and bifurcation diagrams.
//!
//! Owns what is drawn of them; neither computes them nor places panels.

use super::shared::{ALL_LEFT, Ends, colour_of, scale};
use crate::analysis::bifurcation::Diagram;
use crate::analysis::path::PathPoint;
use crate::picture::axis_label::AxisLabel;
use crate::picture::axis_scale::AxisScale;
use crate::picture::colour;
use crate::picture::density::Density;
use crate::picture::layer::{Layer, Stroke};
use crate::picture::panel::Panel;

const ANGLE: &str = "angle of the bush, x";
const SPEED: &str = "angular speed of the bush, y";
const STROBOSCOPIC: &str = "at drive phase 0";

/// Least extent of an axis of states. Otherwise the axis of a cycle would show only rounding errors.
const LEAST_EXTENT: f64 = 1e-3;

fn scale_of_states(label: &str, limits: Ends, values: impl Iterator<Item = f64>) -> AxisScale {
    let scale = scale(label, limits, values);
    if limits.is_some() || scale.high - scale.low >= LEAST_EXTENT {
        return scale;
    }
    let middle = 0.5 * (scale.low + scale.high);
    AxisScale::new(label, middle - 0.5 * LEAST_EXTENT, middle + 0.5 * LEAST_EXTENT)
}

/// Named orbits in the phase plane with their stroboscopic points. Orbits are dashed once all colours are in use.
pub fn phase(title: &str, orbits: &[(String, Vec<PathPoint>)], x: Ends, y: Ends) -> Panel {
    let points = || orbits.iter().flat_map(|(_, path)| path.iter());
    let stroke = |index: usize| Stroke {
        colour: colour_of(index),
        width: if orbits.len() > 1 { 1.0 } else { 0.8 },
        is_dashed: index >= colour::PERIODS.len(),
    };
    // the orbit with the most states is drawn first: a cycle would vanish under a chaotic orbit
    let mut from_below: Vec<usize> = (0..orbits.len()).collect();
    from_below.sort_by_key(|&index| std::cmp::Reverse(distinct_states(&orbits[index].1)));
    let curves = from_below.iter().map(|&index| Layer::Curve {
        name: String::new(),
        points: orbits[index].1.iter().map(|point| [point.x, point.y]).collect(),
        stroke: stroke(index),
    });
    let strobes = from_below.iter().map(|&index| {
        let strobes = orbits[index].1.iter().filter(|point| point.is_stroboscopic);
        Layer::Marks {
            name: String::new(),
            points: strobes.map(|point| [point.x, point.y]).collect(),
            colour: darker(colour_of(index)),
            radius: 3.5,
        }
    });
    let drawn = orbits.iter().enumerate().filter(|(_, (_, path))| !path.is_empty());
    let keys = drawn.map(|(index, (name, _))| Layer::CurveKey {
        name: name.clone(),
        stroke: stroke(index),
    });
    let key_of_marks = points().any(|point| point.is_stroboscopic).then(|| Layer::MarkKey {
        name: STROBOSCOPIC.to_owned(),
        colour: [0x30; 3],
    });
    Panel {
        title: title.to_owned(),
        x: scale_of_states(ANGLE, x, points().map(|point| point.x)),
        y: scale_of_states(SPEED, y, points().map(|point| point.y)),
        layers: curves.chain(strobes).chain(keys).chain(key_of_marks).collect(),
        nothing: "no orbit lasts".to_owned(),
    }
}

/// Number of stroboscopic states that differ in three decimals: few for a cycle, many for a chaotic orbit.
fn distinct_states(path: &[PathPoint]) -> usize {
    let strobes = path.iter().filter(|point| point.is_stroboscopic);
    let states = strobes.map(|point| [point.x, point.y].map(|value| (1e3 * value).round() as i64));
    states.collect::<std::collections::BTreeSet<_>>().len()
}

fn darker(colour: colour::Rgb) -> colour::Rgb {
    colour.map(|value| (f64::from(value) * 0.55) as u8)
}

/// The stroboscopic section as a density over a frame of the given size.
pub fn section(title: &str, points: &[[f64; 2]], x: Ends, y: Ends, frame: [u32; 2]) -> Panel {
    let x = scale_of_states(
        &format!("{ANGLE} ({STROBOSCOPIC})"),
        x,
        points.iter().map(|point| point[0]),
    );
    let y = scale_of_states(
        &format!("{SPEED} ({STROBOSCOPIC})"),
        y,
        points.iter().map(|point| point[1]),
    );
    let density = Density::new(
        points.iter().copied(),
        [x.low, x.high],
        [y.low, y.high],
        frame.map(|size| size as usize),
    );
    Panel {
        title: title.to_owned(),
        x,
        y,
        layers: vec![Layer::Density(density)],
        nothing: ALL_LEFT.to_owned(),
    }
}

/// Which component of the stroboscopic states a bifurcation diagram shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Component {
    /// The angle.
    X,
    /// The angular speed.
    Y,
}

/// The bifurcation diagram as a density over a frame of the given size.
///
/// Each column of pixels shows the states of a fixed whole number of the axis' values. Otherwise a column with one value more
/// would be darker.
pub fn bifurcation(title: &str, diagram: &Diagram, component: Component, limits: Ends, frame: [u32; 2]) -> Panel {
    let axis = &diagram.axis;
    let value = |state: &[f64; 2]| state[component as usize];
    let states = || diagram.columns.iter().flatten().map(value);
    let label = match component {
        Component::X => ANGLE,
        Component::Y => SPEED,
    };
    let y = scale_of_states(&format!("{label} ({STROBOSCOPIC})"), limits, states());
    let group = axis.count().div_ceil(frame[0] as usize);
    let columns = axis.count().div_ceil(group);
    let points = axis.rising().into_iter().enumerate().flat_map(|(place, index)| {
        let column = diagram.columns[index].iter();
        column.map(move |state| [place as f64 + 0.5, value(state)])
    });
    let extent = [0.0, (columns * group) as f64];
    let density = Density::new(points, extent, [y.low, y.high], [columns, frame[1] as usize]);
    let label = AxisLabel::of(axis, &diagram.fixed);
    Panel {
        title: title.to_owned(),
        x: label.scale(axis, -0.5, extent[1] - 0.5),
        y,
        layers: vec![Layer::Density(density)],
        nothing: ALL_LEFT.to_owned(),
    }
}

/// States outside the frame of a panel with a density.
pub fn outside(panel: &Panel) -> usize {
    let of_layer = |layer: &Layer| match layer {
        Layer::Density(density) => density.outside(),
        _ => 0,
    };
    panel.layers.iter().map(of_layer).sum()
}

#[cfg(test)]
mod tests {
    use super::super::shared::MOST_CURVES;
    use super::*;
    use crate::picture::sheet::Sheet;

    fn svg(panel: Panel) -> String {
        Sheet::single(panel, Vec::new()).draw().unwrap().svg
    }

    fn state(x: f64) -> PathPoint {
        PathPoint {
            tau: 0.0,
            x,
            y: x,
            is_stroboscopic: true,
        }
    }

    #[test]
    fn orbits_are_told_apart_and_stand_in_the_legend_in_their_order() {
        let orbits: Vec<(String, Vec<PathPoint>)> = (0..MOST_CURVES)
            .map(|index| (format!("orbit {index}"), (0..=index).map(|k| state(k as f64)).collect()))
            .collect();
        let panel = phase("", &orbits, None, None);
        let keys: Vec<(String, Stroke)> = panel
            .layers
            .iter()
            .filter_map(|layer| match layer {
                Layer::CurveKey { name, stroke } => Some((name.clone(), *stroke)),
                _ => None,
            })
            .collect();
        let names = orbits.iter().map(|(name, _)| name);
        assert!(keys.iter().map(|(name, _)| name).eq(names));
        for (index, (_, one)) in keys.iter().enumerate() {
            assert!(keys[..index].iter().all(|(_, other)| one != other), "{index}");
        }
        // the orbit with the most states is drawn first
        let Layer::Curve { points, .. } = &panel.layers[0] else {
            panic!("curves come first")
        };
        assert_eq!(points.len(), MOST_CURVES);
    }

    #[test]
    fn orbits_that_ran_away_have_neither_axes_nor_a_legend() {
        let svg = svg(phase("", &[("an orbit".to_owned(), Vec::new())], None, None));
        assert!(svg.contains("nothing to draw: no orbit lasts"));
        assert!(!svg.contains("an orbit") && !svg.contains(STROBOSCOPIC) && !svg.contains(">0.5<"));
    }

    #[test]
    fn the_states_of_a_cycle_do_not_shrink_their_axes() {
        let noise = [[0.5, 0.1], [0.5 + 1e-15, 0.1 - 1e-16]];
        let panel = section("", &noise, None, None, [90, 60]);
        for (scale, middle) in [(&panel.x, 0.5), (&panel.y, 0.1)] {
            assert!((scale.high - scale.low - LEAST_EXTENT).abs() < 1e-9, "{scale:?}");
            assert!((0.5 * (scale.high + scale.low) - middle).abs() < 1e-9, "{scale:?}");
        }
        // ends that are given stay
        let panel = section("", &noise, Some([0.5, 0.5 + 1e-6]), None, [90, 60]);
        assert_eq!([panel.x.low, panel.x.high], [0.5, 0.5 + 1e-6]);
    }
}
