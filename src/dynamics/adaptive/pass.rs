//! A pass: one step tried in every lane, accepted where it is good.
//!
//! Owns the error control, the drive over a step, and which lanes are given up. Twin:
//! `shaders/dynamics/adaptive/pass.wgsl`.

#![allow(
    clippy::needless_range_loop,
    reason = "arrays are walked side by side: indices say so best"
)]

use std::f64::consts::TAU;

use super::orbit::FIRST_PART_OF_PERIOD;
use super::{Control, Orbit, PRESSURE_BOUND, Peaks, Scratch, System, Tangent};
use crate::dynamics::decay::single;
use crate::dynamics::dense::Cubic;
use crate::dynamics::matrix::at_nodes;
use crate::dynamics::radau::{self, Drive, ERROR_WEIGHT, Memory, NODES, Start, Trial};
use crate::lanes::{Mask, Real, Ticks};
use crate::model::motion::RUNAWAY_BOUND;
use crate::model::rubbing::Rubbing;

/// Shortest step, in ticks.
pub const SHORTEST_STEP: u32 = 2;

/// The error of the pressure is relative above this pressure, and absolute below it. The value is small because a pressure that
/// grows from near 0 by its own heat, as with a ramp, keeps its relative error.
pub const PRESSURE_FLOOR: f64 = 1e-2;

/// The error of v is relative above this speed.
pub const LARGE_SPEED: f64 = 20.0;

/// A trial is repeated if its error calls for a step of at most this part of its length.
pub const REJECTED: f64 = 0.8;

/// The next step is this part of the step that would have just the tolerated error.
pub const SAFETY: f64 = 0.8;

/// The error allows a step to be at most this number of times as long as the one before. The number is large, because a step that
/// ends at a boundary of the friction layer may be much shorter than its error allows.
pub const LONGER: f64 = 10.0;

impl<R: Real> Orbit<R> {
    /// Tries one step in every lane, and carries the tangent vectors over it.
    #[inline(always)]
    pub(super) fn pass(
        &mut self,
        system: &System<R>,
        control: &Control<R>,
        peaks: &mut Peaks<R>,
        tangents: &mut [Tangent<R>],
        scratch: &mut Scratch<R>,
    ) {
        let rubbing = &system.rubbing;
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let left = R::from_ticks(self.left);
        let running = R::splat(0.5).less(left);
        // lanes that wait for others try a short step, which is not accepted
        // The last two steps of a period share what is left. A very short last step would give a bad guess for the next one: its
        // accelerations differ by little more than rounding.
        let step = R::select(left.less(self.step), left, self.step.min(R::splat(0.5) * left));
        let ticks = R::from_ticks(step.to_ticks().least(self.left));
        let ticks = R::select(running, ticks, R::splat(FIRST_PART_OF_PERIOD * R::PERIOD_TICKS));
        let h = ticks * system.tick;

        let elapsed = (R::splat(self.to) - left) * system.tick;
        let start = self.begin(system);
        let (drive, turn) = self.drive(system, ticks, h, elapsed);
        let memory = Memory::new(
            h,
            &system.rates,
            &system.inverse_rates,
            &system.weights,
            &self.modes,
            scratch,
        );
        let guess = at_nodes!(i => {
            let time = R::splat(NODES[i]).mul_add(h, self.since);
            let [constant, first, second, third] = self.guess;
            third.mul_add(time, second).mul_add(time, first).mul_add(time, constant)
        });
        let trial = radau::solve(rubbing, &start, &drive, &memory, guess, control.newton);

        // factors for the next step: `longer` after an accepted trial, by its error; `again` if this trial is to be repeated
        let growth = self.growth(rubbing, control, &start, &trial, h);
        let sliding = Cubic::new(start.v, trial.v);
        let (shorter, stays) = self.cut(rubbing, control, &start, &trial, &sliding);
        let accepted = stays.and(trial.converged).and(R::splat(REJECTED).less(growth));
        let accepted = accepted.and(running);
        let longer = (growth * R::splat(SAFETY)).max(R::splat(0.2)).min(R::splat(LONGER));
        let again = R::select(
            trial.converged,
            R::select(shorter.less(one), shorter, longer).min(R::splat(0.9)),
            R::splat(0.25),
        );
        // a trial that has converged gives the guess for the next one, even if it is not accepted; any other is forgotten. A lane that
        // waits keeps its guess, so that it does not depend on the others.
        let [constant, first, second, third] = Cubic::new(start.acceleration, trial.acceleration).coefficients();
        let inverse_h = one / h;
        let square = inverse_h * inverse_h;
        let known = |coefficient| R::select(trial.converged, coefficient, zero);
        let guess = [
            constant,
            known(first * inverse_h),
            known(second * square),
            known(third * square * inverse_h),
        ];
        for k in 0..4 {
            self.guess[k] = R::select(running, guess[k], self.guess[k]);
        }
        self.since = R::select(running, R::select(accepted, h, zero), self.since);

        let alive = peaks.lost[0].less(zero).or(zero.less(system.lasts));
        for tangent in tangents {
            Self::carry(
                system,
                &start,
                &trial,
                &memory,
                tangent,
                scratch,
                h,
                accepted.and(alive),
            );
        }
        self.accept(
            system, peaks, &start, &drive, turn, &trial, &memory, scratch, h, elapsed, accepted,
        );
        self.left = self.left.minus(R::select(accepted, ticks, zero).to_ticks());

        self.switch(rubbing, control, start.v);
        let next = R::select(
            accepted,
            self.landing(rubbing, control, &sliding, ticks, ticks * longer),
            ticks * again,
        );
        let longest = control.longest_step_periods * R::splat(R::PERIOD_TICKS) / system.long;
        let longest = longest.min(self.swing_step(rubbing, control) / system.tick);
        let next = R::from_ticks(next.min(longest).max(zero).to_ticks());
        self.step = R::select(running, next, self.step);
        self.give_up(system, running, &start, ticks);
    }

