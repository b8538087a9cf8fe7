//! The full model on a GPU: bushes whose contact pressure frictional heat and wear change.
//!
//! Owns the passage of its batches through a device: kernels for the number of heat modes that is asked for, buffers, and
//! dispatches.

mod buffers;
pub mod layout;
mod pipelines;
pub mod shader_source;

use std::time::{Duration, Instant};

use self::buffers::Buffers;
use self::pipelines::Pipelines;
use super::context::GpuContext;
use super::layout::Span;
use super::pacer::{Load, Pacer};
use crate::backend::{BackendError, EndState, Slice, Stage, Sums};
use crate::experiment::{MAX_MODES, Settings};
use crate::parameters::ParameterSet;

/// A forcing period in the units of the pacer, which are steps of a fixed scheme: some two hundred passes, each of them
/// worth thirty.
const STEPS_PER_PERIOD: u32 = 6000;

/// Most periods of a dispatch: a thread that needs all the passes that a period may take keeps the device busy for some
/// tenths of a second.
const MOST_PERIODS: u32 = 4;

/// A batch of the full model and the kernels that carry it on.
pub struct RubbedBatch {
    pipelines: Pipelines,
    buffers: Buffers,
    instances: Vec<ParameterSet>,
    load: Load,
    /// Without and with a tangent vector. Steps differ from batch to batch in how long they take.
    pacers: [Pacer; 2],
}

impl RubbedBatch {
    /// Takes a new batch, at the beginning of its run, in the buffers and with the kernels of the one before where these
    /// serve.
    pub fn new(
        context: &GpuContext,
        before: Option<Self>,
        load: Load,
        settings: &Settings,
        instances: &[ParameterSet],
    ) -> Result<Self, BackendError> {
        check_modes(settings)?;
        let (pipelines, buffers) = before.map(|batch| (batch.pipelines, batch.buffers)).unzip();
        let pipelines = match pipelines.filter(|pipelines: &Pipelines| pipelines.modes() == settings.modes()) {
            Some(pipelines) => pipelines,
            None => Pipelines::new(context, settings.modes())?,
        };
        let buffers = match buffers.filter(|buffers: &Buffers| buffers.hold(instances.len(), settings)) {
            Some(buffers) => buffers,
            None => Buffers::new(context, &pipelines, instances.len(), settings)?,
        };
        buffers.fill(context, settings, instances);
        context.check()?;
        Ok(Self {
            pipelines,
            buffers,
            instances: instances.to_vec(),
            load: Load {
                instances: instances.len() as u32,
                // one a thread
                workgroup_instances: context.pipelines().workgroup_size(),
                steps_per_period: STEPS_PER_PERIOD,
                most_periods: MOST_PERIODS,
                ..load
            },
            pacers: Default::default(),
        })
    }

    pub fn begin_anew(&self, context: &GpuContext, settings: &Settings) {
        self.buffers.write_run(context, settings, self.instances.len());
    }

    pub fn advance(&mut self, context: &GpuContext, slice: &Slice) -> Result<(), BackendError> {
        let carries_tangent = slice.stage != Stage::Transient;
        let mut pacer = self.pacers[usize::from(carries_tangent)].clone();
        let done = pacer.dispatch(&self.load, slice, |span| self.dispatch(context, carries_tangent, span));
        self.pacers[usize::from(carries_tangent)] = pacer;
        done
    }

    /// Returns how long it took.
    fn dispatch(&self, context: &GpuContext, carries_tangent: bool, span: Span) -> Result<Duration, BackendError> {
        let started = Instant::now();
        self.buffers.set_span(context, span);
        let mut encoder = context.device().create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(self.pipelines.kernel(carries_tangent));
        pass.set_bind_group(0, self.buffers.bindings(), &[]);
        pass.dispatch_workgroups(span.instances.div_ceil(self.load.workgroup_instances), 1, 1);
        drop(pass);
        context.queue().submit([encoder.finish()]);
        context.wait()?;
        Ok(started.elapsed())
    }

    pub fn collect(&self, context: &GpuContext) -> Result<Vec<Sums>, BackendError> {
        let totals = self.buffers.take_totals(context, self.instances.len())?;
        Ok(totals.into_iter().map(Sums::from).collect())
    }

    pub fn end_states(&self, context: &GpuContext) -> Result<Vec<EndState>, BackendError> {
        let orbits = self.buffers.read_orbits(context, self.instances.len())?;
        Ok(orbits
            .iter()
            .zip(&self.instances)
            .map(|(orbit, set)| orbit.end_state(set))
            .collect())
    }
}

/// Bytes of an instance in the buffer that has most of them.
pub fn largest_share(settings: &Settings, modes: u32) -> u64 {
    buffers::largest_share(settings, modes)
}

/// The kernels hold the modes of a thread in arrays of fixed length.
fn check_modes(settings: &Settings) -> Result<(), BackendError> {
    if (1..=MAX_MODES).contains(&settings.modes()) {
        return Ok(());
    }
    Err(BackendError::Unsupported(format!(
        "{} heat modes are not from 1 to the {MAX_MODES} that the GPU's kernels hold: set --modes",
        settings.modes()
    )))
}
