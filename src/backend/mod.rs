//! Backends carry batches of instances on in time; the driver here turns what they sum up into measurements.
//!
//! Owns the contract between the host and a backend, and the order of a run: transient, alignment, measurement. Knows
//! nothing of grids, files or progress bars.

pub mod cpu;
pub mod gpu;
pub mod twins;

use std::ops::ControlFlow;

use crate::dynamics::{statistics, stroboscope};
use crate::experiment::Settings;
use crate::measurement::{BackendKind, CONSTANT_GROWTH, Class, Contact, Cycle, DEFECT_BOUND, Measurement, Status};
use crate::parameters::{Parameter, ParameterSet};

/// What the forcing periods of a slice are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The motion alone settles.
    Transient,
    /// The tangent vectors turn to their directions; nothing is summed up.
    Align,
    /// Everything is summed up.
    Measure,
}

/// Some forcing periods that a backend carries its whole batch on by.
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

/// What is left of an instance at the end of a run.
#[derive(Clone, Copy, Debug)]
pub struct EndState {
    pub x: f64,
    pub y: f64,
    /// The first tangent vector (X, Y), of length 1. NaN with heat or wear, whose tangent space has more dimensions.
    pub tangent: [f64; 2],
    pub x_min: f64,
    pub x_max: f64,
    /// Candidates for the period; see [`stroboscope::period`].
    pub candidates: u32,
    /// The forcing period of the run, counted from 1, at whose end the instance was first found to have run away.
    pub runaway_period: Option<u32>,
    /// Whether the scheme gave the instance up: its motion needed more, or shorter, steps than there may be.
    pub under_resolved: bool,
    pub contact: Contact,
}

/// Integrates batches of instances.
pub trait Backend {
    fn kind(&self) -> BackendKind;

    /// The device, for people: its name and what of it is used.
    fn device(&self) -> String;

    /// A good number of instances for one batch: enough to fill the device, not more than it holds.
    fn batch_size(&self) -> usize;

    /// Takes a new batch, at the beginning of its run; what was loaded before is dropped.
    ///
    /// # Errors
    /// If the device cannot hold the batch or is lost.
    fn load(&mut self, settings: &Settings, instances: &[ParameterSet]) -> Result<(), BackendError>;

    /// Turns the first tangent vectors to these directions, of length 1, in the order of `load`; the second ones stand
    /// across. Without it the first ones begin as (1, 0). With the states as initial states of the instances, a run whose
    /// contact pressure is constant goes on as if it had not been interrupted.
    ///
    /// # Errors
    /// As [`Backend::load`]; and with heat or wear, whose tangent space has more dimensions.
    fn set_tangents(&mut self, tangents: &[[f64; 2]]) -> Result<(), BackendError>;

