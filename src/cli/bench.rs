//! `bench`: the cost of the kernels on this machine, and their accuracy.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use serde_json::json;

use super::against::{self, Timed};
use super::json::JsonArgs;
use super::{Failure, request};
use crate::backend::cpu::InstructionSet;
use crate::backend::gpu::{GpuBackend, GpuContext};
use crate::backend::{Backend, BackendError};
use crate::experiment::{Integration, Precision, Scheme, Settings};
use crate::output::PROGRAM;
use crate::studies::benchmark::kernels::{self, Case, Kernel};
use crate::studies::benchmark::scaling;

#[derive(Args)]
pub struct BenchArgs {
    /// Only this backend: cpu or gpu [default: both, the GPU if there is one]
    #[arg(long, value_name = "cpu|gpu", value_parser = request::named::<Device>)]
    backend: Option<Device>,
    /// Only this scheme [default: all]
    #[arg(long, value_parser = request::named::<Scheme>)]
    scheme: Option<Scheme>,
    /// Only this number type [default: both]
    #[arg(long, value_name = "f32|f64", value_parser = request::named::<Precision>)]
    precision: Option<Precision>,
    /// Error of a step of radau
    #[arg(long, default_value_t = Integration::default().tolerance)]
    tolerance: f64,
    /// Part of the name of the GPU adapter [default: the first, hardware before software]
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Instead, time the default scheme on one thread up to all threads, and on maps of 10^3 to 10^6 points
    #[arg(long, conflicts_with_all = ["backend", "scheme", "precision", "tolerance", "adapter"])]
    scaling: bool,
    /// Instead, time whole commands of this build and of another one in turn, and print the ratios of their times
    #[arg(long, value_name = "PROGRAM", conflicts_with_all = ["backend", "scheme", "precision", "tolerance", "adapter", "scaling"])]
    against: Option<PathBuf>,
    /// Only these commands: point, small-map, map, chaotic-map, full-length, heat-map [default: all]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', requires = "against", value_parser = request::named::<Timed>)]
    commands: Vec<Timed>,
    /// How many times each build runs each command
    #[arg(long, value_name = "N", requires = "against", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    #[command(flatten)]
    json: JsonArgs,
}

#[derive(Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
enum Device {
    Cpu,
    Gpu,
}

/// Numbers of heat modes that are timed: they show how the cost grows with the number. A GPU needs a kernel compiled for each.
const CPU_MODES: [u32; 4] = [4, 8, 12, 24];
const GPU_MODES: [u32; 2] = [8, 12];

/// Time that the rounds of timing may take. The measurement of the accuracy takes additional time.
const BUDGET: Duration = Duration::from_secs(30);

impl BenchArgs {
    fn wants(&self, case: &Case) -> bool {
        self.scheme.is_none_or(|scheme| scheme == case.scheme)
            && self.precision.is_none_or(|precision| precision == case.precision)
    }

    fn cases(&self, gpu: bool) -> Vec<Case> {
        let mut cases = Vec::new();
        if self.backend != Some(Device::Gpu) {
            for (rank, set) in InstructionSet::available().into_iter().enumerate() {
                for precision in [Precision::F64, Precision::F32] {
                    // the slower instruction sets are timed for the reduced model only: its cost on a CPU that has no better set
                    let modes: &[u32] = if rank == 0 { &CPU_MODES } else { &[] };
                    cases.extend(Case::all(Some(set), precision, modes));
                }
            }
        }
        if gpu {
            cases.extend(Case::all(None, Precision::F32, &GPU_MODES));
        }
        cases.retain(|case| self.wants(case));
        for case in &mut cases {
            case.tolerance = self.tolerance;
        }
        cases
    }

    /// The GPU, if one is wanted and there is one.
    fn gpu(&self) -> Result<Option<GpuBackend>, Failure> {
        if self.backend == Some(Device::Cpu) || self.precision == Some(Precision::F64) {
            return Ok(None);
        }
        match GpuContext::open(self.adapter.as_deref(), true) {
            Ok(context) => Ok(Some(GpuBackend::new(context))),
            Err(BackendError::NoDevice(_)) if self.backend.is_none() && self.adapter.is_none() => Ok(None),
            Err(error) => Err(Failure::backend(error)),
        }
    }
}

pub fn run(args: &BenchArgs) -> Result<(), Failure> {
    if args.scaling {
        return scaling(args.json);
    }
    if let Some(other) = &args.against {
        return against::run(other, &args.commands, args.rounds, args.json);
    }
    let settings = Settings {
        integration: Integration {
            tolerance: args.tolerance,
            ..Integration::default()
        },
        ..Settings::default()
    };
    settings.check().map_err(|error| Failure::Input(error.into()))?;
    let mut gpu = args.gpu()?;
    let cases = args.cases(gpu.is_some());
    if cases.is_empty() {
        return Err(Failure::Input(anyhow::anyhow!(
            "no kernel is of this backend, scheme and number type: a GPU has only f32"
        )));
    }
    let gpu = gpu.as_mut().map(|gpu| gpu as &mut dyn Backend);
    let kernels = kernels::measure(&cases, gpu, BUDGET).map_err(Failure::backend)?;
    if args.json.wanted() {
        let default_scheme = Integration::default().scheme;
        args.json
            .print(&json!({ "program": PROGRAM, "default_scheme": default_scheme, "kernels": kernels }));
    } else {
        print(&kernels);
    }
    Ok(())
}

fn scaling(as_json: JsonArgs) -> Result<(), Failure> {
    let threads = scaling::threads().map_err(Failure::backend)?;
    let sizes = scaling::sizes().map_err(Failure::backend)?;
    if as_json.wanted() {
        as_json.print(&json!({ "program": PROGRAM, "threads": threads, "points": sizes }));
        return Ok(());
    }
    print_line!("{PROGRAM}: wall-clock ns for one forcing period of one instance, taylor in f64 on the CPU\n");
    print_line!("  threads        ns  speed-up");
    for row in &threads {
        print_line!(
            "  {:>7} {:>9.0} {:>9.2}",
            row.threads,
            row.ns_per_instance_period,
            row.speed_up
        );
    }
    print_line!("\n   points        ns  (on all threads)");
    for row in &sizes {
        print_line!("  {:>7} {:>9.0}", row.points, row.ns_per_instance_period);
    }
    Ok(())
}

fn print(kernels: &[Kernel]) {
    print_line!(
        "{PROGRAM}: ns for one forcing period of one instance, on one core of the CPU or a whole GPU, and errors of the exponent"
    );
    let mut device = String::new();
    for kernel in kernels {
        if heading(kernel) != device {
            device = heading(kernel);
            print_line!("\n{device}");
            print_line!("  scheme         motion alone  with vectors     mean   error: median    99 %");
        }
        let modes = kernel.modes.map_or(String::new(), |modes| format!(", M = {modes}"));
        print_line!(
            "  {:<14} {:>12.0} {:>13.0} {:>8.0}   {:>13.1e} {:>7.1e}",
            format!("{}{modes}", kernel.scheme.name()),
            kernel.ns_motion_alone,
            kernel.ns_with_vectors,
            kernel.ns_per_instance_period,
            kernel.exponent_error_median,
            kernel.exponent_error_p99
        );
    }
}

/// The heading does not name the CPU's number of threads: the kernels are timed on one thread.
fn heading(kernel: &Kernel) -> String {
    match (kernel.instructions, kernel.lanes) {
        (Some(set), Some(lanes)) => format!("CPU, {set} lanes of {lanes} {}", kernel.precision),
        _ => kernel.device.clone(),
    }
}
