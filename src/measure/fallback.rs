//! Completes what a scheme could not finish, by other schemes on the CPU: taylor in f64, and radau in f64 for what taylor gives
//! up.
//!
//! Owns which measurements are repeated, and what is taken from them. Stiff motion, however slow, forces explicit schemes to very
//! short steps: a bush that sticks in a thin friction layer, strong damping, an escape against friction that grows with the
//! speed. Only the smoothness of the motion limits the steps of radau. For every scheme, the time within a period at which an
//! orbit ran away is found here, too.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use rayon::prelude::*;

use super::{Measurement, Status, one_scheme};
use crate::backend::cpu::CpuBackend;
use crate::backend::{Backend, BackendError, BackendKind, Instance, Slice, Stage};
use crate::dynamics::taylor::escape::escape_time;
use crate::experiment::{Integration, Precision, Scheme, Settings};

/// Error of a step where an exponent is measured.
const TOLERANCE: f64 = 1e-8;

/// Error of a step where an orbit is followed to where it runs away.
const ESCAPE_TOLERANCE: f64 = 1e-6;

/// Most forcing periods over which an orbit is followed from its start to where it runs away. Over a longer time, number types
/// and schemes differ by too much. The orbit is then followed from the beginning of the period at whose end its escape was
/// noticed.
const MOST_ESCAPE_PERIODS: u32 = 512;

/// Where the sum of the exponents misses the divergence by more than this, relative to 1 + |divergence|, the steps of taylor in
/// f64 were too long for the motion.
const ROUGH: f64 = 1e-5;

fn is_rough(measurement: &Measurement) -> bool {
    measurement.divergence_defect().abs() > ROUGH * (1.0 + measurement.divergence.abs())
}

/// The scheme that is tried next, in f64 on the CPU, where `scheme` on a backend of this `kind` gives up.
pub(crate) fn next(scheme: Scheme, kind: BackendKind) -> Scheme {
    if scheme == Scheme::Taylor && kind == BackendKind::CpuF64 {
        Scheme::Radau
    } else {
        Scheme::Taylor
    }
}

/// The settings with which `scheme` replaces another one that gave up.
pub(crate) fn in_place(settings: &Settings, scheme: Scheme) -> Settings {
    Settings {
        integration: Integration {
            tolerance: settings.integration.tolerance.min(TOLERANCE),
            precision: Some(Precision::F64),
            ..scheme.into()
        },
        ..*settings
    }
}

/// Measures instances of constant contact pressure, and completes what the scheme of `settings` could not finish. None if `progress`
/// broke it off.
///
/// # Errors
/// If a backend fails.
pub(super) fn measure(
    backend: &mut dyn Backend,
    settings: &Settings,
    instances: &[Instance],
    progress: &mut dyn FnMut(u64) -> ControlFlow<()>,
) -> Result<Option<Vec<Measurement>>, BackendError> {
    let Some(mut measured) = one_scheme::measure(backend, settings, instances, progress)? else {
        return Ok(None);
    };
    let completed = complete(settings, backend.kind(), instances, &mut measured, progress)?;
    Ok(completed.map(|()| measured))
}

/// Completes the measurements of instances of constant contact pressure by the scheme of `settings` on a backend of this `kind`. None
/// if `progress` broke it off.
///
/// - If an orbit ran away, the time within the period is found. An escape that is not confirmed is under-resolved.
/// - A point that taylor in f64 gives up, or where its exponents miss the divergence by more than [`ROUGH`], is measured again by
///   radau.
/// - A point that another scheme or number type gives up is measured again by taylor in f64. The user chose the steps of rk4 and
///   the tolerance of radau in f64: for points of these two, only escapes are taken from the new measurement.
///
/// # Errors
/// If the CPU backend fails.
fn complete(
    settings: &Settings,
    kind: BackendKind,
    instances: &[Instance],
    measured: &mut [Measurement],
    progress: &mut dyn FnMut(u64) -> ControlFlow<()>,
) -> Result<Option<()>, BackendError> {
    let mut backend = CpuBackend::new(Precision::F64);
    let by = |scheme| in_place(settings, scheme);
    let with = |measured: &[Measurement], wanted: &dyn Fn(&Measurement) -> bool| -> Vec<usize> {
        (0..measured.len()).filter(|&index| wanted(&measured[index])).collect()
    };

    let escaped = with(measured, &has_escaped);
    time_escapes(&mut backend, &by(Scheme::Radau), instances, &escaped, measured)?;

    let scheme = settings.integration.scheme;
    let is_by_default = next(scheme, kind) == Scheme::Radau;
    let given_up = with(measured, &|m| {
        m.status == Status::UnderResolved || (is_by_default && is_rough(m))
    });
    if !given_up.is_empty() {
        let chosen: Vec<_> = given_up.iter().map(|&index| instances[index].clone()).collect();
        // they were reported as done before
        let mut silent = |_| progress(0);
        let anew = match next(scheme, kind) {
            Scheme::Radau => one_scheme::measure(&mut backend, &by(Scheme::Radau), &chosen, &mut silent)?,
            other => measure(&mut backend, &by(other), &chosen, &mut silent)?,
        };
        let Some(anew) = anew else {
            return Ok(None);
        };
        let is_as_asked = scheme == Scheme::Rk4 || (scheme == Scheme::Radau && kind == BackendKind::CpuF64);
        for (&index, anew) in given_up.iter().zip(anew) {
            if !is_as_asked || has_escaped(&anew) {
                measured[index] = Measurement {
                    integrated_periods: anew.integrated_periods + measured[index].integrated_periods,
                    ..anew
                };
            }
        }
    }
    for measurement in measured.iter_mut().filter(|m| has_escaped(m)) {
        // of an orbit that ran away, only the time is kept
        (measurement.x, measurement.y) = (f64::NAN, f64::NAN);
    }
    Ok(Some(()))
}

