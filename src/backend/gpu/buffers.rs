//! The device memory of a batch, for every model.
//!
//! Owns the buffers, and the transfer of their contents to the device and back; the model knows what the contents mean.

use bytemuck::Pod;
use wgpu::BufferUsages;

use super::context::GpuContext;
use super::layout::{Access, Binding};
use crate::backend::BackendError;
use crate::experiment::Settings;

/// The buffers that a model's kernels are bound to, and a staging buffer through which the host reads them.
#[expect(clippy::struct_field_names, reason = "the struct is named after its main field")]
pub(super) struct Buffers {
    bindings: &'static [Binding],
    /// In the order of the bindings.
    buffers: Vec<wgpu::Buffer>,
    staging: wgpu::Buffer,
    group: wgpu::BindGroup,
}

impl Buffers {
    /// Allocates the buffers for a batch of `instances` instances; fails if one cannot be allocated.
    pub fn new(
        context: &GpuContext,
        layout: &wgpu::BindGroupLayout,
        bindings: &'static [Binding],
        settings: &Settings,
        instances: usize,
    ) -> Result<Self, BackendError> {
        let buffer = |label, size, usage| {
            context.device().create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let buffers: Vec<_> = bindings
            .iter()
            .map(|binding| buffer(binding.name, binding.size(settings, instances), usage(binding.access)))
            .collect();
        let read_back = bindings.iter().filter(|binding| binding.is_read_back());
        let largest = read_back.map(|binding| binding.size(settings, instances)).max();
        let staging = buffer(
            "staging",
            largest.expect("a model's kernels tell something"),
            BufferUsages::MAP_READ | BufferUsages::COPY_DST,
        );
        let entries = bindings.iter().zip(&buffers);
        let entries: Vec<_> = entries
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding: binding.number,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        let group = context.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("batch"),
            layout,
            entries: &entries,
        });
        context.check()?;
        Ok(Self {
            bindings,
            buffers,
            staging,
            group,
        })
    }

    /// Whether these buffers belong to a model with these bindings, and are large enough for a batch of `instances`.
    pub fn hold(&self, bindings: &'static [Binding], settings: &Settings, instances: usize) -> bool {
        let fits = |(binding, buffer): (&Binding, &wgpu::Buffer)| binding.size(settings, instances) <= buffer.size();
        std::ptr::eq(self.bindings, bindings) && bindings.iter().zip(&self.buffers).all(fits)
    }

    pub fn group(&self) -> &wgpu::BindGroup {
        &self.group
    }

    fn buffer(&self, number: u32) -> &wgpu::Buffer {
        let place = self.bindings.iter().position(|binding| binding.number == number);
        &self.buffers[place.expect("a model asks for its own bindings")]
    }

    /// Writes the first elements of a buffer.
    pub fn write<T: Pod>(&self, context: &GpuContext, number: u32, elements: &[T]) {
        let bytes = bytemuck::cast_slice(elements);
        context.queue().write_buffer(self.buffer(number), 0, bytes);
    }

    /// Sets buffers to zero.
    pub fn clear(&self, context: &GpuContext, numbers: &[u32]) {
        let mut encoder = context
            .device()
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for &number in numbers {
            encoder.clear_buffer(self.buffer(number), 0, None);
        }
        context.queue().submit([encoder.finish()]);
    }

    /// The first `count` elements of a buffer.
    pub fn read<T: Pod>(&self, context: &GpuContext, number: u32, count: usize) -> Result<Vec<T>, BackendError> {
        self.read_then(context, number, count, |_, _| ())
    }

    /// Reads the first `count` elements of a buffer and sets the buffer to zero.
    pub fn take<T: Pod>(&self, context: &GpuContext, number: u32, count: usize) -> Result<Vec<T>, BackendError> {
        self.read_then(context, number, count, |encoder, buffer| {
            encoder.clear_buffer(buffer, 0, None);
        })
    }

    /// Reads the first `count` elements of a buffer, then carries out the commands that `after` encodes.
    fn read_then<T: Pod>(
        &self,
        context: &GpuContext,
        number: u32,
        count: usize,
        after: impl FnOnce(&mut wgpu::CommandEncoder, &wgpu::Buffer),
    ) -> Result<Vec<T>, BackendError> {
        if count == 0 {
            return Ok(Vec::new());
        }
        let (buffer, size) = (self.buffer(number), (count * size_of::<T>()) as u64);
        let mut encoder = context
            .device()
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &self.staging, 0, size);
        after(&mut encoder, buffer);
        context.queue().submit([encoder.finish()]);
        let staged = self.staging.slice(..size);
        // `get_mapped_range` below fails if the buffer was not mapped
        staged.map_async(wgpu::MapMode::Read, |_| ());
        context.wait()?;
        let elements = staged
            .get_mapped_range()
            .map(|bytes| bytemuck::pod_collect_to_vec(&bytes))
            .map_err(|error| BackendError::Internal(error.to_string()))?;
        self.staging.unmap();
        Ok(elements)
    }
}

fn usage(access: Access) -> BufferUsages {
    BufferUsages::COPY_DST
        | match access {
            Access::Uniform => BufferUsages::UNIFORM,
            Access::Read | Access::ReadWrite | Access::Kept => BufferUsages::STORAGE | BufferUsages::COPY_SRC,
        }
}
