//! The results of an accepted step: the new state, the extremes, and changes of contact.
//!
//! Owns the peaks and times of an instance's contact. Twin: `shaders/dynamics/adaptive/accepted.wgsl`.

use super::events::FAR;
use super::{Orbit, Scratch, System};
use crate::dynamics::decay::decay;
use crate::dynamics::dense::Cubic;
use crate::dynamics::matrix::at_nodes;
use crate::dynamics::radau::{self, Drive, Heat, Memory, ModeStep, Start, Trial};
use crate::lanes::{Mask, Real};

/// Relative error that is allowed for in the interpolated surface temperature within a step. If the temperature may still be a
/// new maximum, it is computed from the heat modes.
pub const ROUGH: f64 = 2e-3;

/// The peaks of an instance's run so far, and when it lost contact.
#[derive(Clone, Copy, Debug)]
pub struct Peaks<R> {
    pub pressure: R,
    /// Time of the greatest pressure: completed periods, and tau since then.
    pub pressure_time: [R; 2],
    pub temperature: R,
    /// Time at which contact was first lost, in the same form. The number of periods is negative as long as there is contact.
    pub lost: [R; 2],
}

impl<R: Real> Peaks<R> {
    /// The peaks at the start of a run.
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
    /// Takes the end of a trial as the new state, in the lanes that accept it.
    #[allow(clippy::too_many_arguments, reason = "the parts of one pass")]
    #[inline(always)]
    pub(super) fn accept(
        &mut self,
        system: &System<R>,
        peaks: &mut Peaks<R>,
        start: &Start<R>,
        drive: &Drive<R>,
        turn: [R; 2],
        trial: &Trial<R>,
        memory: &Memory<R>,
        steps: &Scratch<R>,
        h: R,
        elapsed: R,
        accepted: R::Mask,
    ) {
        let flux = radau::parabola(trial.flux);
        let heat = memory.end(flux);
        self.peaks_of(system, peaks, start, trial, flux, heat, h, elapsed, accepted);
        let put_in = at_nodes!(k => flux[k] * h);
        for (m, step) in steps.iter().enumerate() {
            self.modes[m] = R::select(accepted, advanced(step, self.modes[m], put_in), self.modes[m]);
        }

        let [x_min, x_max] = self.extremes;
        let lowest = Cubic::new(-start.x, at_nodes!(i => -trial.x[i]));
        let highest = Cubic::new(start.x, trial.x);
        self.extremes = [-raised(-x_min, &lowest, accepted), raised(x_max, &highest, accepted)];

        self.fit = R::select(
            accepted,
            self.fit + drive.fit[2] - trial.worn(&system.rubbing, h),
            self.fit,
        );
        self.x = R::select(accepted, trial.x[2], self.x);
        self.v = R::select(accepted, trial.v[2], self.v);
        self.heat = Heat {
            pressure: R::select(accepted, heat.pressure, self.heat.pressure),
            falloff: R::select(accepted, heat.falloff, self.heat.falloff),
        };
        let [sine, versine] = turn;
        let (sin, cos) = (self.sin, self.cos);
        self.sin = R::select(accepted, sin + (cos * sine - sin * versine), sin);
        self.cos = R::select(accepted, cos - (sin * sine + cos * versine), cos);

        // contact changes where this signal has fallen below zero: p in contact; in the gap, minus the pressure that there would
        // be in contact
        let (zero, one, half) = (R::splat(0.0), R::splat(1.0), R::splat(0.5));
        let gap = self.contact.less(half);
        let signal = R::select(gap, -trial.if_closed[2], trial.pressure[2]);
        let changes = accepted.and(signal.less(zero));
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

    /// Updates the peaks of the pressure and of the surface temperature from a step. Its heat flux has the coefficients `flux`,
    /// and `heat` is the heat at its end.
    #[allow(clippy::too_many_arguments, reason = "the parts of one pass")]
    #[inline(always)]
    fn peaks_of(
        &self,
        system: &System<R>,
        peaks: &mut Peaks<R>,
        start: &Start<R>,
        trial: &Trial<R>,
        flux: [R; 3],
        heat: Heat<R>,
        h: R,
        elapsed: R,
        accepted: R::Mask,
    ) {
        let far = R::splat(FAR);
        let pressure = Cubic::new(start.pressure, trial.pressure);
        if !pressure.stays_below(R::select(accepted, peaks.pressure, far)).all() {
            let (highest, part) = pressure.maximum();
            let higher = accepted.and(peaks.pressure.less(highest));
            peaks.pressure = R::select(higher, highest, peaks.pressure);
            let time = [self.periods, part.mul_add(h, elapsed)];
            peaks.pressure_time = [
                R::select(higher, time[0], peaks.pressure_time[0]),
                R::select(higher, time[1], peaks.pressure_time[1]),
            ];
        }
        // within the step the temperature is known only roughly: if it may be a new maximum, it is computed from the modes
        let rough = Cubic::new(start.heat.falloff, trial.falloff(&system.rubbing, start, h, heat));
        let to_beat = peaks.temperature / system.surface_temperature * R::splat(1.0 - ROUGH);
        if !rough.stays_below(R::select(accepted, to_beat, far)).all() {
            let (_, part) = rough.maximum();
            let temperature = self.falloff_within(system, flux, part, h) * system.surface_temperature;
            peaks.temperature = R::select(accepted, peaks.temperature.max(temperature), peaks.temperature);
        }
    }

    /// The sum w_m r_m q_m, to which the surface temperature is proportional, after a part of a step. `flux` holds the
    /// coefficients of the step's heat flux.
    #[inline(always)]
    fn falloff_within(&self, system: &System<R>, flux: [R; 3], part: R, h: R) -> R {
        let h = part * h;
        let inverse_h = R::splat(1.0) / h;
        let put_in = [flux[0] * h, flux[1] * part * h, flux[2] * part * part * h];
        let mut falloff = R::splat(0.0);
        for (m, mode) in self.modes.iter().enumerate() {
            let step = decay(system.rates[m] * h, system.inverse_rates[m] * inverse_h);
            let faster = system.weights[m] * system.rates[m];
            falloff = faster.mul_add(advanced(&step, *mode, put_in), falloff);
        }
        falloff
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

/// In accepted lanes, the larger of a record and the greatest value of a cubic; in the others, the record.
#[inline(always)]
fn raised<R: Real>(record: R, cubic: &Cubic<R>, accepted: R::Mask) -> R {
    if cubic.stays_below(R::select(accepted, record, R::splat(FAR))).all() {
        return record;
    }
    let (highest, _) = cubic.maximum();
    R::select(accepted, record.max(highest), record)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Preset;
    use crate::model::rubbing::HeatModes;
    use crate::model::thermal_modes::ThermalModes;
    use crate::parameters::Parameter;

    /// The heat flux is a parabola of time. The expected temperature is the quadrature of each mode's integral.
    #[test]
    fn the_temperature_within_a_step_is_that_of_the_heat_so_far() {
        let set = Preset::Paper.parameters();
        let modes = HeatModes::new(&set, &ThermalModes::new(set[Parameter::Biot], 6));
        let system = System::<f64>::new(|parameter| set[parameter], |_| &modes);
        let mut orbit = Orbit::start(&system, 0.0, 0.0);
        for (m, mode) in orbit.modes.iter_mut().enumerate() {
            *mode = 0.3 - 0.1 * m as f64;
        }
        let (flux, h) = ([1.3, -2.1, 4.7], 0.04);
        for part in [0.1, 0.5, 0.9, 1.0] {
            let end = part * h;
            let mode = |m: usize| {
                let rate = system.rates[m];
                let put_in = |t: f64| {
                    let s = t / h;
                    (flux[0] + s * (flux[1] + s * flux[2])) * (-rate * (end - t)).exp()
                };
                // Simpson's rule
                let intervals = 2000;
                let width = end / f64::from(intervals);
                let inner: f64 = (1..intervals)
                    .map(|n| put_in(width * f64::from(n)) * if n % 2 == 1 { 4.0 } else { 2.0 })
                    .sum();
                let sum = width / 3.0 * (put_in(0.0) + inner + put_in(end));
                system.weights[m] * rate * (orbit.modes[m] * (-rate * end).exp() + sum)
            };
            let expected: f64 = (0..orbit.modes.len()).map(mode).sum();
            let found = orbit.falloff_within(&system, flux, part, h);
            assert!((found / expected - 1.0).abs() < 1e-9, "{part}: {found} for {expected}");
        }
    }
}
