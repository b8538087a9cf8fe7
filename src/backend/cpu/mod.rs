//! The CPU backend: blocks of lanes on all cores, f64 (the reference) or f32.
//!
//! Owns the dispatch by instruction set, once a batch and outside the loops; the arithmetic is the model's and the
//! scheme's, written once over the lane type. The schemes are long, and compiled for every lane type: the library's unit
//! tests have the portable ones alone, which halves the time that a build of all tests takes.

mod instructions;
mod radau;
mod record;
mod rk4;
mod taylor;

use std::marker::PhantomData;

use rayon::prelude::*;

pub use self::instructions::InstructionSet;
use self::radau::RadauBlock;
use self::rk4::Rk4Block;
use self::taylor::TaylorBlock;
use super::{Backend, BackendError, EndState, Slice, Stage, Sums};
use crate::backend::BackendKind;
use crate::experiment::{Precision, Scheme, Settings};
use crate::lanes::{Pair, Real, Wide};
use crate::parameters::ParameterSet;

#[cfg(all(target_arch = "x86_64", not(test)))]
use crate::lanes::x86::{F32x8, F32x16, F64x4, F64x8};

/// Vectors in flight of rk4 with tangent vectors; measured on AVX-512, as are the next two.
const RK4_IN_FLIGHT: usize = 2;
/// Groups of so many vectors that make a block of rk4.
const RK4_GROUPS: usize = 2;

/// Integrates on all cores of the machine.
pub struct CpuBackend {
    precision: Precision,
    instructions: InstructionSet,
    batch: Option<Box<dyn Batch>>,
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

