//! The scale of a panel's axis: its words, its ends and its ticks.
//!
//! Owns which ticks fit; draws nothing.

use super::text::widest;
use super::ticks::{Tick, decades, thinned, ticks};

/// The size of the numbers at ticks, in pixels.
pub(super) const TICK_SIZE: f64 = 15.0;

/// One axis: its words and its ends.
#[derive(Clone, Debug)]
pub struct AxisScale {
    /// Words beside the axis.
    pub label: String,
    /// Value at the left or lower end.
    pub low: f64,
    /// Value at the right or upper end.
    pub high: f64,
    /// Whether numbers and words are left out, because a panel below has the same scale.
    pub is_bare: bool,
    /// Whether the ends are unknown because there is no value. Then there are no ticks.
    pub is_blank: bool,
    /// Whether values are decadic logarithms of the numbers at the ticks.
    pub is_logarithmic: bool,
    /// The ticks of an axis of listed values; empty for others.
    pub listed: Vec<Tick>,
}

impl AxisScale {
    /// A linear scale with ticks.
    pub fn new(label: &str, low: f64, high: f64) -> Self {
        Self {
            label: label.to_owned(),
            low,
            high,
            is_bare: false,
            is_blank: false,
            is_logarithmic: false,
            listed: Vec::new(),
        }
    }

    /// A logarithmic scale, between the decadic logarithms of two values.
    pub fn logarithmic(label: &str, low: f64, high: f64) -> Self {
        Self {
            is_logarithmic: true,
            ..Self::new(label, low, high)
        }
    }

    /// The same scale without numbers and words: a panel below shows them.
    #[must_use]
    pub fn bare(self) -> Self {
        Self { is_bare: true, ..self }
    }

    /// A scale that reaches a little beyond the finite values. A single value lies in the middle; without any the scale is blank.
    pub fn around(label: &str, values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values
            .filter(|value| value.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            });
        if low > high {
            return Self {
                is_blank: true,
                ..Self::new(label, 0.0, 1.0)
            };
        }
        let margin = if high > low {
            0.04 * (high - low)
        } else {
            0.5 * high.abs().max(1.0)
        };
        Self::new(label, low - margin, high + margin)
    }

    /// Position of a value, 0 at the lower end and 1 at the upper.
    pub(super) fn part(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    /// Whether the interval between two values overlaps the axis; false if both are NaN.
    pub(super) fn meets(&self, [one, other]: [f64; 2]) -> bool {
        one.min(other) <= self.high && one.max(other) >= self.low
    }

    /// As many ticks as their labels leave room for.
    pub(super) fn ticks_across(&self, length: f64) -> Vec<Tick> {
        if self.is_blank {
            return Vec::new();
        }
        let fits = |ticks: &[Tick]| {
            let widest = widest(ticks.iter().map(|tick| tick.label.as_str()), TICK_SIZE);
            ticks.len() as f64 * (widest + 22.0) <= length + widest
        };
        if !self.listed.is_empty() {
            return thinned(&self.listed, fits);
        }
        if self.is_logarithmic {
            return thinned(&decades(self.low, self.high), fits);
        }
        (2..=(length / 60.0) as usize)
            .rev()
            .map(|most| ticks(self.low, self.high, most))
            .find(|ticks| fits(ticks))
            .unwrap_or_else(|| ticks(self.low, self.high, 2))
    }

    /// Ticks at a comfortable distance, or closer where a low frame would have fewer than three.
    pub(super) fn ticks_up(&self, length: f64) -> Vec<Tick> {
        if self.is_blank {
            return Vec::new();
        }
        if !self.listed.is_empty() {
            return thinned(&self.listed, |ticks| ticks.len() as f64 * 1.5 * TICK_SIZE <= length);
        }
        if self.is_logarithmic {
            return decades(self.low, self.high);
        }
        let comfortable = ((length / 48.0) as usize).max(2);
        let closest = ((length / (1.5 * TICK_SIZE)) as usize).max(comfortable);
        (comfortable..=closest)
            .map(|most| ticks(self.low, self.high, most))
            .min_by_key(|ticks| 3usize.saturating_sub(ticks.len()))
            .unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn listed_values_are_at_the_ticks_of_both_axes() {
        let listed: Vec<Tick> = (0..30)
            .map(|place| Tick {
                value: f64::from(place),
                label: format!("{}", 10 * place),
            })
            .collect();
        let scale = AxisScale {
            listed,
            ..AxisScale::new("", -0.5, 29.5)
        };
        for ticks in [scale.ticks_across(300.0), scale.ticks_up(240.0)] {
            assert!((3..=15).contains(&ticks.len()));
            assert!(ticks.iter().all(|tick| tick.label == format!("{}", 10.0 * tick.value)));
        }
    }

    #[test]
    fn scales_have_an_extent() {
        for values in [vec![], vec![f64::NAN], vec![2.0], vec![0.0, 0.0], vec![1.0, 3.0]] {
            let scale = AxisScale::around("", values.iter().copied());
            assert!(scale.low < scale.high, "{values:?}");
        }
    }
}
