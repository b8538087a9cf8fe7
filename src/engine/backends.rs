//! The backend in use and its fall-back: points become instances, instances become batches, and their measurements become those
//! of points.
//!
//! Owns the order of batches and the fall-back to another backend; stores nothing.

use std::ops::ControlFlow;

use super::{Event, Observer, initial_states};
use crate::backend::{Backend, BackendError, Instance};
use crate::design::Design;
use crate::experiment::{Experiment, Settings};
use crate::measure::{self, Measurement, Status};

/// The limit of an eighth of an experiment on the size of a unit is at least this number of points.
const MIN_SHARE: usize = 4096;
/// Least number of points in a unit.
const MIN_UNIT: usize = 64;
/// Most units of an experiment whose units have several batches.
const MOST_UNITS: usize = 4096;

/// A backend, and another one that takes over if it fails.
pub struct Backends {
    active: Box<dyn Backend>,
    fallback: Option<Box<dyn Backend>>,
}

impl Backends {
    /// `fallback` takes over if `active` fails; without a fall-back, a failure ends the run.
    pub fn new(active: Box<dyn Backend>, fallback: Option<Box<dyn Backend>>) -> Self {
        Self { active, fallback }
    }

    /// The backend in use.
    pub fn active(&self) -> &dyn Backend {
        self.active.as_ref()
    }

    /// The backend in use, for work without the fall-back.
    pub fn active_mut(&mut self) -> &mut dyn Backend {
        self.active.as_mut()
    }

    /// Points in a batch that fills the backend in use.
    pub fn points_per_batch(&self, settings: &Settings) -> usize {
        (self.active.batch_size(settings) / settings.sampling.initial_states as usize).max(1)
    }

    /// Further backends, each without a fall-back, that can work at the same time as the one in use.
    pub fn others(&self) -> Vec<Self> {
        let others = self.active.others().into_iter();
        others.map(|backend| Self::new(backend, None)).collect()
    }

    /// Points in a unit: those of a batch, within two limits. A unit is at most an eighth of a large experiment, since an
    /// interrupted run loses its unfinished units. A store does not consist of very many small units: those of a very large experiment
    /// have several batches.
    pub fn points_per_unit(&self, experiment: &Experiment) -> usize {
        let points = experiment.design.len();
        let batch = self.points_per_batch(&experiment.settings);
        let batches = points.div_ceil(MOST_UNITS).div_ceil(batch);
        (batches * batch).min(points.div_ceil(8).max(MIN_SHARE)).max(MIN_UNIT)
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
        let states = initial_states::offsets(&settings.sampling);
        let mut measurements = Vec::with_capacity(indices.len());
        while measurements.len() < indices.len() {
            let points = self.points_per_batch(settings).min(indices.len() - measurements.len());
            let instances: Vec<_> = indices[measurements.len()..][..points]
                .iter()
                .flat_map(|&index| initial_states::points(design.point(index), &states))
                .map(Instance::from)
                .collect();
            let mut progress = |instance_periods| observer(Event::Advanced(instance_periods));
            match measure_states(self.active.as_mut(), settings, &instances, &mut progress) {
                Ok(None) => return Ok(None),
                Ok(Some(batch)) => measurements.extend(
                    batch
                        .chunks(settings.sampling.initial_states as usize)
                        .map(|chunk| initial_states::combine(chunk, settings.sampling.period_tolerance)),
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

/// Measures a batch. If points have several initial states, the runs that have not settled are carried on.
fn measure_states(
    backend: &mut dyn Backend,
    settings: &Settings,
    instances: &[Instance],
    progress: &mut dyn FnMut(u64) -> ControlFlow<()>,
) -> Result<Option<Vec<Measurement>>, BackendError> {
    let Some(mut measured) = measure::measure_batch(backend, settings, instances, progress)? else {
        return Ok(None);
    };
    let unsettled = initial_states::unsettled(settings, instances, &measured);
    if unsettled.is_empty() {
        return Ok(Some(measured));
    }
    let (indices, begun): (Vec<usize>, Vec<Instance>) = unsettled.into_iter().unzip();
    // 0: the announced total counts only the first runs, and these are done
    let progress = &mut |_| progress(0);
    let longer = initial_states::carried_on(settings);
    let Some(again) = measure::measure_batch(backend, &longer, &begun, progress)? else {
        return Ok(None);
    };
    for (index, again) in indices.into_iter().zip(again) {
        let before = measured[index];
        let kept = if again.status == Status::Ok { again } else { before };
        measured[index] = Measurement {
            integrated_periods: before.integrated_periods + again.integrated_periods,
            ..kept
        };
    }
    Ok(Some(measured))
}
