//! Lyapunov exponents over a parameter.
//!
//! Owns what is drawn of them; neither computes them nor places panels.

use super::shared::{ALL_LEFT, BAND, Ends, FAINT, colour_of, scale};
use crate::analysis::exponents::Line;
use crate::machine::units::rounded;
use crate::measure::Measurement;
use crate::picture::axis_label::AxisLabel;
use crate::picture::axis_scale::AxisScale;
use crate::picture::caption::assigned;
use crate::picture::layer::{Layer, Stroke};
use crate::picture::panel::Panel;

/// The exponents over the axis of a line, with error bands, and with marked values and their names. If there is a machine, they are
/// in 1/s, converted with the machine of each point. With wear there is no second exponent, and an exponent of finite time has no
/// error. A curve or band without any value on the line is neither drawn nor named.
pub fn exponents(title: &str, line: &Line, marks: &[(&str, f64)], limits: Ends) -> Panel {
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
        // the axis includes zero if there is any value
        all.flat_map(move |value| [rate_at(index) * value, 0.0])
    });
    let unit = if line.fixed.machine().is_some() { "1/s" } else { "1/τ" };
    let y_label = format!("Lyapunov exponents ({unit})");
    Panel {
        title: title.to_owned(),
        x: AxisScale::new(&label.words, low, high),
        y: scale(&y_label, limits, values.into_iter()),
        layers,
        nothing: ALL_LEFT.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::BackendKind;
    use crate::design::Axis;
    use crate::measure::Status;
    use crate::parameters::ParameterSet;

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