fn has_escaped(measurement: &Measurement) -> bool {
    matches!(measurement.status, Status::Runaway { .. })
}

/// An orbit that ran away, and the state from which it is followed to find the time.
struct Escape {
    /// Index of its measurement.
    index: usize,
    /// The forcing period from which it is followed, and the instance at that time.
    start: u32,
    begun: Instance,
    /// Forcing periods over which it is followed.
    periods: u32,
}

impl Escape {
    fn new(index: usize, measured: &Measurement, instance: &Instance) -> Option<Self> {
        let Status::Runaway { time } = measured.status else {
            return None;
        };
        let noticed = (time / instance.parameters.forcing_period()).round() as u32;
        let (start, begun) = if noticed > MOST_ESCAPE_PERIODS {
            let last = Instance::new(instance.parameters, [measured.x, measured.y]);
            (noticed - 1, last)
        } else {
            (0, instance.clone())
        };
        Some(Self {
            index,
            start,
            begun,
            periods: noticed + 1 - start,
        })
    }

    /// The status of the orbit if it ran away at `time` after the state from which it is followed.
    fn status(&self, time: f64) -> Status {
        Status::Runaway {
            time: f64::from(self.start) * self.begun.parameters.forcing_period() + time,
        }
    }
}

/// Finds when the orbits of `escaped` ran away: by taylor in f64, step by step, and by radau where taylor gives up.
fn time_escapes(
    backend: &mut CpuBackend,
    fallback: &Settings,
    instances: &[Instance],
    escaped: &[usize],
    measured: &mut [Measurement],
) -> Result<(), BackendError> {
    let steps = Scheme::Taylor.default_steps_per_period();
    let escapes: Vec<(Escape, Option<f64>)> = escaped
        .par_iter()
        .filter_map(|&index| Escape::new(index, &measured[index], &instances[index]))
        .map(|escape| {
            let begun = &escape.begun;
            let time = escape_time(&begun.parameters, begun.state, steps, escape.periods);
            (escape, time)
        })
        .collect();
    // orbits that are followed over the same number of periods form a batch
    let mut left: BTreeMap<u32, Vec<Escape>> = BTreeMap::new();
    for (escape, time) in escapes {
        match time {
            Some(time) => measured[escape.index].status = escape.status(time),
            None => left.entry(escape.periods).or_default().push(escape),
        }
    }
    let settings = Settings {
        integration: Integration {
            tolerance: ESCAPE_TOLERANCE,
            ..fallback.integration
        },
        ..*fallback
    };
    left.into_iter()
        .try_for_each(|(periods, escapes)| locate(backend, &settings, periods, &escapes, measured))
}

/// Follows orbits by radau over some periods until they run away; an orbit that does not run away is under-resolved.
fn locate(
    backend: &mut CpuBackend,
    settings: &Settings,
    periods: u32,
    escapes: &[Escape],
    measured: &mut [Measurement],
) -> Result<(), BackendError> {
    let instances: Vec<_> = escapes.iter().map(|escape| escape.begun.clone()).collect();
    backend.load(settings, &instances)?;
    backend.advance(&Slice {
        stage: Stage::Transient,
        first: 0,
        periods,
        elapsed: 0,
    })?;
    for (escape, end) in escapes.iter().zip(backend.end_states()?) {
        let time = end
            .runaway_periods
            .map(|periods| periods * escape.begun.parameters.forcing_period());
        measured[escape.index].status = time.map_or(Status::UnderResolved, |time| escape.status(time));
    }
    Ok(())
}
