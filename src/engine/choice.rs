//! Which backend an experiment runs on, and why.
//!
//! Owns the meaning of `auto`, `gpu` and `cpu`; integrates nothing.

use super::Backends;
use crate::backend::cpu::CpuBackend;
use crate::backend::{BackendError, BackendKind};
use crate::experiment::{BackendChoice, Experiment, Precision};

/// The chosen backend with its fall-back, and the reason for the choice in a sentence.
pub struct Choice {
    /// A GPU that `auto` chose has the CPU as its fall-back; the other choices have none.
    pub backends: Backends,
    /// Without a capital letter and a full stop, such as "the CPU was asked for".
    pub reason: String,
}

/// Chooses by the experiment's device and number type. `auto` chooses a hardware GPU if there is one that can carry the
/// experiment, with the CPU as its fall-back; else it chooses the CPU. It never chooses a software adapter.
///
/// # Errors
/// With `gpu`, if there is no suitable adapter; with `auto`, if no adapter has the requested name.
pub fn choose(experiment: &Experiment) -> Result<Choice, BackendError> {
    let (precision, device) = (experiment.settings.integration.precision, &experiment.device);
    let adapter = device.adapter.as_deref();
    let cpu = || Box::new(CpuBackend::new(precision.unwrap_or(Precision::F64)));
    let on_cpu = |reason: String| Choice {
        backends: Backends::new(cpu(), None),
        reason,
    };
    match device.backend {
        BackendChoice::Cpu => Ok(on_cpu("the CPU was asked for".into())),
        BackendChoice::Gpu => gpu::asked_for(adapter),
        BackendChoice::Auto => {
            if precision == Some(Precision::F64) {
                return Ok(on_cpu("f64 was asked for, which only the CPU has".into()));
            }
            if let Err(error) = experiment.check_f32() {
                return Ok(on_cpu(error.to_string()));
            }
            let found = gpu::if_there(adapter, cpu())?;
            Ok(found.unwrap_or_else(on_cpu))
        }
    }
}

/// All that an experiment can run on at once: every hardware GPU where [`choose`] takes one, else what it chooses.
///
/// # Errors
/// As [`choose`].
pub fn choose_all(experiment: &Experiment) -> Result<(Vec<Backends>, String), BackendError> {
    let Choice { backends, reason } = choose(experiment)?;
    let mut all = vec![backends];
    let device = &experiment.device;
    if device.backend == BackendChoice::Auto && all[0].active().kind() == BackendKind::GpuF32 {
        let precision = experiment.settings.integration.precision.unwrap_or(Precision::F64);
        let others = gpu::all(device.adapter.as_deref(), &|| Box::new(CpuBackend::new(precision)));
        if others.len() > 1 {
            all = others;
        }
    }
    Ok((all, reason))
}

#[cfg(feature = "gpu")]
mod gpu {
    //! GPUs that can be chosen.

    use super::Choice;
    use crate::backend::gpu::{GpuBackend, GpuContext, adapters};
    use crate::backend::{Backend, BackendError};
    use crate::engine::Backends;

    /// The adapter with this in its name, or the best one if no name is given. It may be a software adapter.
    pub fn asked_for(adapter: Option<&str>) -> Result<Choice, BackendError> {
        let gpu = GpuBackend::new(GpuContext::open(adapter, true)?);
        Ok(Choice {
            backends: Backends::new(Box::new(gpu), None),
            reason: "a GPU was asked for".into(),
        })
    }

    /// All hardware GPUs, each with a fall-back.
    pub fn all(adapter: Option<&str>, fallback: &dyn Fn() -> Box<dyn Backend>) -> Vec<Backends> {
        let contexts = GpuContext::open_all(adapter).into_iter();
        contexts
            .map(|context| Backends::new(Box::new(GpuBackend::new(context)), Some(fallback())))
            .collect()
    }

    /// A hardware GPU with a fall-back, or the reason why there is none.
    pub fn if_there(adapter: Option<&str>, fallback: Box<dyn Backend>) -> Result<Result<Choice, String>, BackendError> {
        if let Some(name) = adapter
            && !adapters().iter().any(|adapter| adapter.is_named(name))
        {
            return Err(BackendError::Unsupported(format!(
                "no GPU adapter has `{name}` in its name; `tribochaos devices` lists those that are there"
            )));
        }
        Ok(match GpuContext::open(adapter, false) {
            Ok(context) => {
                let gpu = GpuBackend::new(context);
                let reason = format!("a hardware GPU is there: {}", gpu.device());
                Ok(Choice {
                    backends: Backends::new(Box::new(gpu), Some(fallback)),
                    reason,
                })
            }
            Err(BackendError::NoDevice(_)) => Err("no hardware GPU was found".into()),
            Err(error) => Err(error.to_string()),
        })
    }
}

#[cfg(not(feature = "gpu"))]
mod gpu {
    //! A build without GPUs.

    use super::{Backends, Choice};
    use crate::backend::{Backend, BackendError};

    const NONE: &str = "this build has no GPU backend: it was made without the feature `gpu`";

    pub fn asked_for(_adapter: Option<&str>) -> Result<Choice, BackendError> {
        Err(BackendError::Unsupported(NONE.into()))
    }

    pub fn all(_adapter: Option<&str>, _fallback: &dyn Fn() -> Box<dyn Backend>) -> Vec<Backends> {
        Vec::new()
    }

    #[expect(clippy::unnecessary_wraps, reason = "the same signature as with GPUs")]
    pub fn if_there(
        _adapter: Option<&str>,
        _fallback: Box<dyn Backend>,
    ) -> Result<Result<Choice, String>, BackendError> {
        Ok(Err(NONE.into()))
    }
}
