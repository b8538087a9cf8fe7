//! The CPU backend: blocks of lanes on all cores, f64 (the reference) or f32.
//!
//! Owns the dispatch by instruction set, once a batch and outside the loops; the arithmetic is the model's and the
//! scheme's, written once over the lane type.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::{Backend, BackendError, EndState, Slice, Stage, Sums};
use crate::dynamics::drive::DriveTable;
use crate::dynamics::rk4::{self, StageSpeeds, State, StepSize};
use crate::dynamics::statistics;
use crate::dynamics::stroboscope::{self, Stroboscope};
use crate::dynamics::tangent::{Bases, Growth};
use crate::experiment::{Precision, Settings};
use crate::lanes::{Mask, Real, Wide};
use crate::measurement::{BackendKind, RUNAWAY_BOUND};
use crate::model::motion::Motion;
use crate::parameters::{Parameter, ParameterSet};

#[cfg(target_arch = "x86_64")]
use crate::lanes::x86::{F32x8, F32x16, F64x4, F64x8};

/// A set of vector instructions that the lanes are compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InstructionSet {
    Avx512,
    Avx2,
    /// What every machine of the target has (on x86-64 SSE2, on aarch64 NEON).
    Portable,
}

impl InstructionSet {
    /// Those that this machine has, the fastest first.
    pub fn available() -> Vec<Self> {
        [Self::Avx512, Self::Avx2, Self::Portable]
            .into_iter()
            .filter(|set| set.is_available())
            .collect()
    }

    #[cfg(target_arch = "x86_64")]
    fn is_available(self) -> bool {
        match self {
            Self::Avx512 => {
                is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx2")
                    && is_x86_feature_detected!("fma")
            }
            Self::Avx2 => is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"),
            Self::Portable => true,
        }
    }

    #[cfg(not(target_arch = "x86_64"))]
    fn is_available(self) -> bool {
        self == Self::Portable
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Avx512 => "AVX-512",
            Self::Avx2 => "AVX2 + FMA",
            Self::Portable => "portable",
        }
    }

    /// Numbers in one vector register; for the portable set, worked on together.
    pub fn lanes(self, precision: Precision) -> usize {
        match (self, precision) {
            (Self::Avx512, Precision::F64) | (Self::Avx2, Precision::F32) => 8,
            (Self::Avx512, Precision::F32) => 16,
            (Self::Avx2, Precision::F64) | (Self::Portable, _) => 4,
        }
    }
}

