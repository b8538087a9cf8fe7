//! The CPU backend: blocks of lanes on all cores, f64 (the reference) or f32.
//!
//! Owns the dispatch by instruction set, outside the loops; the arithmetic is the model's and the
//! scheme's, written once over the lane type. The schemes are long and are compiled for every lane type. The library's unit
//! tests therefore have the portable lane types alone, which halves the time that a build of all tests takes.

mod instructions;
mod radau;
mod record;
mod rk4;
mod taylor;

use rayon::prelude::*;

pub use self::instructions::InstructionSet;
use self::radau::RadauBlock;
use self::rk4::Rk4Block;
use self::taylor::TaylorBlock;
use super::{Backend, BackendError, EndState, Instance, Slice, Sums, check_states};
use crate::backend::BackendKind;
use crate::experiment::{Precision, Scheme, Settings};
#[cfg(all(target_arch = "x86_64", not(test)))]
use crate::lanes::x86::{Avx2, Avx512, OverLanes};
use crate::lanes::{Held, Instructions, Pair, Portable, Real, Wide};

/// Vectors that rk4 works on together where it carries tangent vectors. This number and the next two were measured on AVX-512.
const RK4_IN_FLIGHT: usize = 2;
/// Number of such groups of vectors in a block of rk4.
const RK4_GROUPS: usize = 2;

/// Instances in a batch: a second of work for a thread. The few of them that are left undecided still fill several blocks.
const BATCH: usize = 4096;

/// Least number of instances for which another thread pays where something is only read from each.
const READ_A_THREAD: usize = 256;

/// Integrates on all cores of the machine.
pub struct CpuBackend {
    precision: Precision,
    instructions: InstructionSet,
    batch: Option<Box<dyn CpuBatch>>,
}

impl CpuBackend {
    /// The backend with the fastest instruction set of this machine.
    pub fn new(precision: Precision) -> Self {
        Self {
            precision,
            instructions: InstructionSet::available()[0],
            batch: None,
        }
    }

    /// The backend with another instruction set.
    ///
    /// # Panics
    /// If this machine does not have it.
    pub fn with_instructions(precision: Precision, instructions: InstructionSet) -> Self {
        assert!(
            InstructionSet::available().contains(&instructions),
            "this machine has no {}",
            instructions.name()
        );
        Self {
            precision,
            instructions,
            batch: None,
        }
    }

    fn batch(&mut self) -> &mut dyn CpuBatch {
        self.batch
            .as_deref_mut()
            .expect("a batch is loaded before it is advanced")
    }
}

/// The number of threads, in words.
pub fn threads() -> String {
    let threads = rayon::current_num_threads();
    format!("{threads} thread{}", if threads == 1 { "" } else { "s" })
}

impl Backend for CpuBackend {
    fn kind(&self) -> BackendKind {
        match self.precision {
            Precision::F64 => BackendKind::CpuF64,
            Precision::F32 => BackendKind::CpuF32,
        }
    }

    fn device(&self) -> String {
        let lanes = self.instructions.lanes(self.precision);
        format!(
            "CPU, {} lanes of {} {}, {}",
            self.instructions.name(),
            lanes,
            self.kind().precision(),
            threads()
        )
    }

    /// One for each further thread. A thread that has no batch of its own left helps the others with theirs.
    fn others(&self) -> Vec<Box<dyn Backend>> {
        (1..rayon::current_num_threads())
            .map(|_| Box::new(Self::with_instructions(self.precision, self.instructions)) as Box<dyn Backend>)
            .collect()
    }

    fn batch_size(&self, _: &Settings) -> usize {
        BATCH
    }

    fn load(&mut self, settings: &Settings, instances: &[Instance]) -> Result<(), BackendError> {
        check_states(settings, instances)?;
        #[cfg(all(target_arch = "x86_64", not(test)))]
        let blocks = NewBlocks { settings, instances };
        self.batch = Some(match (self.instructions, self.precision) {
            #[cfg(all(target_arch = "x86_64", not(test)))]
            (InstructionSet::Avx512, precision) => {
                let avx512 = Avx512::detect().expect(AVAILABLE);
                match precision {
                    Precision::F64 => avx512.over_f64(blocks),
                    Precision::F32 => avx512.over_f32(blocks),
                }
            }
            #[cfg(all(target_arch = "x86_64", not(test)))]
            (InstructionSet::Avx2, precision) => {
                let avx2 = Avx2::detect().expect(AVAILABLE);
                match precision {
                    Precision::F64 => avx2.over_f64(blocks),
                    Precision::F32 => avx2.over_f32(blocks),
                }
            }
            (_, Precision::F64) => batch::<Portable, Pair<f64>, Quad<f64>>(Portable, settings, instances),
            (_, Precision::F32) => batch::<Portable, Pair<f32>, Quad<f32>>(Portable, settings, instances),
        });
        Ok(())
    }

    fn advance(&mut self, slice: &Slice) -> Result<(), BackendError> {
        self.batch().advance(slice);
        Ok(())
    }

    fn collect(&mut self) -> Result<Vec<Sums>, BackendError> {
        Ok(self.batch().collect())
    }

    fn end_states(&mut self) -> Result<Vec<EndState>, BackendError> {
        Ok(self.batch().end_states())
    }
}

/// This was ensured when the backend was made.
#[cfg(all(target_arch = "x86_64", not(test)))]
const AVAILABLE: &str = "a backend has only instructions that are available";

