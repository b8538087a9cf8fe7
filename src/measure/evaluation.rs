//! Turns the sums that a backend has made for an instance into its measurement.
//!
//! Owns the evaluation; integrates nothing.

use super::{CONSTANT_GROWTH, Class, Cycle, DEFECT_BOUND, DEFECT_FLOOR, Measurement, Status};
use crate::backend::{BackendKind, EndState, Sums};
use crate::dynamics::statistics::{self, Spread};
use crate::dynamics::stroboscope;
use crate::experiment::{Scheme, Settings};
use crate::parameters::{Parameter, ParameterSet};

/// Where growth alternates between bands, batch means give too small an error until the orbit has left the order of the bands
/// several times. They are trusted if the mean growth exceeds this many standard errors of independent periods. For other chaos,
/// the error is at least that of independent periods. In 250 periods, no better distinction is possible: where the batch means
/// are right, this error is 50 % too large.
const BELIEVED: f64 = 6.0;

/// One instance's growth over the whole measurement, in f64.
#[derive(Clone, Debug, Default)]
pub(super) struct GrowthSums {
    /// Length in periods, and growth of the first vector, of each batch.
    batches: Vec<(f64, f64)>,
    /// The same for the second vector.
    second_batches: Vec<(f64, f64)>,
    total: Sums,
    /// Scatter of the growth of single periods, if some were sampled.
    spread: Spread,
}

/// How an instance's run ended.
#[derive(Clone, Copy)]
pub(super) struct Ended<'a> {
    pub parameters: &'a ParameterSet,
    pub settings: &'a Settings,
    /// Periods since the start of the run, of which the last `sampling.periods` were measured.
    pub elapsed: u32,
    pub state: &'a EndState,
    pub backend: BackendKind,
}

/// The measurement of an orbit that ran away; None for any other orbit.
pub(super) fn runaway(parameters: &ParameterSet, end: &EndState, backend: BackendKind) -> Option<Measurement> {
    let time = end.runaway_periods? * parameters.forcing_period();
    Some(Measurement {
        x: end.x,
        y: end.y,
        ..Measurement::runaway(time, backend)
    })
}

/// Whether the backend sums up the divergence, which the multipliers need. The GPU's kernel of radau does not.
pub(super) fn sums_all(backend: BackendKind, settings: &Settings) -> bool {
    settings.integration.scheme != Scheme::Radau || backend != BackendKind::GpuF32
}

impl GrowthSums {
    pub fn add(&mut self, periods: f64, sums: &Sums) {
        self.batches.push((periods, sums.growth[0]));
        self.second_batches.push((periods, sums.growth[1]));
        self.total.add(sums);
    }

    /// Takes note of the growth of a single period, which is part of a batch.
    pub fn sample(&mut self, sums: &Sums) {
        self.spread.add(sums.growth[0]);
    }

    /// Weighted Birkhoff average of the first vector's growth per period, over batches of equal length.
    pub fn weighted_rate(&self) -> f64 {
        let weights = statistics::birkhoff_weights(self.batches.len() as u32);
        let rates = self.batches.iter().map(|(periods, growth)| growth / periods);
        weights.iter().zip(rates).map(|(weight, rate)| weight * rate).sum()
    }

    /// The whole batches in the last `periods`, at least two.
    fn over_last(&self, periods: u32) -> Self {
        let mut length = 0.0;
        let within = self.batches.iter().rev().take_while(|batch| {
            length += batch.0;
            length <= f64::from(periods)
        });
        // a single batch, however long, gives no error
        let first = self.batches.len().saturating_sub(within.count().max(2));
        Self {
            batches: self.batches[first..].to_vec(),
            second_batches: self.second_batches[first..].to_vec(),
            total: Sums::default(),
            spread: Spread::default(),
        }
    }

    /// GrowthSums of the first vector per period, over all batches.
    fn rate(&self) -> f64 {
        rate(&self.batches)
    }

