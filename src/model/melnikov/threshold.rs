//! The threshold: the least value of a parameter at which M begins to change sign.
//!
//! Owns the search in one parameter; curves over a second one are made of it elsewhere.

use super::extremes::Side;
use super::{Melnikov, MelnikovError, check_parameter};
use crate::parameters::{Parameter, ParameterSet};

/// Halvings of the bracket: 2^-30 of a scan's step is about 1e-11 of the range.
const HALVINGS: u32 = 30;

/// Where a threshold is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    pub parameter: Parameter,
    pub low: f64,
    pub high: f64,
    /// Steps of the scan from `low` upward that brackets the first change; a stretch of sign changes that is shorter than a
    /// step may be passed over.
    pub steps: u32,
}

impl Search {
    /// Steps that a search takes unless it is told otherwise.
    pub const STEPS: u32 = 120;

    /// # Errors
    /// If M does not depend on the parameter, a bound is out of its range, or there is no range between them.
    pub fn new(parameter: Parameter, low: f64, high: f64) -> Result<Self, MelnikovError> {
        check_parameter(parameter)?;
        if !(low < high && low.is_finite() && high.is_finite()) {
            return Err(MelnikovError::Range {
                name: parameter.name(),
                low,
                high,
            });
        }
        Ok(Self {
            parameter,
            low,
            high,
            steps: Self::STEPS,
        })
    }
}

/// What a search found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Threshold {
    /// M changes sign from this value upward.
    At(f64),
    /// M changes sign at the lower end of the range already.
    BelowRange,
    /// M changes sign nowhere in the range, to the resolution of the scan.
    Never,
}

impl Threshold {
    pub fn value(self) -> Option<f64> {
        match self {
            Self::At(value) => Some(value),
            Self::BelowRange | Self::Never => None,
        }
    }
}

/// The least value of the search's parameter, upward from its lower bound, at which M changes sign; the other parameters are
/// those of `at`.
///
/// # Errors
/// [`MelnikovError::NoHomoclinicOrbit`] if b is not positive somewhere on the way.
pub fn threshold(at: &ParameterSet, search: &Search) -> Result<Threshold, MelnikovError> {
    let Search {
        parameter,
        low,
        high,
        steps,
    } = *search;
    threshold_along(&|value| at.with(parameter, value), [low, high], steps)
}

/// As [`threshold`], along any path `at` through the parameters, from `low` upward to `high` in `steps` steps.
///
/// # Errors
/// As [`threshold`].
pub fn threshold_along(
    at: &impl Fn(f64) -> ParameterSet,
    [low, high]: [f64; 2],
    steps: u32,
) -> Result<Threshold, MelnikovError> {
    let at = |value: f64| Melnikov::new(&at(value));
    let changes = |value: f64| -> Result<bool, MelnikovError> { Ok(at(value)?.side() == Side::Both) };
    if changes(low)? {
        return Ok(Threshold::BelowRange);
    }
    let value = |k: u32| {
        let t = f64::from(k) / f64::from(steps);
        low * (1.0 - t) + high * t
    };
    for k in 1..=steps {
        if changes(value(k))? {
            let bracket = [value(k - 1), value(k)];
            if let Some(found) = followed(&at, bracket)? {
                // what the one extreme says must hold of the whole function
                let margin = 1e-9 * (bracket[1] - bracket[0]);
                if changes(found + margin)? && !changes(found - margin)? {
                    return Ok(Threshold::At(found));
                }
            }
            return Ok(Threshold::At(bisected(&changes, bracket)?));
        }
    }
    Ok(Threshold::Never)
}

/// Steps of the secant method; it takes about seven.
const STEPS: u32 = 40;

/// The zero of the extreme that crosses zero within the bracket, followed from its upper end by the Illinois variant of false
/// position; None if it does not cross there, which other extremes may do.
fn followed(
    at: &impl Fn(f64) -> Result<Melnikov, MelnikovError>,
    [mut low, mut high]: [f64; 2],
) -> Result<Option<f64>, MelnikovError> {
    let extremes = at(high)?.extremes();
    // of the two sides the one that M has just reached is the shallower
    let (mut tau_0, sign) = if -extremes.minimum < extremes.maximum {
        (extremes.minimum_at, -1.0)
    } else {
        (extremes.maximum_at, 1.0)
    };
    let mut peak = |value: f64| {
        let (time, peak) = at(value)?.peak_near(tau_0, sign);
        tau_0 = time;
        Ok::<f64, MelnikovError>(peak)
    };
    let (mut at_high, mut at_low) = (peak(high)?, peak(low)?);
    if !(at_low < 0.0 && at_high > 0.0) {
        return Ok(None);
    }
    let tolerance = 1e-13 * (high - low);
    let mut last_side = 0;
    for _ in 0..STEPS {
        let next = (low * at_high - high * at_low) / (at_high - at_low);
        let at_next = peak(next)?;
        if at_next > 0.0 {
            (high, at_high) = (next, at_next);
            at_low *= if last_side == 1 { 0.5 } else { 1.0 };
            last_side = 1;
        } else {
            (low, at_low) = (next, at_next);
            at_high *= if last_side == -1 { 0.5 } else { 1.0 };
            last_side = -1;
        }
        if high - low < tolerance || at_next.abs() < 1e-12 {
            return Ok(Some(next));
        }
    }
    Ok(None)
}

fn bisected(
    changes: &impl Fn(f64) -> Result<bool, MelnikovError>,
    [mut low, mut high]: [f64; 2],
) -> Result<f64, MelnikovError> {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if changes(middle)? {
            high = middle;
        } else {
            low = middle;
        }
    }
    Ok(0.5 * (low + high))
}
