//! The sums and notes of the instances in a vector's lanes, for every scheme.
//!
//! Owns sums, extremes, the stroboscope, runaways and under-resolved lanes; steps nothing.

use super::super::{EndState, Sums};
use crate::backend::Contact;
use crate::dynamics::statistics;
use crate::dynamics::stroboscope::{self, Stroboscope};
use crate::dynamics::tangent::Growth;
use crate::experiment::Settings;
use crate::lanes::{Mask, Real};
use crate::model::motion::RUNAWAY_BOUND;

/// Data of a measurement that all instances of a batch share.
pub(super) struct Measuring {
    birkhoff_weights: Vec<f64>,
    /// Measured periods before the stroboscopic window.
    unrecorded: u32,
    periods: u32,
    max_period: u32,
    period_tolerance: f64,
}

impl Measuring {
    pub fn new(settings: &Settings) -> Self {
        Self {
            birkhoff_weights: statistics::birkhoff_weights(settings.sampling.periods),
            unrecorded: settings.sampling.periods
                - stroboscope::window(settings.sampling.periods, settings.sampling.max_period),
            periods: settings.sampling.periods,
            max_period: settings.sampling.max_period,
            period_tolerance: settings.sampling.period_tolerance,
        }
    }
}

/// The record of as many instances as the lane type holds.
pub(super) struct Record<R> {
    growth: Growth<R>,
    birkhoff: R,
    divergence: R,
    pub x_min: R,
    pub x_max: R,
    stroboscope: Stroboscope<R>,
    /// Period of each lane's motion, in forcing periods, once the run has ended.
    motion_periods: Vec<Option<u32>>,
    /// When a lane ran away, in forcing periods since the start of the run.
    runaways: Vec<Option<f64>>,
    /// The state at the beginning of the period in which the lane ran away, for schemes that do not know when within the period.
    runaway_starts: Vec<Option<[f64; 2]>>,
    under_resolved: Vec<bool>,
}

impl<R: Real> Record<R> {
    pub fn new() -> Self {
        let zero = R::splat(0.0);
        Self {
            growth: Growth {
                first: zero,
                second: zero,
            },
            birkhoff: zero,
            divergence: zero,
            x_min: R::splat(f64::INFINITY),
            x_max: R::splat(f64::NEG_INFINITY),
            stroboscope: Stroboscope::default(),
            motion_periods: vec![None; R::LANES],
            runaways: vec![None; R::LANES],
            runaway_starts: vec![None; R::LANES],
            under_resolved: vec![false; R::LANES],
        }
    }

    pub fn clear_sums(&mut self) {
        let zero = R::splat(0.0);
        self.growth = Growth {
            first: zero,
            second: zero,
        };
        self.birkhoff = zero;
        self.divergence = zero;
    }

    /// Begins the measured periods at angle `x`.
    #[inline(always)]
    pub fn begin(&mut self, x: R) {
        self.x_min = x;
        self.x_max = x;
    }

    /// Adds a measured period that ended at (x, y).
    #[inline(always)]
    pub fn add(&mut self, measuring: &Measuring, index: u32, growth: Growth<R>, divergence: R, x: R, y: R) {
        let weight = R::splat(measuring.birkhoff_weights[index as usize]);
        self.growth.first = self.growth.first + growth.first;
        self.growth.second = self.growth.second + growth.second;
        self.birkhoff = growth.first.mul_add(weight, self.birkhoff);
        self.divergence = self.divergence + divergence;
        self.watch(measuring, index, x, y);
    }

    /// Keeps the state (x, y) in which the period `index` ended, if it is one of the last; after the very last, looks for the
    /// period of the motion.
    #[inline(always)]
    pub fn watch(&mut self, measuring: &Measuring, index: u32, x: R, y: R) {
        if index >= measuring.unrecorded {
            self.stroboscope.record(x, y);
            if index + 1 == measuring.periods {
                let tolerance = R::splat(measuring.period_tolerance);
                self.motion_periods = self.stroboscope.periods(measuring.max_period, tolerance);
            }
        }
    }

    /// Notes the lanes that have run away by the end of the period `periods` of the run, counted from 1. This period began in the
    /// state `begun`. Returns whether there are such lanes.
    #[inline(always)]
    pub fn note_runaways(&mut self, x: R, y: R, begun: [R; 2], periods: u32) -> bool {
        let inside = (x.abs() + y.abs()).less(R::splat(RUNAWAY_BOUND));
        if inside.all() {
            return false;
        }
        for (lane, start) in self.runaway_starts.iter_mut().enumerate() {
            if !inside.lane(lane) && start.is_none() {
                *start = Some(begun.map(|value| value.lane(lane)));
            }
        }
        self.note_runaway_lanes(|lane| (!inside.lane(lane)).then(|| periods.into()));
        true
    }

    /// Notes when lanes ran away, in forcing periods since the start of the run: `ran_away` returns that, or None for a lane that
    /// has not. The first time counts.
    pub fn note_runaway_lanes(&mut self, ran_away: impl Fn(usize) -> Option<f64>) {
        for (lane, runaway) in self.runaways.iter_mut().enumerate() {
            *runaway = runaway.or_else(|| ran_away(lane));
        }
    }

    /// Notes the lanes for which `gave_up` is true.
    pub fn note_under_resolved(&mut self, gave_up: impl Fn(usize) -> bool) {
        for (lane, under_resolved) in self.under_resolved.iter_mut().enumerate() {
            *under_resolved |= gave_up(lane);
        }
    }

    /// Whether the lane's instance has neither run away nor been given up.
    pub fn goes_on(&self, lane: usize) -> bool {
        self.runaways[lane].is_none() && !self.under_resolved[lane]
    }

    /// Sums of a lane since they were last cleared.
    pub fn sums(&self, lane: usize) -> Sums {
        Sums {
            growth: [self.growth.first.lane(lane), self.growth.second.lane(lane)],
            birkhoff: self.birkhoff.lane(lane),
            divergence: self.divergence.lane(lane),
        }
    }

    /// The lane's record, with its state (x, y) and its first tangent vector.
    pub fn end_state(&self, lane: usize, state: [f64; 2], tangent: [f64; 2]) -> EndState {
        let [x, y] = self.runaway_starts[lane].unwrap_or(state);
        EndState {
            x,
            y,
            tangent,
            x_min: self.x_min.lane(lane),
            x_max: self.x_max.lane(lane),
            period: self.motion_periods[lane],
            runaway_periods: self.runaways[lane],
            under_resolved: self.under_resolved[lane],
            heated: None,
            contact: Contact::CONSTANT,
        }
    }
}
