//! The standing benchmark: what an instance-period costs, by backend, number type and instruction set.
//!
//! `cargo bench` prints instance-periods per second on one thread of the CPU and on the first GPU adapter: of the reduced
//! model over the 64 x 64 grid zeta_k 0..12 by h1 0..2, and of the full model, by its number of heat modes, over 64 x 16
//! points zeta_k 3..4.5 by gamma 1..1.87 after the shaft has warmed up. Machines are shared and noisy: compare figures of one run only.

use divan::Bencher;
use divan::counter::ItemsCount;
use tribochaos::backend::cpu::{CpuBackend, InstructionSet};
use tribochaos::backend::gpu::{GpuBackend, GpuContext};
use tribochaos::backend::{Backend, Slice, Stage};
use tribochaos::benchmark;
use tribochaos::experiment::{Precision, Scheme, Settings};

fn main() {
    // one core: what one costs is what is compared
    rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build_global()
        .expect("no pool was built before");
    divan::main();
}

/// Periods of one iteration.
const PERIODS: u32 = 4;

#[divan::bench(args = cases(), sample_count = 9, sample_size = 1)]
fn cpu(bencher: Bencher, case: &Case) {
    advance(
        bencher,
        &mut CpuBackend::with_instructions(case.precision, case.instructions.expect("a case of the CPU")),
        case.scheme,
        case.stage,
        case.modes,
    );
}

#[divan::bench(args = gpu_cases(), sample_count = 9, sample_size = 1)]
fn gpu(bencher: Bencher, case: &Case) {
    match GpuContext::open(None, true) {
        Ok(context) => advance(
            bencher,
            &mut GpuBackend::new(context),
            case.scheme,
            case.stage,
            case.modes,
        ),
        Err(error) => eprintln!("no GPU benchmark: {error}"),
    }
}

#[derive(Clone, Copy, Debug)]
struct Case {
    scheme: Scheme,
    /// None on a GPU.
    instructions: Option<InstructionSet>,
    precision: Precision,
    stage: Stage,
    /// Heat modes of the full model.
    modes: u32,
}

impl std::fmt::Display for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (scheme, instructions) = (self.scheme.name(), self.instructions.map_or("", InstructionSet::name));
        write!(f, "{scheme} {instructions} {:?} {:?}", self.precision, self.stage)?;
        if self.scheme.carries_heat() {
            write!(f, " M={}", self.modes)?;
        }
        Ok(())
    }
}

const STAGES: [Stage; 2] = [Stage::Transient, Stage::Measure];

/// Numbers of heat modes, for how the cost grows with them.
const MODES: [u32; 4] = [4, 8, 12, 24];

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for instructions in InstructionSet::available() {
        for precision in [Precision::F64, Precision::F32] {
            cases.extend(kernels(Some(instructions), precision));
        }
    }
    cases
}

/// A GPU has no f64.
fn gpu_cases() -> Vec<Case> {
    kernels(None, Precision::F32)
}

/// In turn, so that all schemes meet the same minute of a shared machine.
fn kernels(instructions: Option<InstructionSet>, precision: Precision) -> Vec<Case> {
    let reduced = [(Scheme::Taylor, 0), (Scheme::Rk4, 0)];
    let full = MODES.map(|modes| (Scheme::Radau, modes));
    STAGES
        .iter()
        .flat_map(|&stage| {
            reduced.iter().chain(&full).map(move |&(scheme, modes)| Case {
                scheme,
                instructions,
                precision,
                stage,
                modes,
            })
        })
        .collect()
}

/// Periods in which the shaft warms up before the full model is measured.
const WARMING: u32 = 8;

fn advance(bencher: Bencher, backend: &mut dyn Backend, scheme: Scheme, stage: Stage, modes: u32) {
    let instances = if scheme.carries_heat() {
        benchmark::rubbed_points(1)
    } else {
        benchmark::points(1)
    };
    let instances = instances.expect("the grid is valid");
    // the slices of all iterations stay within the measured periods
    let settings = Settings {
        scheme: Some(scheme),
        periods: 1_000_000,
        modes: modes.max(1),
        ..Settings::default()
    };
    backend.load(&settings, &instances).expect("the grid fits");
    if scheme.carries_heat() {
        let warming = Slice {
            stage: Stage::Transient,
            first: 0,
            periods: WARMING,
            elapsed: 0,
        };
        backend.advance(&warming).expect("the backend works");
    }
    let mut first = 0;
    bencher
        .counter(ItemsCount::new(instances.len() * PERIODS as usize))
        .bench_local(|| {
            backend
                .advance(&Slice {
                    stage,
                    first,
                    periods: PERIODS,
                    elapsed: first,
                })
                .expect("the backend works");
            first += PERIODS;
        });
}
