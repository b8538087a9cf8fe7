//! The time that a run will take, estimated from a sample of its points.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use super::{Backends, Event, instance_periods};
use crate::backend::{BackendError, BackendKind};
use crate::experiment::Experiment;

/// A sample that takes at least this time is large enough.
const ENOUGH: Duration = Duration::from_secs(1);
/// A sample that takes longer than this is broken off.
const MOST: Duration = Duration::from_secs(5);

/// Length of each series of neighbouring points in a sample. Neighbours share the lanes of a block, as they do in a run.
const NEIGHBOURS: usize = 32;

/// Seconds that the experiment takes, extrapolated from a sample of its points. The sample comes from all over the design, since
/// the cost changes from point to point. It is measured in full, as all points will be, since the cost of a point changes as its
/// shaft warms up, its contact is lost, or its motion is decided.
///
/// # Errors
/// If the backend fails.
pub fn seconds(backends: &mut Backends, experiment: &Experiment) -> Result<f64, BackendError> {
    let settings = &experiment.settings;
    let points = experiment.design.len();
    let batch = backends.points_per_batch(settings).min(points);
    // a GPU takes as long for a few points as for a batch
    let mut sample = match backends.active().kind() {
        BackendKind::GpuF32 => batch,
        BackendKind::CpuF64 | BackendKind::CpuF32 => (batch / 32).max(1),
    };
    loop {
        let indices = spread(sample, points);
        let started = Instant::now();
        let mut done = 0;
        let finished = backends.measure(&experiment.design, settings, &indices, &mut |event| {
            if let Event::Advanced(instance_periods) = event {
                done += instance_periods;
            }
            if started.elapsed() < MOST {
                ControlFlow::Continue(())
            } else {
                ControlFlow::Break(())
            }
        })?;
        let elapsed = started.elapsed();
        if finished.is_some() && elapsed < ENOUGH && sample < batch {
            sample = (4 * sample).min(batch);
            continue;
        }
        let share = match finished {
            Some(_) => indices.len() as f64 / points as f64,
            None => done as f64 / instance_periods(settings, points) as f64,
        };
        return Ok(elapsed.as_secs_f64() / share);
    }
}

/// Indices of about `sample` of the points: series of neighbours from all over the design.
fn spread(sample: usize, points: usize) -> Vec<usize> {
    let runs = sample.div_ceil(NEIGHBOURS);
    let length = sample.div_ceil(runs);
    (0..runs)
        .flat_map(|run| {
            let first = run * points / runs;
            first..(first + length).min((run + 1) * points / runs)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_has_its_size_and_comes_from_all_over_the_grid() {
        for (sample, points) in [(1, 1), (5, 7), (64, 64), (128, 60_300), (1000, 1001)] {
            let indices = spread(sample, points);
            assert!(
                indices.len().abs_diff(sample) <= sample.div_ceil(NEIGHBOURS),
                "{}",
                indices.len()
            );
            assert!(indices.is_sorted_by(|a, b| a < b) && indices.iter().all(|index| *index < points));
        }
        assert_eq!(spread(64, 6400).into_iter().filter(|index| *index >= 3200).count(), 32);
        assert_eq!(spread(64, 64), (0..64).collect::<Vec<_>>());
    }
}
