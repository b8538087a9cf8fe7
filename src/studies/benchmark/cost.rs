//! What an instance-period costs.
//!
//! Owns the run that is timed. It uses the same code as the points of a map: the driver, with sums collected and evaluated.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use super::median;
use crate::backend::{Backend, BackendError, Instance};
use crate::experiment::{Sampling, Settings};
use crate::measure::measure_batch;
use crate::parameters::ParameterSet;

/// Nanoseconds that one forcing period of one instance takes.
#[derive(Clone, Copy, Debug)]
pub struct Cost {
    pub motion_alone: f64,
    /// With tangent vectors and everything that is measured.
    pub with_vectors: f64,
}

impl Cost {
    /// The mean of a period with vectors and one without.
    pub fn mean(&self) -> f64 {
        0.5 * (self.motion_alone + self.with_vectors)
    }

    /// The median of each of the two costs; NaN if there are none.
    pub fn median(costs: &[Self]) -> Self {
        Self {
            motion_alone: median(costs.iter().map(|cost| cost.motion_alone)),
            with_vectors: median(costs.iter().map(|cost| cost.with_vectors)),
        }
    }
}

/// Times a run of `settings.sampling.transient_periods` of the motion alone and `sampling.periods` with tangent vectors, at full
/// length, without the search for cycles at its end.
///
/// # Errors
/// If the backend fails.
pub fn cost(backend: &mut dyn Backend, settings: &Settings, points: &[ParameterSet]) -> Result<Cost, BackendError> {
    let settings = Settings {
        sampling: Sampling {
            align_periods: 0,
            decide_early: false,
            ..settings.sampling
        },
        ..*settings
    };
    let per_instance_period =
        |time: Duration, periods: u32| time.as_nanos() as f64 / (f64::from(periods) * points.len() as f64);
    let instance_periods = |periods: u32| u64::from(periods) * points.len() as u64;
    let transient = instance_periods(settings.sampling.transient_periods);
    let all = transient + instance_periods(settings.sampling.periods);
    let instances = Instance::starts(points);
    // The time is taken where the last period ends. A search for cycles may follow, which takes as long after few periods as after
    // many.
    let (mut done, mut halfway, mut whole) = (0, Duration::ZERO, Duration::ZERO);
    let started = Instant::now();
    measure_batch(backend, &settings, &instances, &mut |instance_periods| {
        done += instance_periods;
        if done == transient {
            halfway = started.elapsed();
        }
        if done == all {
            whole = started.elapsed();
        }
        ControlFlow::Continue(())
    })?;
    Ok(Cost {
        motion_alone: per_instance_period(halfway, settings.sampling.transient_periods),
        with_vectors: per_instance_period(whole.saturating_sub(halfway), settings.sampling.periods),
    })
}
