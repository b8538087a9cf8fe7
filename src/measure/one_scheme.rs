//! A measurement by one scheme, as it is.
//!
//! Owns whether it is decided early; completes nothing that the scheme gave up.

use std::ops::ControlFlow;

use super::whole_run::{self, Start, sums_all};
use super::{Measurement, early, undriven};
use crate::backend::{Backend, BackendError};
use crate::experiment::Settings;
use crate::parameters::ParameterSet;

/// Measures instances of constant contact pressure by one scheme, early if that was asked for.
pub(super) fn measure(
    backend: &mut dyn Backend,
    settings: &Settings,
    instances: &[ParameterSet],
    progress: &mut dyn FnMut(u64) -> ControlFlow<()>,
) -> Result<Option<Vec<Measurement>>, BackendError> {
    let sums_all = sums_all(backend, settings);
    let measured = if settings.sampling.decide_early && sums_all {
        early::measure(backend, settings, instances, progress)?
    } else {
        whole_run::measure(backend, settings, instances, Start::default(), progress)?
    };
    let Some(mut measured) = measured else {
        return Ok(None);
    };
    if sums_all {
        undriven::measure_limit_cycles(backend, settings, instances, &mut measured)?;
    }
    Ok(Some(measured))
}
