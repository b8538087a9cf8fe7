//! The full model on a GPU: frictional heat and wear change the contact pressure of bushes. Its scheme is `radau`.
//!
//! Owns what its buffers are filled with, which of its kernels carries a period on, and how results are read.

pub mod layout;
pub(super) mod shader_source;

use self::layout::{HeatMode, Orbit, Parameters, Run, Totals, binding};
use super::buffers::Buffers;
use super::context::GpuContext;
use super::layout::{Binding, birkhoff_weights, slots};
use super::model::Model;
use super::pacer::Pace;
use super::shader_source::{Kernel, Lanes, Shape};
use crate::backend::{BackendError, EndState, Instance, Slice, Stage, Sums};
use crate::experiment::{MAX_MODES, Settings};
use crate::model::rubbing::Spectra;
use crate::parameters::ParameterSet;

/// The cost of a forcing period in the units of the pacer, steps of a scheme with a fixed step. A period has about two hundred
/// passes, and each pass costs as much as thirty such steps.
const STEPS_PER_PERIOD: u32 = 6000;

/// Most periods of a dispatch: if a thread needs all the passes that a period may take, it keeps the device busy for some tenths
/// of a second.
const MOST_PERIODS: u32 = 4;

/// A batch's model.
pub(super) struct Rubbed {
    modes: u32,
    points: Vec<ParameterSet>,
}

impl Rubbed {
    /// # Errors
    /// If arrays in kernels cannot hold this number of heat modes.
    pub fn new(settings: &Settings, instances: &[Instance]) -> Result<Self, BackendError> {
        let modes = settings.integration.modes;
        if !(1..=MAX_MODES).contains(&modes) {
            return Err(BackendError::Unsupported(format!(
                "{modes} heat modes are not from 1 to the {MAX_MODES} that the GPU's kernels hold: set --modes"
            )));
        }
        Ok(Self {
            modes,
            points: instances.iter().map(|instance| instance.parameters).collect(),
        })
    }
}

impl Model for Rubbed {
    fn bindings(&self) -> &'static [Binding] {
        &layout::BINDINGS
    }

    fn shape(&self, _: Lanes) -> Shape {
        Shape {
            lanes: Lanes::One,
            modes: Some(self.modes),
        }
    }

    fn pace(&self) -> Pace {
        Pace {
            steps_per_period: STEPS_PER_PERIOD,
            most_periods: MOST_PERIODS,
            is_lasting: false,
        }
    }

    fn kernel(&self, slice: &Slice) -> (Kernel, u32) {
        let kernel = match slice.stage {
            Stage::Transient | Stage::Watch => Kernel::Plain,
            Stage::Align | Stage::Measure | Stage::Check | Stage::Linearise => Kernel::Tangent,
        };
        (kernel, slice.periods)
    }

    fn fill(&self, context: &GpuContext, buffers: &Buffers, settings: &Settings, instances: &[Instance]) {
        let slots = slots(self.modes) as usize;
        let mut heat_modes = vec![HeatMode { rate: 0.0, weight: 0.0 }; slots * instances.len()];
        let spectra = Spectra::new(&self.points, self.modes as usize);
        let mut mode_states = vec![0.0; 2 * slots * instances.len()];
        let (parameters, orbits): (Vec<_>, Vec<_>) = instances
            .iter()
            .enumerate()
            .map(|(index, instance)| {
                let heat = spectra.heat_modes(&instance.parameters);
                let (orbit, [modes, tangent]) = Orbit::begun(instance, &heat);
                for slot in 0..slots {
                    heat_modes[slot * instances.len() + index] = HeatMode {
                        rate: heat.rates[slot] as f32,
                        weight: heat.weights[slot] as f32,
                    };
                    mode_states[slot * instances.len() + index] = modes[slot];
                    mode_states[(slots + slot) * instances.len() + index] = tangent[slot];
                }
                (Parameters::new(&instance.parameters, &heat), orbit)
            })
            .unzip();
        buffers.write(context, binding::RUN, &[Run::new(settings, instances.len() as u32)]);
        buffers.write(context, binding::BIRKHOFF_WEIGHTS, &birkhoff_weights(settings));
        buffers.write(context, binding::PARAMETERS, &parameters);
        buffers.write(context, binding::HEAT_MODES, &heat_modes);
        buffers.write(context, binding::ORBITS, &orbits);
        buffers.write(context, binding::MODE_STATES, &mode_states);
        buffers.clear(context, &[binding::TOTALS]);
    }

    fn take_sums(&self, context: &GpuContext, buffers: &Buffers, count: usize) -> Result<Vec<Sums>, BackendError> {
        let totals: Vec<Totals> = buffers.take(context, binding::TOTALS, count)?;
        Ok(totals.into_iter().map(Sums::from).collect())
    }

    fn end_states(&self, context: &GpuContext, buffers: &Buffers, count: usize) -> Result<Vec<EndState>, BackendError> {
        let orbits: Vec<Orbit> = buffers.read(context, binding::ORBITS, count)?;
        let slots = slots(self.modes) as usize;
        let ends = orbits.iter().zip(&self.points);
        if !self.points.iter().any(ParameterSet::is_heated) {
            return Ok(ends
                .map(|(orbit, set)| orbit.end_state(set, [Vec::new(), Vec::new()]))
                .collect());
        }
        let modes: Vec<f32> = buffers.read(context, binding::MODE_STATES, 2 * slots * count)?;
        let spectra = Spectra::new(&self.points, self.modes as usize);
        let end = |(index, (orbit, set)): (usize, (&Orbit, &ParameterSet))| {
            let weights = spectra.heat_modes(set).weights;
            let pressures = [0, slots].map(|first| {
                let pressure = |slot: usize| weights[slot] * f64::from(modes[(first + slot) * count + index]);
                (0..slots).map(pressure).collect()
            });
            orbit.end_state(set, pressures)
        };
        Ok(ends.enumerate().map(end).collect())
    }
}
