//! Panels of the analyses: which layers, labels and colours each has.
//!
//! Owns what is drawn of a result; neither computes it nor places panels.

use super::caption::{AxisLabel, assigned};
use super::colour;
use super::density::Density;
use super::panel::{Layer, Panel, Scale, Stroke};
use crate::analysis::bifurcation::Diagram;
use crate::analysis::exponents::Line;
use crate::analysis::melnikov::Curve;
use crate::analysis::onset::Found;
use crate::analysis::path::PathPoint;
use crate::machine::units::Unit;
use crate::measurement::Measurement;

/// Ends of an axis that are given beforehand; None takes them from the data.
pub type Limits = Option<[f64; 2]>;

const ANGLE: &str = "angle of the bush, x";
const SPEED: &str = "angular speed of the bush, y";
const STROBOSCOPIC: &str = "at drive phase 0";

pub(super) fn scale(label: &str, limits: Limits, values: impl Iterator<Item = f64>) -> Scale {
    match limits {
        Some([low, high]) => Scale::new(label, low, high),
        None => Scale::around(label, values),
    }
}

/// Colour of the curve with an index.
pub(super) fn colour_of(index: usize) -> colour::Rgb {
    colour::PERIODS[index % colour::PERIODS.len()]
}

/// Grey, for zero lines.
pub(super) const FAINT: colour::Rgb = [0x80, 0x80, 0x80];

/// Mel'nikov's function over tau0: named curves of pairs (tau0, M); every second one is dashed.
pub fn melnikov(title: &str, curves: &[(String, Vec<[f64; 2]>)], limits: Limits) -> Panel {
    let points = || curves.iter().flat_map(|(_, points)| points.iter());
    let mut layers = vec![Layer::Level {
        y: 0.0,
        stroke: Stroke::solid(FAINT, 1.0),
    }];
    layers.extend(curves.iter().enumerate().map(|(index, (name, points))| Layer::Curve {
        name: name.clone(),
        points: points.clone(),
        stroke: Stroke {
            colour: colour_of(index),
            width: 2.0,
            is_dashed: index % 2 == 1,
        },
    }));
    let times = points().map(|point| point[0]);
    Panel {
        title: title.to_owned(),
        x: Scale::new(
            "time τ₀",
            times.clone().fold(f64::INFINITY, f64::min),
            times.fold(f64::NEG_INFINITY, f64::max),
        ),
        y: scale(
            "Mel'nikov's function M(τ₀)",
            limits,
            points().map(|point| point[1]).chain([0.0]),
        ),
        layers,
    }
}

/// The threshold in one parameter over another.
pub fn threshold(curve: &Curve) -> Panel {
    let label = AxisLabel::of(&curve.over, &curve.fixed);
    let along = curve.along.coordinate;
    let found = || curve.thresholds.iter().filter_map(|threshold| threshold.value());
    let largest = found().map(f64::abs).fold(0.0, f64::max);
    let unit = Unit::suited(curve.fixed.unit(along), largest);
    // the thresholds beyond which M changes sign on one side, below or above
    let points = |sides: [bool; 2]| -> Vec<[f64; 2]> {
        let points = curve.thresholds.iter().enumerate().map(|(index, threshold)| {
            let found = threshold.value().filter(|_| threshold.changes_sign() == sides);
            [
                label.factor * curve.over.value(index),
                found.map_or(f64::NAN, |value| unit.factor * value),
            ]
        });
        points.collect()
    };
    let curves = [
        ("from here upward Mel'nikov's function changes sign", [false, true]),
        ("from here downward Mel'nikov's function changes sign", [true, false]),
    ];
    let (low, high) = (
        curve.over.start.min(curve.over.stop),
        curve.over.start.max(curve.over.stop),
    );
    Panel {
        title: String::new(),
        x: Scale::new(&label.words, label.factor * low, label.factor * high),
        y: Scale::around(
            &format!("threshold in {}{}", along.symbol(), unit.bracketed()),
            found().map(|value| unit.factor * value),
        ),
        layers: curves
            .into_iter()
            .enumerate()
            .filter(|(_, (_, sides))| curve.thresholds.iter().any(|found| found.changes_sign() == *sides))
            .map(|(index, (name, sides))| Layer::Curve {
                name: name.to_owned(),
                points: points(sides),
                stroke: Stroke::solid(colour_of(index), 2.0),
            })
            .collect(),
    }
}

/// Named orbits in the phase plane with their stroboscopic points.
pub fn phase(title: &str, orbits: &[(String, Vec<PathPoint>)], x: Limits, y: Limits) -> Panel {
    let points = || orbits.iter().flat_map(|(_, path)| path.iter());
    let curves = orbits.iter().enumerate().map(|(index, (name, path))| Layer::Curve {
        name: name.clone(),
        points: path.iter().map(|point| [point.x, point.y]).collect(),
        stroke: Stroke::solid(colour_of(index), if orbits.len() > 1 { 1.0 } else { 0.8 }),
    });
    let strobes = orbits.iter().enumerate().map(|(index, (_, path))| {
        let strobes = path.iter().filter(|point| point.is_stroboscopic);
        Layer::Marks {
            name: String::new(),
            points: strobes.map(|point| [point.x, point.y]).collect(),
            colour: darker(colour_of(index)),
            radius: 3.5,
        }
    });
    // one legend entry for all orbits
    let legend_of_marks = Layer::Marks {
        name: STROBOSCOPIC.to_owned(),
        points: Vec::new(),
        colour: [0x30; 3],
        radius: 3.5,
    };
    Panel {
        title: title.to_owned(),
        x: scale(ANGLE, x, points().map(|point| point.x)),
        y: scale(SPEED, y, points().map(|point| point.y)),
        layers: curves.chain(strobes).chain([legend_of_marks]).collect(),
    }
}

