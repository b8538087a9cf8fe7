//! What a scheme could not finish, by the one that can: radau in f64, on the CPU.
//!
//! Owns which measurements are made anew, and what is taken of them. A scheme of explicit steps is held up by motion that is
//! far stiffer than it is fast: a bush that sticks in a thin friction layer, strong damping, an escape against friction that
//! grows with the speed. Radau's steps are as long as the motion is smooth. It also tells within a period when an orbit ran
//! away, which the others notice at its end.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use super::cpu::CpuBackend;
use super::run::measure_lasting;
use super::{Backend, BackendError, Slice, Stage};
use crate::dynamics::taylor::escape::escape_time;
use crate::experiment::{Precision, Scheme, Settings};
use crate::measurement::{BackendKind, Measurement, Status};
use crate::parameters::{Parameter, ParameterSet};

/// Error of a step where an exponent is measured.
const TOLERANCE: f64 = 1e-8;

/// Error of a step where an orbit is followed to where it runs away.
const ESCAPE_TOLERANCE: f64 = 1e-6;

/// Most forcing periods over which an orbit is followed from its start to where it runs away; after more of them number types
/// and schemes differ by too much, and it is followed from the beginning of the period at whose end it was noticed.
const MOST_ESCAPE_PERIODS: u32 = 512;

/// A sum of exponents that misses the divergence by more than this, relative to 1 + |divergence|, tells of a motion that is
/// rougher than the steps of taylor in f64 were made for.
const ROUGH: f64 = 5e-5;

fn is_rough(measurement: &Measurement) -> bool {
    measurement.backend == BackendKind::CpuF64
        && measurement.divergence_defect().abs() > ROUGH * (1.0 + measurement.divergence.abs())
}

/// Completes the measurements of instances of constant contact pressure by the scheme of `settings`. None if `progress` broke
/// it off.
///
/// - Where an orbit ran away, the time is found within the period; one that did so by the scheme alone is under-resolved.
/// - What is under-resolved, or [`ROUGH`], is measured anew. Of rk4, whose steps were asked for as they are, only an escape is taken.
///
/// # Errors
/// If the CPU backend fails.
pub(super) fn complete(
    settings: &Settings,
    instances: &[ParameterSet],
    measured: &mut [Measurement],
    progress: &mut dyn FnMut(u64) -> ControlFlow<()>,
) -> Result<Option<()>, BackendError> {
    let scheme = settings.scheme();
    let is_radau_f64 =
        |measurement: &Measurement| scheme == Scheme::Radau && measurement.backend == BackendKind::CpuF64;
    let indices = |wanted: &dyn Fn(&Measurement) -> bool| -> Vec<usize> {
        let chosen = measured
            .iter()
            .enumerate()
            .filter(|(_, m)| wanted(m) && !is_radau_f64(m));
        chosen.map(|(index, _)| index).collect()
    };
    let escaped = indices(&|m| matches!(m.status, Status::Runaway { .. }));
    let mut backend = CpuBackend::new(Precision::F64);
    let fallback = Settings {
        scheme: Some(Scheme::Radau),
        steps_per_period: None,
        tolerance: settings.tolerance.min(TOLERANCE),
        precision: Some(Precision::F64),
        ..settings.clone()
    };
    // by the number of periods that they are followed over
    let mut escapes: BTreeMap<u32, Vec<(usize, u32, ParameterSet)>> = BTreeMap::new();
    for &index in &escaped {
        let Status::Runaway { time } = measured[index].status else {
            continue;
        };
        let set = &instances[index];
        let noticed = (time / set.forcing_period()).round() as u32;
        let (start, before) = match noticed > MOST_ESCAPE_PERIODS {
            true => (noticed - 1, last_state(set, &measured[index])),
            false => (0, *set),
        };
        let periods = noticed + 1 - start;
        escapes.entry(periods).or_default().push((index, start, before));
    }
    let escaping = Settings {
        tolerance: ESCAPE_TOLERANCE,
        ..fallback.clone()
    };
    for (periods, escapes) in escapes {
        locate(&mut backend, &escaping, periods, &escapes, measured)?;
    }

    let given_up: Vec<usize> = (0..measured.len())
        .filter(|&index| {
            let m = &measured[index];
            (m.status == Status::UnderResolved || (scheme == Scheme::Taylor && is_rough(m))) && !is_radau_f64(m)
        })
        .collect();
    let chosen: Vec<_> = given_up.iter().map(|&index| instances[index]).collect();
    // it was reported as done before
    let mut unheard = |_| progress(0);
    let anew = match given_up.is_empty() {
        true => Some(Vec::new()),
        false => measure_lasting(&mut backend, &fallback, &chosen, &mut unheard)?,
    };
    let Some(anew) = anew else {
        return Ok(None);
    };
    for (&index, anew) in given_up.iter().zip(anew) {
        let is_escape = matches!(anew.status, Status::Runaway { .. });
        if is_escape || scheme != Scheme::Rk4 {
            measured[index] = Measurement {
                integrated_periods: anew.integrated_periods + measured[index].integrated_periods,
                ..anew
            };
        }
    }
    for measurement in measured.iter_mut() {
        // what is left of an orbit that ran away is when
        if matches!(measurement.status, Status::Runaway { .. }) {
            (measurement.x, measurement.y) = (f64::NAN, f64::NAN);
        }
    }
    Ok(Some(()))
}

/// The instance from its last stroboscopic state on.
fn last_state(set: &ParameterSet, measurement: &Measurement) -> ParameterSet {
    set.with(Parameter::X0, measurement.x)
        .with(Parameter::Y0, measurement.y)
}

/// Finds when orbits ran away, within some periods: of each its index, the period that it is followed from, and the instance
/// as it was then. One that did not was not resolved.
fn locate(
    backend: &mut CpuBackend,
    settings: &Settings,
    periods: u32,
    escapes: &[(usize, u32, ParameterSet)],
    measured: &mut [Measurement],
) -> Result<(), BackendError> {
    let instances: Vec<_> = escapes.iter().map(|escape| escape.2).collect();
    let steps = Scheme::Taylor.default_steps_per_period();
    backend.load(settings, &instances)?;
    backend.advance(&Slice {
        stage: Stage::Transient,
        first: 0,
        periods,
        elapsed: 0,
    })?;
    for (&(index, start, set), end) in escapes.iter().zip(backend.end_states()?) {
        measured[index].status = match end.runaway_periods {
            Some(periods) => Status::Runaway {
                time: (f64::from(start) + periods) * set.forcing_period(),
            },
            // an escape faster than the clock of radau tells is followed step by step
            None if end.under_resolved => {
                escape_time(&set, steps, periods).map_or(Status::UnderResolved, |time| Status::Runaway {
                    time: f64::from(start) * set.forcing_period() + time,
                })
            }
            None => Status::UnderResolved,
        };
    }
    Ok(())
}
