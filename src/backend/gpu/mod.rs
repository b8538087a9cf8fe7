//! The GPU backend: a lane of a thread an instance, f32, in WGSL through wgpu.
//!
//! Owns the passage of batches through a device; the arithmetic is that of `shaders/`, whose files are twins of the
//! model's and the algorithms' modules.

mod adapter;
mod buffers;
mod context;
pub mod layout;
mod pacer;
mod pipelines;
pub mod rubbed;
pub mod shader_source;

use std::time::{Duration, Instant};

pub use adapter::{AdapterDescription, adapters};
pub use context::GpuContext;

use self::buffers::Buffers;
use self::layout::{MAX_STEPS_PER_PERIOD, Span, last_states_size};
use self::pacer::{Load, Pacer};
use self::rubbed::RubbedBatch;
use self::shader_source::{Kernel, Shader};
use super::{Backend, BackendError, EndState, Slice, Stage, Sums};
use crate::backend::BackendKind;
use crate::dynamics::divergence_check::{alike, is_checked};
use crate::experiment::{MAX_MODES, Scheme, Settings};
use crate::parameters::ParameterSet;

/// Instances that fill the largest devices.
const HARDWARE_BATCH: u64 = 1 << 18;
/// Instances that fill a CPU, few enough for a batch to end within seconds.
const SOFTWARE_BATCH: u64 = 1 << 13;

/// Bytes of the largest buffer of a batch: a small device holds it beside what else it does.
const MOST_STATES: u64 = 1 << 29;

/// Integrates on a GPU.
pub struct GpuBackend {
    context: GpuContext,
    /// One a kernel of each scheme.
    pacers: [[Pacer; Kernel::ALL.len()]; Scheme::ALL.len()],
    /// Of the batch.
    scheme: Scheme,
    buffers: Option<Buffers>,
    load: Load,
    /// Of the full model.
    rubbed: Option<RubbedBatch>,
    /// Whether the batch is one of the full model.
    is_rubbed: bool,
}

impl GpuBackend {
    pub fn new(context: GpuContext) -> Self {
        let load = Load {
            instances: 0,
            steps_per_period: 0,
            workgroup_instances: context.pipelines().workgroup_instances(),
            max_workgroups: context.device().limits().max_compute_workgroups_per_dimension,
            most_periods: u32::MAX,
        };
        Self {
            context,
            pacers: Default::default(),
            scheme: Scheme::Taylor,
            buffers: None,
            load,
            rubbed: None,
            is_rubbed: false,
        }
    }

    pub fn context(&self) -> &GpuContext {
        &self.context
    }

    /// Most instances of a batch: the device limits the size of a buffer, of which each takes a `share` at most.
    fn max_instances(&self, share: u64) -> u64 {
        let limits = self.context.device().limits();
        limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) / share
    }

    fn check(&self, settings: &Settings, instances: &[ParameterSet]) -> Result<(), BackendError> {
        let scheme = settings.scheme();
        if Shader::of(scheme).is_none() {
            return Err(BackendError::Unsupported(format!(
                "the scheme {} has no GPU kernels: use --backend cpu",
                scheme.name()
            )));
        }
        if scheme == Scheme::Rk4 && settings.steps_per_period() > MAX_STEPS_PER_PERIOD {
            return Err(BackendError::Unsupported(format!(
                "{} steps a period are more than the {MAX_STEPS_PER_PERIOD} that the GPU's drive table holds: use \
                 --backend cpu or fewer --steps-per-period",
                settings.steps_per_period()
            )));
        }
        self.check_batch(instances, last_states_size(settings) as u64)
    }

    /// What holds for every scheme; an instance takes a `share` of the largest buffer.
    fn check_batch(&self, instances: &[ParameterSet], share: u64) -> Result<(), BackendError> {
        let most = self.max_instances(share);
        if instances.len() as u64 > most {
            return Err(BackendError::Unsupported(format!(
                "a batch of {} points is larger than the {most} that a buffer of the {} holds: use smaller batches",
                instances.len(),
                self.context.description()
            )));
        }
        Ok(())
    }

    fn buffers(&self) -> &Buffers {
        self.buffers.as_ref().expect("a batch is loaded before it is advanced")
    }

    /// Carries the batch on by a slice through all of whose periods it goes in the same way, in as many dispatches as that
    /// takes.
    fn advance_alike(&mut self, kernel: Kernel, slice: &Slice) -> Result<(), BackendError> {
        let mut pacer = self.pacers[self.scheme as usize][kernel as usize].clone();
        let done = pacer.dispatch(&self.load, slice, |span| self.dispatch(kernel, span));
        self.pacers[self.scheme as usize][kernel as usize] = pacer;
        done
    }

    /// Returns how long it took.
    fn dispatch(&self, kernel: Kernel, span: Span) -> Result<Duration, BackendError> {
        let started = Instant::now();
        let buffers = self.buffers();
        let pipelines = self.context.pipelines();
        buffers.set_span(&self.context, span);
        let mut encoder = self.context.device().create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        let shader = Shader::of(self.scheme).expect("a batch is loaded only for schemes that have a shader");
        pass.set_pipeline(pipelines.kernel(self.context.device(), self.scheme, shader, kernel));
        pass.set_bind_group(0, buffers.bindings(), &[]);
        pass.dispatch_workgroups(span.instances.div_ceil(pipelines.workgroup_instances()), 1, 1);
        drop(pass);
        self.context.queue().submit([encoder.finish()]);
        self.context.wait()?;
        Ok(started.elapsed())
    }
}

