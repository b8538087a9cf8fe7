//! What is taken from a kept step: its end as the new state, and what it shows of extremes and of contact.
//!
//! Owns the peaks and times of an instance's contact. Twin: `shaders/dynamics/adaptive/kept.wgsl`.

use std::f64::consts::TAU;

use super::pass::rotation;
use super::{Orbit, Scratch, System};
use crate::dynamics::dense::Cubic;
use crate::dynamics::matrix::at_nodes;
use crate::dynamics::radau::{self, Drive, Heat, Memory, ModeStep, Start, Trial};
use crate::lanes::{Mask, Real};

/// What an instance's run has shown of its contact.
#[derive(Clone, Copy, Debug)]
pub struct Peaks<R> {
    pub pressure: R,
    /// When: completed periods, and tau since.
    pub pressure_time: [R; 2],
    pub temperature: R,
    /// When contact was first lost; periods are negative while it has not been.
    pub lost: [R; 2],
}

impl<R: Real> Peaks<R> {
    /// Before anything has happened.
    pub fn start(orbit: &Orbit<R>) -> Self {
        let zero = R::splat(0.0);
        Self {
            pressure: orbit.fit,
            pressure_time: [zero; 2],
            temperature: zero,
            lost: [R::splat(-1.0), zero],
        }
    }
}

impl<R: Real> Orbit<R> {
    /// Takes the end of a trial as the new state where it is kept.
    #[allow(clippy::too_many_arguments, reason = "the parts of one pass")]
    #[inline(always)]
    pub(super) fn keep(
        &mut self,
        system: &System<R>,
        peaks: &mut Peaks<R>,
        start: &Start<R>,
        drive: &Drive<R>,
        trial: &Trial<R>,
        memory: &Memory<R>,
        steps: &Scratch<R>,
        h: R,
        elapsed: R,
        kept: R::Mask,
    ) {
        let coefficients = radau::parabola(trial.flux);
        let heat = memory.end(coefficients);
        let flux = at_nodes!(k => coefficients[k] * h);
        for (m, step) in steps.iter().enumerate() {
            self.modes[m] = R::select(kept, advanced(step, self.modes[m], flux), self.modes[m]);
        }

        let (pressure, part) = Cubic::new(start.pressure, trial.pressure).maximum();
        let higher = kept.and(peaks.pressure.less(pressure));
        peaks.pressure = R::select(higher, pressure, peaks.pressure);
        let time = [self.periods, part.mul_add(h, elapsed)];
        peaks.pressure_time = [
            R::select(higher, time[0], peaks.pressure_time[0]),
            R::select(higher, time[1], peaks.pressure_time[1]),
        ];
        let falloff = trial.falloff(&system.rubbing, start, h, heat);
        let (falloff, _) = Cubic::new(start.heat.falloff, falloff).maximum();
        let temperature = falloff * system.surface_temperature;
        peaks.temperature = R::select(kept, temperature.max(peaks.temperature), peaks.temperature);

        let (highest, _) = Cubic::new(start.x, trial.x).maximum();
        let (lowest, _) = Cubic::new(-start.x, at_nodes!(i => -trial.x[i])).maximum();
        let [x_min, x_max] = self.extremes;
        self.extremes = [
            R::select(kept, x_min.min(-lowest), x_min),
            R::select(kept, x_max.max(highest), x_max),
        ];

        self.fit = R::select(kept, self.fit + drive.fit[2] - trial.worn(&system.rubbing, h), self.fit);
        self.x = R::select(kept, trial.x[2], self.x);
        self.v = R::select(kept, trial.v[2], self.v);
        self.heat = Heat {
            pressure: R::select(kept, heat.pressure, self.heat.pressure),
            falloff: R::select(kept, heat.falloff, self.heat.falloff),
        };
        let angle = h / system.period * R::splat(TAU);
        let (sine, versine) = rotation(angle);
        let (sin, cos) = (self.sin, self.cos);
        self.sin = R::select(kept, sin + (cos * sine - sin * versine), sin);
        self.cos = R::select(kept, cos - (sin * sine + cos * versine), cos);

        // contact changes where its signal has come down to zero
        let (zero, one, half) = (R::splat(0.0), R::splat(1.0), R::splat(0.5));
        let gap = self.contact.less(half);
        let signal = R::select(gap, -trial.if_closed[2], trial.pressure[2]);
        let changes = kept.and(signal.less(zero));
        if R::select(changes, one, zero).less(half).all() {
            return;
        }
        let first = changes.and(half.less(self.contact)).and(peaks.lost[0].less(zero));
        let lost = [self.periods, elapsed + h];
        peaks.lost = [
            R::select(first, lost[0], peaks.lost[0]),
            R::select(first, lost[1], peaks.lost[1]),
        ];
        self.contact = R::select(changes, one - self.contact, self.contact);
        self.piece = R::select(changes, self.piece_of(&system.rubbing), self.piece);
    }
}

/// A mode after a step; `flux` are the coefficients of the heat flux times the step's length.
#[inline(always)]
pub(super) fn advanced<R: Real>(step: &ModeStep<R>, mode: R, flux: [R; 3]) -> R {
    step.factor.mul_add(
        mode,
        step.moments[0].mul_add(flux[0], step.moments[1].mul_add(flux[1], step.moments[2] * flux[2])),
    )
}
