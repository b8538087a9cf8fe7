//! The standing benchmark: what an instance-period costs, by backend, number type and instruction set.
//!
//! `cargo bench` prints instance-periods per second over the 64 x 64 grid zeta_k 0..12 by h1 0..2, on one thread of the CPU
//! and on the first GPU adapter. Machines are shared and noisy: compare figures of one run only.

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
        &mut CpuBackend::with_instructions(case.precision, case.instructions),
        case.scheme,
        case.stage,
    );
}

#[divan::bench(args = [Stage::Transient, Stage::Measure], consts = [true, false], sample_count = 9, sample_size = 1)]
fn gpu<const TAYLOR: bool>(bencher: Bencher, stage: Stage) {
    let scheme = if TAYLOR { Scheme::Taylor } else { Scheme::Rk4 };
    match GpuContext::open(None, true) {
        Ok(context) => advance(bencher, &mut GpuBackend::new(context), scheme, stage),
        Err(error) => eprintln!("no GPU benchmark: {error}"),
    }
}

#[derive(Clone, Copy, Debug)]
struct Case {
    scheme: Scheme,
    instructions: InstructionSet,
    precision: Precision,
    stage: Stage,
}

impl std::fmt::Display for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (scheme, instructions) = (self.scheme.name(), self.instructions.name());
        write!(f, "{scheme} {instructions} {:?} {:?}", self.precision, self.stage)
    }
}

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for instructions in InstructionSet::available() {
        for precision in [Precision::F64, Precision::F32] {
            // in turn, so that both schemes meet the same minute of a shared machine
            for stage in [Stage::Transient, Stage::Measure] {
                for scheme in [Scheme::Taylor, Scheme::Rk4] {
                    cases.push(Case {
                        scheme,
                        instructions,
                        precision,
                        stage,
                    });
                }
            }
        }
    }
    cases
}

fn advance(bencher: Bencher, backend: &mut dyn Backend, scheme: Scheme, stage: Stage) {
    let instances = benchmark::points(1).expect("the grid is valid");
    // the slices of all iterations stay within the measured periods
    let settings = Settings {
        scheme: Some(scheme),
        periods: 1_000_000,
        ..Settings::default()
    };
    backend.load(&settings, &instances).expect("the grid fits");
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