    /// The measurement of an instance.
    pub fn measurement(&self, ended: &Ended<'_>) -> Measurement {
        let Ended {
            parameters,
            settings,
            state,
            backend,
            ..
        } = *ended;
        if let Some(runaway) = runaway(parameters, state, backend) {
            return runaway;
        }
        if parameters.has_heat_or_wear() || !sums_all(backend, settings) {
            return self.measurement_without_divergence(ended);
        }
        let period_time = parameters.forcing_period();
        let time = f64::from(settings.sampling.periods) * period_time;
        let [lyapunov, lyapunov_second] = statistics::exponents(self.total.growth.map(|growth| growth / time));
        let measurement = self.lasting_measurement(ended, lyapunov);
        let measurement = Measurement {
            lyapunov_second,
            lyapunov_second_error: statistics::standard_error(&self.second_batches) / period_time,
            divergence: self.total.divergence / time,
            ..measurement
        };
        let resolved = is_resolved(&measurement);
        let missed = missed_by_scheme(parameters, backend, lyapunov, measurement.divergence_defect());
        let measurement = self.settled(ended, measurement);
        let measurement = Measurement {
            lyapunov_error: measurement.lyapunov_error + missed,
            lyapunov_second_error: measurement.lyapunov_second_error + missed,
            scheme_error: missed,
            ..measurement
        };
        checked(measurement, resolved && !state.under_resolved)
    }

    /// The measurement of an orbit that may have settled on an attracting cycle. The window is the last periods, over which the
    /// motion repeats. If the mean growth of the whole measurement differs from that of the window by more than the fluctuation
    /// of an average over the window, the exponents are those of the window alone.
    fn settled(&self, ended: &Ended<'_>, measurement: Measurement) -> Measurement {
        let (Some(period), Some(Class::Regular)) = (ended.state.period, measurement.class) else {
            return measurement;
        };
        let window = stroboscope::window(ended.settings.sampling.periods, ended.settings.sampling.max_period);
        let last = self.over_last(stroboscope::span_of(period, window));
        let period_time = ended.parameters.forcing_period();
        let interval = last.batches.iter().map(|batch| batch.0).sum::<f64>() * period_time;
        let [first, second] = [&last.batches, &last.second_batches].map(|batches| rate(batches) / period_time);
        if first >= 0.0 || (measurement.lyapunov - first).abs() * interval < 1.0 {
            return measurement;
        }
        let [lyapunov, lyapunov_second] = statistics::exponents([first, second]);
        let error = |batches: &[(f64, f64)]| statistics::standard_error(batches) / period_time;
        let has_second = !measurement.lyapunov_second.is_nan();
        Measurement {
            lyapunov: if has_second { lyapunov } else { first },
            lyapunov_error: error(&last.batches),
            lyapunov_birkhoff: first,
            lyapunov_interval: interval,
            lyapunov_second: if has_second { lyapunov_second } else { f64::NAN },
            lyapunov_second_error: if has_second {
                error(&last.second_batches)
            } else {
                f64::NAN
            },
            // with heat there are more exponents than these two, and no divergence was summed up
            divergence: if measurement.divergence.is_nan() {
                f64::NAN
            } else {
                first + second
            },
            ..measurement
        }
    }

    /// The measurement of a motion that lasts, given its maximal exponent.
    fn lasting_measurement(&self, ended: &Ended<'_>, lyapunov: f64) -> Measurement {
        let Ended {
            parameters,
            settings,
            elapsed,
            state,
            backend,
        } = *ended;
        let period_time = parameters.forcing_period();
        let lyapunov_error = statistics::standard_error(&self.batches) / period_time;
        let lyapunov_birkhoff = self.total.birkhoff / period_time;
        let time = f64::from(elapsed) * period_time;
        let window = stroboscope::window(settings.sampling.periods, settings.sampling.max_period);
        let may_be_cycle = parameters.is_driven() || state.x_max - state.x_min < settings.sampling.period_tolerance;
        let cycle = state.period.filter(|_| may_be_cycle).map(|period| Cycle {
            period,
            growth_rate: self.over_last(stroboscope::span_of(period, window)).rate() / period_time,
        });
        let lyapunov_interval = f64::from(settings.sampling.periods) * period_time;
        let class = Class::of(lyapunov, lyapunov_error, lyapunov_interval, cycle, lyapunov_birkhoff);
        // NaN if no single period was sampled
        let independent = self.spread.independent_error(settings.sampling.periods) / period_time;
        let lyapunov_error = if class == Class::Chaotic && lyapunov < BELIEVED * independent {
            lyapunov_error.max(independent)
        } else {
            lyapunov_error
        };
        Measurement {
            status: Status::Ok,
            class: Some(class),
            lyapunov,
            lyapunov_error,
            scheme_error: f64::NAN,
            lyapunov_second: f64::NAN,
            lyapunov_second_error: f64::NAN,
            divergence: f64::NAN,
            lyapunov_birkhoff,
            lyapunov_interval,
            period: cycle
                .filter(|cycle| {
                    class == Class::Regular && reached(cycle, lyapunov, lyapunov_error, settings, time, period_time)
                })
                .map(|cycle| cycle.period),
            x: state.x,
            y: state.y,
            x_min: state.x_min,
            x_max: state.x_max,
            chaotic_fraction: f64::from(u8::from(class == Class::Chaotic)),
            attractors: u32::from(class != Class::Unstable),
            unsettled_fraction: 0.0,
            contact: state.contact,
            backend,
            initial_state: parameters.initial_state(),
            integrated_periods: elapsed,
        }
    }

