//! Mel'nikov's function and its thresholds.
//!
//! Owns what is drawn of them; neither computes them nor places panels.

use super::shared::{Ends, FAINT, colour_of, scale};
use crate::analysis::melnikov::Curve;
use crate::machine::units::Unit;
use crate::model::melnikov::Threshold;
use crate::picture::axis_label::AxisLabel;
use crate::picture::axis_scale::AxisScale;
use crate::picture::layer::{Layer, Stroke};
use crate::picture::panel::Panel;
use crate::picture::ticks::number;

/// Mel'nikov's function over tau0: named curves of pairs (tau0, M); every second one is dashed.
pub fn melnikov(title: &str, curves: &[(String, Vec<[f64; 2]>)], limits: Ends) -> Panel {
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
        x: AxisScale::new(
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
    // the thresholds with `sides`: whether M changes sign below the threshold, and above it
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
            AxisScale::around(&y_label, found().map(|value| unit.factor * value))
        } else {
            AxisScale::new(&y_label, searched[0], searched[1])
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::melnikov::threshold_curve;
    use crate::design::Axis;
    use crate::parameters::ParameterSet;
    use crate::picture::sheet::Sheet;

    fn svg(panel: Panel) -> String {
        Sheet::single(panel, Vec::new()).draw().unwrap().svg
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
}
