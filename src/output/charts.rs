//! Panels of the analyses: which layers, labels and colours each has.
//!
//! Owns what is drawn of a result; neither computes it nor places panels.

use super::caption::{AxisLabel, assigned};
use super::colour;
use super::density::Density;
use super::panel::{Layer, Panel, Scale, Stroke};
use super::ticks::number;
pub use super::ticks::rounded;
use crate::analysis::bifurcation::Diagram;
use crate::analysis::exponents::Line;
use crate::analysis::melnikov::Curve;
use crate::analysis::path::PathPoint;
use crate::machine::units::{Unit, five_digits};
use crate::measure::Measurement;
use crate::model::melnikov::Threshold;

/// Ends of an axis that are given beforehand; None takes them from the data.
pub type Limits = Option<[f64; 2]>;

const ANGLE: &str = "angle of the bush, x";
const SPEED: &str = "angular speed of the bush, y";
const STROBOSCOPIC: &str = "at drive phase 0";
const ALL_LEFT: &str = "every orbit ran away or was given up as under-resolved";

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

/// Curves that can be told apart in one picture: each colour solid and dashed.
pub const MOST_CURVES: usize = 2 * colour::PERIODS.len();

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
        nothing: "no curve has a value".to_owned(),
    }
}

/// The threshold in one parameter over another.
pub fn threshold(curve: &Curve) -> Panel {
    let label = AxisLabel::of(&curve.over, &curve.fixed);
    let along = curve.along.coordinate;
    let found = || curve.thresholds.iter().filter_map(|threshold| threshold.value());
    let ends = [curve.along.first(), curve.along.last()].map(f64::abs);
    let largest = found().map(f64::abs).reduce(f64::max).unwrap_or(ends[0].max(ends[1]));
    let unit = Unit::suited(curve.fixed.unit(along), largest);
    // the thresholds beyond which M changes sign on one side, below or above
    let points = |sides: [bool; 2]| -> Vec<[f64; 2]> {
        let points = curve.thresholds.iter().enumerate().map(|(index, threshold)| {
            let found = threshold.value().filter(|_| threshold.changes_sign() == sides);
            [
                label.place(&curve.over, curve.over.value(index)),
                found.map_or(f64::NAN, |value| unit.factor * value),
            ]
        });
        points.collect()
    };
    let curves = [
        ("from here upward Mel'nikov's function changes sign", [false, true]),
        ("from here downward Mel'nikov's function changes sign", [true, false]),
    ];
    let searched = [curve.along.first(), curve.along.last()].map(|value| unit.factor * value);
    let y_label = format!("threshold in {}{}", along.symbol(), unit.bracketed());
    let always = curve
        .thresholds
        .iter()
        .filter(|found| **found == Threshold::Always)
        .count();
    let how = match always {
        0 => "changes sign nowhere",
        all if all == curve.thresholds.len() => "changes sign everywhere",
        _ => "changes sign nowhere, or everywhere,",
    };
    Panel {
        title: String::new(),
        x: label.scale(&curve.over, 0.0, curve.over.count() as f64 - 1.0),
        y: if found().next().is_some() {
            Scale::around(&y_label, found().map(|value| unit.factor * value))
        } else {
            Scale::new(&y_label, searched[0], searched[1])
        },
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
        nothing: format!(
            "Mel'nikov's function {how} for {} from {} to {}{}",
            along.symbol(),
            number(searched[0]),
            number(searched[1]),
            unit.bracketed()
        ),
    }
}

