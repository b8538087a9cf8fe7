//! A block of instances that one thread carries on by the fixed-step scheme.
//!
//! Owns the loops over forcing periods and steps; compiled for each instruction set by its caller.

use std::f64::consts::TAU;

use super::super::{BackendError, EndState, Slice, Stage, Sums};
use super::Block;
use super::record::{Measuring, Record};
use crate::dynamics::drive::DriveTable;
use crate::dynamics::rk4::{self, StageSpeeds, State, StepSize};
use crate::dynamics::tangent::{Bases, Growth, Vector};
use crate::experiment::Settings;
use crate::lanes::{Real, Wide};
use crate::model::motion::Motion;
use crate::parameters::{Parameter, ParameterSet};

/// What all instances of a batch share.
pub(super) struct Run<S> {
    drive: DriveTable<S>,
    measuring: Measuring,
    renormalise_every: usize,
}

/// The instances of `G` groups. The motion alone is stepped for all groups together: so many independent vectors hide
/// each other's latency. With tangent vectors a group has enough of its own, and more would not fit the registers.
pub(super) struct Rk4Block<R, const G: usize> {
    motion: Motion<Wide<R, G>>,
    h: StepSize<Wide<R, G>>,
    groups: [Group<R>; G],
}

impl<R: Real + Send + Sync, const G: usize> Block for Rk4Block<R, G> {
    type Run = Run<R::Scalar>;
    const INSTANCES: usize = R::LANES * G;
    const IS_SPLIT: bool = true;

    fn run(settings: &Settings, _: &[ParameterSet]) -> Self::Run {
        Run {
            drive: DriveTable::new::<R>(settings.steps_per_period()),
            measuring: Measuring::new(settings),
            renormalise_every: settings.renormalise_every as usize,
        }
    }

    fn new(_: &Self::Run, settings: &Settings, instances: &[ParameterSet]) -> Self {
        let instance = |index: usize| &instances[index.min(instances.len() - 1)];
        let steps = f64::from(settings.steps_per_period());
        let h = |index| TAU / (instance(index)[Parameter::Omega0] * steps);
        Self {
            motion: Motion::new(|parameter| Wide::from_lanes(|lane| instance(lane)[parameter])),
            h: StepSize::new(h),
            groups: std::array::from_fn(|group| {
                let first = group * R::LANES;
                Group::new(|lane| instance(first + lane), |lane| h(first + lane))
            }),
        }
    }

    fn set_tangents(&mut self, tangent: impl Fn(usize) -> [f64; 2]) -> Result<(), BackendError> {
        for (group, first) in self.groups.iter_mut().zip((0..).step_by(R::LANES)) {
            group.bases = Bases::along(Vector::from_lanes(|lane| tangent(first + lane)));
        }
        Ok(())
    }

    #[inline(always)]
    fn advance_plain(&mut self, run: &Self::Run, slice: &Slice) {
        for n in 0..slice.periods {
            self.period(run);
            for group in &mut self.groups {
                let State { x, y } = group.state;
                group.record.note_runaways(x, y, slice.elapsed + n + 1);
            }
        }
    }

    #[inline(always)]
    fn advance(&mut self, run: &Self::Run, slice: &Slice) {
        let is_measured = slice.stage == Stage::Measure;
        for n in 0..slice.periods {
            for group in &mut self.groups {
                let index = slice.first + n;
                if is_measured && index == 0 {
                    group.record.begin(group.state.x);
                }
                let (growth, divergence) = group.period_with_tangent(run);
                let State { x, y } = group.state;
                if is_measured {
                    group.record.add(&run.measuring, index, growth, divergence, x, y);
                }
                group.record.note_runaways(x, y, slice.elapsed + n + 1);
            }
        }
    }

    fn sums(&self, index: usize) -> Sums {
        self.groups[index / R::LANES].record.sums(index % R::LANES)
    }

    fn clear_sums(&mut self) {
        for group in &mut self.groups {
            group.record.clear_sums();
        }
    }

    fn end_state(&self, index: usize) -> EndState {
        let (group, lane) = (&self.groups[index / R::LANES], index % R::LANES);
        let state = [group.state.x, group.state.y].map(|value| value.lane(lane));
        group.record.end_state(lane, state, group.bases.first.lane(lane))
    }
}

impl<R: Real, const G: usize> Rk4Block<R, G> {
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
}

/// As many instances as the lane type holds, and everything that is carried along with them.
struct Group<R> {
    motion: Motion<R>,
    h: StepSize<R>,
    state: State<R>,
    bases: Bases<R>,
    record: Record<R>,
}

impl<R: Real> Group<R> {
    fn new<'a>(instance: impl Fn(usize) -> &'a ParameterSet, h: impl Fn(usize) -> f64) -> Self {
        let lanes = |parameter| R::from_lanes(|lane| instance(lane)[parameter]);
        Self {
            motion: Motion::new(lanes),
            h: StepSize::new(h),
            state: State {
                x: lanes(Parameter::X0),
                y: lanes(Parameter::Y0),
            },
            bases: Bases::start(),
            record: Record::new(),
        }
    }

    /// One forcing period with tangent vectors and extremes of x; returns growth and divergence over it.
    #[inline(always)]
    fn period_with_tangent(&mut self, run: &Run<R::Scalar>) -> (Growth<R>, R) {
        let (motion, h) = (self.motion, self.h);
        let (mut state, mut bases) = (self.state, self.bases);
        let (mut x_min, mut x_max) = (self.record.x_min, self.record.x_max);
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
        (self.record.x_min, self.record.x_max) = (x_min, x_max);
        (growth, divergence)
    }
}
