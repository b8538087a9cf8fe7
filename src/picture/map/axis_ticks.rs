//! The ticks of a map's axes.
//!
//! Owns which of them fit; draws nothing.

use crate::design::{Axis, Spacing};
use crate::picture::axis_label::AxisLabel;
use crate::picture::text::widest;
use crate::picture::ticks::{self, Tick, ticks};

/// The ticks of an axis of a map, at values of the axis.
pub fn axis_ticks(axis: &Axis, label: &AxisLabel, length: f64, room: impl Fn(f64) -> f64, size: f64) -> Vec<Tick> {
    let fits = |ticks: &[Tick]| {
        let widest = widest(ticks.iter().map(|tick| tick.label.as_str()), size);
        ticks.len() as f64 * room(widest) <= length + room(widest)
    };
    match axis.spacing() {
        Spacing::Even { .. } => even_ticks(axis, label.factor, length, room, size),
        Spacing::Logarithmic { .. } => {
            let [low, high] = axis.ends().map(|end| (label.factor * end).log10());
            let ticks = ticks::thinned(&ticks::decades(low, high), fits);
            let values = ticks.into_iter().map(|tick| Tick {
                value: 10f64.powf(tick.value) / label.factor,
                ..tick
            });
            values.collect()
        }
        Spacing::Listed(_) => {
            let rising = axis.rising();
            let ticks = ticks::thinned(&label.listed(axis), fits);
            let values = ticks.into_iter().map(|tick| Tick {
                value: axis.value(rising[tick.value as usize]),
                ..tick
            });
            values.collect()
        }
    }
}

/// Ticks between the first and the last value of the axis, not in the half cells beyond, where the map says nothing. Multiplied
/// by `factor`, they are round numbers. `room` is the least distance between ticks, given the width of the widest label;
/// `length` is the length of the whole map.
fn even_ticks(axis: &Axis, factor: f64, length: f64, room: impl Fn(f64) -> f64, size: f64) -> Vec<Tick> {
    let [start, stop] = [axis.first(), axis.last()].map(|end| factor * end);
    let (low, high) = (start.min(stop), start.max(stop));
    let length = length * (axis.count() - 1) as f64 / axis.count() as f64;
    let most = (length / room(0.0)) as usize;
    let fits = |ticks: &Vec<Tick>| {
        let widest = widest(ticks.iter().map(|tick| tick.label.as_str()), size);
        ticks.len() as f64 * room(widest) <= length + room(widest)
    };
    let mut ticks = (1..=most)
        .rev()
        .map(|most| ticks(low, high, most))
        .find(fits)
        .unwrap_or_else(|| ticks(low, high, 1));
    for tick in &mut ticks {
        tick.value /= factor;
    }
    ticks
}