/// Vectors in flight: on AVX-512 a plain step at 6 is within some percent of the hardware's peak.
const IN_FLIGHT: usize = 6;
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
            instructions.is_available(),
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
        fn boxed<R: Real + Send + 'static>(
            advance: AdvanceBlock<R>,
            settings: &Settings,
            instances: &[ParameterSet],
        ) -> Box<dyn Batch>
        where
            Motion<R>: Send + Sync,
            R: Sync,
        {
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
type AdvanceBlock<R> = unsafe fn(&mut Block<R>, &Run<<R as Real>::Scalar>, &Slice);

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx2,fma")]
unsafe fn advance_avx512<R: Real>(block: &mut Block<R>, run: &Run<R::Scalar>, slice: &Slice) {
    block.advance(run, slice);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
unsafe fn advance_avx2<R: Real>(block: &mut Block<R>, run: &Run<R::Scalar>, slice: &Slice) {
    block.advance(run, slice);
}

unsafe fn advance_portable<R: Real>(block: &mut Block<R>, run: &Run<R::Scalar>, slice: &Slice) {
    block.advance(run, slice);
}

/// What all instances of a batch share.
struct Run<S> {
    drive: DriveTable<S>,
    birkhoff_weights: Vec<f64>,
    renormalise_every: usize,
    /// Measured periods before the stroboscopic window.
    unrecorded: u32,
    period_tolerance: f64,
}

struct Blocks<R: Real> {
    advance: AdvanceBlock<R>,
    run: Run<R::Scalar>,
    blocks: Vec<Block<R>>,
    instances: usize,
}

impl<R: Real> Blocks<R> {
    fn new(advance: AdvanceBlock<R>, settings: &Settings, instances: &[ParameterSet]) -> Self {
        let run = Run {
            drive: DriveTable::new::<R>(settings.steps_per_period),
            birkhoff_weights: statistics::birkhoff_weights(settings.periods),
            renormalise_every: settings.renormalise_every as usize,
            unrecorded: settings.periods - stroboscope::window(settings.periods),
            period_tolerance: settings.period_tolerance,
        };
        let blocks = instances
            .chunks(R::LANES)
            .map(|chunk| Block::new(chunk, settings.steps_per_period))
            .collect();
        Self {
            advance,
            run,
            blocks,
            instances: instances.len(),
        }
    }

    fn for_instances<T>(&self, value: impl Fn(&Block<R>, usize) -> T) -> Vec<T> {
        (0..self.instances)
            .map(|index| value(&self.blocks[index / R::LANES], index % R::LANES))
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
        let sums = self.for_instances(|block, lane| Sums {
            growth: [block.growth.first.lane(lane), block.growth.second.lane(lane)],
            birkhoff: block.birkhoff.lane(lane),
            divergence: block.divergence.lane(lane),
        });
        for block in &mut self.blocks {
            block.clear_sums();
        }
        sums
    }

    fn end_states(&self) -> Vec<EndState> {
        self.for_instances(|block, lane| EndState {
            x: block.state.x.lane(lane),
            y: block.state.y.lane(lane),
            x_min: block.x_min.lane(lane),
            x_max: block.x_max.lane(lane),
            candidates: block.stroboscopes[lane].candidates(),
            runaway_period: block.runaway_periods[lane],
        })
    }
}

/// As many instances as the lane type holds; a last block is filled up with copies.
struct Block<R> {
    motion: Motion<R>,
    h: StepSize<R>,
    state: State<R>,
    bases: Bases<R>,
    growth: Growth<R>,
    birkhoff: R,
    divergence: R,
    x_min: R,
    x_max: R,
    stroboscopes: Vec<Stroboscope>,
    runaway_periods: Vec<Option<u32>>,
}

impl<R: Real> Block<R> {
    fn new(instances: &[ParameterSet], steps_per_period: u32) -> Self {
        let value = |parameter, lane: usize| instances[lane.min(instances.len() - 1)][parameter];
        let lanes = |parameter| R::from_lanes(|lane| value(parameter, lane));
        let zero = R::splat(0.0);
        Self {
            motion: Motion::new(lanes),
            h: StepSize::new(|lane| TAU / (value(Parameter::Omega0, lane) * f64::from(steps_per_period))),
            state: State {
                x: lanes(Parameter::X0),
                y: lanes(Parameter::Y0),
            },
            bases: Bases::start(),
            growth: Growth {
                first: zero,
                second: zero,
            },
            birkhoff: zero,
            divergence: zero,
            x_min: R::splat(f64::INFINITY),
            x_max: R::splat(f64::NEG_INFINITY),
            stroboscopes: vec![Stroboscope::default(); R::LANES],
            runaway_periods: vec![None; R::LANES],
        }
    }

    fn clear_sums(&mut self) {
        let zero = R::splat(0.0);
        self.growth = Growth {
            first: zero,
            second: zero,
        };
        self.birkhoff = zero;
        self.divergence = zero;
    }

    #[inline(always)]
    fn advance(&mut self, run: &Run<R::Scalar>, slice: &Slice) {
        for n in 0..slice.periods {
            match slice.stage {
                Stage::Transient => self.period(run),
                Stage::Align => {
                    self.period_with_tangent(run);
                }
                Stage::Measure => self.measured_period(run, slice.first + n),
            }
            self.note_runaways(slice.elapsed + n + 1);
        }
    }

    /// One forcing period of the motion alone.
    #[inline(always)]
    fn period(&mut self, run: &Run<R::Scalar>) {
        let (motion, h) = (self.motion, self.h);
        let mut state = self.state;
        let mut start = motion.shaft_speed(R::splat(0.0));
        for &[middle, end] in run.drive.steps() {
            let speed = StageSpeeds {
                start,
                middle: motion.shaft_speed(R::broadcast(middle)),
                end: motion.shaft_speed(R::broadcast(end)),
            };
            state = rk4::step(&motion, &h, speed, state);
            start = speed.end;
        }
        self.state = state;
    }

    /// One forcing period with tangent vectors and extremes of x; returns growth and divergence over it.
    #[inline(always)]
    fn period_with_tangent(&mut self, run: &Run<R::Scalar>) -> (Growth<R>, R) {
        let (motion, h) = (self.motion, self.h);
        let (mut state, mut bases) = (self.state, self.bases);
        let (mut x_min, mut x_max) = (self.x_min, self.x_max);
        let zero = R::splat(0.0);
        let mut growth = Growth {
            first: zero,
            second: zero,
        };
        let mut divergence = zero;
        let mut start = motion.shaft_speed(zero);
        for steps in run.drive.steps().chunks(run.renormalise_every) {
            for &[middle, end] in steps {
                let speed = StageSpeeds {
                    start,
                    middle: motion.shaft_speed(R::broadcast(middle)),
                    end: motion.shaft_speed(R::broadcast(end)),
                };
                let step_divergence;
                (state, bases, step_divergence) = rk4::step_with_tangent(&motion, &h, speed, state, bases);
                divergence = divergence + step_divergence;
                x_min = x_min.min(state.x);
                x_max = x_max.max(state.x);
                start = speed.end;
            }
            let norms = bases.orthonormalise();
            growth = Growth {
                first: growth.first + norms.first,
                second: growth.second + norms.second,
            };
        }
        (self.state, self.bases) = (state, bases);
        (self.x_min, self.x_max) = (x_min, x_max);
        (growth, divergence)
    }

    #[inline(always)]
    fn measured_period(&mut self, run: &Run<R::Scalar>, index: u32) {
        if index == 0 {
            self.x_min = self.state.x;
            self.x_max = self.state.x;
        }
        let (growth, divergence) = self.period_with_tangent(run);
        let weight = R::splat(run.birkhoff_weights[index as usize]);
        self.growth.first = self.growth.first + growth.first;
        self.growth.second = self.growth.second + growth.second;
        self.birkhoff = growth.first.mul_add(weight, self.birkhoff);
        self.divergence = self.divergence + divergence;
        if index >= run.unrecorded {
            for (lane, stroboscope) in self.stroboscopes.iter_mut().enumerate() {
                stroboscope.record(self.state.x.lane(lane), self.state.y.lane(lane), run.period_tolerance);
            }
        }
    }

    #[inline(always)]
    fn note_runaways(&mut self, period: u32) {
        let bound = R::splat(RUNAWAY_BOUND);
        let inside = (self.state.x.abs() + self.state.y.abs()).less(bound);
        if !inside.all() {
            for (lane, runaway) in self.runaway_periods.iter_mut().enumerate() {
                if !inside.lane(lane) && runaway.is_none() {
                    *runaway = Some(period);
                }
            }
        }
    }
}
