//! A block of instances that one thread carries on by the fixed-step scheme.
//!
//! Owns the loops over forcing periods and steps; compiled for each instruction set by its caller.

use std::f64::consts::TAU;

use super::super::{EndState, Instance, Slice, Sums};
use super::Block;
use super::record::{Measuring, Record};
use crate::dynamics::divergence_check::{checked_growth, growth_of_first};
use crate::dynamics::drive::DriveTable;
use crate::dynamics::rk4::{self, StageSpeeds, State, StepSize};
use crate::dynamics::tangent::{Bases, Growth, Vector};
use crate::dynamics::taylor::is_layer_resolved;
use crate::experiment::Settings;
use crate::lanes::{Real, Wide};
use crate::model::motion::Motion;
use crate::parameters::Parameter;

/// Data that all instances of a batch share.
pub(super) struct Run<S> {
    drive: DriveTable<S>,
    measuring: Measuring,
    renormalise_every: usize,
}

/// The instances of `G` groups. The motion alone is stepped for all groups together: their independent vectors hide each
/// other's latency. With tangent vectors, a single group has enough independent operations, and more would not fit the
/// registers.
pub(super) struct Rk4Block<R, const G: usize> {
    motion: Motion<Wide<R, G>>,
    h: StepSize<Wide<R, G>>,
    groups: [Group<R>; G],
}

impl<R: Real + Send + Sync, const G: usize> Block for Rk4Block<R, G> {
    type Run = Run<R::Scalar>;
    const INSTANCES: usize = R::LANES * G;
    const IS_SPLIT: bool = true;

    fn run(settings: &Settings, _: &[Instance]) -> Self::Run {
        Run {
            drive: DriveTable::new::<R>(settings.integration.steps_per_period),
            measuring: Measuring::new(settings),
            renormalise_every: settings.integration.renormalise_every as usize,
        }
    }

    fn new(_: &Self::Run, settings: &Settings, instances: &[Instance]) -> Self {
        let instance = |index: usize| &instances[index.min(instances.len() - 1)];
        let steps = f64::from(settings.integration.steps_per_period);
        let h = |index| TAU / (instance(index).parameters[Parameter::Omega0] * steps);
        Self {
            motion: Motion::new(|parameter| Wide::from_lanes(|lane| instance(lane).parameters[parameter])),
            h: StepSize::new(h),
            groups: std::array::from_fn(|group| {
                let first = group * R::LANES;
                let mut group = Group::new(|lane| instance(first + lane), |lane| h(first + lane));
                group
                    .record
                    .note_under_resolved(|lane| !is_layer_resolved::<R>(&instance(first + lane).parameters));
                group
            }),
        }
    }

    #[inline(always)]
    fn advance_plain(&mut self, run: &Self::Run, slice: &Slice) {
        for n in 0..slice.periods {
            let begun = self.groups.each_ref().map(|group| group.state);
            self.period(run);
            for (group, begun) in self.groups.iter_mut().zip(begun) {
                if slice.stage.is_watched() {
                    let State { x, y } = group.state;
                    group.record.watch(&run.measuring, slice.first + n, x, y);
                }
                group.note_runaways(begun, slice.elapsed + n + 1);
            }
        }
    }

    #[inline(always)]
    fn advance(&mut self, run: &Self::Run, slice: &Slice) {
        let is_measured = slice.stage.is_measured();
        for n in 0..slice.periods {
            for group in &mut self.groups {
                let index = slice.first + n;
                if is_measured && index == 0 {
                    group.record.begin(group.state.x);
                }
                let begun = group.state;
                let (growth, divergence) = if slice.stage.is_checked(index) {
                    group.checked_period(run)
                } else {
                    group.period_with_tangent(run)
                };
                let State { x, y } = group.state;
                if is_measured {
                    group.record.add(&run.measuring, index, growth, divergence, x, y);
                }
                group.note_runaways(begun, slice.elapsed + n + 1);
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
        group.record.end_state(lane, state, group.vector.lane(lane))
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
    /// The first tangent vector, of length 1.
    vector: Vector<R>,
    record: Record<R>,
}

impl<R: Real> Group<R> {
    fn new<'a>(instance: impl Fn(usize) -> &'a Instance, h: impl Fn(usize) -> f64) -> Self {
        let [x, y] = [0, 1].map(|n| R::from_lanes(|lane| instance(lane).state[n]));
        Self {
            motion: Motion::new(|parameter| R::from_lanes(|lane| instance(lane).parameters[parameter])),
            h: StepSize::new(h),
            state: State { x, y },
            vector: Vector::from_lanes(|lane| instance(lane).tangent),
            record: Record::new(),
        }
    }

    #[inline(always)]
    fn note_runaways(&mut self, begun: State<R>, periods: u32) {
        let State { x, y } = self.state;
        self.record.note_runaways(x, y, [begun.x, begun.y], periods);
    }

    /// One forcing period with a tangent vector and extremes of x; returns growth and divergence over it.
    #[inline(always)]
    fn period_with_tangent(&mut self, run: &Run<R::Scalar>) -> (Growth<R>, R) {
        let (mut first, mut divergence) = (R::splat(0.0), R::splat(0.0));
        let mut start = self.motion.shaft_speed(R::splat(0.0));
        for steps in run.drive.steps().chunks(run.renormalise_every) {
            let end;
            ([end], start, divergence) = self.steps([self.vector], steps, start, divergence);
            let norm;
            (self.vector, norm) = end.normalised();
            first = first + norm.ln();
        }
        (growth_of_first(first, divergence), divergence)
    }

    /// As [`Group::period_with_tangent`], with both tangent vectors.
    #[inline(always)]
    fn checked_period(&mut self, run: &Run<R::Scalar>) -> (Growth<R>, R) {
        let (mut first, mut second, mut divergence) = (R::splat(0.0), R::splat(0.0), R::splat(0.0));
        let mut start = self.motion.shaft_speed(R::splat(0.0));
        let mut bases = Bases::along(self.vector);
        for steps in run.drive.steps().chunks(run.renormalise_every) {
            let ends;
            (ends, start, divergence) = self.steps([bases.first, bases.second], steps, start, divergence);
            bases = Bases {
                first: ends[0],
                second: ends[1],
            };
            let growth = bases.orthonormalise();
            first = first + growth.first;
            second = second + growth.second;
        }
        self.vector = bases.first;
        (checked_growth(Growth { first, second }, divergence), divergence)
    }

    /// Some steps with `N` tangent vectors and extremes of x. Takes and returns the vectors, the shaft's speed, and the
    /// divergence so far.
    #[inline(always)]
    fn steps<const N: usize>(
        &mut self,
        mut vectors: [Vector<R>; N],
        steps: &[[R::Scalar; 2]],
        mut start: R,
        mut divergence: R,
    ) -> ([Vector<R>; N], R, R) {
        let (motion, h, mut state) = (self.motion, self.h, self.state);
        let (mut x_min, mut x_max) = (self.record.x_min, self.record.x_max);
        for &[middle, end] in steps {
            let speed = StageSpeeds {
                start,
                middle: motion.shaft_speed(R::broadcast(middle)),
                end: motion.shaft_speed(R::broadcast(end)),
            };
            let step_divergence;
            (state, vectors, step_divergence) = rk4::step_with_tangent(&motion, &h, speed, state, vectors);
            divergence = divergence + step_divergence;
            x_min = x_min.min(state.x);
            x_max = x_max.max(state.x);
            start = speed.end;
        }
        self.state = state;
        (self.record.x_min, self.record.x_max) = (x_min, x_max);
        (vectors, start, divergence)
    }
}
