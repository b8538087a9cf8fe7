//! Data that host and device share in memory in every model: the span of a dispatch, and the description of each buffer of a
//! model.
//!
//! Owns the size of a buffer; the layout of each model tells the contents of its buffers.

use bytemuck::{Pod, Zeroable};

use crate::dynamics::{statistics, stroboscope};
use crate::experiment::Settings;

/// The number of the binding of [`Span`]: it is the same in every model.
pub(super) const SPAN: u32 = 1;

/// The part of a slice that one dispatch carries out.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Span {
    pub first_instance: u32,
    pub instances: u32,
    pub first: u32,
    pub periods: u32,
    pub elapsed: u32,
    pub watched: u32,
}

/// How kernels use a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    Uniform,
    Read,
    /// Kernels write it, and the host reads it.
    ReadWrite,
    /// Kernels write it for themselves alone.
    Kept,
}

/// How many elements a buffer has.
#[derive(Clone, Copy, Debug)]
pub(super) enum Count {
    One,
    /// One for each measured period.
    Periods,
    /// One for each instance.
    Instances,
    /// As many for each instance as the function returns.
    OfInstance(fn(&Settings) -> usize),
}

/// A buffer that the kernels of a model are bound to.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    /// Number of the binding within group 0 of the shader.
    pub number: u32,
    /// Name of the buffer in the shader.
    pub name: &'static str,
    pub access: Access,
    /// Bytes of an element.
    element: usize,
    count: Count,
}

impl Binding {
    /// A buffer of elements `T`.
    pub(super) const fn of<T>(number: u32, name: &'static str, access: Access, count: Count) -> Self {
        Self {
            number,
            name,
            access,
            element: size_of::<T>(),
            count,
        }
    }

    /// Bytes of one element: a device must be able to bind at least as many.
    pub(super) fn element(&self) -> u64 {
        self.element as u64
    }

    /// Bytes for one instance; 0 if instances have no elements of their own.
    pub(super) fn share(&self, settings: &Settings) -> u64 {
        let elements = match self.count {
            Count::One | Count::Periods => 0,
            Count::Instances => 1,
            Count::OfInstance(elements) => elements(settings),
        };
        (elements * self.element) as u64
    }

    /// Bytes for a batch of `instances` instances.
    pub(super) fn size(&self, settings: &Settings, instances: usize) -> u64 {
        match self.count {
            Count::One => self.element(),
            Count::Periods => u64::from(settings.sampling.periods) * self.element(),
            // a binding has one element at least
            Count::Instances | Count::OfInstance(_) => instances.max(1) as u64 * self.share(settings),
        }
    }

    /// Whether the host reads the buffer.
    pub(super) fn is_read_back(&self) -> bool {
        self.access == Access::ReadWrite
    }
}

/// Number of last stroboscopic states that are kept of an instance; each is an element with x and y.
pub(super) fn last_states(settings: &Settings) -> usize {
    stroboscope::most_states(settings.sampling.max_period) as usize
}

/// Heat modes of an instance: `modes` and the lumped one.
pub(super) fn slots(modes: u32) -> u32 {
    modes + 1
}

/// The weights of the Birkhoff average in f32, as a device takes them.
pub(super) fn birkhoff_weights(settings: &Settings) -> Vec<f32> {
    let weights = statistics::birkhoff_weights(settings.sampling.periods);
    weights.into_iter().map(|weight| weight as f32).collect()
}
