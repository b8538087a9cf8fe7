//! The device memory of a batch.
//!
//! Owns the buffers, their filling and their reading back; decides nothing of what is dispatched.

use bytemuck::Pod;
use wgpu::BufferUsages;

use super::context::GpuContext;
use super::layout::{self, DRIVE_ENTRIES, Orbit, Parameters, Run, Span, Tangent, Totals, binding};
use crate::backend::BackendError;
use crate::dynamics::statistics;
use crate::experiment::{Scheme, Settings};
use crate::parameters::ParameterSet;

/// Buffers for a batch of up to `instances`, measured over up to `periods`, of each of which so many bytes of states are kept.
pub struct Buffers {
    instances: usize,
    periods: u32,
    states: usize,
    run: wgpu::Buffer,
    span: wgpu::Buffer,
    drive: wgpu::Buffer,
    birkhoff_weights: wgpu::Buffer,
    parameters: wgpu::Buffer,
    orbits: wgpu::Buffer,
    tangents: wgpu::Buffer,
    totals: wgpu::Buffer,
    staging: wgpu::Buffer,
    bindings: wgpu::BindGroup,
}

impl Buffers {
    /// Allocates; what cannot be allocated is an error.
    pub fn new(context: &GpuContext, instances: usize, settings: &Settings) -> Result<Self, BackendError> {
        let (periods, states) = (settings.periods, layout::last_states_size(settings));
        let buffer = |label, size: usize, usage| {
            context.device().create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: size as u64,
                usage,
                mapped_at_creation: false,
            })
        };
        let uniform = |label, size| buffer(label, size, BufferUsages::UNIFORM | BufferUsages::COPY_DST);
        let storage = |label, size| {
            let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
            buffer(label, size, usage)
        };
        // a binding has one element at least
        let count = instances.max(1);
        let run = uniform("run", size_of::<Run>());
        let span = uniform("span", size_of::<Span>());
        let drive = uniform("drive", DRIVE_ENTRIES * size_of::<[f32; 4]>());
        let birkhoff_weights = storage("birkhoff_weights", periods as usize * size_of::<f32>());
        let parameters = storage("parameters", count * size_of::<Parameters>());
        let orbits = storage("orbits", count * size_of::<Orbit>());
        let tangents = storage("tangents", count * size_of::<Tangent>());
        let totals = storage("totals", count * size_of::<Totals>());
        let last_states = storage("last_states", count * states);
        let staging = buffer(
            "staging",
            count * size_of::<Orbit>().max(size_of::<Totals>()),
            BufferUsages::MAP_READ | BufferUsages::COPY_DST,
        );
        let bindings = context.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("batch"),
            layout: context.pipelines().layout(),
            entries: &[
                entry(binding::RUN, &run),
                entry(binding::SPAN, &span),
                entry(binding::DRIVE, &drive),
                entry(binding::BIRKHOFF_WEIGHTS, &birkhoff_weights),
                entry(binding::PARAMETERS, &parameters),
                entry(binding::ORBITS, &orbits),
                entry(binding::TANGENTS, &tangents),
                entry(binding::TOTALS, &totals),
                entry(binding::LAST_STATES, &last_states),
            ],
        });
        context.check()?;
        Ok(Self {
            instances,
            periods,
            states,
            run,
            span,
            drive,
            birkhoff_weights,
            parameters,
            orbits,
            tangents,
            totals,
            staging,
            bindings,
        })
    }

    /// Whether a batch fits.
    pub fn hold(&self, instances: usize, settings: &Settings) -> bool {
        let states = layout::last_states_size(settings);
        self.instances >= instances && self.periods >= settings.periods && self.states >= states
    }

    pub fn bindings(&self) -> &wgpu::BindGroup {
        &self.bindings
    }

    /// Writes a batch at the beginning of its run. The stroboscope's memory needs no clearing: it reads only what it
    /// has written.
    pub fn fill(&self, context: &GpuContext, settings: &Settings, instances: &[ParameterSet]) {
        let parameters: Vec<Parameters> = instances.iter().map(|set| Parameters::new(set, settings)).collect();
        let orbits: Vec<Orbit> = instances.iter().map(Orbit::start).collect();
        let run = Run::new(settings, instances.len() as u32);
        write(context, &self.run, &[run]);
        if settings.scheme() == Scheme::Rk4 {
            write(
                context,
                &self.drive,
                &layout::drive_entries(settings.steps_per_period()),
            );
        }
        write(context, &self.birkhoff_weights, &birkhoff_weights(settings));
        write(context, &self.parameters, &parameters);
        write(context, &self.orbits, &orbits);
        self.set_tangents(context, &vec![[1.0, 0.0]; instances.len()]);
        let mut encoder = context.device().create_command_encoder(&Default::default());
        encoder.clear_buffer(&self.totals, 0, None);
        context.queue().submit([encoder.finish()]);
    }

    /// Sets what the next dispatch carries out.
    pub fn set_span(&self, context: &GpuContext, span: Span) {
        write(context, &self.span, &[span]);
    }

    /// Turns the tangent vectors of the first instances.
    pub fn set_tangents(&self, context: &GpuContext, tangents: &[[f64; 2]]) {
        let tangents: Vec<Tangent> = tangents.iter().map(|vector| vector.map(|value| value as f32)).collect();
        write(context, &self.tangents, &tangents);
    }

    /// The orbits and tangent vectors of the first `count` instances.
    pub fn read_orbits(&self, context: &GpuContext, count: usize) -> Result<Vec<(Orbit, Tangent)>, BackendError> {
        let orbits: Vec<Orbit> = read(context, &self.orbits, &self.staging, count, |_| ())?;
        let tangents: Vec<Tangent> = read(context, &self.tangents, &self.staging, count, |_| ())?;
        Ok(orbits.into_iter().zip(tangents).collect())
    }

    /// The totals of the first `count` instances, which begin at zero again.
    pub fn take_totals(&self, context: &GpuContext, count: usize) -> Result<Vec<Totals>, BackendError> {
        read(context, &self.totals, &self.staging, count, |encoder| {
            encoder.clear_buffer(&self.totals, 0, None);
        })
    }
}