    fn batch(&mut self) -> &mut dyn Batch {
        self.batch
            .as_deref_mut()
            .expect("a batch is loaded before it is advanced")
    }
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
        let threads = rayon::current_num_threads();
        format!(
            "CPU, {} lanes of {} {}, {threads} threads",
            self.instructions.name(),
            lanes,
            self.kind().precision()
        )
    }

    fn batch_size(&self, _: &Settings) -> usize {
        // a second of work, in many more blocks than there are threads, which wait for each other after every slice of it
        4096 * rayon::current_num_threads()
    }

    fn load(&mut self, settings: &Settings, instances: &[ParameterSet]) -> Result<(), BackendError> {
        self.batch = Some(match (self.instructions, self.precision) {
            #[cfg(all(target_arch = "x86_64", not(test)))]
            (InstructionSet::Avx512, Precision::F64) => batch::<Avx512, F64x8, Quad<F64x8>>(settings, instances),
            #[cfg(all(target_arch = "x86_64", not(test)))]
            (InstructionSet::Avx512, Precision::F32) => batch::<Avx512, F32x16, Quad<F32x16>>(settings, instances),
            #[cfg(all(target_arch = "x86_64", not(test)))]
            (InstructionSet::Avx2, Precision::F64) => batch::<Avx2, F64x4, Quad<F64x4>>(settings, instances),
            #[cfg(all(target_arch = "x86_64", not(test)))]
            (InstructionSet::Avx2, Precision::F32) => batch::<Avx2, F32x8, Quad<F32x8>>(settings, instances),
            (_, Precision::F64) => batch::<Portable, Pair<f64>, Quad<f64>>(settings, instances),
            (_, Precision::F32) => batch::<Portable, Pair<f32>, Quad<f32>>(settings, instances),
        });
        Ok(())
    }

    fn set_tangents(&mut self, tangents: &[[f64; 2]]) -> Result<(), BackendError> {
        self.batch().set_tangents(tangents)
    }

    fn begin_anew(&mut self, settings: &Settings) {
        self.batch().begin_anew(settings);
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

/// What Taylor's blocks are made of: the operations of one vector, or of two, wait for each other too long to fill the
/// machine.
type Quad<V> = Pair<Pair<V>>;

/// The batch for a scheme, in vectors `V` of the instruction set `I`, or in `T`, as many of them as Taylor's blocks hold.
fn batch<I: Instructions, V: Real + Send + Sync + 'static, T: Real + Send + Sync + 'static>(
    settings: &Settings,
    instances: &[ParameterSet],
) -> Box<dyn Batch> {
    match settings.scheme() {
        Scheme::Taylor => Box::new(Blocks::<I, TaylorBlock<T>>::new(settings, instances)),
        Scheme::Radau => Box::new(Blocks::<I, RadauBlock<V>>::new(settings, instances)),
        Scheme::Rk4 => Box::new(Blocks::<I, Rk4Block<Wide<V, RK4_IN_FLIGHT>, RK4_GROUPS>>::new(
            settings, instances,
        )),
    }
}

/// A batch of any scheme and lane type.
trait Batch: Send {
    fn set_tangents(&mut self, tangents: &[[f64; 2]]) -> Result<(), BackendError>;
    fn begin_anew(&mut self, settings: &Settings);
    fn advance(&mut self, slice: &Slice);
    fn collect(&mut self) -> Vec<Sums>;
    fn end_states(&self) -> Vec<EndState>;
}

/// Instances that one thread carries on together by one scheme.
trait Block: Send + Sync + Sized {
    /// What all instances of a batch share.
    type Run: Send + Sync;
    /// Number of instances that a block holds.
    const INSTANCES: usize;

    fn run(settings: &Settings, instances: &[ParameterSet]) -> Self::Run;

    /// A block of at most [`Block::INSTANCES`] instances; it is filled up with copies of the last one.
    fn new(run: &Self::Run, settings: &Settings, instances: &[ParameterSet]) -> Self;

    /// Turns the first tangent vectors to what `tangent` gives for each instance, also those that fill the block up.
    ///
    /// # Errors
    /// If the tangent space has more than two dimensions.
    fn set_tangents(&mut self, tangent: impl Fn(usize) -> [f64; 2]) -> Result<(), BackendError>;

    /// Changes the lengths and the tolerance of a run of heat or wear.
    fn change(_: &mut Self::Run, _: &Settings) {
        unreachable!("only with heat or wear a batch goes on by other settings")
    }

    /// Whether the transient is [`Block::advance_plain`]'s; it is a function of its own since compilers take much longer
    /// over twice as much in one.
    const IS_SPLIT: bool = false;

    /// Carries the block on by a slice; sums up where its stage is to be measured. As the next function, it must be
    /// `#[inline(always)]`, as is all that it calls in its loops, so that it is compiled for its caller's instruction set.
    fn advance(&mut self, run: &Self::Run, slice: &Slice);

    /// Carries the motion alone on by a slice.
    #[inline(always)]
    fn advance_plain(&mut self, _: &Self::Run, _: &Slice) {
        unreachable!("only a split block is advanced in this way")
    }

    /// Sums of an instance since they were last cleared.
    fn sums(&self, index: usize) -> Sums;
    fn clear_sums(&mut self);
    fn end_state(&self, index: usize) -> EndState;
}

/// An instruction set that blocks are compiled for.
trait Instructions: 'static {
    /// [`Block::advance_plain`] with these instructions.
    ///
    /// # Safety
    /// The machine must have them.
    unsafe fn plain<B: Block>(block: &mut B, run: &B::Run, slice: &Slice);

    /// [`Block::advance`] with these instructions.
    ///
    /// # Safety
    /// The machine must have them.
    unsafe fn advance<B: Block>(block: &mut B, run: &B::Run, slice: &Slice);
}

/// A local variable as long as a cache line, and aligned to one.
///
/// The compiler aligns a function's stack for variables, but not for vectors that it puts aside because registers run out:
/// without such a variable most of these straddle two cache lines, and every access to them takes twice as long.
#[cfg(all(target_arch = "x86_64", not(test)))]
#[repr(align(64))]
struct CacheLine([u8; 64]);

