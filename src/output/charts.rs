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

/// Least extent of an axis of states: those of a cycle differ by rounding errors, which are nothing to see.
const LEAST_EXTENT: f64 = 1e-3;

fn scale_of_states(label: &str, limits: Limits, values: impl Iterator<Item = f64>) -> Scale {
    let scale = scale(label, limits, values);
    if limits.is_some() || scale.high - scale.low >= LEAST_EXTENT {
        return scale;
    }
    let middle = 0.5 * (scale.low + scale.high);
    Scale::new(label, middle - 0.5 * LEAST_EXTENT, middle + 0.5 * LEAST_EXTENT)
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
    let points: Vec<[f64; 2]> = curve
        .thresholds
        .iter()
        .enumerate()
        .map(|(index, threshold)| {
            let value = label.factor * curve.over.value(index);
            [value, threshold.value().unwrap_or(f64::NAN)]
        })
        .collect();
    let (low, high) = (
        curve.over.start.min(curve.over.stop),
        curve.over.start.max(curve.over.stop),
    );
    let info = curve.search.parameter.info();
    Panel {
        title: String::new(),
        x: Scale::new(&label.words, label.factor * low, label.factor * high),
        y: Scale::around(
            &format!("threshold in {}", info.symbol),
            points.iter().map(|point| point[1]),
        ),
        layers: vec![Layer::Curve {
            name: "from here upward Mel'nikov's function changes sign".to_owned(),
            points,
            stroke: Stroke::solid(colour_of(0), 2.0),
        }],
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
        x: scale_of_states(ANGLE, x, points().map(|point| point.x)),
        y: scale_of_states(SPEED, y, points().map(|point| point.y)),
        layers: curves.chain(strobes).chain([legend_of_marks]).collect(),
    }
}

fn darker(colour: colour::Rgb) -> colour::Rgb {
    colour.map(|value| (f64::from(value) * 0.55) as u8)
}

/// The stroboscopic section as a density over a frame of the given size.
pub fn section(title: &str, points: &[[f64; 2]], x: Limits, y: Limits, frame: [u32; 2]) -> Panel {
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
    let y = scale_of_states(&format!("{label} ({STROBOSCOPIC})"), limits, states());
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

/// The exponents over the axis of a line, with error bands and the onset of chaos. With heat there is no second one, and one
/// of finite time has no error: what is nowhere on the line is neither drawn nor named.
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
    let occurs = |value: fn(&Measurement) -> f64| line.measurements.iter().any(|m| value(m).is_finite());
    let has_second = occurs(|m| m.lyapunov_second);
    let bands = match (occurs(|m| m.lyapunov_error), has_second) {
        (true, true) => " (bands: ± 2 standard errors)",
        (true, false) => " (band: ± 2 standard errors)",
        (false, _) => "",
    };
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
    ];
    if has_second {
        layers.push(Layer::Curve {
            name: "λ₂".to_owned(),
            points: curve(|m| m.lyapunov_second),
            stroke: Stroke::solid(second, 1.2),
        });
    }
    layers.push(Layer::Curve {
        name: format!("λ₁{bands}"),
        points: curve(|m| m.lyapunov),
        stroke: Stroke::solid(first, 1.2),
    });
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
    let with_band = |value: f64, error: f64| [value, value - BAND * error, value + BAND * error];
    let values = line.measurements.iter().flat_map(|m| {
        let first = with_band(m.lyapunov, m.lyapunov_error);
        let second = with_band(m.lyapunov_second, m.lyapunov_second_error);
        first.into_iter().chain(second).chain([0.0])
    });
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Axis;
    use crate::measurement::{BackendKind, Status};
    use crate::parameters::ParameterSet;

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

    #[test]
    fn bands_lie_within_the_frame() {
        let measured = |lyapunov| Measurement {
            status: Status::Ok,
            lyapunov,
            lyapunov_error: 0.1,
            lyapunov_second: -1.0,
            lyapunov_second_error: 0.2,
            ..Measurement::runaway(0.0, BackendKind::CpuF64)
        };
        let line = Line {
            axis: Axis::parse("zeta_k=3:4:2").unwrap(),
            fixed: ParameterSet::default().into(),
            start: [0.1, 0.0],
            measurements: vec![measured(0.0), measured(0.5)],
        };
        let scale = exponents("", &line, None, None).y;
        assert!(
            scale.low < -1.0 - BAND * 0.2 && scale.high > 0.5 + BAND * 0.1,
            "{scale:?}"
        );
    }
}
