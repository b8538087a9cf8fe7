//! The threshold: the least value of a parameter at which M begins to change sign.
//!
//! Owns the search in one parameter; curves over a second one are made of it elsewhere.

use super::extremes::Side;
use super::{Melnikov, MelnikovError, check_parameter};
use crate::parameters::{Parameter, ParameterSet};

/// Halvings of the bracket: 2^-40 of a scan's step is below 1e-12 of the range.
const HALVINGS: u32 = 36;

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
    let changes = |value: f64| -> Result<bool, MelnikovError> {
        Ok(Melnikov::new(&at.with(search.parameter, value))?.side() == Side::Both)
    };
    if changes(search.low)? {
        return Ok(Threshold::BelowRange);
    }
    let value = |k: u32| {
        let t = f64::from(k) / f64::from(search.steps);
        search.low * (1.0 - t) + search.high * t
    };
    for k in 1..=search.steps {
        if changes(value(k))? {
            let (mut low, mut high) = (value(k - 1), value(k));
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if changes(middle)? {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            return Ok(Threshold::At(0.5 * (low + high)));
        }
    }
    Ok(Threshold::Never)
}
