//! The CPU backend: blocks of lanes on all cores, f64 (the reference) or f32.
//!
//! Owns the dispatch by instruction set, once a batch and outside the loops; the arithmetic is the model's and the
//! scheme's, written once over the lane type.

mod block;
mod instructions;

use rayon::prelude::*;

use self::block::{Block, Run};
pub use self::instructions::InstructionSet;
use super::{Backend, BackendError, EndState, Slice, Sums};
use crate::experiment::{Precision, Settings};
use crate::lanes::{Real, Wide};
use crate::measurement::BackendKind;
use crate::parameters::ParameterSet;

#[cfg(target_arch = "x86_64")]
use crate::lanes::x86::{F32x8, F32x16, F64x4, F64x8};

/// Vectors in flight with tangent vectors; measured on AVX-512, as is the next.
const IN_FLIGHT: usize = 2;
/// Groups of so many vectors that make a block.
const GROUPS: usize = 3;
/// Lanes of the portable set.
const PORTABLE: usize = 4;

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

    fn batch_size(&self) -> usize {
        // some seconds of work, in many more blocks than there are threads
        2048 * rayon::current_num_threads()
    }

    fn load(&mut self, settings: &Settings, instances: &[ParameterSet]) -> Result<(), BackendError> {
        fn boxed<R: Real + Send + Sync + 'static>(
            advance: AdvanceBlock<R>,
            settings: &Settings,
            instances: &[ParameterSet],
        ) -> Box<dyn Batch> {
            Box::new(Blocks::<R>::new(advance, settings, instances))
        }
        self.batch = Some(match (self.instructions, self.precision) {
            #[cfg(target_arch = "x86_64")]
            (InstructionSet::Avx512, Precision::F64) => {
                boxed::<Wide<F64x8, IN_FLIGHT>>(advance_avx512, settings, instances)
            }
            #[cfg(target_arch = "x86_64")]
            (InstructionSet::Avx512, Precision::F32) => {
                boxed::<Wide<F32x16, IN_FLIGHT>>(advance_avx512, settings, instances)
            }
            #[cfg(target_arch = "x86_64")]
            (InstructionSet::Avx2, Precision::F64) => {
                boxed::<Wide<F64x4, IN_FLIGHT>>(advance_avx2, settings, instances)
            }
            #[cfg(target_arch = "x86_64")]
            (InstructionSet::Avx2, Precision::F32) => {
                boxed::<Wide<F32x8, IN_FLIGHT>>(advance_avx2, settings, instances)
            }
            (_, Precision::F64) => boxed::<Wide<f64, PORTABLE>>(advance_portable, settings, instances),
            (_, Precision::F32) => boxed::<Wide<f32, PORTABLE>>(advance_portable, settings, instances),
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

/// A batch of any lane type.
trait Batch: Send {
    fn advance(&mut self, slice: &Slice);
    fn collect(&mut self) -> Vec<Sums>;
    fn end_states(&self) -> Vec<EndState>;
}

/// Carries one block on by a slice, compiled for an instruction set.
///
/// # Safety
/// The machine must have the instruction set.
type AdvanceBlock<R> = unsafe fn(&mut Block<R, GROUPS>, &Run<<R as Real>::Scalar>, &Slice);

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx2,fma")]
unsafe fn advance_avx512<R: Real>(block: &mut Block<R, GROUPS>, run: &Run<R::Scalar>, slice: &Slice) {
    block.advance(run, slice);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
unsafe fn advance_avx2<R: Real>(block: &mut Block<R, GROUPS>, run: &Run<R::Scalar>, slice: &Slice) {
    block.advance(run, slice);
}

unsafe fn advance_portable<R: Real>(block: &mut Block<R, GROUPS>, run: &Run<R::Scalar>, slice: &Slice) {
    block.advance(run, slice);
}

struct Blocks<R: Real> {
    advance: AdvanceBlock<R>,
    run: Run<R::Scalar>,
    blocks: Vec<Block<R, GROUPS>>,
    instances: usize,
}

impl<R: Real> Blocks<R> {
    fn new(advance: AdvanceBlock<R>, settings: &Settings, instances: &[ParameterSet]) -> Self {
        let blocks = instances
            .chunks(Block::<R, GROUPS>::INSTANCES)
            .map(|chunk| Block::new(chunk, settings.steps_per_period))
            .collect();
        Self {
            advance,
            run: Run::new::<R>(settings),
            blocks,
            instances: instances.len(),
        }
    }

    fn for_instances<T>(&self, value: impl Fn(&Block<R, GROUPS>, usize) -> T) -> Vec<T> {
        let size = Block::<R, GROUPS>::INSTANCES;
        (0..self.instances)
            .map(|index| value(&self.blocks[index / size], index % size))
            .collect()
    }
}

impl<R: Real + Send + Sync> Batch for Blocks<R> {
    fn advance(&mut self, slice: &Slice) {
        let (run, advance) = (&self.run, self.advance);
        self.blocks.par_iter_mut().for_each(|block| {
            // SAFETY: `CpuBackend` pairs the function with the instruction set it has found available.
            unsafe { advance(block, run, slice) };
        });
    }

    fn collect(&mut self) -> Vec<Sums> {
        let sums = self.for_instances(Block::sums);
        self.blocks.iter_mut().for_each(Block::clear_sums);
        sums
    }

    fn end_states(&self) -> Vec<EndState> {
        self.for_instances(Block::end_state)
    }
}
