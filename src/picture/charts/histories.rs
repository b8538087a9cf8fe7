//! Panels over time: the history of an instance, alone or together with others.
//!
//! Owns which quantities are drawn, their words and how a long curve is thinned; follows no instance and places no panel.

use super::shared::{Ends, FAINT, colour_of, scale};
use crate::dynamics::history::{History, Sample};
use crate::machine::Scales;
use crate::machine::units::{Unit, si};
use crate::picture::axis_scale::AxisScale;
use crate::picture::layer::{Layer, Stroke};
use crate::picture::panel::Panel;

const TIME: &str = "time τ";

const NOTHING: &str = "there is no sample";

/// Words of the axis of pressure.
pub const PRESSURE: &str = "pressure p";
/// Words of the axis of wear.
pub const WEAR: &str = "wear u_w";

/// A quantity of a machine in SI units: its words, its unit, and the factor that converts the dimensionless value.
type Si = (&'static str, &'static str, fn(&Scales) -> f64);

const SI_TIME: Si = ("time t", "s", |scales| scales.time);

/// A drawn quantity.
struct Drawn {
    /// Words of its axis.
    label: &'static str,
    si: Si,
    marks_zero: bool,
    of: fn(&Sample) -> f64,
}

const DRAWN: [Drawn; 5] = [
    Drawn {
        label: PRESSURE,
        si: ("pressure P", "Pa", |scales| scales.pressure),
        marks_zero: false,
        of: |sample| sample.pressure,
    },
    Drawn {
        label: WEAR,
        si: ("wear U_w", "m", |scales| scales.length),
        marks_zero: false,
        of: |sample| sample.wear,
    },
    Drawn {
        label: "temperature θ(1, τ)",
        si: ("surface T − T₀", "K", |scales| scales.temperature),
        marks_zero: false,
        of: |sample| sample.temperature,
    },
    Drawn {
        label: "angle x = φ",
        si: ("angle φ", "rad", |_| 1.0),
        marks_zero: true,
        of: |sample| sample.x,
    },
    Drawn {
        label: "speed y = φ\u{307}",
        si: ("speed dφ/dt", "rad/s", |scales| 1.0 / scales.time),
        marks_zero: true,
        of: |sample| sample.y,
    },
];

/// The words of an axis, and the factor for its dimensionless values, whose magnitude is at most `largest`.
fn worded(label: &str, (words, unit, factor): Si, scales: Option<&Scales>, largest: f64) -> (String, f64) {
    let Some(factor) = scales.map(factor) else {
        return (label.to_owned(), 1.0);
    };
    let unit = Unit::suited(unit, factor * largest);
    (format!("{words}{}", unit.bracketed()), factor * unit.factor)
}

/// A history in five panels over one axis of time: p, u_w, theta(1, tau), phi and phi-dot; with the scales of a machine, in
/// SI units. The loss of contact is a line through all of them, and its time stands above the first.
pub fn stacked(history: &History, scales: Option<&Scales>) -> Vec<Panel> {
    let end = history.samples.last().map_or(0.0, |sample| sample.tau);
    // a run that was given up at once still needs an axis
    let end = if end > 0.0 { end } else { 1.0 };
    let (time_label, time_factor) = worded(TIME, SI_TIME, scales, end);
    let time = AxisScale::new(&time_label, 0.0, time_factor * end);
    let lowest = DRAWN.len() - 1;
    let panels = DRAWN.iter().enumerate().map(|(index, drawn)| {
        let values = history.samples.iter().map(drawn.of);
        let largest = values.fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let (label, factor) = worded(drawn.label, drawn.si, scales, largest);
        let value = |sample: &Sample| factor * (drawn.of)(sample);
        let mut layers = Vec::new();
        if drawn.marks_zero {
            layers.push(Layer::Level {
                y: 0.0,
                stroke: Stroke::solid(FAINT, 1.0),
            });
        }
        let curve = curve(&history.samples, value).into_iter();
        let points = thinned(curve.map(|[tau, value]| [time_factor * tau, value]).collect());
        // a line needs two points
        layers.push(if points.len() < 2 {
            Layer::Marks {
                name: String::new(),
                points,
                colour: colour_of(index),
                radius: 3.5,
            }
        } else {
            Layer::Curve {
                name: String::new(),
                points,
                stroke: Stroke::solid(colour_of(index), 1.2),
            }
        });
        if let Some(lost) = history.contact_lost {
            let words = match scales {
                Some(scales) => format!("contact lost at t_c = {}", si(scales.time * lost, "s")),
                None => format!("contact lost at τ_c = {lost:.3}"),
            };
            layers.push(Layer::Flag {
                x: time_factor * lost,
                words: if index == 0 { words } else { String::new() },
                stroke: Stroke::dashed([0, 0, 0], 1.2),
            });
        }
        Panel {
            title: String::new(),
            x: if index < lowest {
                time.clone().bare()
            } else {
                time.clone()
            },
            y: AxisScale::around(&label, history.samples.iter().map(value)),
            layers,
            nothing: NOTHING.to_owned(),
        }
    });
    panels.collect()
}

/// One quantity of a history as pairs (tau, value).
pub fn curve(samples: &[Sample], value: impl Fn(&Sample) -> f64) -> Vec<[f64; 2]> {
    samples.iter().map(|sample| [sample.tau, value(sample)]).collect()
}

/// A named curve over time.
pub struct Course {
    /// Words in the legend.
    pub name: String,
    /// Pairs (tau, value).
    pub points: Vec<[f64; 2]>,
    /// Index of the colour; curves with the same index have the same colour.
    pub colour: usize,
    /// Distinguishes it from other curves of its colour.
    pub is_dashed: bool,
}

