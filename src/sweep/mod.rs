//! From a design to its measurements: points to instances, instances to batches, batches to a backend, and back.
//!
//! Owns the order of the work, the fall-back to another backend, and cancellation; neither stores nor draws nor prints.

pub mod audit;
pub mod choice;
pub mod estimate;
pub mod initial_states;

use std::ops::ControlFlow;

use crate::backend::{Backend, BackendError};
use crate::design::Design;
use crate::experiment::{Experiment, Settings};
use crate::measure::{self, Measurement, Status};
use crate::parameters::ParameterSet;

/// Instance-periods of `points` points: the work of a sweep.
pub fn instance_periods(settings: &Settings, points: usize) -> u64 {
    points as u64
        * u64::from(settings.initial_states)
        * (u64::from(settings.transient_periods) + u64::from(settings.periods))
}

/// Rows and columns of a map's tiles: whole rows of it if they hold no more than `points`, else parts of one.
pub fn tile_shape(experiment: &Experiment, points: usize) -> [usize; 2] {
    let [x, y] = [0, 1].map(|axis| experiment.design.axes()[axis].count());
    if points >= x {
        [(points / x).min(y), x]
    } else {
        [1, points]
    }
}

/// An eighth of a map is no reason to make tiles smaller than this.
const MIN_SHARE: usize = 4096;
/// Least number of points in a tile.
const MIN_TILE: usize = 64;

/// A backend, and another one that takes over if it fails.
pub struct Backends {
    active: Box<dyn Backend>,
    fallback: Option<Box<dyn Backend>>,
}

/// What a sweep tells while it runs.
pub enum Event<'a> {
    /// So many instance-periods were done since the last event.
    Advanced(u64),
    /// The backend failed; the fall-back goes on from the last finished batch.
    FellBack { error: &'a BackendError, device: &'a str },
}

/// Hears events; may break the sweep off.
pub type Observer<'a> = dyn FnMut(Event<'_>) -> ControlFlow<()> + 'a;

impl Backends {
    pub fn new(active: Box<dyn Backend>, fallback: Option<Box<dyn Backend>>) -> Self {
        Self { active, fallback }
    }

    /// The backend in use.
    pub fn active(&self) -> &dyn Backend {
        self.active.as_ref()
    }

    pub fn active_mut(&mut self) -> &mut dyn Backend {
        self.active.as_mut()
    }

    /// Points in a batch such that the backend in use is filled by one.
    pub fn points_per_batch(&self, settings: &Settings) -> usize {
        (self.active.batch_size(settings) / settings.initial_states as usize).max(1)
    }

    /// Points in a tile: a batch, but no more than an eighth of a large map, since what is not a finished tile is lost when
    /// the run is interrupted, and not so few that the store falls into crumbs.
    pub fn points_per_tile(&self, experiment: &Experiment) -> usize {
        let eighth = experiment.design.len().div_ceil(8).max(MIN_SHARE);
        self.points_per_batch(&experiment.settings).min(eighth).max(MIN_TILE)
    }

    /// Measures the points of a design with the given indices, in their order; None if the observer broke it off.
    ///
    /// # Errors
    /// If the backend fails and no fall-back is left.
    pub fn measure(
        &mut self,
        design: &Design,
        settings: &Settings,
        indices: &[usize],
        observer: &mut Observer<'_>,
    ) -> Result<Option<Vec<Measurement>>, BackendError> {
        let states = initial_states::offsets(settings);
        let mut measurements = Vec::with_capacity(indices.len());
        while measurements.len() < indices.len() {
            let points = self.points_per_batch(settings).min(indices.len() - measurements.len());
            let instances: Vec<_> = indices[measurements.len()..][..points]
                .iter()
                .flat_map(|&index| initial_states::instances(design.point(index), &states))
                .collect();
            let mut progress = |instance_periods| observer(Event::Advanced(instance_periods));
            match measure_states(self.active.as_mut(), settings, &instances, &mut progress) {
                Ok(None) => return Ok(None),
                Ok(Some(batch)) => measurements.extend(
                    batch
                        .chunks(settings.initial_states as usize)
                        .map(|chunk| initial_states::combine(chunk, settings.period_tolerance)),
                ),
                Err(error) => {
                    self.active = self.fallback.take().ok_or_else(|| error.clone())?;
                    let event = Event::FellBack {
                        error: &error,
                        device: &self.active.device(),
                    };
                    if observer(event).is_break() {
                        return Ok(None);
                    }
                }
            }
        }
        Ok(Some(measurements))
    }
}

/// Measures a batch; of several initial states of a point, those that have not settled are carried on.
fn measure_states(
    backend: &mut dyn Backend,
    settings: &Settings,
    instances: &[ParameterSet],
    progress: &mut dyn FnMut(u64) -> ControlFlow<()>,
) -> Result<Option<Vec<Measurement>>, BackendError> {
    let Some(mut measured) = measure::measure_batch(backend, settings, instances, progress)? else {
        return Ok(None);
    };
    let unsettled = initial_states::unsettled(settings, instances, &measured);
    if unsettled.is_empty() {
        return Ok(Some(measured));
    }
    let (indices, begun): (Vec<usize>, Vec<ParameterSet>) = unsettled.into_iter().unzip();
    // what was announced has been done
    let progress = &mut |_| progress(0);
    let longer = initial_states::carried_on(settings);
    let Some(again) = measure::measure_batch(backend, &longer, &begun, progress)? else {
        return Ok(None);
    };
    for (index, again) in indices.into_iter().zip(again) {
        let before = measured[index];
        let kept = if again.status == Status::Ok { again } else { before };
        measured[index] = Measurement {
            initial_state: before.initial_state,
            integrated_periods: before.integrated_periods + again.integrated_periods,
            ..kept
        };
    }
    Ok(Some(measured))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Request;

    #[test]
    fn tiles_are_whole_rows_or_parts_of_one() {
        let experiment = Request::default().resolve().unwrap();
        assert_eq!(tile_shape(&experiment, 4096), [13, 300]);
        assert_eq!(tile_shape(&experiment, 1 << 20), [201, 300]);
        assert_eq!(tile_shape(&experiment, 299), [1, 299]);
    }
}
