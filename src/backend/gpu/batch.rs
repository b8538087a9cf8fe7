//! A batch on a device, for every model.
//!
//! Owns the division of a slice into dispatches, and each dispatch; the model knows what the kernels compute, and from what.

use std::time::{Duration, Instant};

use super::buffers::Buffers;
use super::context::{GpuContext, WORKGROUP_SIZE};
use super::kernels::{Compiled, Kernels};
use super::layout::{SPAN, Span};
use super::model::Model;
use super::pacer::Load;
use crate::backend::{BackendError, EndState, Instance, Slice, Sums};
use crate::experiment::{Scheme, Settings};

/// Instances that are carried on together, and their memory on a device.
pub(super) struct GpuBatch {
    model: Box<dyn Model>,
    scheme: Scheme,
    buffers: Buffers,
    load: Load,
}

impl GpuBatch {
    /// A batch at the beginning of its run, in buffers that hold it.
    pub fn new(
        context: &GpuContext,
        model: Box<dyn Model>,
        buffers: Buffers,
        kernels: &mut Kernels,
        settings: &Settings,
        instances: &[Instance],
    ) -> Self {
        let load = Load {
            pace: model.pace(),
            instances: instances.len() as u32,
            workgroup_instances: WORKGROUP_SIZE * kernels.shape().lanes.count(),
            max_workgroups: context.device().limits().max_compute_workgroups_per_dimension,
        };
        if !load.pace.is_lasting {
            kernels.forget_pace();
        }
        model.fill(context, &buffers, settings, instances);
        Self {
            model,
            scheme: settings.integration.scheme,
            buffers,
            load,
        }
    }

    /// The scheme that advances the batch.
    pub fn scheme(&self) -> Scheme {
        self.scheme
    }

    /// The memory of a batch that is no longer needed.
    pub fn into_buffers(self) -> Buffers {
        self.buffers
    }

    /// Advances the batch by a slice, in as many dispatches as that takes.
    pub fn advance(&self, context: &GpuContext, kernels: &mut Kernels, slice: &Slice) -> Result<(), BackendError> {
        let mut left = *slice;
        while left.periods > 0 {
            let (kernel, periods) = self.model.kernel(&left);
            let Compiled { pipeline, pacer, .. } = kernels.kernel(kernel);
            let alike = Slice { periods, ..left };
            pacer.dispatch(&self.load, &alike, |span| self.dispatch(context, pipeline, span))?;
            left.first += periods;
            left.elapsed += periods;
            left.periods -= periods;
        }
        Ok(())
    }

    /// Carries out one dispatch; returns how long it took.
    fn dispatch(
        &self,
        context: &GpuContext,
        pipeline: &wgpu::ComputePipeline,
        span: Span,
    ) -> Result<Duration, BackendError> {
        let started = Instant::now();
        self.buffers.write(context, SPAN, &[span]);
        let mut encoder = context
            .device()
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, self.buffers.group(), &[]);
        pass.dispatch_workgroups(span.instances.div_ceil(self.load.workgroup_instances), 1, 1);
        drop(pass);
        context.queue().submit([encoder.finish()]);
        context.wait()?;
        Ok(started.elapsed())
    }

    pub fn take_sums(&self, context: &GpuContext) -> Result<Vec<Sums>, BackendError> {
        self.model
            .take_sums(context, &self.buffers, self.load.instances as usize)
    }

    pub fn end_states(&self, context: &GpuContext) -> Result<Vec<EndState>, BackendError> {
        self.model
            .end_states(context, &self.buffers, self.load.instances as usize)
    }
}