#[cfg(all(target_arch = "x86_64", not(test)))]
macro_rules! align_stack {
    () => {
        let line = CacheLine([0; 64]);
        std::hint::black_box(&line.0);
    };
}

#[cfg(all(target_arch = "x86_64", not(test)))]
struct Avx512;
#[cfg(all(target_arch = "x86_64", not(test)))]
struct Avx2;
struct Portable;

#[cfg(all(target_arch = "x86_64", not(test)))]
impl Instructions for Avx512 {
    #[target_feature(enable = "avx512f,avx2,fma")]
    unsafe fn plain<B: Block>(block: &mut B, run: &B::Run, slice: &Slice) {
        align_stack!();
        block.advance_plain(run, slice);
    }
    #[target_feature(enable = "avx512f,avx2,fma")]
    unsafe fn advance<B: Block>(block: &mut B, run: &B::Run, slice: &Slice) {
        align_stack!();
        block.advance(run, slice);
    }
}

#[cfg(all(target_arch = "x86_64", not(test)))]
impl Instructions for Avx2 {
    #[target_feature(enable = "avx2,fma")]
    unsafe fn plain<B: Block>(block: &mut B, run: &B::Run, slice: &Slice) {
        align_stack!();
        block.advance_plain(run, slice);
    }
    #[target_feature(enable = "avx2,fma")]
    unsafe fn advance<B: Block>(block: &mut B, run: &B::Run, slice: &Slice) {
        align_stack!();
        block.advance(run, slice);
    }
}

impl Instructions for Portable {
    unsafe fn plain<B: Block>(block: &mut B, run: &B::Run, slice: &Slice) {
        block.advance_plain(run, slice);
    }
    unsafe fn advance<B: Block>(block: &mut B, run: &B::Run, slice: &Slice) {
        block.advance(run, slice);
    }
}

struct Blocks<I, B: Block> {
    run: B::Run,
    blocks: Vec<B>,
    instances: usize,
    instructions: PhantomData<fn() -> I>,
}

impl<I: Instructions, B: Block> Blocks<I, B> {
    fn new(settings: &Settings, instances: &[ParameterSet]) -> Self {
        let run = B::run(settings, instances);
        let blocks = instances.chunks(B::INSTANCES);
        Self {
            blocks: blocks.map(|chunk| B::new(&run, settings, chunk)).collect(),
            run,
            instances: instances.len(),
            instructions: PhantomData,
        }
    }

    fn for_instances<T: Send>(&self, value: impl Fn(&B, usize) -> T + Sync) -> Vec<T> {
        (0..self.instances)
            .into_par_iter()
            .with_min_len(256)
            .map(|index| value(&self.blocks[index / B::INSTANCES], index % B::INSTANCES))
            .collect()
    }
}

impl<I: Instructions, B: Block> Batch for Blocks<I, B> {
    fn set_tangents(&mut self, tangents: &[[f64; 2]]) -> Result<(), BackendError> {
        let last = tangents.len() - 1;
        let mut blocks = self.blocks.iter_mut().zip((0..).step_by(B::INSTANCES));
        blocks.try_for_each(|(block, first)| block.set_tangents(|index| tangents[(first + index).min(last)]))
    }

    fn begin_anew(&mut self, settings: &Settings) {
        B::change(&mut self.run, settings);
    }

    fn advance(&mut self, slice: &Slice) {
        let run = &self.run;
        let advance = if B::IS_SPLIT && slice.stage == Stage::Transient {
            I::plain::<B>
        } else {
            I::advance::<B>
        };
        self.blocks.par_iter_mut().for_each(|block| {
            // SAFETY: `CpuBackend` pairs lanes and instructions with the set that it has found available.
            unsafe { advance(block, run, slice) };
        });
    }

    fn collect(&mut self) -> Vec<Sums> {
        let sums = self.for_instances(B::sums);
        self.blocks.iter_mut().for_each(B::clear_sums);
        sums
    }

    fn end_states(&self) -> Vec<EndState> {
        self.for_instances(B::end_state)
    }
}
