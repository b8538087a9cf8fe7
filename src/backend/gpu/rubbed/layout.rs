//! Data that host and device share in memory: the structs of `shaders/shared/rubbed_bindings.wgsl`, field by field, and the
//! bindings' numbers.
//!
//! Owns the conversion of parameters and settings to these structs, and of these structs to results; neither allocates nor
//! dispatches.

use bytemuck::{Pod, Zeroable};
use nalgebra::DMatrix;

use super::super::layout::Access::{Kept, Read, ReadWrite, Uniform};
use super::super::layout::{Binding, Count, Span, last_states, slots};
use crate::backend::rubbed::Begun;
use crate::backend::{Contact, EndState, HeatedState, Instance, Sums};
use crate::dynamics::adaptive::{Control, System};
use crate::dynamics::stroboscope;
use crate::experiment::Settings;
use crate::lanes::Real;
use crate::model::rubbing::HeatModes;
use crate::parameters::{Parameter, ParameterSet};

/// The bindings' numbers, as in the shader.
pub(super) mod binding {
    pub(super) use crate::backend::gpu::layout::SPAN;
    pub const RUN: u32 = 0;
    pub const BIRKHOFF_WEIGHTS: u32 = 2;
    pub const PARAMETERS: u32 = 3;
    pub const HEAT_MODES: u32 = 4;
    pub const MODE_STATES: u32 = 5;
    pub const LAST_STATES: u32 = 6;
    pub const ORBITS: u32 = 7;
    pub const TOTALS: u32 = 8;
}

/// Everything that the shader binds.
pub static BINDINGS: [Binding; 9] = [
    Binding::of::<Run>(binding::RUN, "run", Uniform, Count::One),
    Binding::of::<Span>(binding::SPAN, "span", Uniform, Count::One),
    Binding::of::<f32>(binding::BIRKHOFF_WEIGHTS, "birkhoff_weights", Read, Count::Periods),
    Binding::of::<Parameters>(binding::PARAMETERS, "parameters", Read, Count::Instances),
    Binding::of::<HeatMode>(binding::HEAT_MODES, "heat_modes", Read, Count::OfInstance(heat_modes)),
    Binding::of::<f32>(
        binding::MODE_STATES,
        "mode_states",
        ReadWrite,
        Count::OfInstance(mode_states),
    ),
    Binding::of::<[f32; 2]>(
        binding::LAST_STATES,
        "last_states",
        Kept,
        Count::OfInstance(last_states),
    ),
    Binding::of::<Orbit>(binding::ORBITS, "orbits", ReadWrite, Count::Instances),
    Binding::of::<Totals>(binding::TOTALS, "totals", ReadWrite, Count::Instances),
];

fn heat_modes(settings: &Settings) -> usize {
    slots(settings.integration.modes) as usize
}

/// Elements for the heat modes of an instance and for those of its tangent vector.
fn mode_states(settings: &Settings) -> usize {
    2 * heat_modes(settings)
}

/// Data that all instances of a batch share.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Run {
    pub instances: u32,
    pub unrecorded: u32,
    pub window: u32,
    pub max_period: u32,
    pub period_tolerance: f32,
    pub tolerance: f32,
    pub newton: f32,
    pub reach: f32,
    pub longest_step_periods: f32,
    pub swing: f32,
}

impl Run {
    pub fn new(settings: &Settings, instances: u32) -> Self {
        let Control {
            tolerance,
            newton,
            reach,
            longest_step_periods,
            swing,
        } = Control::<f32>::new(&settings.integration);
        let window = stroboscope::window(settings.sampling.periods, settings.sampling.max_period);
        Self {
            instances,
            unrecorded: settings.sampling.periods - window,
            window,
            max_period: settings.sampling.max_period,
            period_tolerance: settings.sampling.period_tolerance as f32,
            tolerance,
            newton,
            reach,
            longest_step_periods,
            swing,
        }
    }
}

/// One instance's parameters.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Parameters {
    pub zeta_k: f32,
    pub h1: f32,
    pub omega_k: f32,
    pub b: f32,
    pub epsilon: f32,
    pub f_0: f32,
    pub alpha: f32,
    pub beta: f32,
    pub epsilon_0: f32,
    pub gamma: f32,
    pub k_w: f32,
    pub ramp_rate: f32,
    pub period: f32,
    pub surface_temperature: f32,
}

impl Parameters {
    pub fn new(set: &ParameterSet, heat: &HeatModes) -> Self {
        let value = |parameter| set[parameter] as f32;
        Self {
            zeta_k: value(Parameter::ZetaK),
            h1: value(Parameter::H1),
            omega_k: value(Parameter::OmegaK),
            b: value(Parameter::B),
            epsilon: value(Parameter::Epsilon),
            f_0: value(Parameter::F0),
            alpha: value(Parameter::Alpha),
            beta: value(Parameter::Beta),
            epsilon_0: value(Parameter::Epsilon0),
            gamma: value(Parameter::Gamma),
            k_w: value(Parameter::KW),
            // compilers of shaders may assume that no number is infinite
            ramp_rate: value(Parameter::RampRate).min(f32::MAX),
            period: set.forcing_period() as f32,
            surface_temperature: heat.surface_temperature as f32,
        }
    }
}

/// One heat mode of one instance.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct HeatMode {
    pub rate: f32,
    pub weight: f32,
}

