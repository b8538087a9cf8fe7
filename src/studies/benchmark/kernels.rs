//! The kernels of this program on this machine: what each costs and how exact it is.
//!
//! Owns the choice of the kernels and of the points; prints nothing.

use std::time::{Duration, Instant};

use serde::Serialize;

use super::accuracy::References;
use super::cost::{self, Cost};
use super::points_of_model;
use crate::backend::cpu::{CpuBackend, InstructionSet};
use crate::backend::{Backend, BackendError};
use crate::experiment::{Integration, Precision, Sampling, Scheme, Settings};
use crate::parameters::ParameterSet;

/// A scheme on a device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    pub scheme: Scheme,
    /// None on a GPU.
    pub instructions: Option<InstructionSet>,
    pub precision: Precision,
    /// Heat modes of the full model.
    pub modes: Option<u32>,
    /// Tolerance of radau's steps.
    pub tolerance: f64,
}

impl Case {
    /// All kernels of an instruction set, or of a GPU, in a number type: those of the reduced model, and those of the full model
    /// with each of these numbers of heat modes.
    pub fn all(instructions: Option<InstructionSet>, precision: Precision, modes: &[u32]) -> Vec<Self> {
        let case = |scheme, modes| Self {
            scheme,
            instructions,
            precision,
            modes,
            tolerance: Integration::default().tolerance,
        };
        [Scheme::Taylor, Scheme::Rk4]
            .map(|scheme| case(scheme, None))
            .into_iter()
            .chain(modes.iter().map(|&modes| case(Scheme::Radau, Some(modes))))
            .collect()
    }

    pub fn settings(&self) -> Settings {
        let default = Integration::from(self.scheme);
        Settings {
            integration: Integration {
                modes: self.modes.unwrap_or(default.modes),
                tolerance: self.tolerance,
                precision: Some(self.precision),
                ..default
            },
            ..Settings::default()
        }
    }

    /// The points on which the kernel is timed. For the slower instruction sets, it is only every third or every ninth point.
    pub fn points(&self) -> Vec<ParameterSet> {
        let stride = match self.instructions {
            Some(InstructionSet::Avx512) | None => 1,
            Some(InstructionSet::Avx2) => 3,
            Some(InstructionSet::Portable) => 9,
        };
        points_of_model(self.scheme.carries_heat(), stride)
    }

    /// Periods of the motion alone, and with tangent vectors.
    fn timed(&self) -> (u32, u32) {
        if self.scheme.carries_heat() {
            (16, 16)
        } else {
            // as many measured periods as a map has by default, so that sums are collected as often
            (100, 250)
        }
    }

    /// Times a run on a backend of the case.
    ///
    /// # Errors
    /// If the backend fails.
    pub fn cost(&self, backend: &mut dyn Backend) -> Result<Cost, BackendError> {
        let (transient_periods, periods) = self.timed();
        let settings = Settings {
            sampling: Sampling {
                transient_periods,
                periods,
                ..self.settings().sampling
            },
            ..self.settings()
        };
        cost::cost(backend, &settings, &self.points())
    }
}

/// A kernel as it was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Kernel {
    /// `reduced`, or `full` with frictional heat.
    pub model: &'static str,
    pub backend: &'static str,
    pub device: String,
    pub precision: &'static str,
    pub scheme: Scheme,
    /// Name of the instruction set on the CPU.
    pub instructions: Option<&'static str>,
    /// Numbers in a vector register of the CPU.
    pub lanes: Option<usize>,
    pub modes: Option<u32>,
    /// Tolerance of radau's steps.
    pub tolerance: Option<f64>,
    /// The mean of a period with tangent vectors and one without; on one core of the CPU, or on a whole GPU.
    pub ns_per_instance_period: f64,
    pub ns_motion_alone: f64,
    pub ns_with_vectors: f64,
    /// Absolute errors of the exponent over 20 periods from the start, on the insensitive points.
    pub exponent_error_median: f64,
    pub exponent_error_p99: f64,
}

/// Most rounds of timing: every kernel is timed once in each.
const ROUNDS: usize = 5;

/// Measures the cases in rounds, as many as `budget` allows and at least one; cases of a GPU are measured on `gpu`.
///
/// # Errors
/// If a backend fails.
///
/// # Panics
/// If a case is one of a GPU and there is none.
pub fn measure(
    cases: &[Case],
    mut gpu: Option<&mut dyn Backend>,
    budget: Duration,
) -> Result<Vec<Kernel>, BackendError> {
    let mut costs = vec![Vec::with_capacity(ROUNDS); cases.len()];
    let one_core = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("a thread can be started");
    let started = Instant::now();
    for round in 1..=ROUNDS as u32 {
        for (case, costs) in cases.iter().zip(&mut costs) {
            let cost = if let Some(set) = case.instructions {
                one_core.install(|| case.cost(&mut CpuBackend::with_instructions(case.precision, set)))?
            } else {
                let gpu = gpu.as_deref_mut().expect("a case of a GPU comes with one");
                // an untimed run, in which the kernel is compiled; those of the full model are compiled again for every number of
                // modes
                if round == 1 || case.modes.is_some() {
                    case.cost(gpu)?;
                }
                case.cost(gpu)?
            };
            costs.push(cost);
        }
        if started.elapsed() * (round + 1) / round > budget {
            break;
        }
    }
    let references = [false, true].map(|rubbed| {
        let needed = cases.iter().any(|case| case.scheme.carries_heat() == rubbed);
        needed.then(|| References::of_model(rubbed))
    });
    let measured = cases.iter().zip(&costs).map(|(case, costs)| {
        let references = references[usize::from(case.scheme.carries_heat())].as_ref();
        let references = references.expect("computed for every model that occurs");
        if let Some(set) = case.instructions {
            let mut cpu = CpuBackend::with_instructions(case.precision, set);
            kernel(case, costs, references, &mut cpu)
        } else {
            let gpu = gpu.as_deref_mut().expect("a case of a GPU comes with one");
            kernel(case, costs, references, gpu)
        }
    });
    measured.collect()
}

fn kernel(
    case: &Case,
    costs: &[Cost],
    references: &References,
    backend: &mut dyn Backend,
) -> Result<Kernel, BackendError> {
    let errors = references.errors(backend, &case.settings())?;
    let cost = Cost::median(costs);
    let kind = backend.kind();
    Ok(Kernel {
        model: if case.scheme.carries_heat() { "full" } else { "reduced" },
        backend: kind.device_class(),
        device: backend.device(),
        precision: kind.precision(),
        scheme: case.scheme,
        instructions: case.instructions.map(InstructionSet::name),
        lanes: case.instructions.map(|set| set.lanes(case.precision)),
        modes: case.modes,
        tolerance: case.scheme.carries_heat().then_some(case.tolerance),
        ns_per_instance_period: cost.mean(),
        ns_motion_alone: cost.motion_alone,
        ns_with_vectors: cost.with_vectors,
        exponent_error_median: errors.median(),
        exponent_error_p99: errors.quantile(0.99),
    })
}
