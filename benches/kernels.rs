//! The standing benchmark: what an instance-period costs, by backend, number type and instruction set.
//!
//! `cargo bench` prints instance-periods per second on one thread of the CPU and on the first GPU adapter: of the reduced
//! model over the 64 x 64 grid zeta_k 0..12 by h1 0..2, and of the full model, by its number of heat modes, over 64 x 16
//! points zeta_k 3..4.5 by gamma 1..1.87 after the shaft has warmed up. Machines are shared and noisy: compare figures of one run only.

use divan::Bencher;
use divan::counter::ItemsCount;
use tribochaos::backend::cpu::{CpuBackend, InstructionSet};
use tribochaos::backend::gpu::{GpuBackend, GpuContext};
use tribochaos::backend::{Backend, Instance, Slice, Stage};
use tribochaos::experiment::{Precision, Sampling, Settings};
use tribochaos::studies::benchmark::kernels::Case;

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

#[divan::bench(args = cpu_phases(), sample_count = 9, sample_size = 1)]
fn cpu(bencher: Bencher, phase: &Phase) {
    let instructions = phase.case.instructions.expect("a case of the CPU");
    phase.advance(
        bencher,
        &mut CpuBackend::with_instructions(phase.case.precision, instructions),
    );
}

#[divan::bench(args = gpu_phases(), sample_count = 9, sample_size = 1)]
fn gpu(bencher: Bencher, phase: &Phase) {
    match GpuContext::open(None, true) {
        Ok(context) => phase.advance(bencher, &mut GpuBackend::new(context)),
        Err(error) => eprintln!("no GPU benchmark: {error}"),
    }
}

/// A kernel without tangent vectors or with them.
#[derive(Clone, Copy, Debug)]
struct Phase {
    case: Case,
    stage: Stage,
}

impl std::fmt::Display for Phase {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let case = &self.case;
        let (scheme, instructions) = (case.scheme.name(), case.instructions.map_or("", InstructionSet::name));
        write!(f, "{scheme} {instructions} {:?} {:?}", case.precision, self.stage)?;
        if let Some(modes) = case.modes {
            write!(f, " M={modes}")?;
        }
        Ok(())
    }
}

/// Numbers of heat modes, for how the cost grows with them.
const MODES: [u32; 4] = [4, 8, 12, 24];

fn cpu_phases() -> Vec<Phase> {
    let mut phases = Vec::new();
    for instructions in InstructionSet::available() {
        for precision in [Precision::F64, Precision::F32] {
            phases.extend(kernel_phases(Some(instructions), precision));
        }
    }
    phases
}

/// A GPU has no f64.
fn gpu_phases() -> Vec<Phase> {
    kernel_phases(None, Precision::F32)
}

/// In turn, so that all schemes meet the same minute of a shared machine.
fn kernel_phases(instructions: Option<InstructionSet>, precision: Precision) -> Vec<Phase> {
    let cases = Case::all(instructions, precision, &MODES);
    [Stage::Transient, Stage::Measure]
        .into_iter()
        .flat_map(|stage| cases.iter().map(move |&case| Phase { case, stage }))
        .collect()
}

/// The most that a core can do: fused multiply-adds of f64 that wait for nothing. Items are operations, two each; in f32 they are
/// twice as many.
#[cfg(target_arch = "x86_64")]
#[divan::bench(args = vector_sets(), sample_count = 9, sample_size = 1)]
fn multiply_adds(bencher: Bencher, instructions: InstructionSet) {
    use std::hint::black_box;
    const ROUNDS: usize = 1 << 22;
    /// As many in flight as hide their latency.
    const IN_FLIGHT: usize = 12;
    macro_rules! peak {
        ($name:ident, $feature:literal, $set:ident, $fma:ident) => {
            #[target_feature(enable = $feature)]
            fn $name() {
                use std::arch::x86_64::{$fma, $set};
                let (factor, addend) = (black_box($set(0.5)), black_box($set(1.0)));
                let mut sums = [addend; IN_FLIGHT];
                for _ in 0..ROUNDS {
                    for sum in &mut sums {
                        *sum = $fma(*sum, factor, addend);
                    }
                }
                black_box(sums);
            }
        };
    }
    peak!(avx512, "avx512f", _mm512_set1_pd, _mm512_fmadd_pd);
    peak!(avx2, "avx2,fma", _mm256_set1_pd, _mm256_fmadd_pd);
    let lanes = instructions.lanes(Precision::F64);
    bencher
        .counter(ItemsCount::new(2 * lanes * IN_FLIGHT * ROUNDS))
        .bench_local(|| match instructions {
            // SAFETY: only sets that this machine has are asked for.
            InstructionSet::Avx512 => unsafe { avx512() },
            InstructionSet::Avx2 => unsafe { avx2() },
            InstructionSet::Portable => unreachable!("not one of the sets of vectors"),
        });
}

#[cfg(target_arch = "x86_64")]
fn vector_sets() -> Vec<InstructionSet> {
    let mut sets = InstructionSet::available();
    sets.retain(|set| *set != InstructionSet::Portable);
    sets
}

/// Periods in which the shaft warms up before the full model is measured.
const WARMING: u32 = 8;

impl Phase {
    fn advance(&self, bencher: Bencher, backend: &mut dyn Backend) {
        let points = self.case.points();
        // the slices of all iterations stay within the measured periods
        let settings = Settings {
            sampling: Sampling {
                periods: 1_000_000,
                ..self.case.settings().sampling
            },
            ..self.case.settings()
        };
        backend
            .load(&settings, &Instance::starts(&points))
            .expect("the grid fits");
        if self.case.scheme.carries_heat() {
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
            .counter(ItemsCount::new(points.len() * PERIODS as usize))
            .bench_local(|| {
                backend
                    .advance(&Slice {
                        stage: self.stage,
                        first,
                        periods: PERIODS,
                        elapsed: first,
                    })
                    .expect("the backend works");
                first += PERIODS;
            });
    }
}
