//! A block of instances that one thread carries on by the Taylor scheme.
//!
//! Owns the loops over forcing periods and passes, in which every lane takes a step of its own length; lanes meet at the
//! end of a period. Compiled for each instruction set by its caller.

use super::super::{EndState, Instance, Slice, Sums};
use super::Block;
use super::record::{Measuring, Record};
use crate::dynamics::divergence_check::{checked_growth, growth_of_first};
use crate::dynamics::tangent::{Growth, Vector};
use crate::dynamics::taylor::growth::{Area, Carried, RENEWAL_STEPS};
use crate::dynamics::taylor::{self, COEFFICIENTS, Flow, is_layer_resolved};
use crate::experiment::Settings;
use crate::lanes::{Real, Ticks};
use crate::parameters::Parameter;

/// As many instances as the lane type holds, and everything that is carried along with them.
pub(super) struct TaylorBlock<R> {
    flow: Flow<R>,
    unit: R,
    inverse_unit: R,
    x: R,
    y: R,
    /// x and y at the beginning of the last period.
    begun: [R; 2],
    /// The first tangent vector (X, Y), of length 1.
    vector: Vector<R>,
    /// A period's ticks in lanes that go on, 0 in those that have run away or were given up.
    period: R,
    /// Passes after which lanes that have not finished their period are given up.
    most_passes: u32,
    record: Record<R>,
}

impl<R: Real + Send + Sync> Block for TaylorBlock<R> {
    type Run = Measuring;
    const INSTANCES: usize = R::LANES;
    const IS_SPLIT: bool = true;

    fn run(settings: &Settings, _: &[Instance]) -> Measuring {
        Measuring::new(settings)
    }

    fn new(_: &Measuring, settings: &Settings, instances: &[Instance]) -> Self {
        let instance = |lane: usize| &instances[lane.min(instances.len() - 1)];
        let parameters = |lane| &instance(lane).parameters;
        let lanes = |parameter| R::from_lanes(|lane| parameters(lane)[parameter]);
        let unit = R::from_lanes(|lane| taylor::unit_of_time(parameters(lane)[Parameter::Omega0]));
        let steps = settings.integration.steps_per_period;
        let longest = R::from_lanes(|lane| taylor::longest_step_units(parameters(lane), steps));
        let periods = instances.iter().map(|instance| instance.parameters.forcing_period());
        let [x, y] = [0, 1].map(|n| R::from_lanes(|lane| instance(lane).state[n]));
        let mut block = Self {
            flow: Flow::new(lanes, unit, longest),
            unit,
            inverse_unit: R::splat(1.0) / unit,
            x,
            y,
            begun: [x, y],
            vector: Vector::from_lanes(|lane| instance(lane).tangent),
            period: R::splat(R::PERIOD_TICKS),
            most_passes: periods.map(taylor::most_passes).max().expect("a block has instances"),
            record: Record::new(),
        };
        block.refuse(|lane| !is_layer_resolved::<R>(parameters(lane)));
        block
    }

    #[inline(always)]
    fn advance_plain(&mut self, run: &Measuring, slice: &Slice) {
        for n in 0..slice.periods {
            if self.flow.any_thin {
                self.period::<true>();
            } else {
                self.period::<false>();
            }
            if slice.stage.is_watched() {
                self.record.watch(run, slice.first + n, self.x, self.y);
            }
            self.note_runaways(slice.elapsed + n + 1);
        }
    }

    #[inline(always)]
    fn advance(&mut self, run: &Measuring, slice: &Slice) {
        let is_measured = slice.stage.is_measured();
        for n in 0..slice.periods {
            let index = slice.first + n;
            if is_measured && index == 0 {
                self.record.begin(self.x);
            }
            let (growth, divergence) = match (slice.stage.is_checked(index), self.flow.any_thin) {
                (true, false) => self.period_with_tangent::<true, false>(),
                (false, false) => self.period_with_tangent::<false, false>(),
                (true, true) => self.period_with_tangent::<true, true>(),
                (false, true) => self.period_with_tangent::<false, true>(),
            };
            if is_measured {
                self.record.add(run, index, growth, divergence, self.x, self.y);
            }
            self.note_runaways(slice.elapsed + n + 1);
        }
    }

