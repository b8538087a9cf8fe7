//! The GPU backend: one instance in each lane of a thread, in f32, in WGSL through wgpu.
//!
//! Owns the passage of batches through a device; the arithmetic is that of `shaders/`, whose files are twins of the
//! model's and the algorithms' modules.

mod adapter;
mod batch;
mod buffers;
mod context;
mod kernels;
pub mod layout;
mod model;
mod pacer;
pub mod reduced;
pub mod rubbed;
pub mod shader_source;

pub use adapter::{AdapterDescription, adapters};
pub use context::GpuContext;

use self::batch::GpuBatch;
use self::buffers::Buffers;
use self::kernels::Kernels;
use self::layout::Binding;
use self::model::Model;
use self::reduced::Reduced;
use self::rubbed::Rubbed;
use self::shader_source::Shader;
use super::{Backend, BackendError, EndState, Instance, Slice, Stage, Sums, check_states};
use crate::backend::BackendKind;
use crate::experiment::{Integration, MAX_MODES, Scheme, Settings};

/// Instances that fill the largest devices.
const HARDWARE_BATCH: u64 = 1 << 18;
/// Instances that fill a CPU, few enough for a batch to end within seconds.
const SOFTWARE_BATCH: u64 = 1 << 13;

/// Most bytes of the largest buffer of a batch: a small device then has memory left for its other work.
const MOST_STATES: u64 = 1 << 29;

/// The model of a batch of these instances.
///
/// # Errors
/// If its kernels cannot do what the settings ask for.
fn model_of(settings: &Settings, instances: &[Instance]) -> Result<Box<dyn Model>, BackendError> {
    Ok(match settings.integration.scheme {
        Scheme::Rk4 | Scheme::Taylor => Box::new(Reduced::new(settings)?),
        Scheme::Radau => Box::new(Rubbed::new(settings, instances)?),
    })
}

/// The buffers that the shader of each model binds.
const BINDINGS: [&[Binding]; 2] = [&reduced::layout::BINDINGS, &rubbed::layout::BINDINGS];

impl Shader {
    /// The shader of a scheme.
    pub fn of(scheme: Scheme) -> &'static Self {
        match scheme {
            Scheme::Rk4 => &reduced::shader_source::RK4,
            Scheme::Taylor => &reduced::shader_source::TAYLOR,
            Scheme::Radau => &rubbed::shader_source::RADAU,
        }
    }
}

/// Integrates on a GPU.
pub struct GpuBackend {
    context: GpuContext,
    /// For each scheme, the kernels that were used last.
    kernels: [Option<Kernels>; Scheme::ALL.len()],
    batch: Option<GpuBatch>,
}

impl GpuBackend {
    pub fn new(context: GpuContext) -> Self {
        Self {
            context,
            kernels: Default::default(),
            batch: None,
        }
    }

    pub fn context(&self) -> &GpuContext {
        &self.context
    }

    /// Most instances of a batch: the device limits the size of a buffer, and an instance takes at most `share` bytes of one.
    fn max_instances(&self, share: u64) -> u64 {
        let limits = self.context.device().limits();
        limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) / share
    }

    fn check_size(
        &self,
        bindings: &[Binding],
        settings: &Settings,
        instances: &[Instance],
    ) -> Result<(), BackendError> {
        let most = self.max_instances(largest_share(bindings, settings));
        if instances.len() as u64 > most {
            return Err(BackendError::Unsupported(format!(
                "a batch of {} points is larger than the {most} that a buffer of the {} holds: use smaller batches",
                instances.len(),
                self.context.description()
            )));
        }
        Ok(())
    }

    fn batch(&self) -> &GpuBatch {
        self.batch.as_ref().expect(LOADED)
    }
}

/// The rule that callers must keep.
const LOADED: &str = "a batch is loaded before it is advanced";

/// Bytes for one instance in the buffer that needs the most.
fn largest_share(bindings: &[Binding], settings: &Settings) -> u64 {
    let shares = bindings.iter().map(|binding| binding.share(settings));
    shares.max().expect("a model binds something")
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
        // the size must suit every model, since the settings may leave the choice of the model to the points
        let largest = Settings {
            integration: Integration {
                modes: MAX_MODES,
                ..settings.integration
            },
            ..*settings
        };
        let shares = BINDINGS.map(|bindings| largest_share(bindings, &largest));
        let share = shares.into_iter().max().expect("there are models");
        fills.min(self.max_instances(share)).min(MOST_STATES / share).max(1) as usize
    }

    fn load(&mut self, settings: &Settings, instances: &[Instance]) -> Result<(), BackendError> {
        check_states(settings, instances)?;
        let scheme = settings.integration.scheme;
        let model = model_of(settings, instances)?;
        let bindings = model.bindings();
        self.check_size(bindings, settings, instances)?;
        let shape = model.shape(self.context.lanes());
        let place = &mut self.kernels[scheme as usize];
        let kernels = match place {
            Some(kernels) if kernels.shape() == shape => kernels,
            _ => place.insert(Kernels::new(&self.context, Shader::of(scheme), shape, bindings)?),
        };
        // buffers that do not fit the batch are freed before others are allocated
        let before = self.batch.take().map(GpuBatch::into_buffers);
        let buffers = match before.filter(|buffers| buffers.hold(bindings, settings, instances.len())) {
            Some(buffers) => buffers,
            None => Buffers::new(&self.context, kernels.layout(), bindings, settings, instances.len())?,
        };
        let batch = GpuBatch::new(&self.context, model, buffers, kernels, settings, instances);
        self.batch = Some(batch);
        self.context.check()
    }

    fn advance(&mut self, slice: &Slice) -> Result<(), BackendError> {
        if slice.stage == Stage::Linearise {
            let error = "the kernels normalise every vector; the CPU linearises motion";
            return Err(BackendError::Unsupported(error.to_owned()));
        }
        let batch = self.batch.as_ref().expect(LOADED);
        let kernels = self.kernels[batch.scheme() as usize].as_mut().expect(LOADED);
        batch.advance(&self.context, kernels, slice)
    }

    fn collect(&mut self) -> Result<Vec<Sums>, BackendError> {
        self.batch().take_sums(&self.context)
    }

    fn end_states(&mut self) -> Result<Vec<EndState>, BackendError> {
        self.batch().end_states(&self.context)
    }
}