/// The weights of the Birkhoff average as a device takes them.
pub fn birkhoff_weights(settings: &Settings) -> Vec<f32> {
    let weights = statistics::birkhoff_weights(settings.periods);
    weights.into_iter().map(|weight| weight as f32).collect()
}

/// Reads `count` elements of a buffer by way of a staging buffer, then does what `after` encodes.
pub fn read<T: Pod>(
    context: &GpuContext,
    buffer: &wgpu::Buffer,
    staging: &wgpu::Buffer,
    count: usize,
    after: impl FnOnce(&mut wgpu::CommandEncoder),
) -> Result<Vec<T>, BackendError> {
    if count == 0 {
        return Ok(Vec::new());
    }
    let size = (count * size_of::<T>()) as u64;
    let mut encoder = context.device().create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(buffer, 0, staging, 0, size);
    after(&mut encoder);
    context.queue().submit([encoder.finish()]);
    let staged = staging.slice(..size);
    // whether it is mapped shows below
    staged.map_async(wgpu::MapMode::Read, |_| ());
    context.wait()?;
    let elements = staged
        .get_mapped_range()
        .map(|bytes| bytemuck::pod_collect_to_vec(&bytes))
        .map_err(|error| BackendError::Internal(error.to_string()))?;
    staging.unmap();
    Ok(elements)
}

pub fn write<T: Pod>(context: &GpuContext, buffer: &wgpu::Buffer, elements: &[T]) {
    context.queue().write_buffer(buffer, 0, bytemuck::cast_slice(elements));
}

pub fn entry(binding: u32, buffer: &wgpu::Buffer) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry {
        binding,
        resource: buffer.as_entire_binding(),
    }
}
