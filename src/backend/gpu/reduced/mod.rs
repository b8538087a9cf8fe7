//! The reduced model on a GPU: bushes of constant contact pressure, by `taylor` or `rk4`.
//!
//! Owns what its buffers are filled with, which of its kernels carries a period on, and how results are read.

pub mod layout;
pub(super) mod shader_source;

use self::layout::{MAX_STEPS_PER_PERIOD, Orbit, Parameters, Run, Tangent, Totals, binding};
use super::buffers::Buffers;
use super::context::GpuContext;
use super::layout::{Binding, birkhoff_weights};
use super::model::Model;
use super::pacer::Pace;
use super::shader_source::{Kernel, Lanes, Shape};
use crate::backend::{BackendError, EndState, Instance, Slice, Stage, Sums};
use crate::dynamics::divergence_check::{alike, is_checked};
use crate::experiment::{Scheme, Settings};

/// A batch's model.
pub(super) struct Reduced {
    steps_per_period: u32,
}

impl Reduced {
    /// # Errors
    /// If a period has more steps than the drive table.
    pub fn new(settings: &Settings) -> Result<Self, BackendError> {
        let steps_per_period = settings.integration.steps_per_period;
        if settings.integration.scheme == Scheme::Rk4 && steps_per_period > MAX_STEPS_PER_PERIOD {
            return Err(BackendError::Unsupported(format!(
                "{steps_per_period} steps a period are more than the {MAX_STEPS_PER_PERIOD} that the GPU's drive table \
                 holds: use --backend cpu or fewer --steps-per-period"
            )));
        }
        Ok(Self { steps_per_period })
    }
}

impl Model for Reduced {
    fn bindings(&self) -> &'static [Binding] {
        &layout::BINDINGS
    }

    fn shape(&self, lanes: Lanes) -> Shape {
        Shape { lanes, modes: None }
    }

    fn pace(&self) -> Pace {
        Pace {
            steps_per_period: self.steps_per_period,
            most_periods: u32::MAX,
            is_lasting: true,
        }
    }

    fn kernel(&self, slice: &Slice) -> (Kernel, u32) {
        match slice.stage {
            Stage::Transient | Stage::Watch => (Kernel::Plain, slice.periods),
            Stage::Measure if is_checked(slice.first) => (Kernel::Checked, 1),
            Stage::Measure => (Kernel::Tangent, alike(slice.first).min(slice.periods)),
            Stage::Check => (Kernel::Checked, slice.periods),
            Stage::Align | Stage::Linearise => (Kernel::Tangent, slice.periods),
        }
    }

    fn fill(&self, context: &GpuContext, buffers: &Buffers, settings: &Settings, instances: &[Instance]) {
        let points = instances.iter().map(|instance| &instance.parameters);
        let parameters: Vec<Parameters> = points.map(|set| Parameters::new(set, settings)).collect();
        let orbits: Vec<Orbit> = instances.iter().map(Orbit::start).collect();
        let vectors = instances.iter().map(|instance| instance.tangent);
        let tangents: Vec<Tangent> = vectors.map(|vector| vector.map(|value| value as f32)).collect();
        buffers.write(context, binding::RUN, &[Run::new(settings, instances.len() as u32)]);
        buffers.write(context, binding::BIRKHOFF_WEIGHTS, &birkhoff_weights(settings));
        if settings.integration.scheme == Scheme::Rk4 {
            buffers.write(context, binding::DRIVE, &layout::drive_entries(self.steps_per_period));
        }
        buffers.write(context, binding::PARAMETERS, &parameters);
        buffers.write(context, binding::ORBITS, &orbits);
        buffers.write(context, binding::TANGENTS, &tangents);
        buffers.clear(context, &[binding::TOTALS]);
    }

    fn take_sums(&self, context: &GpuContext, buffers: &Buffers, count: usize) -> Result<Vec<Sums>, BackendError> {
        let totals: Vec<Totals> = buffers.take(context, binding::TOTALS, count)?;
        Ok(totals.into_iter().map(Sums::from).collect())
    }

    fn end_states(&self, context: &GpuContext, buffers: &Buffers, count: usize) -> Result<Vec<EndState>, BackendError> {
        let orbits: Vec<Orbit> = buffers.read(context, binding::ORBITS, count)?;
        let tangents: Vec<Tangent> = buffers.read(context, binding::TANGENTS, count)?;
        Ok(orbits.into_iter().zip(tangents).map(EndState::from).collect())
    }
}