    /// Carries the batch on by a slice. Slices of one stage come in order and without gaps.
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

impl BackendError {
    /// Why no tangent vectors can be set where there is heat or wear.
    fn tangents_with_heat() -> Self {
        Self::Unsupported("tangent vectors with heat or wear are more than a direction in (x, y)".to_owned())
    }
}

/// Longest slice, so that progress shows and a run can be cancelled.
const LONGEST_SLICE: u32 = 16;

/// Runs a batch from its initial states to its measurements. `progress` hears after every slice how many
/// instance-periods it did, and may break the run off; then None is returned.
///
/// Instances whose contact wears have no transient: all their motion is one, and everything of it is measured, over
/// `settings.periods`.
///
/// # Errors
/// If the backend fails, or the scheme that was asked for does not carry the heat and wear of an instance.
pub fn measure_batch(
    backend: &mut dyn Backend,
    settings: &Settings,
    instances: &[ParameterSet],
    progress: &mut dyn FnMut(u64) -> ControlFlow<()>,
) -> Result<Option<Vec<Measurement>>, BackendError> {
    let settings = settings
        .for_model(instances.iter().any(ParameterSet::is_rubbed))
        .map_err(|error| BackendError::Unsupported(error.to_string()))?;
    let (wearing, lasting): (Vec<usize>, Vec<usize>) =
        (0..instances.len()).partition(|&index| instances[index].wears());
    let mut measured = vec![None; instances.len()];
    let whole_run = u64::from(settings.transient_periods) + u64::from(settings.periods);
    let from_the_start = Settings {
        transient_periods: 0,
        align_periods: 0,
        ..settings.clone()
    };
    for (indices, settings, share) in [
        (lasting, &settings, whole_run),
        (wearing, &from_the_start, u64::from(settings.periods)),
    ] {
        if indices.is_empty() {
            continue;
        }
        let instances: Vec<_> = indices.iter().map(|&index| instances[index]).collect();
        // both kinds count as a whole run, which is what was announced
        let progress = &mut |instance_periods: u64| progress(instance_periods * whole_run / share);
        let Some(batch) = measure_alike(backend, settings, &instances, progress)? else {
            return Ok(None);
        };
        for (index, measurement) in indices.into_iter().zip(batch) {
            measured[index] = Some(measurement);
        }
    }
    Ok(measured.into_iter().collect())
}

/// Runs a batch of instances all of which wear or none.
fn measure_alike(
    backend: &mut dyn Backend,
    settings: &Settings,
    instances: &[ParameterSet],
    progress: &mut dyn FnMut(u64) -> ControlFlow<()>,
) -> Result<Option<Vec<Measurement>>, BackendError> {
    backend.load(settings, instances)?;
    let mut elapsed = 0;
    let mut advance = |backend: &mut dyn Backend, stage, range: std::ops::Range<u32>| {
        let mut first = range.start;
        while first < range.end {
            let periods = LONGEST_SLICE.min(range.end - first);
            backend.advance(&Slice {
                stage,
                first,
                periods,
                elapsed,
            })?;
            first += periods;
            elapsed += periods;
            if progress(u64::from(periods) * instances.len() as u64).is_break() {
                return Ok(ControlFlow::Break(()));
            }
        }
        Ok(ControlFlow::Continue(()))
    };
    for (stage, periods) in [
        (Stage::Transient, settings.transient_periods - settings.align_periods),
        (Stage::Align, settings.align_periods),
    ] {
        if advance(backend, stage, 0..periods)?.is_break() {
            return Ok(None);
        }
    }
    let mut growth: Vec<Growth> = vec![Growth::default(); instances.len()];
    for batch in statistics::batches(settings.periods) {
        if advance(backend, Stage::Measure, batch.clone())?.is_break() {
            return Ok(None);
        }
        for (growth, sums) in growth.iter_mut().zip(backend.collect()?) {
            growth.add(batch.len() as f64, &sums);
        }
    }
    let ends = backend.end_states()?;
    let kind = backend.kind();
    Ok(Some(
        instances
            .iter()
            .zip(growth.iter().zip(&ends))
            .map(|(parameters, (growth, end))| growth.measurement(parameters, settings, end, kind))
            .collect(),
    ))
}

/// One instance's growth over the whole measurement, in f64.
#[derive(Clone, Debug, Default)]
struct Growth {
    /// Length in periods, and growth of the first vector, of each batch.
    batches: Vec<(f64, f64)>,
    /// The same of the second vector.
    second_batches: Vec<(f64, f64)>,
    total: Sums,
}

impl Growth {
    fn add(&mut self, periods: f64, sums: &Sums) {
        self.batches.push((periods, sums.growth[0]));
        self.second_batches.push((periods, sums.growth[1]));
        self.total.growth[0] += sums.growth[0];
        self.total.growth[1] += sums.growth[1];
        self.total.birkhoff += sums.birkhoff;
        self.total.divergence += sums.divergence;
    }

    /// Growth per period over the whole batches in the last `periods`, at least one.
    fn rate_over_last(&self, periods: u32) -> f64 {
        let mut sum = (0.0, 0.0);
        for batch in self.batches.iter().rev() {
            if sum.0 > 0.0 && sum.0 + batch.0 > f64::from(periods) {
                break;
            }
            sum = (sum.0 + batch.0, sum.1 + batch.1);
        }
        sum.1 / sum.0
    }

    fn measurement(
        &self,
        parameters: &ParameterSet,
        settings: &Settings,
        end: &EndState,
        backend: BackendKind,
    ) -> Measurement {
        let period_time = parameters.forcing_period();
        if let Some(period) = end.runaway_period {
            return Measurement::runaway(f64::from(period) * period_time, backend);
        }
        if settings.scheme().carries_heat() {
            return self.rubbed_measurement(parameters, settings, end, backend);
        }
        let time = f64::from(settings.periods) * period_time;
        let [lyapunov, lyapunov_second] = statistics::exponents(self.total.growth.map(|growth| growth / time));
        let measurement = self.lasting_measurement(parameters, settings, end, backend, lyapunov);
        let measurement = Measurement {
            lyapunov_second,
            lyapunov_second_error: statistics::standard_error(&self.second_batches) / period_time,
            divergence: self.total.divergence / time,
            ..measurement
        };
        // written so that NaN fails
        let resolved = measurement.divergence_defect().abs() <= DEFECT_BOUND * (1.0 + measurement.divergence.abs());
        checked(measurement, resolved && !end.under_resolved)
    }

