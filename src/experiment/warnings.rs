//! Warnings about an experiment, for the user, before it runs.

use std::f64::consts::TAU;

use super::integration::USUAL_MODES;
use super::{Experiment, MAX_MODES, Precision, Scheme};
use crate::machine::plausibility_warnings;
use crate::model::rubbing::SETTLED;
use crate::model::thermal_modes;
use crate::parameters::Parameter;

/// The decay rate of the last heat mode should be this many times omega_0, the angular frequency of the drive. With the paper's
/// preset, 12 modes reach 63. With omega-tilde = 0.024 they reach 15, and peak pressure and wear are wrong by 1e-3
/// (zeta_k = gamma = 3.9, compared with 64 modes).
const FAST_MODE: f64 = 50.0;

/// The Biot number at which the last heat mode should decay twice as fast as [`FAST_MODE`] says.
const WELL_COOLED: f64 = 50.0;

/// Upper bound of biot / [`WELL_COOLED`]: a greater Biot number does not raise the required rate further.
const MOST_COOLING: f64 = 6.0;

/// An angle in rad at which the terms that sin and cos have beyond the third order are a quarter of those of third order.
const LARGE_ANGLE: f64 = 0.5;

impl Experiment {
    /// Warnings that a user should read before a long run, one sentence each.
    pub fn warnings(&self) -> Vec<String> {
        let numerical = match self.settings.integration.scheme {
            // this scheme shortens its steps itself; where it cannot, the point is under-resolved
            Scheme::Taylor => Vec::new(),
            Scheme::Rk4 => self.fixed_step_warnings(),
            Scheme::Radau => self
                .settling_warning()
                .into_iter()
                .chain(self.modes_warning())
                .collect(),
        };
        self.machine_warnings().into_iter().chain(numerical).collect()
    }

    /// The warnings about the machine, which do not depend on how the experiment is computed.
    pub fn machine_warnings(&self) -> Vec<String> {
        let corners = self.design.extreme_machines();
        if corners.is_empty() {
            return Vec::new();
        }
        let mut warnings = plausibility_warnings(&corners);
        let b = self.extent(Parameter::B).0;
        if b <= 0.0 {
            warnings.push(format!(
                "b = {b:.4} is not positive: the springs do not hold the bush at large angles, and it runs away; raise \
                 tangent_cubic_stiffness"
            ));
        }
        if b > 0.0 && b.sqrt().recip() > LARGE_ANGLE {
            warnings.push(format!(
                "the wells lie at angles of {:.3} rad, and the equation of motion takes the moment of the springs to third \
                 order in the angle, which holds for small ones: raise tangent_cubic_stiffness",
                b.sqrt().recip()
            ));
        }
        warnings
    }