/// Four vectors together, of which Taylor's blocks are made: the operations of one vector, or of two, wait for each other too
/// long to keep a core busy.
type Quad<V> = Pair<Pair<V>>;

/// The batch for a scheme, in vectors `V` of the instruction set `I`. Taylor's blocks use `T` instead, several such vectors
/// together.
fn batch<I: Instructions, V: Real + Send + Sync + 'static, T: Real + Send + Sync + 'static>(
    instructions: I,
    settings: &Settings,
    instances: &[Instance],
) -> Box<dyn CpuBatch> {
    match settings.integration.scheme {
        Scheme::Taylor => Box::new(Blocks::<I, TaylorBlock<T>>::new(instructions, settings, instances)),
        Scheme::Radau => Box::new(Blocks::<I, RadauBlock<V>>::new(instructions, settings, instances)),
        Scheme::Rk4 => Box::new(Blocks::<I, Rk4Block<Wide<V, RK4_IN_FLIGHT>, RK4_GROUPS>>::new(
            instructions,
            settings,
            instances,
        )),
    }
}

/// Everything that a batch is made of, except its lane type.
#[cfg(all(target_arch = "x86_64", not(test)))]
struct NewBlocks<'a> {
    settings: &'a Settings,
    instances: &'a [Instance],
}

#[cfg(all(target_arch = "x86_64", not(test)))]
impl OverLanes for NewBlocks<'_> {
    type Output = Box<dyn CpuBatch>;

    fn carry_out<I: Instructions, V: Real + Send + Sync + 'static>(self, instructions: I) -> Box<dyn CpuBatch> {
        batch::<I, V, Quad<V>>(instructions, self.settings, self.instances)
    }
}

/// A batch of any scheme and lane type.
trait CpuBatch: Send {
    fn advance(&mut self, slice: &Slice);
    fn collect(&mut self) -> Vec<Sums>;
    fn end_states(&self) -> Vec<EndState>;
}

/// Instances that one thread carries on together by one scheme.
trait Block: Send + Sync + Sized {
    /// Data that all instances of a batch share.
    type Run: Send + Sync;
    /// Number of instances that a block holds.
    const INSTANCES: usize;

    fn run(settings: &Settings, instances: &[Instance]) -> Self::Run;

    /// A block of at most [`Block::INSTANCES`] instances; it is filled up with copies of the last one.
    fn new(run: &Self::Run, settings: &Settings, instances: &[Instance]) -> Self;

    /// Whether the motion alone is left to [`Block::advance_plain`]. It is a separate function, since compilers take much longer for
    /// one function of twice the size.
    const IS_SPLIT: bool = false;

    /// Advances the block by a slice, and sums up if the slice is measured. This function, the next one, and all functions that
    /// they call in their loops must be `#[inline(always)]`, so that they are compiled for the caller's instruction set.
    fn advance(&mut self, run: &Self::Run, slice: &Slice);

    /// Advances the motion alone by a slice.
    #[inline(always)]
    fn advance_plain(&mut self, _: &Self::Run, _: &Slice) {
        unreachable!("only a split block is advanced in this way")
    }

    /// Sums of an instance since they were last cleared.
    fn sums(&self, index: usize) -> Sums;
    fn clear_sums(&mut self);
    fn end_state(&self, index: usize) -> EndState;
}

/// The blocks of a batch, in lanes of the instructions `I`.
#[expect(clippy::struct_field_names, reason = "the struct is named after its main field")]
struct Blocks<I, B: Block> {
    run: Held<I, B::Run>,
    blocks: Vec<Held<I, B>>,
    instances: usize,
}

impl<I: Instructions, B: Block> Blocks<I, B> {
    fn new(instructions: I, settings: &Settings, instances: &[Instance]) -> Self {
        let run = Held::new(instructions, || B::run(settings, instances));
        let block = |chunk| Held::new(instructions, || run.with(|run| B::new(run, settings, chunk)));
        Self {
            blocks: instances.chunks(B::INSTANCES).map(block).collect(),
            run,
            instances: instances.len(),
        }
    }

    fn for_instances<T: Send>(&self, value: impl Fn(&B, usize) -> T + Sync) -> Vec<T> {
        (0..self.instances)
            .into_par_iter()
            .with_min_len(READ_A_THREAD)
            .map(|index| self.blocks[index / B::INSTANCES].with(|block| value(block, index % B::INSTANCES)))
            .collect()
    }
}

impl<I: Instructions, B: Block> CpuBatch for Blocks<I, B> {
    fn advance(&mut self, slice: &Slice) {
        let blocks = self.blocks.par_iter_mut();
        // the code that advances a block is inlined, so that it is compiled for the instructions
        self.run.with(|run| {
            if B::IS_SPLIT && slice.stage.is_plain() {
                blocks.for_each(|block| {
                    block.with_mut(
                        #[inline(always)]
                        |block| block.advance_plain(run, slice),
                    );
                });
            } else {
                blocks.for_each(|block| {
                    block.with_mut(
                        #[inline(always)]
                        |block| block.advance(run, slice),
                    );
                });
            }
        });
    }

    fn collect(&mut self) -> Vec<Sums> {
        let sums = self.for_instances(B::sums);
        self.blocks.iter_mut().for_each(|block| block.with_mut(B::clear_sums));
        sums
    }

    fn end_states(&self) -> Vec<EndState> {
        self.for_instances(B::end_state)
    }
}
