//! The state of an instance.
//!
//! Owns what is known of an instance between two steps, and what follows from it. Twin: `shaders/dynamics/adaptive/orbit.wgsl`.

use super::System;
use crate::dynamics::radau::{Heat, ModeStep, Start};
use crate::lanes::{Real, Ticks};

/// A lane is given up at once if its periods need more steps than usual by a factor above this.
pub(super) const MOST_LONG: f64 = 2e4;

/// The first step of a run, as a part of the period.
pub const FIRST_PART_OF_PERIOD: f64 = 1.0 / 4096.0;

/// State of an instance.
#[derive(Clone, Debug)]
pub struct Orbit<R: Real> {
    pub x: R,
    /// Sliding velocity (shaft speed) - y.
    pub v: R,
    /// h_U - u_w.
    pub fit: R,
    pub modes: Vec<R>,
    pub(super) heat: Heat<R>,
    /// 1 in contact, 0 in the gap.
    pub contact: R,
    /// Sine and cosine of the drive's phase, and the ticks left until the lanes meet.
    pub(super) sin: R,
    pub(super) cos: R,
    pub(super) left: R::Ticks,
    /// The tick of the period at which the lanes meet next, or where they are now.
    pub(super) to: f64,
    /// Completed periods.
    pub periods: R,
    /// Length of the next step, in ticks.
    pub step: R,
    /// Piece of the friction law: 0 below the layer, 1 and 2 its halves, 3 above.
    pub piece: R,
    /// Guess for the next trial: the acceleration as a cubic in time from the last trial's start, and the time since then.
    pub guess: [R; 4],
    pub since: R,
    /// Least and greatest x since they were last set.
    pub extremes: [R; 2],
    /// 1 in lanes that have been given up: `under_resolved` if they needed too many or too short steps, `runaway` if the motion
    /// or the pressure ran away.
    pub under_resolved: R,
    pub runaway: R,
    /// When the lane ran away, as a part of its period.
    pub runaway_phase: R,
}

/// Working memory of a pass: the decay of each heat mode over the step.
pub type Scratch<R> = Vec<ModeStep<R>>;

impl<R: Real> Orbit<R> {
    /// The state at the start of a run, from (x, y).
    pub fn start(system: &System<R>, x: R, y: R) -> Self {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let mut orbit = Self {
            x,
            v: system.rubbing.omega_k - y,
            fit: system.fit(zero),
            modes: vec![zero; system.rates.len()],
            heat: Heat {
                pressure: zero,
                falloff: zero,
            },
            contact: one,
            sin: zero,
            cos: one,
            left: R::Ticks::splat(0.0),
            to: 0.0,
            periods: zero,
            step: R::splat(FIRST_PART_OF_PERIOD * R::PERIOD_TICKS),
            piece: zero,
            guess: [zero; 4],
            since: zero,
            extremes: [x; 2],
            under_resolved: zero,
            runaway: zero,
            runaway_phase: one,
        };
        orbit.under_resolved = R::select(R::splat(MOST_LONG).less(system.long), one, zero);
        orbit.begin_run(system);
        orbit
    }

    /// Goes on after some completed periods of a run without wear, with the heat modes `modes` and a first step of `step` ticks.
    /// `contact` is 1 in contact, 0 in the gap.
    #[must_use]
    pub fn resumed(mut self, system: &System<R>, periods: R, modes: Vec<R>, contact: R, step: R) -> Self {
        let heat = system.heat(modes.iter().zip(&system.weights).map(|(mode, weight)| *weight * *mode));
        (self.periods, self.modes, self.heat) = (periods, modes, heat);
        (self.contact, self.step) = (contact, step);
        self.fit = system.fit(self.time(system));
        self.begin_run(system);
        self
    }

    /// Sets what the first trial of a run begins with.
    fn begin_run(&mut self, system: &System<R>) {
        self.piece = self.piece_of(&system.rubbing);
        self.guess[0] = self.begin(system).acceleration;
    }

    #[inline(always)]
    pub(super) fn begin(&self, system: &System<R>) -> Start<R> {
        let speed = system.rubbing.zeta_k.mul_add(self.sin, system.rubbing.omega_k);
        Start::new(
            &system.rubbing,
            system.rubbing.piece(self.piece),
            self.x,
            self.v,
            speed,
            self.fit,
            self.heat,
            self.contact,
        )
    }

    /// Time since the start of the run.
    pub fn time(&self, system: &System<R>) -> R {
        self.periods.mul_add(system.period, R::splat(self.to) * system.tick)
    }

    /// u_w.
    pub fn wear(&self, system: &System<R>) -> R {
        system.fit(self.time(system)) - self.fit
    }

    /// The pressure that each heat mode causes in one lane.
    pub fn mode_pressures(&self, system: &System<R>, lane: usize) -> Vec<f64> {
        let modes = self.modes.iter().zip(&system.weights);
        modes
            .map(|(mode, weight)| mode.lane(lane) * weight.lane(lane))
            .collect()
    }

    /// The sums over the heat modes: the pressure that they cause, and the rate at which it falls off without a heat flux.
    pub fn heat_sums(&self) -> [R; 2] {
        [self.heat.pressure, self.heat.falloff]
    }

    /// p, 0 in the gap.
    pub fn pressure(&self) -> R {
        self.contact * (self.fit + self.heat.pressure)
    }

    /// theta(1), the temperature of the shaft's surface.
    pub fn surface_temperature(&self, system: &System<R>) -> R {
        self.heat.falloff * system.surface_temperature
    }

    /// Angular speed of the bush.
    #[inline(always)]
    pub fn y(&self, system: &System<R>) -> R {
        system.rubbing.zeta_k.mul_add(self.sin, system.rubbing.omega_k) - self.v
    }
}