    fn sums(&self, index: usize) -> Sums {
        self.record.sums(index)
    }

    fn clear_sums(&mut self) {
        self.record.clear_sums();
    }

    fn end_state(&self, index: usize) -> EndState {
        let state = [self.x, self.y].map(|value| value.lane(index));
        self.record.end_state(index, state, self.vector.lane(index))
    }
}

impl<R: Real> TaylorBlock<R> {
    /// One forcing period of the motion alone.
    #[inline(always)]
    fn period<const THIN: bool>(&mut self) {
        let mut state = self.flow.start(self.x, self.y * self.unit, self.period.to_ticks());
        for _ in 0..self.most_passes {
            if state.left.all_zero() {
                break;
            }
            (_, state) = taylor::step::<R, COEFFICIENTS, THIN>(&self.flow, &state);
        }
        self.end(state.x, state.w, state.left);
    }

    /// One forcing period with a tangent vector, or with both, and extremes of x; returns growth and divergence over it.
    #[inline(always)]
    fn period_with_tangent<const BOTH: bool, const THIN: bool>(&mut self) -> (Growth<R>, R) {
        let mut state = self.flow.start(self.x, self.y * self.unit, self.period.to_ticks());
        let mut first = Carried::new(Vector {
            x: self.vector.x,
            y: self.vector.y * self.unit,
        });
        let mut area = Area::new(first.vector);
        let (mut x_min, mut x_max) = (self.record.x_min, self.record.x_max);
        let mut divergence = R::splat(0.0);
        for pass in 1..=self.most_passes {
            if state.left.all_zero() {
                break;
            }
            let (step, end) = taylor::step::<R, COEFFICIENTS, THIN>(&self.flow, &state);
            let turning = taylor::turning(&step, &end);
            first.vector = step.series.carried(first.vector, step.s);
            if BOTH {
                area.second = step.series.carried(area.second, step.s);
            }
            if pass.is_multiple_of(RENEWAL_STEPS) {
                let left = R::from_ticks(state.left);
                if BOTH {
                    area.renew(first.vector, left);
                }
                first.settle(BOTH.then_some(&mut area), left);
            }
            divergence = divergence + step.series.divergence_to(step.s);
            x_min = x_min.min(turning).min(end.x);
            x_max = x_max.max(turning).max(end.x);
            state = end;
        }
        (self.record.x_min, self.record.x_max) = (x_min, x_max);
        let grown;
        (self.vector, grown) = first.close(self.inverse_unit);
        let growth = if BOTH {
            let second = area.close(first.vector) - grown;
            checked_growth(Growth { first: grown, second }, divergence)
        } else {
            growth_of_first(grown, divergence)
        };
        self.end(state.x, state.w, state.left);
        (growth, divergence)
    }

    #[inline(always)]
    fn note_runaways(&mut self, period: u32) {
        if self.record.note_runaways(self.x, self.y, self.begun, period) {
            self.stop_lanes();
        }
    }

    /// Takes the state in which a period ended, with the ticks that it still had to go.
    #[inline(always)]
    fn end(&mut self, x: R, w: R, left: R::Ticks) {
        self.begun = [self.x, self.y];
        self.x = x;
        self.y = w * self.inverse_unit;
        if !left.all_zero() {
            self.give_up(left);
        }
    }

    /// Lanes that have not finished their period are under-resolved.
    #[cold]
    fn give_up(&mut self, left: R::Ticks) {
        let left = R::from_ticks(left);
        self.refuse(|lane| left.lane(lane) > 0.0);
    }

    /// Gives lanes up as under-resolved.
    #[cold]
    fn refuse(&mut self, is_refused: impl Fn(usize) -> bool) {
        self.record.note_under_resolved(is_refused);
        self.stop_lanes();
    }

    /// Lanes that have run away or were given up do nothing more.
    #[cold]
    fn stop_lanes(&mut self) {
        let record = &self.record;
        let vector = self.vector;
        self.vector = Vector::from_lanes(|lane| {
            if record.goes_on(lane) {
                vector.lane(lane)
            } else {
                [1.0, 0.0]
            }
        });
        self.period = R::from_lanes(|lane| f64::from(u8::from(record.goes_on(lane))) * R::PERIOD_TICKS);
    }
}