    /// The measurement of a motion without a sum of the divergence: with frictional heat or wear, and by radau on a GPU. With heat
    /// there may be a second tangent vector. With wear the motion is transient: it has an exponent of finite time and no class.
    fn measurement_without_divergence(&self, ended: &Ended<'_>) -> Measurement {
        let Ended {
            parameters,
            settings,
            state,
            ..
        } = *ended;
        let time = f64::from(settings.sampling.periods) * parameters.forcing_period();
        let growth = self.total.growth[0];
        if !parameters.wears() {
            // NaN without a second vector
            let [lyapunov, lyapunov_second] = statistics::exponents(self.total.growth.map(|growth| growth / time));
            let measurement = Measurement {
                lyapunov_second,
                lyapunov_second_error: statistics::standard_error(&self.second_batches) / parameters.forcing_period(),
                ..self.lasting_measurement(ended, lyapunov)
            };
            let measurement = self.settled(ended, measurement);
            let measurement = if parameters.has_heat_or_wear() {
                measurement
            } else {
                // no sum shows what the scheme missed: the comparison with a finer scheme, which follows, does
                let missed = missed_by_scheme(parameters, ended.backend, measurement.lyapunov, 0.0);
                Measurement {
                    lyapunov_error: measurement.lyapunov_error + missed,
                    scheme_error: missed,
                    ..measurement
                }
            };
            return checked(measurement, !state.under_resolved);
        }
        let interval = state.contact.lost.unwrap_or(time);
        let measurement = Measurement {
            class: None,
            period: None,
            lyapunov_error: f64::NAN,
            lyapunov_birkhoff: f64::NAN,
            lyapunov_interval: interval,
            chaotic_fraction: 0.0,
            ..self.lasting_measurement(ended, growth / interval)
        };
        if state.under_resolved || !measurement.lyapunov.is_finite() {
            unresolved(&measurement)
        } else {
            measurement
        }
    }
}

/// The possible error of either exponent by the scheme, given the maximal exponent and the difference between the sum of the
/// exponents and the divergence.
///
/// If the scheme makes one exponent too large, it mostly makes the other one too small. In comparisons between schemes, an
/// exponent was wrong by up to 23 times the difference of the sum, and mostly by less than that; three errors are to cover it. A
/// bush that creeps in the friction layer stops in the computation once a step moves x by less than the spacing of the number
/// type. Its speed has then not yet reached its limit. The friction, and with it the exponent, has a relative error of that speed
/// over the layer's half-width.
pub(super) fn missed_by_scheme(parameters: &ParameterSet, backend: BackendKind, lyapunov: f64, defect: f64) -> f64 {
    let is_dry = parameters[Parameter::Epsilon] * parameters[Parameter::F0] > 0.0;
    let creep = if is_dry {
        CREEP * backend.epsilon() / parameters[Parameter::Epsilon0]
    } else {
        0.0
    };
    10.0 * defect.abs() + creep * lyapunov.abs()
}

/// Speed at which a creeping bush stops, in spacings of the number type: 1 over the length of a step.
const CREEP: f64 = 8.0;

/// GrowthSums per period over batches.
fn rate(batches: &[(f64, f64)]) -> f64 {
    let [length, growth] = batches
        .iter()
        .fold([0.0, 0.0], |sum, batch| [sum[0] + batch.0, sum[1] + batch.1]);
    growth / length
}