    /// The changes of the shaft speed and of the fit from the start of a step of length `h` to its nodes. Changes, not values, so
    /// that f32 keeps the digits of v. Also the sine and 1 - cosine of the angle by which the drive's phase advances.
    #[inline(always)]
    fn drive(&self, system: &System<R>, ticks: R, h: R, elapsed: R) -> (Drive<R>, [R; 2]) {
        let mut drive = Drive {
            h,
            speed: [R::splat(0.0); 3],
            fit: [R::splat(0.0); 3],
        };
        let angle = ticks * R::splat(TAU / R::PERIOD_TICKS);
        let turns = at_nodes!(i => rotation(angle * R::splat(NODES[i])));
        drive.speed = at_nodes!(i => system.rubbing.zeta_k * (self.cos * turns[i][0] - self.sin * turns[i][1]));
        if system.ramps {
            let now = self.periods.mul_add(system.period, elapsed);
            let fit = system.fit(now);
            for i in 0..3 {
                drive.fit[i] = system.fit(R::splat(NODES[i]).mul_add(h, now)) - fit;
            }
        }
        (drive, turns[2])
    }

    /// The length that a trial with just the tolerated error would have, over the length of this trial.
    #[inline(always)]
    fn growth(&self, rubbing: &Rubbing<R>, control: &Control<R>, start: &Start<R>, trial: &Trial<R>, h: R) -> R {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        // the error estimate is the amount by which the quadratics, extrapolated to the start, miss the values there; stiff
        // motion damps this error
        let weight = h * R::splat(ERROR_WEIGHT);
        let rate =
            (rubbing.epsilon * start.pressure).mul_add(rubbing.friction_slope(&start.piece, self.v), rubbing.damping);
        let forgets = weight.mul_add(rate.max(zero), one);
        let inside = (self.piece - R::splat(1.5)).abs().less(one);
        // at large speeds, as in a runaway, the error of v is relative
        let large = (self.v.abs() * R::splat(1.0 / LARGE_SPEED)).max(one);
        let scale = R::select(inside, rubbing.layer, large);
        let pressure = start.pressure.abs() + R::splat(PRESSURE_FLOOR);
        let motion = (start.acceleration - radau::parabola(trial.acceleration)[0]).abs() * pressure;
        let heat = (start.flux - radau::parabola(trial.flux)[0]).abs() * rubbing.two_gamma * scale;
        let allowed = control.tolerance * forgets * pressure * scale;
        // the embedded formula is of order 3: its error grows with the fourth power of the step
        let error = (motion.max(heat) * weight).max(R::splat(1e-12) * allowed);
        (allowed / error).sqrt().sqrt()
    }