    fn fixed_step_warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        let steps_per_period = self.settings.integration.steps_per_period;
        // RK4 is stable where (decay rate)*(step) is below 2.785; the layer's decay rate is eps*F0*2/eps0.
        let rate =
            self.extent(Parameter::Epsilon).1 * self.extent(Parameter::F0).1 * 2.0 / self.extent(Parameter::Epsilon0).0;
        let step = TAU / (self.extent(Parameter::Omega0).0 * f64::from(steps_per_period));
        if rate * step > 2.785 {
            let enough = (f64::from(steps_per_period) * rate * step / 2.0).ceil();
            warnings.push(format!(
                "the step is too long for the friction layer (rate {rate:.3} x step {step:.3e} is above 2.785, RK4's \
                 limit of stability): sticking will be wrong; use --steps-per-period {enough} or more"
            ));
        }
        // between two renormalisations the second tangent vector shrinks relative to the first by up to e^shrinkage
        let every = self.settings.integration.renormalise_every.min(steps_per_period);
        let shrinkage = rate * step * f64::from(every);
        let digits = match self.settings.integration.precision {
            Some(Precision::F64) => -f64::EPSILON.ln(),
            Some(Precision::F32) | None => -f64::from(f32::EPSILON).ln(),
        };
        if shrinkage > digits {
            let enough = (f64::from(every) * 0.5 * digits / shrinkage).floor().max(1.0);
            warnings.push(format!(
                "between two renormalisations the friction layer may turn both tangent vectors into one direction, and the \
                 second exponent is lost: use --renormalise-every {enough}"
            ));
        }
        warnings
    }

    /// The warning if the transient is too short for the heat of the shaft to reach a steady state. If every point wears, there
    /// is no steady state and no warning. The slowest heat mode decays at the rate mu_1^2 omega-tilde.
    fn settling_warning(&self) -> Option<String> {
        if self.extent(Parameter::Gamma).1 == 0.0 || self.extent(Parameter::KW).0 > 0.0 {
            return None;
        }
        let (biot, omega_tilde) = (self.extent(Parameter::Biot).0, self.extent(Parameter::OmegaTilde).0);
        let slowest = thermal_modes::slowest_rate(biot, omega_tilde);
        let period = TAU / self.extent(Parameter::Omega0).1;
        let transient = f64::from(self.settings.sampling.transient_periods) * period;
        (slowest * transient < SETTLED).then(|| {
            let enough = (SETTLED / (slowest * period)).ceil();
            format!(
                "the shaft warms through in about {:.3} tau (1/(mu_1^2 omega_tilde), at biot = {biot} and omega_tilde = \
                 {omega_tilde}), and the transient of {transient:.4} tau is too short for its heat to settle: use \
                 --transient-periods {enough} or more",
                1.0 / slowest
            )
        })
    }

    /// The warning if heat is conducted so slowly that the lumped mode, which stands for all further modes, does not follow the
    /// pulses of friction.
    fn modes_warning(&self) -> Option<String> {
        if self.extent(Parameter::Gamma).1 == 0.0 {
            return None;
        }
        let (rates, needed) = (self.mode_rates(), self.fast_mode());
        let modes = self.settings.integration.modes;
        let rate = *rates.get(modes as usize - 1)?;
        (rate < needed).then(|| {
            let enough = enough(&rates, needed);
            let remedy = if rates[enough as usize - 1] < needed {
                format!("even {MAX_MODES} modes are too few to promise more: raise omega_tilde")
            } else {
                format!("use --modes {enough} or more, or leave it out")
            };
            format!(
                "the shaft conducts heat so slowly (omega_tilde = {}) that the last of {modes} heat modes decays at {rate:.3}, below \
                 the {needed:.4} that this drive and this cooling ask for: pressure, wear and temperature may be off by 1e-4 or more; {remedy}",
                self.extent(Parameter::OmegaTilde).0
            )
        })
    }

    /// The number of heat modes that the drive and the cooling need, from [`USUAL_MODES`] to [`MAX_MODES`].
    pub(super) fn enough_modes(&self) -> u32 {
        enough(&self.mode_rates(), self.fast_mode())
    }

    /// Decay rates of the heat modes, the least in the design, the slowest mode first.
    fn mode_rates(&self) -> Vec<f64> {
        let (biot, omega_tilde) = (self.extent(Parameter::Biot).0, self.extent(Parameter::OmegaTilde).0);
        let roots = thermal_modes::roots(biot, MAX_MODES as usize);
        roots.into_iter().map(|mu| mu * mu * omega_tilde).collect()
    }

    /// The rate at which the last heat mode should decay. A well-cooled shaft loses the heat of a pulse from a thin layer at its
    /// surface; only faster modes resolve this layer.
    fn fast_mode(&self) -> f64 {
        let cooling = (self.extent(Parameter::Biot).1 / WELL_COOLED).min(MOST_COOLING);
        FAST_MODE * (1.0 + cooling) * self.extent(Parameter::Omega0).1
    }
}

/// The least number of modes whose last one decays at the rate `needed` or faster, from [`USUAL_MODES`] to [`MAX_MODES`].
fn enough(rates: &[f64], needed: f64) -> u32 {
    let is_fast = |modes: &u32| rates[*modes as usize - 1] >= needed;
    (USUAL_MODES..MAX_MODES).find(is_fast).unwrap_or(MAX_MODES)
}
