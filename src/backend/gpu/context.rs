//! An open GPU: device and queue, and the errors that they have reported.
//!
//! Owns the device and turns every way it can fail into a [`BackendError`]; knows nothing of batches.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::BINDINGS;
use super::adapter::{self, AdapterDescription};
use super::layout::{Access, Binding};
use super::shader_source::Lanes;
use crate::backend::BackendError;

/// Threads in a workgroup: a whole number of every vendor's subgroups.
pub(super) const WORKGROUP_SIZE: u32 = 64;

/// A device that has not answered for this time counts as lost. Dispatches last a tenth of a second.
const PATIENCE: Duration = Duration::from_mins(1);

/// An open GPU, and how kernels are to be compiled for it.
pub struct GpuContext {
    device: wgpu::Device,
    queue: wgpu::Queue,
    description: AdapterDescription,
    faults: Arc<Faults>,
    lanes: Lanes,
}

impl GpuContext {
    /// Opens the first adapter with `adapter` in its name, in upper or lower case; without a name, the best one. It may be a
    /// software adapter only if `allow_software`.
    ///
    /// # Errors
    /// [`BackendError::NoDevice`] if no adapter fits, [`BackendError::Unsupported`] if its limits are too low, and other errors
    /// that its driver reports.
    pub fn open(adapter: Option<&str>, allow_software: bool) -> Result<Self, BackendError> {
        Self::open_with_workgroups(adapter, allow_software, u32::MAX)
    }

    /// As [`GpuContext::open`]; a dispatch has at most `most_workgroups` workgroups, and no more than the adapter allows.
    ///
    /// # Errors
    /// As [`GpuContext::open`].
    pub fn open_with_workgroups(
        adapter: Option<&str>,
        allow_software: bool,
        most_workgroups: u32,
    ) -> Result<Self, BackendError> {
        Self::of(&adapter::choose(adapter, allow_software)?, most_workgroups)
    }

    /// Opens every hardware adapter with `adapter` in its name, or every one; those that do not open are left out.
    pub fn open_all(adapter: Option<&str>) -> Vec<Self> {
        let adapters = adapter::all_hardware(adapter);
        adapters
            .iter()
            .filter_map(|adapter| Self::of(adapter, u32::MAX).ok())
            .collect()
    }

    fn of(adapter: &wgpu::Adapter, most_workgroups: u32) -> Result<Self, BackendError> {
        let description = AdapterDescription::new(&adapter.get_info());
        // the highest limits of the adapter: the default ones would keep batches small
        let mut limits = adapter.limits();
        check_limits(&description, &limits)?;
        limits.max_compute_workgroups_per_dimension = limits.max_compute_workgroups_per_dimension.min(most_workgroups);
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("tribochaos"),
            required_limits: limits,
            ..Default::default()
        }))
        .map_err(|error| BackendError::NoDevice(format!("{description} does not open: {error}")))?;
        let faults = Faults::watching(&device);
        let context = Self {
            device,
            queue,
            lanes: Lanes::suiting(description.is_software),
            description,
            faults,
        };
        context.check()?;
        Ok(context)
    }

    /// The same context with `lanes` instances in a thread, instead of the number that suits the adapter.
    #[must_use]
    pub fn with_lanes(self, lanes: Lanes) -> Self {
        Self { lanes, ..self }
    }

    pub fn description(&self) -> &AdapterDescription {
        &self.description
    }

    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// Instances of the reduced model in a thread.
    pub(super) fn lanes(&self) -> Lanes {
        self.lanes
    }

    /// Fails if the device is lost or has reported an error since the last call of this; wgpu's own calls report nothing.
    pub(super) fn check(&self) -> Result<(), BackendError> {
        if let Some(error) = self.faults.take_error() {
            // every call to a lost device is an error, and wgpu reports the loss itself only when the device is polled
            let _ = self.poll(wgpu::PollType::Poll);
            self.faults.check_not_lost()?;
            return Err(error);
        }
        self.faults.check_not_lost()
    }

    /// Waits until the device has done all it was given.
    pub(super) fn wait(&self) -> Result<(), BackendError> {
        let waited = self.poll(wgpu::PollType::Wait {
            submission_index: None,
            timeout: Some(PATIENCE),
        });
        self.check()?;
        waited
    }

    fn poll(&self, poll: wgpu::PollType) -> Result<(), BackendError> {
        // if the driver reports a loss during a poll, wgpu panics instead of returning
        match catch_unwind(AssertUnwindSafe(|| self.device.poll(poll))) {
            Ok(Ok(_)) => Ok(()),
            Ok(Err(wgpu::PollError::Timeout)) => Err(BackendError::DeviceLost(format!(
                "it did not answer for {} s",
                PATIENCE.as_secs()
            ))),
            Ok(Err(error)) => Err(BackendError::Internal(error.to_string())),
            Err(_) => Err(BackendError::DeviceLost("its driver gave no reason".to_owned())),
        }
    }
}

