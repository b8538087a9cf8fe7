//! The bush's motion under a contact pressure that frictional heat and wear change, equations (2.1) to (2.5).
//!
//! Owns the coefficients of the coupled system and its pointwise laws; the scheme advances the heat modes. Twin:
//! `shaders/model/rubbing.wgsl`.

use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, PoisonError};

use super::friction::{Friction, Piece};
use super::thermal_modes::{ThermalModes, slowest_rate};
use crate::lanes::Real;
use crate::parameters::{Parameter, ParameterSet};

/// Stands for the half-width of the layer if there is no dry friction, and so no layer: no speed reaches its boundaries.
pub const NO_LAYER: f64 = 1e30;

/// The system
///
/// ```text
/// x'' = x - b x^3 + eps p F(v) - eps h1 y           y = x',  v = (shaft speed) - y
/// p   = h_U - u_w + sum_m w_m q_m                   w_m = 2 gamma c_m, the lumped mode last
/// q_m' = -r_m q_m + Q                               r_m = mu_m^2 omega-tilde,  Q = F(v) v p
/// u_w' = k_w |v| p
/// ```
///
/// in contact; in the gap after contact is lost p = 0.
#[derive(Clone, Copy, Debug)]
pub struct Rubbing<R> {
    minus_b: R,
    minus_three_b: R,
    /// Mean speed of the shaft.
    pub omega_k: R,
    /// Amplitude of the shaft's speed.
    pub zeta_k: R,
    /// Strength eps of the friction in the equation of motion.
    pub epsilon: R,
    /// eps h1.
    pub damping: R,
    /// Wear coefficient.
    pub k_w: R,
    /// 2 gamma.
    pub two_gamma: R,
    /// delta of the fit h_U = 1 - exp(-delta tau^2); infinite where there is no ramp.
    pub ramp_rate: R,
    /// Half-width of the friction layer; [`NO_LAYER`] where there is no dry friction.
    pub epsilon_0: R,
    /// Width of the friction layer, but at most 1: the unit in which errors of v are measured in the layer.
    pub layer: R,
    friction: Friction<R>,
}

impl<R: Real> Rubbing<R> {
    /// The system with the parameters that `value` gives.
    pub fn new(value: impl Fn(Parameter) -> R) -> Self {
        use Parameter::{Alpha, B, Beta, Epsilon, Epsilon0, F0, Gamma, H1, KW, OmegaK, RampRate, ZetaK};
        let epsilon = value(Epsilon);
        // dry friction moves the bush by epsilon, and heats by gamma
        let is_dry = R::splat(0.0).less((epsilon + value(Gamma)) * value(F0));
        let epsilon_0 = R::select(is_dry, value(Epsilon0), R::splat(NO_LAYER));
        Self {
            minus_b: -value(B),
            minus_three_b: R::splat(-3.0) * value(B),
            omega_k: value(OmegaK),
            zeta_k: value(ZetaK),
            epsilon,
            damping: epsilon * value(H1),
            k_w: value(KW),
            two_gamma: R::splat(2.0) * value(Gamma),
            ramp_rate: value(RampRate),
            epsilon_0,
            layer: (epsilon_0 + epsilon_0).min(R::splat(1.0)),
            friction: Friction::new(R::splat(1.0), value(F0), value(Alpha), value(Beta), epsilon_0),
        }
    }

    /// The piece of the friction law that has this index.
    #[inline(always)]
    pub fn piece(&self, index: R) -> Piece<R> {
        self.friction.piece(index, self.epsilon_0)
    }

    /// Kinetic friction F(v) by a piece of the law, also beyond its boundaries.
    #[inline(always)]
    pub fn friction(&self, piece: &Piece<R>, v: R) -> R {
        let cubic = self.friction.cubic();
        cubic.mul_add(v, piece.a_2).mul_add(v, piece.a_1).mul_add(v, piece.a_0)
    }

    /// F'(v), likewise.
    #[inline(always)]
    pub fn friction_slope(&self, piece: &Piece<R>, v: R) -> R {
        let (two, three_cubic) = (R::splat(2.0), R::splat(3.0) * self.friction.cubic());
        three_cubic.mul_add(v, two * piece.a_2).mul_add(v, piece.a_1)
    }

    /// Acceleration of the bush, given the product of pressure and friction.
    #[inline(always)]
    pub fn acceleration(&self, x: R, y: R, rubbed: R) -> R {
        let restoring = self.minus_b.mul_add(x * x, R::splat(1.0));
        x.mul_add(restoring, self.epsilon * rubbed - self.damping * y)
    }