/// Named orbits in the phase plane with their stroboscopic points; those beyond the colours are dashed.
pub fn phase(title: &str, orbits: &[(String, Vec<PathPoint>)], x: Limits, y: Limits) -> Panel {
    let points = || orbits.iter().flat_map(|(_, path)| path.iter());
    let stroke = |index: usize| Stroke {
        colour: colour_of(index),
        width: if orbits.len() > 1 { 1.0 } else { 0.8 },
        is_dashed: index >= colour::PERIODS.len(),
    };
    // what wanders most lies lowest: a cycle would vanish under a chaotic orbit
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

/// Stroboscopic states that differ, to three digits: few of a cycle, many of a chaotic orbit.
fn distinct_states(path: &[PathPoint]) -> usize {
    let strobes = path.iter().filter(|point| point.is_stroboscopic);
    let states = strobes.map(|point| [point.x, point.y].map(|value| (1e3 * value).round() as i64));
    states.collect::<std::collections::BTreeSet<_>>().len()
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
        nothing: ALL_LEFT.to_owned(),
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

/// Standard errors that a band is wide to either side.
pub(super) const BAND: f64 = 2.0;

/// The exponents over the axis of a line, with error bands and marked values, each with its name; in 1/s where there is a machine, by the
/// machine of each point. With heat there is no second one, and one of finite time has no error: what is nowhere on the line
/// is neither drawn nor named.
pub fn exponents(title: &str, line: &Line, marks: &[(&str, f64)], limits: Limits) -> Panel {
    let axis = &line.axis;
    let label = AxisLabel::of(axis, &line.fixed);
    let order = axis.rising();
    let place_at = |index: usize| label.place(axis, axis.value(index));
    let rate_at = |index: usize| {
        let at = line.fixed.at([(axis.coordinate, axis.value(index))]);
        at.machine().map_or(1.0, |machine| 1.0 / machine.scales().time)
    };
    let curve = |value: fn(&Measurement) -> f64| -> Vec<[f64; 2]> {
        let points = order.iter().map(|&index| (index, &line.measurements[index]));
        points
            .map(|(index, m)| [place_at(index), rate_at(index) * value(m)])
            .collect()
    };
    let band = |value: fn(&Measurement) -> [f64; 2]| -> Vec<[f64; 3]> {
        let points = order.iter().map(|&index| (index, &line.measurements[index]));
        points
            .map(|(index, m)| {
                let [value, error] = value(m).map(|value| rate_at(index) * value);
                [place_at(index), value - BAND * error, value + BAND * error]
            })
            .collect()
    };
    let (first, second, third) = (colour_of(4), colour_of(0), FAINT);
    let [low, high] = axis.ends().map(|end| label.place(axis, end));
    let occurs = |value: fn(&Measurement) -> f64| line.measurements.iter().any(|m| value(m).is_finite());
    let (lasts, has_second) = (occurs(|m| m.lyapunov_error), occurs(|m| m.lyapunov_second));
    let bands = match (lasts, has_second) {
        (true, true) => " (bands: ± 2 standard errors)",
        (true, false) => " (band: ± 2 standard errors)",
        (false, _) => ", of finite time",
    };
    let mut layers = vec![
        Layer::Curve {
            name: "λ₃ = 0, along the flow".to_owned(),
            points: if lasts {
                vec![[low, 0.0], [high, 0.0]]
            } else {
                Vec::new()
            },
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
    for (name, value) in marks {
        layers.push(Layer::Flag {
            x: label.place(axis, *value),
            words: format!("{name}: {}", assigned(&line.fixed, axis.coordinate, rounded(*value))),
            stroke: Stroke::dashed([0, 0, 0], 1.2),
        });
    }
    let with_band = |value: f64, error: f64| [value, value - BAND * error, value + BAND * error];
    let values = line.measurements.iter().enumerate().flat_map(|(index, m)| {
        let first = with_band(m.lyapunov, m.lyapunov_error);
        let second = with_band(m.lyapunov_second, m.lyapunov_second_error);
        let all = first.into_iter().chain(second).filter(|value| value.is_finite());
        // zero is shown where anything is
        all.flat_map(move |value| [rate_at(index) * value, 0.0])
    });
    let unit = if line.fixed.machine().is_some() { "1/s" } else { "1/τ" };
    let y_label = format!("Lyapunov exponents ({unit})");
    Panel {
        title: title.to_owned(),
        x: Scale::new(&label.words, low, high),
        y: scale(&y_label, limits, values.into_iter()),
        layers,
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

/// The initial state as captions name it, to five digits: the recipe beside them has all.
pub fn start(state: [f64; 2]) -> String {
    let [x, y] = state.map(|value| number(five_digits(value)));
    format!("({x}, {y})")
}

#[cfg(test)]
mod tests {
    use super::super::sheet::Sheet;
    use super::*;
    use crate::analysis::melnikov::threshold_curve;
    use crate::backend::BackendKind;
    use crate::design::Axis;
    use crate::measure::Status;
    use crate::parameters::ParameterSet;

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
        // the orbit of the most states lies lowest
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
    fn a_threshold_that_is_nowhere_has_the_axis_that_was_searched() {
        let at = ParameterSet::default().into();
        let over = Axis::parse("h1=0:2:5").unwrap();
        let along = |axis: &str| Axis::parse(axis).unwrap();
        let panel = threshold(&threshold_curve(&at, &along("zeta_k=0:1:60"), &over).unwrap());
        assert_eq!([panel.y.low, panel.y.high], [0.0, 1.0]);
        let empty = svg(panel);
        assert!(empty.contains("changes sign nowhere for ζₖ from 0 to 1") && !empty.contains("from here upward"));
        let found = svg(threshold(
            &threshold_curve(&at, &along("zeta_k=0:20:60"), &over).unwrap(),
        ));
        assert!(found.contains("from here upward") && !found.contains("nothing to draw"));
    }

    #[test]
    fn initial_states_have_the_digits_that_people_read() {
        assert_eq!(start([0.30000000000000004, -1.0]), "(0.3, \u{2212}1)");
        assert_eq!(start([0.374_540_118_847_362_5, 0.0]), "(0.37454, 0)");
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
        let scale = exponents("", &line, &[], None).y;
        assert!(
            scale.low < -1.0 - BAND * 0.2 && scale.high > 0.5 + BAND * 0.1,
            "{scale:?}"
        );
    }
}