/// Whether the sum of the exponents agrees with the mean divergence; written so that NaN fails.
pub(super) fn is_resolved(measurement: &Measurement) -> bool {
    measurement.divergence_defect().abs() <= DEFECT_BOUND * measurement.divergence.abs() + DEFECT_FLOOR
}

/// The measurement of a lasting motion, or an under-resolved one if the motion is not resolved or if one of the numbers is not
/// finite.
pub(super) fn checked(measurement: Measurement, resolved: bool) -> Measurement {
    let finite = [
        measurement.lyapunov,
        measurement.lyapunov_error,
        measurement.lyapunov_birkhoff,
    ]
    .iter()
    .all(|value| value.is_finite());
    if resolved && finite {
        measurement
    } else {
        unresolved(&measurement)
    }
}

/// The measurement of an under-resolved point: it keeps only the results for the contact. The sums of an instance that was given
/// up no longer change, and would look like exponents of 0.
fn unresolved(measurement: &Measurement) -> Measurement {
    Measurement {
        contact: measurement.contact,
        initial_state: measurement.initial_state,
        integrated_periods: measurement.integrated_periods,
        ..Measurement::unmeasured(Status::UnderResolved, measurement.backend)
    }
}

/// Whether the run was long enough for the cycle's attraction to bring a disturbance of order 1 well below the tolerance of the
/// period. A spiral that still decays slowly returns near itself after some number of periods that is not its period. If the
/// growth is the same in every period, the orbit was on the cycle from the start. After a chaotic transient only the last periods
/// are known to have been on the cycle.
fn reached(cycle: &Cycle, lyapunov: f64, error: f64, settings: &Settings, time: f64, period_time: f64) -> bool {
    if error < CONSTANT_GROWTH {
        return true;
    }
    let decay = if lyapunov < 0.0 {
        -lyapunov * time
    } else {
        let window = stroboscope::window(settings.sampling.periods, settings.sampling.max_period);
        -cycle.growth_rate * f64::from(stroboscope::span_of(cycle.period, window)) * period_time
    };
    decay > (10.0 / settings.sampling.period_tolerance).ln()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::Contact;
    use crate::experiment::Sampling;

    /// Where no cycle was found, there are no multipliers: the motion before the cycle is left out of the mean.
    #[test]
    fn a_transient_is_no_part_of_the_mean_on_a_cycle() {
        let parameters = ParameterSet::default().with(Parameter::Gamma, 0.01);
        let settings = Settings {
            integration: Scheme::Radau.into(),
            sampling: Sampling {
                periods: 256,
                ..Sampling::default()
            },
        };
        let state = EndState {
            x: 0.5,
            y: 0.0,
            tangent: [f64::NAN; 2],
            x_min: -1.0,
            x_max: 1.0,
            period: Some(2),
            runaway_periods: None,
            under_resolved: false,
            heated: None,
            contact: Contact::CONSTANT,
        };
        let measured = |rates: [f64; 2]| {
            let mut growth = GrowthSums::default();
            for batch in 0..32 {
                let sums = Sums {
                    growth: [8.0 * rates[usize::from(batch >= 20)], f64::NAN],
                    divergence: f64::NAN,
                    ..Sums::default()
                };
                growth.add(8.0, &sums);
            }
            growth.measurement(&Ended {
                parameters: &parameters,
                settings: &settings,
                elapsed: 556,
                state: &state,
                backend: BackendKind::CpuF64,
            })
        };
        let period_time = parameters.forcing_period();
        let after_chaos = measured([0.9, -0.3]);
        assert_eq!((after_chaos.class, after_chaos.period), (Some(Class::Regular), Some(2)));
        assert!(
            (after_chaos.lyapunov + 0.3 / period_time).abs() < 1e-12,
            "{after_chaos:?}"
        );
        assert!((after_chaos.lyapunov_interval - 64.0 * period_time).abs() < 1e-9);
        let throughout = measured([-0.3, -0.3]);
        assert!(
            (throughout.lyapunov + 0.3 / period_time).abs() < 1e-12,
            "{throughout:?}"
        );
        assert!((throughout.lyapunov_interval - 256.0 * period_time).abs() < 1e-9);
    }
}