    /// The longest step, in tau, that resolves the slower of the two rates of the linearised motion. With stiffness k and damping
    /// d, this rate is about k/d if the motion is overdamped, and else the square root of k.
    #[inline(always)]
    fn swing_step(&self, rubbing: &Rubbing<R>, control: &Control<R>) -> R {
        let stiffness = rubbing.stiffness(self.x).abs();
        let piece = rubbing.piece(self.piece);
        let pressure = self.contact * (self.fit + self.heat.pressure);
        let damping = (rubbing.epsilon * pressure)
            .mul_add(rubbing.friction_slope(&piece, self.v), rubbing.damping)
            .abs();
        let slower = R::splat(0.5).mul_add(damping, stiffness.sqrt());
        control.swing * slower / stiffness.max(R::splat(1e-6))
    }

    /// Gives up lanes whose step has become too short, and lanes whose state has run away or is NaN. The last step started at
    /// `start` and had the length `ticks`.
    #[inline(always)]
    fn give_up(&mut self, system: &System<R>, running: R::Mask, start: &Start<R>, ticks: R) {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        // written so that a lane with NaN is given up
        let size = self.x.abs() + self.y(system).abs();
        let is_pressure_bounded = self.heat.pressure.abs().less(R::splat(PRESSURE_BOUND));
        let bounded = is_pressure_bounded.and(size.less(R::splat(RUNAWAY_BOUND)));
        let steps = R::splat(f64::from(SHORTEST_STEP)).less(self.step);
        let fine = bounded.and(steps);
        if fine.all() {
            return;
        }
        let left = R::from_ticks(self.left);
        let lost = R::select(running, R::select(fine, zero, one), zero);
        let ran_away = R::select(bounded, zero, lost);
        // what reaches its bound, |x| + |y| or the pressure, grows nearly as an exponential over this step
        let size_before = start.x.abs() + (start.shaft_speed - start.v).abs();
        let from = R::select(is_pressure_bounded, size_before, start.heat.pressure.abs());
        let to = R::select(is_pressure_bounded, size, self.heat.pressure.abs());
        let bound = R::select(is_pressure_bounded, R::splat(RUNAWAY_BOUND), R::splat(PRESSURE_BOUND));
        let part = ((bound / from).ln() / (to / from).ln()).max(zero).min(one);
        let since = (one - part) * ticks + left;
        let phase = (R::splat(self.to) - since) * R::splat(1.0 / R::PERIOD_TICKS);
        self.runaway_phase = R::select(zero.less(ran_away), phase, self.runaway_phase);
        self.runaway = self.runaway.max(ran_away);
        self.under_resolved = self.under_resolved.max(lost - ran_away);
        self.left = R::select(lost.less(R::splat(0.5)), left, zero).to_ticks();
    }
}

/// sin and 1 - cos of an angle of 0 to 2 pi/16, by their series: no digits are lost in either.
#[inline(always)]
fn rotation<R: Real>(angle: R) -> [R; 2] {
    let square = angle * angle;
    let terms = if single::<R>() { 4 } else { 7 };
    let [mut sine, mut versine] = ROTATION[terms - 1].map(R::splat);
    for n in (0..terms - 1).rev() {
        sine = sine.mul_add(square, R::splat(ROTATION[n][0]));
        versine = versine.mul_add(square, R::splat(ROTATION[n][1]));
    }
    [angle * sine, square * versine]
}

/// Coefficients of a^(2n) in sin(a)/a and (1 - cos(a))/a^2: (-1)^n/(2n+1)! and (-1)^n/(2n+2)!.
const ROTATION: [[f64; 2]; 7] = {
    let mut coefficients = [[1.0, 0.5]; 7];
    let mut n = 1;
    while n < coefficients.len() {
        let k = 2.0 * n as f64;
        let [sine, versine] = coefficients[n - 1];
        coefficients[n] = [-sine / (k * (k + 1.0)), -versine / ((k + 1.0) * (k + 2.0))];
        n += 1;
    }
    coefficients
};
