//! The onset of chaos over one parameter.
//!
//! Owns its definition and the refinement of the bracket in which it lies; measures through [`super::exponents`].
//!
//! The onset is the least value of a fine grid, upward, at which the exponent of some initial state stands above a bound
//! while its motion is classed neither as regular nor as quasi-periodic. The class keeps out what an exponent over a finite
//! window lets in far below: slowly attracting cycles and quasi-periodic motion. The fine grid covers the bracket of the
//! first upward change that a coarse scan with long windows shows; above the onset chaos is not monotone, so that a bracket is
//! scanned, never bisected.

use super::exponents::{Line, lines};
use crate::backend::BackendError;
use crate::experiment::{Scheme, Settings};
use crate::grid::{Axis, Coordinate, Fixed, Grid};
use crate::measurement::{Class, Measurement};
use crate::sweep::{Backends, Observer};

/// The most values of the fine grid that a bracket is scanned at: more take hours.
pub const MOST_VALUES: usize = 100_000;

/// Forcing periods over which an onset is confirmed.
pub const CONFIRMING_PERIODS: u32 = 2000;

/// What counts as chaos at the onset, and how finely the bracket is scanned.
#[derive(Clone, Debug, PartialEq)]
pub struct Definition {
    /// Least exponent, per unit of tau.
    pub least_exponent: f64,
    /// Distance of the fine grid's values, which are its multiples.
    pub spacing: f64,
    pub settings: Settings,
}

impl Definition {
    /// An exponent above 0.005 over 100 periods after 380, with the friction layer resolved: the fixed steps of rk4 are
    /// then at least 4000 a period; those of the other schemes end at the layer's boundaries.
    pub fn new(spacing: f64, settings: &Settings) -> Self {
        let mut settings = Settings {
            transient_periods: 380,
            align_periods: 50,
            periods: 100,
            decide_early: false,
            initial_states: 1,
            ..settings.clone()
        };
        if settings.scheme() == Scheme::Rk4 {
            let steps = settings.steps_per_period().max(4000);
            settings.steps_per_period = Some(steps);
            settings.renormalise_every = steps / 4;
        }
        Self {
            least_exponent: 0.005,
            spacing,
            settings,
        }
    }

    /// Chaos on the fine grid.
    pub fn is_chaos(&self, measurement: &Measurement) -> bool {
        matches!(measurement.class, Some(Class::Chaotic | Class::Undecided))
            && measurement.lyapunov > self.least_exponent
    }

    /// Chaos on a coarse scan: beyond doubt.
    fn is_certain_chaos(&self, measurement: &Measurement) -> bool {
        measurement.class == Some(Class::Chaotic) && measurement.lyapunov > self.least_exponent
    }
}

/// An onset that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// The first chaotic value of the fine grid; chaos sets in between it and the value `spacing` below.
    pub value: f64,
    pub spacing: f64,
    /// The initial state (x, y) from which chaos comes first.
    pub start: [f64; 2],
    pub exponent: f64,
    pub error: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Onset {
    Found(Found),
    /// Chaotic at the axis' lowest decided value: the onset lies below.
    BelowAxis,
    /// No initial state leads to chaos on the axis.
    Never,
}

/// The onset of chaos over an axis on which `coarse` lines were measured, one for each initial state; the first upward change
/// to chaos among them is scanned again by the definition, and if it does not hold there, the next. None if the observer
/// broke it off.
///
/// # Errors
/// If a bracket has more than [`MOST_VALUES`], or the backend fails and no fall-back is left.
pub fn onset(
    backends: &mut Backends,
    definition: &Definition,
    at: &Fixed,
    coarse: &[Line],
    observer: &mut Observer<'_>,
) -> Result<Option<Onset>, BackendError> {
    let starts: Vec<[f64; 2]> = coarse.iter().map(|line| line.start).collect();
    for bracket in brackets(definition, coarse) {
        let Some(low) = bracket.low else {
            return Ok(Some(Onset::BelowAxis));
        };
        let values = ((bracket.high - low) / definition.spacing).round();
        if values > MOST_VALUES as f64 {
            // in f32, whose digits show no rounding errors
            return Err(BackendError::Unsupported(format!(
                "the onset lies between {} and {}, where a spacing of {:e} makes {values} values (at most {MOST_VALUES}): give a \
                 greater spacing, or a finer axis between the two",
                low as f32, bracket.high as f32, definition.spacing
            )));
        }
        let fine = fine_axis(&coarse[0].axis, low, bracket.high, definition.spacing);
        match scan(backends, definition, at, &fine, &starts, observer)? {
            None => return Ok(None),
            Some(None) => {}
            Some(Some(found)) => return Ok(Some(Onset::Found(found))),
        }
    }
    Ok(Some(Onset::Never))
}

