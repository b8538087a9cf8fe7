//! Backends advance batches of instances in time; [`measure`](crate::measure) turns their sums into measurements.
//!
//! Owns the contract between the host and a backend. Knows nothing of grids, files or progress bars.

pub mod contact;
pub mod cpu;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod instance;
pub mod kind;
mod rubbed;
pub mod twins;

pub use self::contact::Contact;
pub use self::instance::{HeatedState, Instance};
pub use self::kind::BackendKind;

use crate::dynamics::divergence_check;
use crate::experiment::{Integration, Settings};

/// Checks that a scheme can carry the heat and wear of the instances.
///
/// # Errors
/// If it cannot.
pub fn check_model(integration: &Integration, instances: &[Instance]) -> Result<(), BackendError> {
    let rubbed = instances.iter().any(|instance| instance.parameters.has_heat_or_wear());
    integration
        .check_model(rubbed)
        .map_err(|error| BackendError::Unsupported(error.to_string()))
}

/// Checks that instances with heat or wear start with the tangent vector (1, 0), with which every motion starts, and that motion
/// goes on with as many heat modes as the settings say.
fn check_states(settings: &Settings, instances: &[Instance]) -> Result<(), BackendError> {
    let refuse = |error: &str| Err(BackendError::Unsupported(error.to_owned()));
    let modes = settings.integration.modes as usize + 1;
    for instance in instances {
        if instance.parameters.has_heat_or_wear() && !instance.has_first_tangent() {
            return refuse("tangent vectors with heat or wear are more than a direction in (x, y)");
        }
        let Some(heated) = &instance.heated else { continue };
        if !instance.parameters.is_heated() {
            return refuse("only motion with heat and without wear goes on with heat modes");
        }
        let has_vectors = heated.vectors.nrows() == modes + 2 && heated.vectors.ncols() > 0;
        if heated.pressures.len() != modes || !has_vectors {
            return refuse(
                "a motion goes on with the number of heat modes with which it began, and with a tangent vector of as many",
            );
        }
    }
    Ok(())
}

/// The purpose of the forcing periods of a slice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The motion alone settles.
    Transient,
    /// The motion alone, whose stroboscopic states are compared at the end.
    Watch,
    /// The tangent vectors turn to their directions; nothing is summed up.
    Align,
    /// Everything is summed up, and stroboscopic states are compared at the end.
    Measure,
    /// As `Measure`, and the sum of the exponents is compared with the divergence in every period. The difference
    /// counts [`CHECKED_EVERY`](crate::dynamics::divergence_check::CHECKED_EVERY) times, as in the few checked periods of a
    /// measurement.
    Check,
    /// Every tangent vector that was given is carried, and none is normalised: at the end, vectors are their images by the
    /// linearised motion. With heat alone, by radau on the CPU.
    Linearise,
}

impl Stage {
    /// Whether the motion is alone, without a tangent vector.
    pub fn is_plain(self) -> bool {
        matches!(self, Self::Transient | Self::Watch)
    }

    /// Whether stroboscopic states are kept.
    pub fn is_watched(self) -> bool {
        matches!(self, Self::Watch | Self::Measure | Self::Check)
    }

    /// Whether everything is summed up.
    pub fn is_measured(self) -> bool {
        matches!(self, Self::Measure | Self::Check)
    }

    /// Whether both tangent vectors are carried through the period `index` of the stage.
    pub fn is_checked(self, index: u32) -> bool {
        match self {
            Self::Transient | Self::Watch | Self::Align | Self::Linearise => false,
            Self::Measure => divergence_check::is_checked(index),
            Self::Check => true,
        }
    }
}

/// Consecutive forcing periods by which a backend advances its whole batch.
#[derive(Clone, Copy, Debug)]
pub struct Slice {
    pub stage: Stage,
    /// Index of the first period within its stage.
    pub first: u32,
    pub periods: u32,
    /// Periods since the start of the run.
    pub elapsed: u32,
}

