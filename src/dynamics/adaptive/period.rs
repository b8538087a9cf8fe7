//! Instances over forcing periods.
//!
//! Owns the clock: the time at which all lanes meet, and the number of passes they may take until then. In
//! `shaders/dynamics/adaptive/orbit.wgsl` the kernel has the loops over periods.

use super::orbit::MOST_LONG;
use super::{Control, Orbit, Peaks, Scratch, System, Tangent};
use crate::lanes::{Mask, Real, Ticks};

/// Most passes that a period may take; a lane that needs more is under-resolved. A period that is divided into more steps than
/// usual (`System::long`) may take more in the same proportion.
pub const PASS_BUDGET: u32 = 100_000;

/// Passes between two checks that the length of a tangent vector neither overflows nor vanishes.
pub const SETTLING_PASSES: u32 = 16;

impl<R: Real> Orbit<R> {
    /// Follows the orbit, and tangent vectors if there are any, over one forcing period.
    #[inline(always)]
    pub fn period(
        &mut self,
        system: &System<R>,
        control: &Control<R>,
        peaks: &mut Peaks<R>,
        tangents: &mut [Tangent<R>],
        scratch: &mut Scratch<R>,
    ) {
        self.part_of_period(system, control, peaks, tangents, scratch, 0, 1);
    }

    /// Follows the orbit over part `part` of a forcing period that is divided into `parts` equal parts. The parts must follow one
    /// another from 0 on.
    #[allow(clippy::too_many_arguments, reason = "what a step needs, and where it ends")]
    #[inline(always)]
    pub fn part_of_period(
        &mut self,
        system: &System<R>,
        control: &Control<R>,
        peaks: &mut Peaks<R>,
        tangents: &mut [Tangent<R>],
        scratch: &mut Scratch<R>,
        part: u32,
        parts: u32,
    ) {
        let (zero, half, one) = (R::splat(0.0), R::splat(0.5), R::splat(1.0));
        if part == 0 {
            // the drive's phase is set to 0 exactly, so that rounding does not grow from period to period
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
            self.pass(system, control, peaks, tangents, scratch);
            passes += 1;
            if passes % SETTLING_PASSES == 0 {
                for tangent in &mut *tangents {
                    tangent.settle(system, R::from_ticks(self.left));
                }
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
    use crate::dynamics::radau::ModeStep;
    use crate::experiment::{Preset, Scheme};
    use crate::model::rubbing::HeatModes;
    use crate::model::thermal_modes::ThermalModes;
    use crate::parameters::{Parameter, ParameterSet};

    fn system<R: Real>(set: &ParameterSet) -> System<R> {
        let modes = HeatModes::new(set, &ThermalModes::new(set[Parameter::Biot], 6));
        System::new(|parameter| R::splat(set[parameter]), |_| &modes)
    }

    /// Follows the orbit over the first of `parts` parts of a period.
    fn follow<R: Real>(orbit: &mut Orbit<R>, system: &System<R>, parts: u32) {
        let control = Control::new(&Scheme::Radau.into());
        let mut peaks = Peaks::start(orbit);
        let mut scratch = vec![ModeStep::empty(); orbit.modes.len()];
        orbit.part_of_period(system, &control, &mut peaks, &mut [], &mut scratch, 0, parts);
    }

    /// In f32 a period may be divided into parts of a single tick.
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