/// Several curves over time in one panel.
pub fn courses(label: &str, courses: &[Course], x: Ends, y: Ends) -> Panel {
    let points = || courses.iter().flat_map(|course| course.points.iter());
    let layers = courses.iter().map(|course| Layer::Curve {
        name: course.name.clone(),
        points: thinned(course.points.clone()),
        stroke: Stroke {
            colour: colour_of(course.colour),
            width: 1.8,
            is_dashed: course.is_dashed,
        },
    });
    Panel {
        title: String::new(),
        x: scale(TIME, x, points().map(|point| point[0])),
        y: scale(label, y, points().map(|point| point[1])),
        layers: layers.collect(),
        nothing: NOTHING.to_owned(),
    }
}

/// Number of stretches into which a long curve is divided: two for each pixel of a frame.
const STRETCHES: usize = 1800;

/// A long curve without the points that would not be visible. Of each stretch, the first, the last and the extreme points stay.
fn thinned(points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    if points.len() <= 4 * STRETCHES {
        return points;
    }
    let mut kept = Vec::with_capacity(4 * STRETCHES);
    for stretch in points.chunks(points.len().div_ceil(STRETCHES)) {
        let by_value = |&a: &usize, &b: &usize| stretch[a][1].total_cmp(&stretch[b][1]);
        let least = (0..stretch.len()).min_by(by_value).unwrap_or(0);
        let greatest = (0..stretch.len()).max_by(by_value).unwrap_or(0);
        let mut indices = [0, least.min(greatest), least.max(greatest), stretch.len() - 1].to_vec();
        indices.dedup();
        kept.extend(indices.into_iter().map(|index| stretch[index]));
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::sheet::Sheet;
    use crate::picture::text;

    fn made_up(count: usize) -> History {
        let sample = |k: usize| {
            let tau = k as f64 * 0.1;
            Sample {
                tau,
                x: tau.sin(),
                y: tau.cos(),
                v: 0.4,
                pressure: 1.0,
                wear: 0.0,
                temperature: 0.0,
            }
        };
        History {
            samples: (0..count).map(sample).collect(),
            contact_lost: Some(7.25),
            given_up: false,
            pressure_ran_away: false,
            runaway: None,
            peak_pressure: 1.0,
            peak_pressure_time: 0.0,
            peak_temperature: 0.0,
        }
    }

    #[test]
    fn panels_share_their_axis_and_say_once_when_contact_was_lost() {
        for count in [1, 100] {
            let panels = stacked(&made_up(count), None);
            assert!(
                panels
                    .iter()
                    .all(|panel| panel.x.low < panel.x.high && panel.y.low < panel.y.high)
            );
            assert_eq!(panels.iter().filter(|panel| !panel.x.is_bare).count(), 1);
            let page = Sheet::stacked(panels, vec!["a caption".to_owned()]).draw().unwrap();
            assert_eq!(page.svg.matches("> = 7.250<").count(), 1);
            assert_eq!(page.svg.matches(">time τ<").count(), 1);
            let tree = resvg::usvg::Tree::from_str(&page.svg, text::options()).unwrap();
            let bounds = tree.root().abs_layer_bounding_box();
            assert!(bounds.left() >= 0.0 && bounds.top() >= 0.0);
            assert!(bounds.right() <= page.width as f32 && bounds.bottom() <= page.height as f32);
        }
    }

    #[test]
    fn a_machine_s_history_is_drawn_in_si_units() {
        let scales = Scales {
            time: 0.02,
            temperature: 0.1,
            pressure: 2e6,
            length: 3e-9,
            speed: 0.05,
        };
        let panels = stacked(&made_up(100), Some(&scales));
        let labels: Vec<&str> = panels.iter().map(|panel| panel.y.label.as_str()).collect();
        assert_eq!(
            labels,
            [
                "pressure P (MPa)",
                "wear U_w (m)",
                "surface T − T₀ (K)",
                "angle φ (rad)",
                "speed dφ/dt (rad/s)"
            ]
        );
        // 9.9 tau of 20 ms each
        assert_eq!(panels[4].x.label, "time t (ms)");
        assert!((panels[4].x.high - 198.0).abs() < 1e-9);
        let Layer::Flag { x, words, .. } = &panels[0].layers[1] else {
            panic!("the loss of contact is a flag")
        };
        assert!(
            (x - 145.0).abs() < 1e-9 && words == "contact lost at t_c = 145 ms",
            "{words}"
        );
        let Layer::Curve { points, .. } = &panels[4].layers[1] else {
            panic!("the speed is a curve")
        };
        assert!(
            (points[0][1] - 50.0).abs() < 1e-9 && (points[1][0] - 2.0).abs() < 1e-9,
            "{points:?}"
        );
    }

    #[test]
    fn long_curves_keep_their_ends_and_extremes() {
        let points: Vec<[f64; 2]> = (0..100_000)
            .map(|k| [f64::from(k), if k == 54_321 { 7.0 } else { f64::from(k % 13) * 0.1 }])
            .collect();
        let thin = thinned(points.clone());
        assert!(thin.len() <= 4 * STRETCHES);
        assert!(thin.windows(2).all(|pair| pair[0][0] < pair[1][0]));
        assert_eq!((thin[0], thin[thin.len() - 1]), (points[0], points[99_999]));
        assert!(thin.contains(&[54_321.0, 7.0]));
        assert_eq!(thinned(points[..50].to_vec()), points[..50]);
    }
}
