//! The state of an instance, and how it is followed over forcing periods.
//!
//! Owns the clock: where the lanes meet, and the passes that they may take until then. Twin:
//! `shaders/dynamics/adaptive/orbit.wgsl`; loops over periods are the kernel's there.

use super::pass::FIRST_PART_OF_PERIOD;
use super::{Control, Peaks, System, Tangent};
use crate::dynamics::radau::{Heat, ModeStep, Start};
use crate::lanes::{Mask, Real, Ticks};

/// Passes that a period may take, and one longer than pi as many more: beyond, it is under-resolved.
pub const PASS_BUDGET: u32 = 100_000;

/// What would have to be divided into more steps than usual by more than this is given up at once.
const MOST_LONG: f64 = 2e4;

/// Passes after which it is seen to that no tangent vector's length leaves the numbers.
pub const SETTLING_PASSES: u32 = 16;

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
    /// Drive phase: its sine and cosine, and the ticks left to where the lanes meet.
    pub(super) sin: R,
    pub(super) cos: R,
    pub(super) left: R::Ticks,
    /// The tick of the period that the lanes are on their way to, or at.
    pub(super) to: f64,
    /// Completed periods.
    pub periods: R,
    /// Length of the next step, in ticks.
    pub step: R,
    /// Piece of the friction law: 0 below the layer, 1 and 2 its halves, 3 above.
    pub piece: R,
    /// Acceleration as a quadratic in time around the last trial's start, and the time since then: guesses the next.
    pub guess: [R; 3],
    pub since: R,
    /// Least and greatest x since they were last set.
    pub extremes: [R; 2],
    /// 1 in lanes that have been given up: because they needed too many or too short steps, or because the motion or the
    /// pressure ran away.
    pub under_resolved: R,
    pub runaway: R,
    /// When the lane ran away, as a part of its period.
    pub runaway_phase: R,
}

/// Room for what a pass knows of each mode.
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
            guess: [zero; 3],
            since: zero,
            extremes: [x; 2],
            under_resolved: zero,
            runaway: zero,
            runaway_phase: one,
        };
        orbit.under_resolved = R::select(R::splat(MOST_LONG).less(system.long), one, zero);
        orbit.piece = orbit.piece_of(&system.rubbing);
        orbit.guess[0] = orbit.begin(system).acceleration;
        orbit
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

    /// One forcing period; a tangent vector is carried along if there is one.
    #[inline(always)]
    pub fn period(
        &mut self,
        system: &System<R>,
        control: &Control<R>,
        peaks: &mut Peaks<R>,
        tangent: Option<&mut Tangent<R>>,
        scratch: &mut Scratch<R>,
    ) {
        self.part_of_period(system, control, peaks, tangent, scratch, 0, 1);
    }

    /// Part `part` of `parts` equal parts of a forcing period, which follow one another from 0 on.
    #[allow(clippy::too_many_arguments, reason = "what a step needs, and where it ends")]
    #[inline(always)]
    pub fn part_of_period(
        &mut self,
        system: &System<R>,
        control: &Control<R>,
        peaks: &mut Peaks<R>,
        mut tangent: Option<&mut Tangent<R>>,
        scratch: &mut Scratch<R>,
        part: u32,
        parts: u32,
    ) {
        let (zero, half, one) = (R::splat(0.0), R::splat(0.5), R::splat(1.0));
        if part == 0 {
            // the drive's phase is 0 exactly: rounding does not grow from period to period
            self.sin = zero;
            self.cos = one;
        }
        let ticks = |parts_done: u32| (R::PERIOD_TICKS * f64::from(parts_done) / f64::from(parts)).floor();
        let (from, to) = (ticks(part), ticks(part + 1));
        let alive = self.under_resolved.less(half).and(self.runaway.less(half));
        self.left = R::select(alive, R::splat(to - from), zero).to_ticks();
        self.to = to;
        let mut passes = 0;
        let long = (0..R::LANES).fold(1.0, |long: f64, lane| long.max(system.long.lane(lane)));
        let budget = (f64::from(PASS_BUDGET) * long.min(MOST_LONG)) as u32;
        while !self.left.all_zero() {
            self.pass(system, control, peaks, tangent.as_deref_mut(), scratch);
            passes += 1;
            if passes % SETTLING_PASSES == 0
                && let Some(tangent) = tangent.as_deref_mut()
            {
                tangent.settle(system, R::from_ticks(self.left));
            }
            if passes == budget {
                let unfinished = R::splat(0.5).less(R::from_ticks(self.left));
                self.under_resolved = R::select(unfinished, R::splat(1.0), self.under_resolved);
                self.left = R::Ticks::splat(0.0);
            }
        }
        if part + 1 == parts {
            self.periods = self.periods + one;
            self.to = 0.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::{Preset, Scheme};
    use crate::model::rubbing::HeatModes;
    use crate::model::thermal_modes::ThermalModes;
    use crate::parameters::{Parameter, ParameterSet};

    fn system<R: Real>(set: &ParameterSet) -> System<R> {
        let modes = HeatModes::new(set, &ThermalModes::new(set[Parameter::Biot], 6));
        System::new(|parameter| R::splat(set[parameter]), |_| &modes)
    }

    /// Follows the orbit over part 0 of so many of a period.
    fn follow<R: Real>(orbit: &mut Orbit<R>, system: &System<R>, parts: u32) {
        let control = Control::new(&Scheme::Radau.into());
        let mut peaks = Peaks::start(orbit);
        let mut scratch = vec![ModeStep::empty(); orbit.modes.len()];
        orbit.part_of_period(system, &control, &mut peaks, None, &mut scratch, 0, parts);
    }

    /// In f32 a tick is a part of a period that can be asked for.
    #[test]
    fn the_last_tick_is_a_step_as_well() {
        let system = system::<f32>(&Preset::Paper.parameters());
        let mut orbit = Orbit::start(&system, 0.5, 0.0);
        follow(&mut orbit, &system, f32::PERIOD_TICKS as u32);
        assert_eq!((orbit.under_resolved, orbit.to), (0.0, 1.0));
    }

    #[test]
    fn what_was_given_up_stands_still_and_all_else_goes_on() {
        let system = system::<f64>(&Preset::Paper.parameters());
        for (under_resolved, runaway) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let mut orbit = Orbit::start(&system, 0.5, 0.0);
            (orbit.under_resolved, orbit.runaway) = (under_resolved, runaway);
            follow(&mut orbit, &system, 1);
            let has_moved = orbit.x != 0.5;
            assert_eq!(has_moved, under_resolved + runaway == 0.0, "{under_resolved} {runaway}");
            assert_eq!((orbit.under_resolved, orbit.runaway), (under_resolved, runaway));
        }
    }
}
