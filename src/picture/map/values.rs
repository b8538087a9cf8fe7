//! The values of a quantity as a map shows them: their unit, their limits, and the colour bar that explains them.
//!
//! Owns the choice of limits; draws nothing.

use super::bar::Bar;
use super::plot::Cell;
use super::style::Style;
use crate::machine::units::Unit;
use crate::map::ParameterMap;
use crate::measure::Quantity;
use crate::picture::error::PictureError;
use crate::picture::ticks::{round_step, round_up};

/// Quantities whose zero separates two kinds of values.
fn is_two_sided(quantity: Quantity) -> bool {
    matches!(
        quantity,
        Quantity::Lyapunov | Quantity::LyapunovSecond | Quantity::LyapunovBirkhoff | Quantity::X | Quantity::Y
    )
}

/// The values of a quantity as they are drawn: in SI units where there is a machine and the quantity has one.
pub struct Shown {
    pub values: Vec<f64>,
    /// Words of the colour bar, with the unit.
    label: String,
    /// The factor from units without a prefix to the units shown.
    factor: f64,
}

impl Shown {
    pub fn of(map: &ParameterMap, quantity: Quantity) -> Self {
        if let Some((values, unit)) = map.si_column(quantity) {
            let finite = values.iter().filter(|value| value.is_finite());
            let largest = finite.fold(0.0, |largest: f64, value| largest.max(value.abs()));
            let unit = Unit::suited(unit, largest);
            return Self {
                values: values.iter().map(|value| unit.factor * value).collect(),
                label: format!("{}{}", label(map, quantity), unit.bracketed()),
                factor: unit.factor,
            };
        }
        let units = match quantity.info().units {
            "1" => String::new(),
            units => format!(" ({})", units.replace("tau", "τ")),
        };
        Self {
            values: map.values(quantity).collect(),
            label: format!("{}{units}", label(map, quantity)),
            factor: 1.0,
        }
    }
}

/// The name of a quantity in pictures of a map.
pub fn label(map: &ParameterMap, quantity: Quantity) -> &'static str {
    let experiment = &map.experiment;
    match quantity {
        Quantity::Lyapunov if experiment.wears() => "Lyapunov exponent of finite time, λ₁",
        _ if experiment.design.fixed.machine().is_some() => quantity.si_label(),
        _ => quantity.info().label,
    }
}

/// The colour bar; none if there is no value that it would explain.
pub fn bar(quantity: Quantity, shown: &Shown, cells: &[Cell], style: &Style) -> Result<Option<Bar>, PictureError> {
    if let Some((low, high)) = style.limits
        && !(low < high && low.is_finite() && high.is_finite())
    {
        return Err(PictureError::Limits { low, high });
    }
    let mut values: Vec<f64> = cells
        .iter()
        .filter_map(|cell| {
            if let Cell::Value(value) = cell {
                Some(*value)
            } else {
                None
            }
        })
        .collect();
    if values.is_empty() {
        return Ok(None);
    }
    values.sort_unstable_by(f64::total_cmp);
    let (least, greatest) = (values[0], values[values.len() - 1]);
    let two_sided = is_two_sided(quantity);
    let limits = style
        .limits
        .map(|(low, high)| (shown.factor * low, shown.factor * high));
    let (low, high) = limits.unwrap_or_else(|| if two_sided { symmetric(&values) } else { span(&values) });
    let colours = style.colours;
    let reach = low.abs().max(high.abs());
    Ok(Some(Bar {
        label: shown.label.clone(),
        low,
        high,
        below: least < low,
        above: greatest > high,
        colour: Box::new(move |value| {
            let value = value.clamp(low, high);
            if two_sided {
                colours.two_sided(value / reach)
            } else {
                colours.sequential((value - low) / (high - low))
            }
        }),
    }))
}

/// Limits that are symmetric about zero, from sorted values. A few extreme values must not make all others pale. If some values
/// are positive, they set the scale: chaotic exponents are small compared with those of strongly damped motion, but must be
/// visible.
fn symmetric(values: &[f64]) -> (f64, f64) {
    let positive = &values[values.partition_point(|value| *value <= 0.0)..];
    let reach = if positive.is_empty() {
        quantile(values, 0.01).abs()
    } else {
        1.25 * quantile(positive, 0.99)
    };
    // All values may be zero.
    let reach = if reach > 0.0 { round_up(reach) } else { 1.0 };
    (-reach, reach)
}

/// Round limits between which nearly all of the sorted values lie.
fn span(values: &[f64]) -> (f64, f64) {
    let (low, high) = (quantile(values, 0.01), quantile(values, 0.99));
    // A single value lies in the middle of the scale.
    let width = if high > low {
        high - low
    } else {
        2.0 * low.abs().max(1.0)
    };
    let (low, high) = if high > low {
        (low, high)
    } else {
        (low - width / 2.0, low + width / 2.0)
    };
    let step = round_step(width / 10.0);
    ((low / step).floor() * step, (high / step).ceil() * step)
}

fn quantile(sorted: &[f64], fraction: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * fraction).round() as usize]
}
