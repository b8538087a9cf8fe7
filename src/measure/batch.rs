//! Batches of any instances: constant pressure, heat, wear.
//!
//! Owns which run an instance needs; the runs are made elsewhere.

use std::ops::ControlFlow;

use super::{Measurement, early, fallback, scheme_error, undriven, whole_run};
use crate::backend::{Backend, BackendError, Instance, check_model};
use crate::experiment::{Sampling, Settings};
use crate::parameters::ParameterSet;

/// Measures a batch of instances; [`Instance::starts`] makes instances of points. After every slice, `progress` hears how many
/// instance-periods of a run at full length were done. It may break the run off; the result is then None.
///
/// If the contact wears, the whole motion is transient. Such a run has no separate transient part: all of it is measured, over
/// `sampling.periods`.
///
/// # Errors
/// If the backend fails, or the scheme that was asked for does not carry the heat and wear of an instance.
pub fn measure_batch(
    backend: &mut dyn Backend,
    settings: &Settings,
    instances: &[Instance],
    progress: &mut dyn FnMut(u64) -> ControlFlow<()>,
) -> Result<Option<Vec<Measurement>>, BackendError> {
    check_model(&settings.integration, instances)?;
    let with = |wanted: &dyn Fn(&ParameterSet) -> bool| -> Vec<usize> {
        (0..instances.len())
            .filter(|&index| wanted(&instances[index].parameters))
            .collect()
    };
    let constant = with(&|set| !set.has_heat_or_wear());
    let heated = with(&ParameterSet::is_heated);
    let wearing = with(&ParameterSet::wears);
    let mut measured = vec![None; instances.len()];
    let whole_run = u64::from(settings.sampling.transient_periods) + u64::from(settings.sampling.periods);
    let from_the_start = Settings {
        sampling: Sampling {
            transient_periods: 0,
            align_periods: 0,
            ..settings.sampling
        },
        ..*settings
    };
    for (indices, settings, share) in [
        (constant, settings, whole_run),
        (heated, settings, whole_run),
        (wearing, &from_the_start, u64::from(settings.sampling.periods)),
    ] {
        if indices.is_empty() {
            continue;
        }
        let instances: Vec<_> = indices
            .iter()
            .map(|&index| undriven::instance(instances[index].clone()))
            .collect();
        // every kind counts as a whole run, because the announced amount of work is that of whole runs
        let progress = &mut |instance_periods: u64| progress(instance_periods * whole_run / share);
        let batch = if instances[0].parameters.has_heat_or_wear() {
            measure_heated(backend, settings, &instances, progress)?
        } else {
            measure_constant(backend, settings, &instances, progress)?
        };
        let Some(batch) = batch else {
            return Ok(None);
        };
        for (index, measurement) in indices.into_iter().zip(batch) {
            measured[index] = Some(measurement);
        }
    }
    Ok(measured.into_iter().collect())
}

/// Measures instances of constant contact pressure. Other schemes complete what the scheme could not finish, and the errors
/// include the scheme's share.
fn measure_constant(
    backend: &mut dyn Backend,
    settings: &Settings,
    instances: &[Instance],
    progress: &mut dyn FnMut(u64) -> ControlFlow<()>,
) -> Result<Option<Vec<Measurement>>, BackendError> {
    let Some(mut measured) = fallback::measure(backend, settings, instances, progress)? else {
        return Ok(None);
    };
    let estimated = scheme_error::add(settings, instances, &mut measured, progress)?;
    Ok(estimated.map(|()| measured))
}

/// Measures instances with heat or wear. Either all of them wear, or none does.
fn measure_heated(
    backend: &mut dyn Backend,
    settings: &Settings,
    instances: &[Instance],
    progress: &mut dyn FnMut(u64) -> ControlFlow<()>,
) -> Result<Option<Vec<Measurement>>, BackendError> {
    let wears = instances[0].parameters.wears();
    if settings.sampling.decide_early && !wears {
        early::measure(backend, settings, instances, progress)
    } else {
        whole_run::measure(backend, settings, instances, 0, progress)
    }
}
