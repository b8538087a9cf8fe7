//! The device memory of a batch of the full model.
//!
//! Owns the buffers, their filling and their reading back; decides nothing of what is dispatched.

use wgpu::BufferUsages;

use super::super::buffers::{birkhoff_weights, entry, read, write};
use super::super::context::GpuContext;
use super::super::layout::{Span, last_states_size};
use super::layout::{self, HeatMode, Orbit, Parameters, Run, Totals, binding};
use super::pipelines::Pipelines;
use crate::backend::BackendError;
use crate::experiment::Settings;
use crate::model::rubbing::Spectra;
use crate::parameters::ParameterSet;

/// Bytes of an instance in the buffer that has most of them.
pub fn largest_share(settings: &Settings, modes: u32) -> u64 {
    let heat_modes = layout::slots(modes) * size_of::<HeatMode>();
    last_states_size(settings).max(heat_modes) as u64
}

/// Buffers for a batch of up to `instances` with `modes` heat modes, measured over up to `periods`, of each of which so many
/// bytes of states are kept.
pub struct Buffers {
    instances: usize,
    modes_each: u32,
    periods: u32,
    states: usize,
    run: wgpu::Buffer,
    span: wgpu::Buffer,
    birkhoff_weights: wgpu::Buffer,
    parameters: wgpu::Buffer,
    heat_modes: wgpu::Buffer,
    modes: wgpu::Buffer,
    orbits: wgpu::Buffer,
    totals: wgpu::Buffer,
    staging: wgpu::Buffer,
    bindings: wgpu::BindGroup,
}

impl Buffers {
    /// Allocates; what cannot be allocated is an error.
    pub fn new(
        context: &GpuContext,
        pipelines: &Pipelines,
        instances: usize,
        settings: &Settings,
    ) -> Result<Self, BackendError> {
        let (periods, states) = (settings.periods, last_states_size(settings));
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
        let slots = count * layout::slots(pipelines.modes());
        let run = uniform("run", size_of::<Run>());
        let span = uniform("span", size_of::<Span>());
        let birkhoff_weights = storage("birkhoff_weights", periods as usize * size_of::<f32>());
        let parameters = storage("parameters", count * size_of::<Parameters>());
        let heat_modes = storage("heat_modes", slots * size_of::<HeatMode>());
        // with those of the tangents
        let modes = storage("modes", 2 * slots * size_of::<f32>());
        let orbits = storage("orbits", count * size_of::<Orbit>());
        let totals = storage("totals", count * size_of::<Totals>());
        let last_states = storage("last_states", count * states);
        let staging = buffer(
            "staging",
            count * size_of::<Orbit>().max(size_of::<Totals>()),
            BufferUsages::MAP_READ | BufferUsages::COPY_DST,
        );
        let bindings = context.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("rubbed batch"),
            layout: pipelines.layout(),
            entries: &[
                entry(binding::RUN, &run),
                entry(binding::SPAN, &span),
                entry(binding::BIRKHOFF_WEIGHTS, &birkhoff_weights),
                entry(binding::PARAMETERS, &parameters),
                entry(binding::HEAT_MODES, &heat_modes),
                entry(binding::MODES, &modes),
                entry(binding::LAST_STATES, &last_states),
                entry(binding::ORBITS, &orbits),
                entry(binding::TOTALS, &totals),
            ],
        });
        context.check()?;
        Ok(Self {
            instances,
            modes_each: pipelines.modes(),
            periods,
            states,
            run,
            span,
            birkhoff_weights,
            parameters,
            heat_modes,
            modes,
            orbits,
            totals,
            staging,
            bindings,
        })
    }

    /// Whether a batch fits.
    pub fn hold(&self, instances: usize, settings: &Settings) -> bool {
        let kernels_fit = self.modes_each == settings.modes();
        let states_fit = self.states >= last_states_size(settings);
        self.instances >= instances && kernels_fit && self.periods >= settings.periods && states_fit
    }

    pub fn bindings(&self) -> &wgpu::BindGroup {
        &self.bindings
    }

    /// Writes a batch at the beginning of its run. The stroboscope's memory needs no clearing: it reads only what it
    /// has written.
    pub fn fill(&self, context: &GpuContext, settings: &Settings, instances: &[ParameterSet]) {
        let slots = layout::slots(settings.modes());
        let mut heat_modes = vec![HeatMode { rate: 0.0, weight: 0.0 }; slots * instances.len()];
        let spectra = Spectra::new(instances, settings.modes() as usize);
        let (parameters, orbits): (Vec<_>, Vec<_>) = instances
            .iter()
            .enumerate()
            .map(|(instance, set)| {
                let heat = spectra.heat_modes(set);
                for slot in 0..slots {
                    heat_modes[slot * instances.len() + instance] = HeatMode {
                        rate: heat.rates[slot] as f32,
                        weight: heat.weights[slot] as f32,
                    };
                }
                (Parameters::new(set, &heat), Orbit::start(set, &heat))
            })
            .unzip();
        self.write_run(context, settings, instances.len());
        write(context, &self.parameters, &parameters);
        write(context, &self.heat_modes, &heat_modes);
        write(context, &self.orbits, &orbits);
        let mut encoder = context.device().create_command_encoder(&Default::default());
        encoder.clear_buffer(&self.modes, 0, None);
        encoder.clear_buffer(&self.totals, 0, None);
        context.queue().submit([encoder.finish()]);
    }

    /// Writes what so many instances share of a run.
    pub fn write_run(&self, context: &GpuContext, settings: &Settings, instances: usize) {
        write(context, &self.run, &[Run::new(settings, instances as u32)]);
        write(context, &self.birkhoff_weights, &birkhoff_weights(settings));
    }

    /// Sets what the next dispatch carries out.
    pub fn set_span(&self, context: &GpuContext, span: Span) {
        write(context, &self.span, &[span]);
    }

    /// The orbits of the first `count` instances.
    pub fn read_orbits(&self, context: &GpuContext, count: usize) -> Result<Vec<Orbit>, BackendError> {
        read(context, &self.orbits, &self.staging, count, |_| ())
    }

    /// The totals of the first `count` instances, which begin at zero again.
    pub fn take_totals(&self, context: &GpuContext, count: usize) -> Result<Vec<Totals>, BackendError> {
        read(context, &self.totals, &self.staging, count, |encoder| {
            encoder.clear_buffer(&self.totals, 0, None);
        })
    }
}