/// Measures again where the onset was found, over [`CONFIRMING_PERIODS`]: the definition's 100 periods leave an error as
/// large as the exponent, and chaos that ends within some hundreds passes for one that lasts. None if the observer broke
/// it off.
///
/// # Errors
/// If the backend fails and no fall-back is left.
pub fn confirm(
    backends: &mut Backends,
    definition: &Definition,
    at: &Fixed,
    coordinate: Coordinate,
    found: &Found,
    observer: &mut Observer<'_>,
) -> Result<Option<Measurement>, BackendError> {
    let settings = Settings {
        periods: CONFIRMING_PERIODS,
        ..definition.settings.clone()
    };
    let grid = Grid {
        axes: Vec::new(),
        fixed: at.at([(coordinate, found.value)]).from_state(found.start),
    };
    let measured = backends.measure(&grid, &settings, &[0], observer)?;
    Ok(measured.map(|measured| measured[0]))
}

/// The first value of a rising axis, whose step is the definition's spacing, at which one of the initial states leads to
/// chaos by the definition. The outer None means that the observer broke it off.
///
/// # Errors
/// If the backend fails and no fall-back is left.
pub fn scan(
    backends: &mut Backends,
    definition: &Definition,
    at: &Fixed,
    axis: &Axis,
    starts: &[[f64; 2]],
    observer: &mut Observer<'_>,
) -> Result<Option<Option<Found>>, BackendError> {
    // the fine grid may reach beyond the axis by a spacing
    let grid = Grid {
        axes: vec![*axis],
        fixed: *at,
    };
    grid.extents()
        .map_err(|error| BackendError::Unsupported(error.to_string()))?;
    let scanned = lines(backends, &definition.settings, at, axis, starts, observer)?;
    Ok(scanned.map(|scanned| first_chaos(definition, axis, &scanned)))
}

/// A change to chaos between two values of the coarse axis, `low < high`; without `low` there is no decided value below.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bracket {
    low: Option<f64>,
    high: f64,
}

/// The upward changes to chaos of all lines, the lowest first, overlapping ones joined.
fn brackets(definition: &Definition, lines: &[Line]) -> Vec<Bracket> {
    let mut brackets = Vec::new();
    for line in lines {
        let mut order: Vec<usize> = (0..line.axis.count).collect();
        if line.axis.step() < 0.0 {
            order.reverse();
        }
        let mut low = None;
        let mut in_chaos = false;
        for index in order {
            let (value, measurement) = (line.axis.value(index), &line.measurements[index]);
            if definition.is_certain_chaos(measurement) {
                if !in_chaos {
                    brackets.push(Bracket { low, high: value });
                }
                in_chaos = true;
            } else if matches!(measurement.class, Some(Class::Regular | Class::QuasiPeriodic)) {
                low = Some(value);
                in_chaos = false;
            }
        }
    }
    brackets.sort_by(|a, b| a.high.total_cmp(&b.high));
    brackets
}

/// The multiples of the spacing from the last that is no greater than `low` to the first that is no less than `high`.
fn fine_axis(coarse: &Axis, low: f64, high: f64, spacing: f64) -> Axis {
    let first = (low / spacing + 1e-6).floor();
    let last = (high / spacing - 1e-6).ceil().max(first + 1.0);
    Axis {
        coordinate: coarse.coordinate,
        start: first * spacing,
        stop: last * spacing,
        count: (last - first) as usize + 1,
    }
}

fn first_chaos(definition: &Definition, axis: &Axis, lines: &[Line]) -> Option<Found> {
    (0..axis.count).find_map(|index| {
        let line = lines
            .iter()
            .find(|line| definition.is_chaos(&line.measurements[index]))?;
        let measurement = &line.measurements[index];
        Some(Found {
            value: axis.value(index),
            spacing: definition.spacing,
            start: line.start,
            exponent: measurement.lyapunov,
            error: measurement.lyapunov_error,
        })
    })
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use crate::backend::cpu::CpuBackend;
    use crate::experiment::Precision;
    use crate::measurement::{BackendKind, Status};
    use crate::parameters::ParameterSet;

    #[test]
    fn a_bracket_of_too_many_values_is_refused() {
        let of = |class, lyapunov| Measurement {
            status: Status::Ok,
            class,
            lyapunov,
            ..Measurement::runaway(0.0, BackendKind::CpuF64)
        };
        let at: Fixed = ParameterSet::default().into();
        // what is undecided between the two widens the bracket beyond a step of the axis
        let line = Line {
            axis: Axis::parse("zeta_k=3:4:3").unwrap(),
            fixed: at,
            start: [0.1, 0.0],
            measurements: vec![
                of(Some(Class::Regular), -0.1),
                of(None, f64::NAN),
                of(Some(Class::Chaotic), 0.1),
            ],
        };
        let definition = Definition::new(0.6e-5, &Settings::default());
        let mut backends = Backends::new(Box::new(CpuBackend::new(Precision::F64)), None);
        let observer = &mut |_: crate::sweep::Event<'_>| ControlFlow::Continue(());
        let refused = onset(&mut backends, &definition, &at, &[line], observer).unwrap_err();
        let message = refused.to_string();
        assert!(
            message.contains("between 3 and 4, where a spacing of 6e-6 makes 166667 values"),
            "{message}"
        );
    }
}
