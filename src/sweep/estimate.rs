//! How long a sweep will take, by trying.

use std::time::Instant;

use crate::backend::{Backend, BackendError, Slice, Stage};
use crate::experiment::Experiment;

/// Seconds that the experiment takes on the backend, extrapolated from a few periods of one batch.
///
/// # Errors
/// If the backend fails.
pub fn seconds(backend: &mut dyn Backend, experiment: &Experiment) -> Result<f64, BackendError> {
    let settings = &experiment.settings;
    let points = experiment.grid.len();
    // points from all over the grid: they may differ in cost
    let sample = backend.batch_size().min(points);
    let instances: Vec<_> = (0..sample)
        .map(|i| experiment.grid.point(i * (points / sample)))
        .collect();
    backend.load(settings, &instances)?;
    let mut elapsed = 0;
    let mut seconds_per_period = |stage| {
        // the first period warms up
        let mut seconds = 0.0;
        for first in 0..2 {
            let started = Instant::now();
            backend.advance(&Slice {
                stage,
                first,
                periods: 1,
                elapsed,
            })?;
            elapsed += 1;
            seconds = started.elapsed().as_secs_f64();
        }
        Ok::<_, BackendError>(seconds)
    };
    let plain = seconds_per_period(Stage::Transient)?;
    let tangent = seconds_per_period(Stage::Measure)?;
    let plain_periods = f64::from(settings.transient_periods - settings.align_periods);
    let tangent_periods = f64::from(settings.align_periods + settings.periods);
    let batches = points as f64 * f64::from(settings.initial_states) / sample as f64;
    Ok(batches * (plain * plain_periods + tangent * tangent_periods))
}