/// Checks that the adapter has what the kernels need; that is little, but not every adapter has it.
fn check_limits(description: &AdapterDescription, limits: &wgpu::Limits) -> Result<(), BackendError> {
    let workgroup = limits
        .max_compute_invocations_per_workgroup
        .min(limits.max_compute_workgroup_size_x);
    let storage_buffers = |model: &&[Binding]| model.iter().filter(|it| it.access != Access::Uniform).count();
    let uniforms = BINDINGS
        .iter()
        .flat_map(|model| model.iter().filter(|it| it.access == Access::Uniform));
    for (what, has, needs) in [
        (
            "threads in a workgroup",
            u64::from(workgroup),
            u64::from(WORKGROUP_SIZE),
        ),
        (
            "storage buffers in a kernel",
            limits.max_storage_buffers_per_shader_stage.into(),
            BINDINGS.iter().map(storage_buffers).max().unwrap_or(0) as u64,
        ),
        (
            "bytes in a uniform buffer",
            limits.max_uniform_buffer_binding_size,
            uniforms.map(Binding::element).max().unwrap_or(0),
        ),
    ] {
        if has < needs {
            return Err(BackendError::Unsupported(format!(
                "{description} allows {has} {what}, and {needs} are needed: use --backend cpu"
            )));
        }
    }
    Ok(())
}

/// Errors that wgpu has reported of a device, outside of the calls that caused them.
#[derive(Default)]
struct Faults {
    /// Why the device was lost. Once set, this stays.
    lost: Mutex<Option<String>>,
    /// The first other error since the last check; those that follow are its consequences.
    error: Mutex<Option<BackendError>>,
}

impl Faults {
    fn watching(device: &wgpu::Device) -> Arc<Self> {
        let faults = Arc::new(Self::default());
        let of_loss = Arc::clone(&faults);
        device.set_device_lost_callback(move |reason, message| {
            let message = match reason {
                wgpu::DeviceLostReason::Destroyed => "it was closed while in use".to_owned(),
                wgpu::DeviceLostReason::Unknown => message,
            };
            set_first(&of_loss.lost, message);
        });
        let of_errors = Arc::clone(&faults);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let error = match error {
                wgpu::Error::OutOfMemory { source } => BackendError::OutOfMemory(source.to_string()),
                wgpu::Error::Validation { description, .. } | wgpu::Error::Internal { description, .. } => {
                    BackendError::Internal(description)
                }
            };
            set_first(&of_errors.error, error);
        }));
        faults
    }

    fn take_error(&self) -> Option<BackendError> {
        lock(&self.error).take()
    }

    fn check_not_lost(&self) -> Result<(), BackendError> {
        match &*lock(&self.lost) {
            Some(reason) => Err(BackendError::DeviceLost(reason.clone())),
            None => Ok(()),
        }
    }
}

fn set_first<T>(place: &Mutex<Option<T>>, value: T) {
    lock(place).get_or_insert(value);
}

/// Locks, also after a panic elsewhere: it leaves nothing half done here.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