/// One instance as it is carried along.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Orbit {
    pub x: f32,
    pub v: f32,
    pub fit: f32,
    pub heat_pressure: f32,
    pub heat_falloff: f32,
    pub contact: f32,
    pub sine: f32,
    pub cosine: f32,
    pub left: u32,
    pub periods: f32,
    pub step: f32,
    pub piece: f32,
    pub guess_0: f32,
    pub guess_1: f32,
    pub guess_2: f32,
    pub guess_3: f32,
    pub since: f32,
    pub tangent_x: f32,
    pub tangent_v: f32,
    pub tangent_fit: f32,
    pub tangent_pressure: f32,
    pub tangent_falloff: f32,
    pub tangent_flux: f32,
    pub peak_pressure: f32,
    pub peak_periods: f32,
    pub peak_time: f32,
    pub peak_temperature: f32,
    pub lost_periods: f32,
    pub lost_time: f32,
    pub x_min: f32,
    pub x_max: f32,
    pub period: u32,
    pub under_resolved: u32,
    pub runaway: u32,
    pub given_up_period: u32,
    pub runaway_phase: f32,
}

impl Orbit {
    /// The instance as its run begins or goes on, its heat modes, and those of its tangent vector.
    pub fn begun(instance: &Instance, heat: &HeatModes) -> (Self, [Vec<f32>; 2]) {
        let system = System::<f32>::new(|parameter| instance.parameters[parameter] as f32, |_| heat);
        let Begun { orbit, peaks, tangents } = Begun::new(&system, 1, |_| instance);
        let [tangent] = <[_; 1]>::try_from(tangents).expect("one vector was asked for");
        let (at, [pressure, falloff]) = (tangent.at, orbit.heat_sums());
        let begun = Self {
            x: orbit.x,
            v: orbit.v,
            fit: orbit.fit,
            heat_pressure: pressure,
            heat_falloff: falloff,
            contact: orbit.contact,
            sine: 0.0,
            cosine: 1.0,
            left: 0,
            periods: orbit.periods,
            step: orbit.step,
            piece: orbit.piece,
            guess_0: orbit.guess[0],
            guess_1: orbit.guess[1],
            guess_2: orbit.guess[2],
            guess_3: orbit.guess[3],
            since: orbit.since,
            tangent_x: at.x,
            tangent_v: at.v,
            tangent_fit: at.fit,
            tangent_pressure: at.heat.pressure,
            tangent_falloff: at.heat.falloff,
            tangent_flux: at.flux,
            peak_pressure: peaks.pressure,
            peak_periods: peaks.pressure_time[0],
            peak_time: peaks.pressure_time[1],
            peak_temperature: peaks.temperature,
            lost_periods: peaks.lost[0],
            lost_time: peaks.lost[1],
            x_min: orbit.x,
            x_max: orbit.x,
            period: 0,
            under_resolved: 0,
            runaway: 0,
            given_up_period: 0,
            runaway_phase: 1.0,
        };
        (begun, [orbit.modes, tangent.modes])
    }

    /// The end state of the instance with the parameters `set`, given the pressures that its heat modes cause, and those of the modes
    /// of its tangent vector.
    pub fn end_state(&self, set: &ParameterSet, [pressures, tangent]: [Vec<f64>; 2]) -> EndState {
        let tau = |periods: f32, time: f32| f64::from(periods) * set.forcing_period() + f64::from(time);
        let ramp = set[Parameter::RampRate] * tau(self.periods, 0.0).powi(2);
        // without a ramp the fit is 1 from the start
        let fit = if ramp.is_finite() { -(-ramp).exp_m1() } else { 1.0 };
        let contact = Contact {
            lost: (self.lost_periods >= 0.0).then(|| tau(self.lost_periods, self.lost_time)),
            peak_pressure: self.peak_pressure.into(),
            peak_pressure_time: tau(self.peak_periods, self.peak_time),
            final_wear: fit - f64::from(self.fit),
            peak_temperature: self.peak_temperature.into(),
        };
        let heated = set.is_heated().then(|| {
            let in_plane = [self.tangent_x.into(), -f64::from(self.tangent_v)];
            Box::new(HeatedState {
                pressures,
                vectors: DMatrix::from_iterator(2 + tangent.len(), 1, in_plane.into_iter().chain(tangent)),
                periods: self.periods.into(),
                is_in_contact: self.contact > 0.0,
                contact,
                step: f64::from(self.step) / f32::PERIOD_TICKS,
            })
        });
        EndState {
            x: self.x.into(),
            // the drive's phase is 0
            y: set[Parameter::OmegaK] - f64::from(self.v),
            tangent: [f64::NAN; 2],
            x_min: self.x_min.into(),
            x_max: self.x_max.into(),
            period: (self.period > 0).then_some(self.period),
            runaway_periods: (self.runaway > 0)
                .then(|| f64::from(self.given_up_period) - 1.0 + f64::from(self.runaway_phase)),
            under_resolved: self.under_resolved > 0,
            heated,
            contact,
        }
    }
}

/// One instance's sums over measured periods since they were last collected.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Totals {
    pub growth: f32,
    pub birkhoff: f32,
}

impl From<Totals> for Sums {
    fn from(totals: Totals) -> Self {
        Self {
            growth: [totals.growth.into(), f64::NAN],
            birkhoff: totals.birkhoff.into(),
            // not summed up: the tangent space has more dimensions than two
            divergence: f64::NAN,
        }
    }
}
