//! What differs between the models that a GPU carries on: [`Reduced`], of constant contact pressure, and [`Rubbed`], with
//! frictional heat and wear.
//!
//! Owns the contract between a batch's one way through the device and its model. A model is the layout of its buffers, the
//! shader of its scheme, and how what is in the buffers is written and read.

use super::buffers::Buffers;
use super::context::GpuContext;
use super::layout::Binding;
use super::pacer::Pace;
use super::reduced::{self, Reduced};
use super::rubbed::{self, Rubbed};
use super::shader_source::{Kernel, Lanes, Shape};
use crate::backend::{BackendError, EndState, Instance, Slice, Sums};
use crate::experiment::{Scheme, Settings};

/// The model of a batch.
pub(super) trait Model: Send {
    /// What group 0 of its shader binds.
    fn bindings(&self) -> &'static [Binding];

    /// What a thread carries, on an adapter that so many lanes suit.
    fn shape(&self, lanes: Lanes) -> Shape;

    fn pace(&self) -> Pace;

    /// The kernel that carries on a slice of one period at least, and through how many of its periods; another one may have
    /// to carry on the rest.
    fn kernel(&self, slice: &Slice) -> (Kernel, u32);

    /// Writes a batch at the beginning of its run. The stroboscope's memory needs no clearing: it reads only what it has
    /// written.
    fn fill(&self, context: &GpuContext, buffers: &Buffers, settings: &Settings, instances: &[Instance]);

    /// Writes what so many instances share of a run.
    fn write_run(&self, context: &GpuContext, buffers: &Buffers, settings: &Settings, instances: usize);

    /// The sums of the first `count` instances, which begin at zero again.
    fn take_sums(&self, context: &GpuContext, buffers: &Buffers, count: usize) -> Result<Vec<Sums>, BackendError>;

    /// What is left of the first `count` instances.
    fn end_states(&self, context: &GpuContext, buffers: &Buffers, count: usize) -> Result<Vec<EndState>, BackendError>;
}

/// The model of a batch of these instances.
///
/// # Errors
/// If its kernels cannot do what the settings ask for.
pub(super) fn of(settings: &Settings, instances: &[Instance]) -> Result<Box<dyn Model>, BackendError> {
    Ok(match settings.integration.scheme {
        Scheme::Rk4 | Scheme::Taylor => Box::new(Reduced::new(settings)?),
        Scheme::Radau => Box::new(Rubbed::new(settings, instances)?),
    })
}

/// What the shader of each model binds.
pub(super) const BINDINGS: [&[Binding]; 2] = [&reduced::layout::BINDINGS, &rubbed::layout::BINDINGS];
