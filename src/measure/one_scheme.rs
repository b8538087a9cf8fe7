//! A measurement by one scheme alone.
//!
//! Owns whether it is decided early; completes nothing that the scheme gave up.

use std::ops::ControlFlow;

use super::evaluation::sums_all;
use super::{Measurement, early, undriven, whole_run};
use crate::backend::{Backend, BackendError, Instance};
use crate::experiment::Settings;

/// Measures instances of constant contact pressure by one scheme, early if that was asked for.
pub(super) fn measure(
    backend: &mut dyn Backend,
    settings: &Settings,
    instances: &[Instance],
    progress: &mut dyn FnMut(u64) -> ControlFlow<()>,
) -> Result<Option<Vec<Measurement>>, BackendError> {
    let sums_all = sums_all(backend.kind(), settings);
    let measured = if settings.sampling.decide_early && sums_all {
        early::measure(backend, settings, instances, progress)?
    } else {
        whole_run::measure(backend, settings, instances, 0, progress)?
    };
    let Some(mut measured) = measured else {
        return Ok(None);
    };
    if sums_all {
        undriven::measure_limit_cycles(backend, settings, instances, &mut measured)?;
    }
    Ok(Some(measured))
}
