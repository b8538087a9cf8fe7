//! Data that host and device share in memory: the structs of `shaders/shared/bindings.wgsl`, field by field, and the
//! bindings' numbers.
//!
//! Owns the conversion of parameters and settings to these structs, and of these structs to results; neither allocates nor
//! dispatches.

use bytemuck::{Pod, Zeroable};

use super::super::layout::Access::{Kept, Read, ReadWrite, Uniform};
use super::super::layout::{Binding, Count, Span, last_states};
use crate::backend::{Contact, EndState, Instance, Sums};
use crate::dynamics::drive::DriveTable;
use crate::dynamics::{stroboscope, taylor};
use crate::experiment::{Scheme, Settings};
use crate::parameters::{Parameter, ParameterSet};

/// The bindings' numbers, as in the shader.
pub(super) mod binding {
    pub(super) use crate::backend::gpu::layout::SPAN;
    pub const RUN: u32 = 0;
    pub const DRIVE: u32 = 2;
    pub const BIRKHOFF_WEIGHTS: u32 = 3;
    pub const PARAMETERS: u32 = 4;
    pub const ORBITS: u32 = 5;
    pub const TANGENTS: u32 = 6;
    pub const TOTALS: u32 = 7;
    pub const LAST_STATES: u32 = 8;
}

/// Everything that the shader binds.
pub static BINDINGS: [Binding; 9] = [
    Binding::of::<Run>(binding::RUN, "run", Uniform, Count::One),
    Binding::of::<Span>(binding::SPAN, "span", Uniform, Count::One),
    Binding::of::<Drive>(binding::DRIVE, "drive", Uniform, Count::One),
    Binding::of::<f32>(binding::BIRKHOFF_WEIGHTS, "birkhoff_weights", Read, Count::Periods),
    Binding::of::<Parameters>(binding::PARAMETERS, "parameters", Read, Count::Instances),
    Binding::of::<Orbit>(binding::ORBITS, "orbits", ReadWrite, Count::Instances),
    Binding::of::<Tangent>(binding::TANGENTS, "tangents", ReadWrite, Count::Instances),
    Binding::of::<Totals>(binding::TOTALS, "totals", ReadWrite, Count::Instances),
    Binding::of::<[f32; 2]>(
        binding::LAST_STATES,
        "last_states",
        Kept,
        Count::OfInstance(last_states),
    ),
];

/// Entries of the drive table. It has 64 KiB, a size that every device allows for a uniform buffer.
const DRIVE_ENTRIES: usize = 4096;

/// The drive table: each entry has sin z at the [middle, end] of two steps.
type Drive = [[[f32; 2]; 2]; DRIVE_ENTRIES];

/// Steps that the drive table holds, two in each entry.
pub(super) const MAX_STEPS_PER_PERIOD: u32 = 2 * DRIVE_ENTRIES as u32;

/// Data that all instances of a batch share.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Run {
    pub instances: u32,
    pub steps_per_period: u32,
    pub renormalise_every: u32,
    pub unrecorded: u32,
    pub window: u32,
    pub max_period: u32,
    pub period_tolerance: f32,
}

impl Run {
    pub fn new(settings: &Settings, instances: u32) -> Self {
        let window = stroboscope::window(settings.sampling.periods, settings.sampling.max_period);
        Self {
            instances,
            steps_per_period: settings.integration.steps_per_period,
            renormalise_every: settings.integration.renormalise_every,
            unrecorded: settings.sampling.periods - window,
            window,
            max_period: settings.sampling.max_period,
            period_tolerance: settings.sampling.period_tolerance as f32,
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
    pub step_units: f32,
    pub unit_of_time: f32,
}

impl Parameters {
    pub fn new(set: &ParameterSet, settings: &Settings) -> Self {
        let value = |parameter| set[parameter] as f32;
        let steps = settings.integration.steps_per_period;
        let (step_units, unit_of_time) = match settings.integration.scheme {
            Scheme::Taylor => (
                taylor::longest_step_units(set, steps),
                taylor::unit_of_time(set[Parameter::Omega0]),
            ),
            Scheme::Rk4 | Scheme::Radau => (set.forcing_period() / f64::from(steps), 1.0),
        };
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
            step_units: step_units as f32,
            unit_of_time: unit_of_time as f32,
        }
    }
}

/// One instance as it is carried along.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Orbit {
    pub x: f32,
    pub y: f32,
    pub x_min: f32,
    pub x_max: f32,
    pub period: u32,
    pub runaway_period: u32,
    pub under_resolved: u32,
}

impl Orbit {
    /// The instance at the beginning of its run.
    pub fn start(instance: &Instance) -> Self {
        let [x, y] = instance.state.map(|value| value as f32);
        Self {
            x,
            y,
            x_min: x,
            x_max: x,
            period: 0,
            runaway_period: 0,
            under_resolved: u32::from(!taylor::is_layer_resolved::<f32>(&instance.parameters)),
        }
    }
}

/// One instance's tangent vector (X, Y), of length 1.
pub type Tangent = [f32; 2];

impl From<(Orbit, Tangent)> for EndState {
    fn from((orbit, tangent): (Orbit, Tangent)) -> Self {
        Self {
            x: orbit.x.into(),
            y: orbit.y.into(),
            tangent: tangent.map(f64::from),
            x_min: orbit.x_min.into(),
            x_max: orbit.x_max.into(),
            period: (orbit.period > 0).then_some(orbit.period),
            runaway_periods: (orbit.runaway_period > 0).then_some(orbit.runaway_period.into()),
            under_resolved: orbit.under_resolved > 0,
            heated: None,
            contact: Contact::CONSTANT,
        }
    }
}

/// One instance's sums over measured periods since they were last collected.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Totals {
    pub growth_first: f32,
    pub growth_second: f32,
    pub birkhoff: f32,
    pub divergence: f32,
}

impl From<Totals> for Sums {
    fn from(totals: Totals) -> Self {
        Self {
            growth: [totals.growth_first.into(), totals.growth_second.into()],
            birkhoff: totals.birkhoff.into(),
            divergence: totals.divergence.into(),
        }
    }
}

/// The drive table as the shader reads it: [middle, end] of two steps in each entry. Unused entries are zero.
pub fn drive_entries(steps_per_period: u32) -> Vec<[[f32; 2]; 2]> {
    let mut entries = vec![[[0.0; 2]; 2]; DRIVE_ENTRIES];
    for (entry, steps) in entries
        .iter_mut()
        .zip(DriveTable::new::<f32>(steps_per_period).steps().chunks(2))
    {
        entry[..steps.len()].copy_from_slice(steps);
    }
    entries
}