    /// d(acceleration)/dx = 1 - 3 b x^2.
    #[inline(always)]
    pub fn stiffness(&self, x: R) -> R {
        self.minus_three_b.mul_add(x * x, R::splat(1.0))
    }
}

/// A ramp of the fit, 1 - exp(-delta tau^2), has ended, to rounding, once delta tau^2 exceeds this.
const RAMP_END: f64 = 37.0;

/// The heat has settled when the slowest mode has decayed by a factor of e to this power.
pub const SETTLED: f64 = 10.0;

/// Whether the fit no longer grows at this time since the start of the motion.
pub fn has_ramp_ended(parameters: &ParameterSet, time: f64) -> bool {
    let rate = parameters[Parameter::RampRate];
    rate.is_infinite() || rate * time * time > RAMP_END
}

/// Whether the shaft has warmed up by this time since the start of the motion.
pub fn is_warm(parameters: &ParameterSet, time: f64) -> bool {
    let rate = slowest_rate(parameters[Parameter::Biot], parameters[Parameter::OmegaTilde]);
    parameters[Parameter::Gamma] == 0.0 || rate * time > SETTLED
}

/// The spectra of the shafts in a batch.
#[derive(Clone, Debug)]
pub struct Spectra(HashMap<u64, Arc<ThermalModes>>);

/// The spectra that were computed last, by Biot number and number of modes. Each is computed only once, because this takes as long
/// as many steps, and batches follow one another quickly.
static COMPUTED: Mutex<BTreeMap<(u64, usize), Arc<ThermalModes>>> = Mutex::new(BTreeMap::new());

/// Most spectra that are kept.
const MOST_COMPUTED: usize = 10_000;

/// The spectrum of a Biot number, which has these bits.
fn spectrum(bits: u64, modes: usize) -> Arc<ThermalModes> {
    // what is in there is complete, also after a panic elsewhere
    let computed = || COMPUTED.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(found) = computed().get(&(bits, modes)) {
        return Arc::clone(found);
    }
    let new = Arc::new(ThermalModes::new(f64::from_bits(bits), modes));
    let mut computed = computed();
    if computed.len() >= MOST_COMPUTED {
        computed.clear();
    }
    computed.insert((bits, modes), Arc::clone(&new));
    new
}

impl Spectra {
    /// The spectra of all instances, with `modes` heat modes each.
    pub fn new<'a>(instances: impl IntoIterator<Item = &'a ParameterSet>, modes: usize) -> Self {
        let mut spectra = HashMap::new();
        for instance in instances {
            let bits = instance[Parameter::Biot].to_bits();
            spectra.entry(bits).or_insert_with(|| spectrum(bits, modes));
        }
        Self(spectra)
    }

    /// The heat modes of one of the instances.
    ///
    /// # Panics
    /// If no instance has its Biot number.
    pub fn heat_modes(&self, instance: &ParameterSet) -> HeatModes {
        HeatModes::new(instance, &self.0[&instance[Parameter::Biot].to_bits()])
    }
}

/// The heat modes of one instance, as the scheme needs them: the lumped mode last.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatModes {
    /// r_m = mu_m^2 omega-tilde, per unit of tau.
    pub rates: Vec<f64>,
    /// 2 gamma c_m.
    pub weights: Vec<f64>,
    /// The factor 1/(2 Bi omega-tilde): theta(1) is this factor times the sum of 2 gamma c_m r_m q_m.
    pub surface_temperature: f64,
}

impl HeatModes {
    /// No modes, for a shaft whose heat is not computed.
    pub fn none() -> Self {
        Self {
            rates: Vec::new(),
            weights: Vec::new(),
            surface_temperature: 0.0,
        }
    }

    /// The modes of an instance; `modes` is the spectrum of its shaft, which must belong to its Biot number.
    pub fn new(parameters: &ParameterSet, modes: &ThermalModes) -> Self {
        let (omega_tilde, gamma) = (parameters[Parameter::OmegaTilde], parameters[Parameter::Gamma]);
        let rates = modes.roots.iter().map(|mu| mu * mu).chain([modes.lumped_rate]);
        let weights = modes.pressure_weights.iter().copied().chain([modes.lumped_weight]);
        Self {
            rates: rates.map(|rate| rate * omega_tilde).collect(),
            weights: weights.map(|weight| 2.0 * gamma * weight).collect(),
            surface_temperature: 0.5 / (parameters[Parameter::Biot] * omega_tilde),
        }
    }
}