    /// The measurement of a motion that lasts, given its maximal exponent.
    fn lasting_measurement(
        &self,
        parameters: &ParameterSet,
        settings: &Settings,
        end: &EndState,
        backend: BackendKind,
        lyapunov: f64,
    ) -> Measurement {
        let period_time = parameters.forcing_period();
        let lyapunov_error = statistics::standard_error(&self.batches) / period_time;
        let lyapunov_birkhoff = self.total.birkhoff / period_time;
        let window = stroboscope::window(settings.periods);
        let cycle = stroboscope::period(end.candidates, window).map(|period| Cycle {
            period,
            growth_rate: self.rate_over_last(window) / period_time,
        });
        let class = Class::of(lyapunov, lyapunov_error, cycle, lyapunov_birkhoff);
        Measurement {
            status: Status::Ok,
            class: Some(class),
            lyapunov,
            lyapunov_error,
            lyapunov_second: f64::NAN,
            lyapunov_second_error: f64::NAN,
            divergence: f64::NAN,
            lyapunov_birkhoff,
            lyapunov_interval: f64::from(settings.periods) * period_time,
            period: cycle
                .filter(|cycle| {
                    class == Class::Regular && reached(cycle, lyapunov, lyapunov_error, settings, period_time)
                })
                .map(|cycle| cycle.period),
            x: end.x,
            y: end.y,
            x_min: end.x_min,
            x_max: end.x_max,
            chaotic_fraction: f64::from(u8::from(class == Class::Chaotic)),
            attractors: 1,
            contact: end.contact,
            backend,
            initial_state: [parameters[Parameter::X0], parameters[Parameter::Y0]],
        }
    }

    /// The measurement of a motion with frictional heat or wear. One tangent vector is carried, and with wear the motion
    /// is a transient: it has an exponent of finite time and no class.
    fn rubbed_measurement(
        &self,
        parameters: &ParameterSet,
        settings: &Settings,
        end: &EndState,
        backend: BackendKind,
    ) -> Measurement {
        let time = f64::from(settings.periods) * parameters.forcing_period();
        let growth = self.total.growth[0];
        if !parameters.wears() {
            let measurement = self.lasting_measurement(parameters, settings, end, backend, growth / time);
            return checked(measurement, !end.under_resolved);
        }
        let interval = end.contact.lost.unwrap_or(time);
        let measurement = Measurement {
            class: None,
            period: None,
            lyapunov_error: f64::NAN,
            lyapunov_birkhoff: f64::NAN,
            lyapunov_interval: interval,
            chaotic_fraction: 0.0,
            ..self.lasting_measurement(parameters, settings, end, backend, growth / interval)
        };
        Measurement {
            status: if end.under_resolved || !measurement.lyapunov.is_finite() {
                Status::UnderResolved
            } else {
                Status::Ok
            },
            ..measurement
        }
    }
}

/// The measurement of a lasting motion, as under-resolved if it is, or if a number of it is none.
fn checked(measurement: Measurement, resolved: bool) -> Measurement {
    let finite = [
        measurement.lyapunov,
        measurement.lyapunov_error,
        measurement.lyapunov_birkhoff,
    ]
    .iter()
    .all(|value| value.is_finite());
    if resolved && finite {
        return measurement;
    }
    Measurement {
        status: Status::UnderResolved,
        class: None,
        period: None,
        chaotic_fraction: 0.0,
        ..measurement
    }
}

/// Whether the run was long enough for the cycle's attraction to bring a disturbance of order 1 well below the
/// tolerance of the period. A spiral that still decays slowly returns near itself after some odd number of periods, which
/// is not its period. Growth that is the same in every period tells of a cycle from the start. After a chaotic transient only the last periods are known to have been on the cycle.
fn reached(cycle: &Cycle, lyapunov: f64, error: f64, settings: &Settings, period_time: f64) -> bool {
    if error < CONSTANT_GROWTH {
        return true;
    }
    let (rate, periods) = if lyapunov < 0.0 {
        (lyapunov, settings.transient_periods + settings.periods)
    } else {
        (cycle.growth_rate, stroboscope::window(settings.periods))
    };
    -rate * f64::from(periods) * period_time > (10.0 / settings.period_tolerance).ln()
}
