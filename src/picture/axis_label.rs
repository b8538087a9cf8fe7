//! The words of an axis of an experiment, and where its values lie on a scale.
//!
//! Owns units and places of axes; captions are [`super::caption`]'s.

use super::axis_scale::AxisScale;
use super::ticks::{Tick, number};
use crate::design::{Axis, Fixed, Spacing};
use crate::machine::units::{Unit, rounded};

/// The words of an axis, and the factor that converts its values to the unit in the words.
#[derive(Clone, Debug)]
pub struct AxisLabel {
    /// Meaning, symbol and unit.
    pub words: String,
    /// For example 1000 if the unit has the prefix milli.
    pub factor: f64,
}

impl AxisLabel {
    /// What the axis' coordinate means, its symbol, and its unit with a prefix that suits the values.
    pub fn of(axis: &Axis, at: &Fixed) -> Self {
        let coordinate = axis.coordinate;
        // The table of parameters is in ASCII, for terminals.
        let meaning = [("epsilon", "ε"), ("h1", "h₁"), ("ramp_rate", "δ"), ("tau^2", "τ²")]
            .iter()
            .fold(coordinate.meaning().to_owned(), |words, (name, symbol)| {
                words.replace(name, symbol)
            });
        let unit = Unit::suited(
            at.unit(coordinate),
            axis.ends().map(f64::abs).into_iter().fold(0.0, f64::max),
        );
        Self {
            words: format!("{meaning}, {}{}", coordinate.symbol(), unit.bracketed()),
            factor: unit.factor,
        }
    }

    /// Where a value of the axis lies on its [`AxisLabel::scale`].
    pub fn place(&self, axis: &Axis, value: f64) -> f64 {
        match axis.spacing() {
            Spacing::Even { .. } => self.factor * value,
            Spacing::Logarithmic { .. } => (self.factor * value).log10(),
            Spacing::Listed(_) => axis.place(value),
        }
    }

    /// The scale of a panel's axis between the places `from` and `to`, which are counted as in [`Axis::place`].
    pub fn scale(&self, axis: &Axis, from: f64, to: f64) -> AxisScale {
        let [low, high] = axis.ends().map(|end| self.place(axis, end));
        let between = |place: f64| low + place * (high - low) / (axis.count() - 1) as f64;
        match axis.spacing() {
            Spacing::Even { .. } => AxisScale::new(&self.words, between(from), between(to)),
            Spacing::Logarithmic { .. } => AxisScale::logarithmic(&self.words, between(from), between(to)),
            Spacing::Listed(_) => AxisScale {
                listed: self.listed(axis),
                ..AxisScale::new(&self.words, from, to)
            },
        }
    }

    /// Ticks for the values of a list, at their places, in rising order.
    pub fn listed(&self, axis: &Axis) -> Vec<Tick> {
        let rising = axis.rising().into_iter().enumerate();
        rising
            .map(|(place, index)| Tick {
                value: place as f64,
                label: number(rounded(self.factor * axis.value(index))),
            })
            .collect()
    }
}