impl Backend for GpuBackend {
    fn kind(&self) -> BackendKind {
        BackendKind::GpuF32
    }

    fn device(&self) -> String {
        let adapter = self.context.description();
        format!(
            "GPU {} ({}), {}",
            adapter.name,
            adapter.backend,
            self.kind().precision()
        )
    }

    fn batch_size(&self, settings: &Settings) -> usize {
        let fills = if self.context.description().is_software {
            SOFTWARE_BATCH
        } else {
            HARDWARE_BATCH
        };
        let share = rubbed::largest_share(settings, MAX_MODES);
        fills.min(self.max_instances(share)).min(MOST_STATES / share).max(1) as usize
    }

    fn load(&mut self, settings: &Settings, instances: &[ParameterSet]) -> Result<(), BackendError> {
        self.is_rubbed = settings.scheme() == Scheme::Radau;
        if self.is_rubbed {
            self.check_batch(instances, rubbed::largest_share(settings, settings.modes()))?;
            let before = self.rubbed.take();
            self.rubbed = Some(RubbedBatch::new(&self.context, before, self.load, settings, instances)?);
            return Ok(());
        }
        self.check(settings, instances)?;
        let fits = |buffers: &Buffers| buffers.hold(instances.len(), settings);
        if !self.buffers.as_ref().is_some_and(fits) {
            // the old ones are freed first
            self.buffers = None;
            self.buffers = Some(Buffers::new(&self.context, instances.len(), settings)?);
        }
        self.load.instances = instances.len() as u32;
        self.scheme = settings.scheme();
        self.load.steps_per_period = settings.steps_per_period();
        self.buffers().fill(&self.context, settings, instances);
        self.context.check()
    }

    fn set_tangents(&mut self, tangents: &[[f64; 2]]) -> Result<(), BackendError> {
        if self.is_rubbed {
            return Err(BackendError::tangents_with_heat());
        }
        self.buffers().set_tangents(&self.context, tangents);
        self.context.check()
    }

    fn begin_anew(&mut self, settings: &Settings) {
        let rubbed = self.rubbed.as_ref().filter(|_| self.is_rubbed);
        rubbed
            .expect("only with heat or wear a batch goes on by other settings")
            .begin_anew(&self.context, settings);
    }

    fn advance(&mut self, slice: &Slice) -> Result<(), BackendError> {
        if let Some(rubbed) = self.rubbed.as_mut().filter(|_| self.is_rubbed) {
            return rubbed.advance(&self.context, slice);
        }
        let mut left = *slice;
        while left.periods > 0 {
            let (kernel, alike) = match left.stage {
                Stage::Transient => (Kernel::Plain, left.periods),
                Stage::Measure if is_checked(left.first) => (Kernel::Checked, 1),
                Stage::Measure => (Kernel::Tangent, alike(left.first)),
                Stage::Check => (Kernel::Checked, left.periods),
                Stage::Align => (Kernel::Tangent, left.periods),
            };
            let periods = alike.min(left.periods);
            self.advance_alike(kernel, &Slice { periods, ..left })?;
            left.first += periods;
            left.elapsed += periods;
            left.periods -= periods;
        }
        Ok(())
    }

    fn collect(&mut self) -> Result<Vec<Sums>, BackendError> {
        if let Some(rubbed) = self.rubbed.as_ref().filter(|_| self.is_rubbed) {
            return rubbed.collect(&self.context);
        }
        let totals = self
            .buffers()
            .take_totals(&self.context, self.load.instances as usize)?;
        Ok(totals.into_iter().map(Sums::from).collect())
    }

    fn end_states(&mut self) -> Result<Vec<EndState>, BackendError> {
        if let Some(rubbed) = self.rubbed.as_ref().filter(|_| self.is_rubbed) {
            return rubbed.end_states(&self.context);
        }
        let orbits = self
            .buffers()
            .read_orbits(&self.context, self.load.instances as usize)?;
        Ok(orbits.into_iter().map(EndState::from).collect())
    }
}