fn darker(colour: colour::Rgb) -> colour::Rgb {
    colour.map(|value| (f64::from(value) * 0.55) as u8)
}

/// The stroboscopic section as a density over a frame of the given size.
pub fn section(title: &str, points: &[[f64; 2]], x: Limits, y: Limits, frame: [u32; 2]) -> Panel {
    let x = scale(
        &format!("{ANGLE} ({STROBOSCOPIC})"),
        x,
        points.iter().map(|point| point[0]),
    );
    let y = scale(
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
    }
}

/// Which component of the stroboscopic states a bifurcation diagram shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Component {
    X,
    Y,
}

/// The bifurcation diagram as a density over a frame of the given size.
///
/// Each column of pixels has the states of a whole number of the axis' values, so that no column is darker for having one
/// more.
pub fn bifurcation(title: &str, diagram: &Diagram, component: Component, limits: Limits, frame: [u32; 2]) -> Panel {
    let axis = &diagram.axis;
    let value = |state: &[f64; 2]| state[component as usize];
    let states = || diagram.columns.iter().flatten().map(value);
    let label = match component {
        Component::X => ANGLE,
        Component::Y => SPEED,
    };
    let y = scale(&format!("{label} ({STROBOSCOPIC})"), limits, states());
    let group = axis.count.div_ceil(frame[0] as usize);
    let columns = axis.count.div_ceil(group);
    let rises = axis.step() > 0.0;
    let points = diagram.columns.iter().enumerate().flat_map(|(index, column)| {
        let place = if rises { index } else { axis.count - 1 - index };
        column.iter().map(move |state| [place as f64 + 0.5, value(state)])
    });
    let extent = [0.0, (columns * group) as f64];
    let density = Density::new(points, extent, [y.low, y.high], [columns, frame[1] as usize]);
    let (step, lowest) = (axis.step().abs(), axis.start.min(axis.stop));
    let left = lowest - 0.5 * step;
    let label = AxisLabel::of(axis, &diagram.fixed);
    let ends = [left, left + extent[1] * step].map(|end| label.factor * end);
    Panel {
        title: title.to_owned(),
        x: Scale::new(&label.words, ends[0], ends[1]),
        y,
        layers: vec![Layer::Density(density)],
    }
}

/// Standard errors that a band is wide to either side.
const BAND: f64 = 2.0;

/// The three exponents over the axis of a line, with error bands and the onset of chaos.
pub fn exponents(title: &str, line: &Line, onset: Option<&Found>, limits: Limits) -> Panel {
    let axis = &line.axis;
    let label = AxisLabel::of(axis, &line.fixed);
    let value_at = |index: usize| label.factor * axis.value(index);
    let curve = |value: fn(&Measurement) -> f64| -> Vec<[f64; 2]> {
        let points = line.measurements.iter().enumerate();
        points.map(|(index, m)| [value_at(index), value(m)]).collect()
    };
    let band = |value: fn(&Measurement) -> [f64; 2]| -> Vec<[f64; 3]> {
        let points = line.measurements.iter().enumerate();
        points
            .map(|(index, m)| {
                let [value, error] = value(m);
                [value_at(index), value - BAND * error, value + BAND * error]
            })
            .collect()
    };
    let (first, second, third) = (colour_of(4), colour_of(0), FAINT);
    let (low, high) = (axis.start.min(axis.stop), axis.start.max(axis.stop));
    let (low, high) = (label.factor * low, label.factor * high);
    let mut layers = vec![
        Layer::Curve {
            name: "λ₃ = 0, along the flow".to_owned(),
            points: vec![[low, 0.0], [high, 0.0]],
            stroke: Stroke::solid(third, 1.2),
        },
        Layer::Band {
            name: String::new(),
            points: band(|m| [m.lyapunov_second, m.lyapunov_second_error]),
            colour: second,
        },
        Layer::Band {
            name: String::new(),
            points: band(|m| [m.lyapunov, m.lyapunov_error]),
            colour: first,
        },
        Layer::Curve {
            name: "λ₂".to_owned(),
            points: curve(|m| m.lyapunov_second),
            stroke: Stroke::solid(second, 1.2),
        },
        Layer::Curve {
            name: "λ₁ (bands: ± 2 standard errors)".to_owned(),
            points: curve(|m| m.lyapunov),
            stroke: Stroke::solid(first, 1.2),
        },
    ];
    if let Some(found) = onset {
        layers.push(Layer::Flag {
            x: label.factor * found.value,
            words: format!(
                "onset: {}",
                assigned(&line.fixed, axis.coordinate, rounded(found.value))
            ),
            stroke: Stroke::dashed([0, 0, 0], 1.2),
        });
    }
    let values = line
        .measurements
        .iter()
        .flat_map(|m| [m.lyapunov, m.lyapunov_second, 0.0]);
    Panel {
        title: title.to_owned(),
        x: Scale::new(&label.words, low, high),
        y: scale("Lyapunov exponents (1/τ)", limits, values),
        layers,
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

/// The value without rounding errors in its last digits.
pub fn rounded(value: f64) -> f64 {
    format!("{value:.9e}").parse().unwrap_or(value)
}

/// The initial state as captions name it.
pub fn start([x, y]: [f64; 2]) -> String {
    format!("({x}, {y})").replace('-', "\u{2212}")
}
