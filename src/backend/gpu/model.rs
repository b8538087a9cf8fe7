//! The differences between the two models on a GPU: [`Reduced`](super::reduced::Reduced), of constant contact pressure, and [`Rubbed`](super::rubbed::Rubbed), with frictional
//! heat and wear.
//!
//! Owns the contract between a model and a batch, whose handling is the same for both models. A model consists of the layout of
//! its buffers, the shader of its scheme, and the code that writes and reads its buffers.

use super::buffers::Buffers;
use super::context::GpuContext;
use super::layout::Binding;
use super::pacer::Pace;
use super::shader_source::{Kernel, Lanes, Shape};
use crate::backend::{BackendError, EndState, Instance, Slice, Sums};
use crate::experiment::Settings;

/// The model of a batch.
pub(super) trait Model: Send {
    /// The buffers that group 0 of its shader binds.
    fn bindings(&self) -> &'static [Binding];

    /// The shape of a thread's data, on an adapter for which `lanes` is best.
    fn shape(&self, lanes: Lanes) -> Shape;

    fn pace(&self) -> Pace;

    /// The kernel for the first periods of a slice, and the number of these periods. The slice has at least one period; another
    /// kernel may be needed for the rest.
    fn kernel(&self, slice: &Slice) -> (Kernel, u32);

    /// Writes a batch at the beginning of its run. The memory of stroboscopic states needs no clearing: kernels read only the
    /// states that they have written.
    fn fill(&self, context: &GpuContext, buffers: &Buffers, settings: &Settings, instances: &[Instance]);

    /// Reads the sums of the first `count` instances and sets them to zero.
    fn take_sums(&self, context: &GpuContext, buffers: &Buffers, count: usize) -> Result<Vec<Sums>, BackendError>;

    /// The end states of the first `count` instances.
    fn end_states(&self, context: &GpuContext, buffers: &Buffers, count: usize) -> Result<Vec<EndState>, BackendError>;
}
