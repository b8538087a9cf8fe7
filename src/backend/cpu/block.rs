//! A block of instances that one thread carries on.
//!
//! Owns the loops over forcing periods and steps; compiled for each instruction set by its caller.

use std::f64::consts::TAU;

use super::super::{EndState, Slice, Stage, Sums};
use crate::dynamics::drive::DriveTable;
use crate::dynamics::rk4::{self, StageSpeeds, State, StepSize};
use crate::dynamics::statistics;
use crate::dynamics::stroboscope::{self, Stroboscope};
use crate::dynamics::tangent::{Bases, Growth};
use crate::experiment::Settings;
use crate::lanes::{Mask, Real, Wide};
use crate::measurement::RUNAWAY_BOUND;
use crate::model::motion::Motion;
use crate::parameters::{Parameter, ParameterSet};

/// What all instances of a batch share.
pub(super) struct Run<S> {
    drive: DriveTable<S>,
    birkhoff_weights: Vec<f64>,
    renormalise_every: usize,
    /// Measured periods before the stroboscopic window.
    unrecorded: u32,
    period_tolerance: f64,
}

impl<S: Copy> Run<S> {
    pub fn new<R: Real<Scalar = S>>(settings: &Settings) -> Self {
        Self {
            drive: DriveTable::new::<R>(settings.steps_per_period),
            birkhoff_weights: statistics::birkhoff_weights(settings.periods),
            renormalise_every: settings.renormalise_every as usize,
            unrecorded: settings.periods - stroboscope::window(settings.periods),
            period_tolerance: settings.period_tolerance,
        }
    }
}

/// The instances of `G` groups. The motion alone is stepped for all groups together: so many independent vectors hide
/// each other's latency. With tangent vectors a group has enough of its own, and more would not fit the registers.
pub(super) struct Block<R, const G: usize> {
    motion: Motion<Wide<R, G>>,
    h: StepSize<Wide<R, G>>,
    groups: [Group<R>; G],
}

impl<R: Real, const G: usize> Block<R, G> {
    /// Number of instances that a block holds.
    pub const INSTANCES: usize = R::LANES * G;

    /// A block of at most [`Block::INSTANCES`] instances; it is filled up with copies of the last one.
    pub fn new(instances: &[ParameterSet], steps_per_period: u32) -> Self {
        let instance = |index: usize| &instances[index.min(instances.len() - 1)];
        let h = |index| TAU / (instance(index)[Parameter::Omega0] * f64::from(steps_per_period));
        Self {
            motion: Motion::new(|parameter| Wide::from_lanes(|lane| instance(lane)[parameter])),
            h: StepSize::new(h),
            groups: std::array::from_fn(|group| {
                let first = group * R::LANES;
                Group::new(|lane| instance(first + lane), |lane| h(first + lane))
            }),
        }
    }

    #[inline(always)]
    pub fn advance(&mut self, run: &Run<R::Scalar>, slice: &Slice) {
        for n in 0..slice.periods {
            if slice.stage == Stage::Transient {
                self.period(run);
            }
            for group in &mut self.groups {
                match slice.stage {
                    Stage::Transient => {}
                    Stage::Align => {
                        group.period_with_tangent(run);
                    }
                    Stage::Measure => group.measured_period(run, slice.first + n),
                }
                group.note_runaways(slice.elapsed + n + 1);
            }
        }
    }

    /// One forcing period of the motion alone.
    #[inline(always)]
    fn period(&mut self, run: &Run<R::Scalar>) {
        let (motion, h) = (self.motion, self.h);
        let mut state = State {
            x: Wide::from_parts(|group| self.groups[group].state.x),
            y: Wide::from_parts(|group| self.groups[group].state.y),
        };
        let mut start = motion.shaft_speed(Wide::splat(0.0));
        for &[middle, end] in run.drive.steps() {
            let speed = StageSpeeds {
                start,
                middle: motion.shaft_speed(Wide::broadcast(middle)),
                end: motion.shaft_speed(Wide::broadcast(end)),
            };
            state = rk4::step(&motion, &h, speed, state);
            start = speed.end;
        }
        for (group, (x, y)) in self
            .groups
            .iter_mut()
            .zip(state.x.parts().into_iter().zip(state.y.parts()))
        {
            group.state = State { x, y };
        }
    }

    /// Sums of an instance since they were last cleared.
    pub fn sums(&self, index: usize) -> Sums {
        let (group, lane) = (&self.groups[index / R::LANES], index % R::LANES);
        Sums {
            growth: [group.growth.first.lane(lane), group.growth.second.lane(lane)],
            birkhoff: group.birkhoff.lane(lane),
            divergence: group.divergence.lane(lane),
        }
    }

    pub fn clear_sums(&mut self) {
        for group in &mut self.groups {
            group.clear_sums();
        }
    }

    pub fn end_state(&self, index: usize) -> EndState {
        let (group, lane) = (&self.groups[index / R::LANES], index % R::LANES);
        EndState {
            x: group.state.x.lane(lane),
            y: group.state.y.lane(lane),
            x_min: group.x_min.lane(lane),
            x_max: group.x_max.lane(lane),
            candidates: group.stroboscopes[lane].candidates(),
            runaway_period: group.runaway_periods[lane],
        }
    }
}

/// As many instances as the lane type holds, and everything that is carried along with them.
struct Group<R> {
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

impl<R: Real> Group<R> {
    fn new<'a>(instance: impl Fn(usize) -> &'a ParameterSet, h: impl Fn(usize) -> f64) -> Self {
        let lanes = |parameter| R::from_lanes(|lane| instance(lane)[parameter]);
        let zero = R::splat(0.0);
        Self {
            motion: Motion::new(lanes),
            h: StepSize::new(h),
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
