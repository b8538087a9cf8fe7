//! The threshold: where M begins or ceases to change sign.
//!
//! Owns the search along an axis and the border between two points; curves over two axes are made of them elsewhere.

use super::{Melnikov, MelnikovError, check_depends};
use crate::design::{Axis, Fixed};
use crate::parameters::ParameterSet;

/// The first change along a rising axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Threshold {
    /// M changes sign above this value, and not below.
    Begins(f64),
    /// M changes sign below this value, and not above.
    Ceases(f64),
    /// M changes sign at every value of the axis.
    Always,
    /// M changes sign at no value of the axis.
    Never,
}

impl Threshold {
    /// The threshold in the unit of the axis; None if M changes sign at all values of the axis or at none.
    pub fn value(self) -> Option<f64> {
        match self {
            Self::Begins(value) | Self::Ceases(value) => Some(value),
            Self::Always | Self::Never => None,
        }
    }

    /// Whether M changes sign below the threshold and above it; if there is none, both tell about the whole axis.
    pub fn changes_sign(self) -> [bool; 2] {
        match self {
            Self::Begins(_) => [false, true],
            Self::Ceases(_) => [true, false],
            Self::Always => [true, true],
            Self::Never => [false, false],
        }
    }
}

/// The least value on a rising axis at which M begins or ceases to change sign; everything else is as in `at`. The search
/// compares neighbouring values of the axis: it may miss a range that is shorter than a step of the axis.
///
/// # Errors
/// [`MelnikovError::NotAParameter`] if M does not depend on the axis' coordinate, [`MelnikovError::NoHomoclinicOrbit`] if b
/// is not positive somewhere on the way, [`MelnikovError::Rubbed`] if there is frictional heat or wear.
pub fn threshold(at: &Fixed, along: &Axis) -> Result<Threshold, MelnikovError> {
    check_depends(at, along.coordinate)?;
    let at = |value: f64| *at.at([(along.coordinate, value)]).parameters();
    let at_first = changes_sign(&at(along.first()))?;
    for index in 1..along.count() {
        let [last, next] = [along.value(index - 1), along.value(index)];
        if changes_sign(&at(next))? != at_first {
            return Ok(if at_first {
                Threshold::Ceases(border(&at, [next, last])?)
            } else {
                Threshold::Begins(border(&at, [last, next])?)
            });
        }
    }
    Ok(if at_first { Threshold::Always } else { Threshold::Never })
}

/// Whether M changes sign.
///
/// # Errors
/// As [`Melnikov::new`].
pub fn changes_sign(at: &ParameterSet) -> Result<bool, MelnikovError> {
    Ok(Melnikov::new(at)?.changes_sign())
}

/// The value at which M begins to change sign on the path `at` through the parameters, from the value `outside`, where it does
/// not, to the value `inside`, where it does.
///
/// # Errors
/// As [`Melnikov::new`].
pub fn border(at: &impl Fn(f64) -> ParameterSet, [outside, inside]: [f64; 2]) -> Result<f64, MelnikovError> {
    if let Some(found) = followed(at, [outside, inside])? {
        // the result from one extreme must hold for the whole function
        let margin = 1e-9 * (inside - outside);
        if changes_sign(&at(found + margin))? && !changes_sign(&at(found - margin))? {
            return Ok(found);
        }
    }
    bisected(at, [outside, inside])
}

/// Most steps of false position; it takes about seven.
const STEPS: u32 = 40;

/// The value at which an extreme of M crosses zero on the path. The extreme is followed from `inside`, and the Illinois variant
/// of false position finds its zero. None if this extreme does not cross zero; another one may.
fn followed(
    at: &impl Fn(f64) -> ParameterSet,
    [mut outside, mut inside]: [f64; 2],
) -> Result<Option<f64>, MelnikovError> {
    let extremes = Melnikov::new(&at(inside))?.extremes();
    // of the two signs, M has just reached the one with the smaller extreme
    let (mut tau_0, sign) = if -extremes.minimum < extremes.maximum {
        (extremes.minimum_at, -1.0)
    } else {
        (extremes.maximum_at, 1.0)
    };
    let mut peak = |value: f64| {
        let (time, peak) = Melnikov::new(&at(value))?.peak_near(tau_0, sign);
        tau_0 = time;
        Ok::<f64, MelnikovError>(peak)
    };
    let (mut at_inside, mut at_outside) = (peak(inside)?, peak(outside)?);
    if !(at_outside < 0.0 && at_inside > 0.0) {
        return Ok(None);
    }
    let tolerance = 1e-13 * (inside - outside).abs();
    let mut last_side = 0;
    for _ in 0..STEPS {
        let next = (outside * at_inside - inside * at_outside) / (at_inside - at_outside);
        let at_next = peak(next)?;
        if at_next > 0.0 {
            (inside, at_inside) = (next, at_next);
            at_outside *= if last_side == 1 { 0.5 } else { 1.0 };
            last_side = 1;
        } else {
            (outside, at_outside) = (next, at_next);
            at_inside *= if last_side == -1 { 0.5 } else { 1.0 };
            last_side = -1;
        }
        if (inside - outside).abs() < tolerance || at_next.abs() < 1e-12 {
            return Ok(Some(next));
        }
    }
    Ok(None)
}

/// Halvings of the bracket: 2^-30 of a scan's step is about 1e-11 of the range.
const HALVINGS: u32 = 30;

fn bisected(at: &impl Fn(f64) -> ParameterSet, [mut outside, mut inside]: [f64; 2]) -> Result<f64, MelnikovError> {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (outside + inside);
        if changes_sign(&at(middle))? {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    Ok(0.5 * (outside + inside))
}