/// Sums over one instance's measured periods since they were last collected.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    /// Logarithm of the growth of the first and of the second tangent vector.
    pub growth: [f64; 2],
    /// Growth of the first vector, weighted for the Birkhoff average (weights of sum 1 over all periods).
    pub birkhoff: f64,
    /// Integral of the divergence over tau.
    pub divergence: f64,
}

impl Sums {
    /// Adds the sums over other periods.
    pub fn add(&mut self, other: &Self) {
        self.growth[0] += other.growth[0];
        self.growth[1] += other.growth[1];
        self.birkhoff += other.birkhoff;
        self.divergence += other.divergence;
    }
}

/// State of an instance at the end of a run, and what the run has shown of it.
#[derive(Clone, Debug)]
pub struct EndState {
    /// The last stroboscopic state. For an instance that ran away, it is the last one before that; by radau, it is the state in
    /// which the scheme stopped.
    pub x: f64,
    pub y: f64,
    /// The first tangent vector (X, Y), of length 1. NaN with heat or wear, and by radau on a GPU.
    pub tangent: [f64; 2],
    /// The rest of the state, with heat and without wear.
    pub heated: Option<Box<HeatedState>>,
    pub x_min: f64,
    pub x_max: f64,
    /// Forcing periods after which the motion at the end of the run repeats; see
    /// [`period_of`](crate::dynamics::stroboscope::period_of).
    pub period: Option<u32>,
    /// When the instance ran away, in forcing periods since the start of the run. This is the end of the period in which it ran
    /// away, unless the scheme knows the time within the period.
    pub runaway_periods: Option<f64>,
    /// Whether the scheme gave the instance up: its motion needed more steps, or shorter ones, than are allowed, or the number
    /// type does not resolve its friction layer.
    pub under_resolved: bool,
    pub contact: Contact,
}

/// Integrates batches of instances.
pub trait Backend: Send {
    fn kind(&self) -> BackendKind;

    /// Description of the device for the user: its name, and which part of it is used.
    fn device(&self) -> String;

    /// Further backends of the same kind that can work at the same time as this one, each with a batch of its own. None where one
    /// batch keeps the device busy.
    fn others(&self) -> Vec<Box<dyn Backend>> {
        Vec::new()
    }

    /// A good number of instances for one batch: enough to fill the device, not more than it holds.
    fn batch_size(&self, settings: &Settings) -> usize;

    /// Takes a new batch; the batch that was loaded before is dropped. An instance without wear can start with the state and
    /// the tangent vectors that it had at the end of a run: it then goes on as if that run had not been interrupted, with heat
    /// except for rounding and the guesses of the scheme. Wear always begins anew.
    ///
    /// # Errors
    /// If the device cannot hold the batch or is lost; also if an instance with heat or wear has another tangent vector than
    /// (1, 0), since its tangent space has more dimensions: [`HeatedState`] has its vectors.
    fn load(&mut self, settings: &Settings, instances: &[Instance]) -> Result<(), BackendError>;

    /// Advances the batch by a slice. Slices of one stage come in order and without gaps.
    ///
    /// # Errors
    /// If the device fails; the batch is then lost.
    fn advance(&mut self, slice: &Slice) -> Result<(), BackendError>;

    /// The sums of every instance since the last call, in the order of `load`.
    ///
    /// # Errors
    /// As [`Backend::advance`].
    fn collect(&mut self) -> Result<Vec<Sums>, BackendError>;

    /// The state of every instance, in the order of `load`.
    ///
    /// # Errors
    /// As [`Backend::advance`].
    fn end_states(&mut self) -> Result<Vec<EndState>, BackendError>;
}

/// Why a backend cannot go on.
#[derive(Debug, Clone, thiserror::Error)]
pub enum BackendError {
    #[error("{0}")]
    NoDevice(String),
    #[error("the GPU was lost: {0}")]
    DeviceLost(String),
    #[error("the GPU is out of memory: {0}; a batch of fewer points may fit")]
    OutOfMemory(String),
    #[error("{0}")]
    Unsupported(String),
    #[error("the GPU refused a command, which is an error of this program; please report it: {0}")]
    Internal(String),
}
