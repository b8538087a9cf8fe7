//! The experiment: a validated and fully resolved description of what is computed, and its TOML form.
//!
//! Owns the numerical settings with their defaults and limits; opens no file and computes nothing.

mod builder;
mod device;
mod difference;
mod integration;
mod outline;
mod preset;
mod request;
mod sampling;
mod settings;
mod warnings;

pub use builder::Builder;
pub use device::{BackendChoice, Checking, Device};
pub use integration::{Integration, IntegrationRequest, MAX_MODES, Precision, Scheme};
pub use outline::Outline;
pub use preset::Preset;
pub use request::Request;
pub use sampling::{InitialBox, Sampling};
pub use settings::Settings;

use crate::design::{AxisError, Coordinate, Design, DesignError, Extents, PointsError, Varied};
use crate::machine::{Description, MachineError, SiQuantity};
use crate::model::friction::thinnest_layer;
use crate::parameters::{PARAMETERS, Parameter, ParameterError};

/// A validated, fully resolved experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// The points: what varies, and what all have in common.
    pub design: Design,
    /// How points are integrated and what is sampled of them; with the design this identifies the results.
    pub settings: Settings,
    /// The device that computes it: it changes the results only by rounding.
    pub device: Device,
    /// How the results are checked. The checks do not change them.
    pub checking: Checking,
    extents: Extents,
}

impl Experiment {
    /// Whether another experiment has the same results, up to rounding. Devices and checks do not matter.
    pub fn has_results_of(&self, other: &Self) -> bool {
        self.design == other.design && self.settings == other.settings
    }

    /// The parameters that no axis changes, in the table's order.
    pub fn fixed_parameters(&self) -> impl Iterator<Item = (Parameter, f64)> + '_ {
        PARAMETERS
            .iter()
            .map(|info| info.parameter)
            .filter(|&parameter| {
                let mut varied = self.design.varied.coordinates().into_iter();
                !varied.any(|coordinate| self.design.fixed.moves(coordinate, parameter))
            })
            .map(|parameter| (parameter, self.design.fixed[parameter]))
    }

    /// The quantities of the machine that vary.
    fn varied_quantities(&self) -> Vec<SiQuantity> {
        let varied = self.design.varied.coordinates().into_iter();
        varied
            .filter_map(|coordinate| match coordinate {
                Coordinate::Si(quantity) => Some(quantity),
                Coordinate::Parameter(_) => None,
            })
            .collect()
    }

    /// The machine as it is written to files, with every value that does not vary.
    pub fn machine_description(&self) -> Option<Description> {
        let machine = self.design.fixed.machine()?;
        Some(machine.description(&self.varied_quantities()))
    }

    /// Least and greatest value of a parameter over the design.
    pub fn extent(&self, parameter: Parameter) -> (f64, f64) {
        self.extents[parameter]
    }

    /// Whether there is frictional heat or wear anywhere in the design. The pressure is then not constant.
    pub fn has_heat_or_wear(&self) -> bool {
        self.extent(Parameter::Gamma).1 > 0.0 || self.extent(Parameter::KW).1 > 0.0
    }

    /// Whether all points may be decided early, before their full length. This needs a motion that lasts: with wear, there is none.
    pub fn decides_early(&self) -> bool {
        self.settings.sampling.decide_early && !self.wears()
    }

    /// Whether the contact wears anywhere in the design.
    pub fn wears(&self) -> bool {
        self.extent(Parameter::KW).1 > 0.0
    }

    /// Whether f32 resolves the friction layer everywhere in the design.
    ///
    /// # Errors
    /// If not; the error gives the thinnest layer and the greatest speed of the shaft.
    pub fn check_f32(&self) -> Result<(), ExperimentError> {
        let (slowest, fastest) = self.extent(Parameter::OmegaK);
        let speed = slowest.abs().max(fastest.abs()) + self.extent(Parameter::ZetaK).1;
        self.check_layer_in_f32(self.extent(Parameter::Epsilon0).0, speed)
    }

    /// Whether f32 resolves the friction layer anywhere in the design. Points at which it does not are computed in f64.
    ///
    /// # Errors
    /// If not; the error gives the thickest layer and the least speed of the shaft.
    pub fn check_f32_anywhere(&self) -> Result<(), ExperimentError> {
        let (slowest, fastest) = self.extent(Parameter::OmegaK);
        // 0 if the speed changes its sign
        let speed = slowest.max(-fastest).max(0.0) + self.extent(Parameter::ZetaK).0;
        self.check_layer_in_f32(self.extent(Parameter::Epsilon0).1, speed)
    }

    fn check_layer_in_f32(&self, value: f64, speed: f64) -> Result<(), ExperimentError> {
        let is_dry = self.extent(Parameter::Epsilon).1 * self.extent(Parameter::F0).1 > 0.0;
        let least = thinnest_layer(f32::EPSILON.into(), speed);
        if is_dry && value <= least {
            return Err(ExperimentError::LayerTooThinForF32 { value, least, speed });
        }
        Ok(())
    }

    /// # Errors
    /// [`ExperimentError::Wears`] if the contact wears at some point: there is no attractor whose states could be shown.
    pub fn check_lasting(&self) -> Result<(), ExperimentError> {
        if self.wears() {
            return Err(ExperimentError::Wears);
        }
        Ok(())
    }

    /// # Errors
    /// [`ExperimentError::StartVaried`] if x0 or y0 varies.
    pub fn check_start_fixed(&self) -> Result<(), ExperimentError> {
        let is_initial = |coordinate: &Coordinate| [Parameter::X0.into(), Parameter::Y0.into()].contains(coordinate);
        match self.design.varied.coordinates().into_iter().find(is_initial) {
            Some(coordinate) => Err(ExperimentError::StartVaried {
                name: coordinate.name(),
            }),
            None => Ok(()),
        }
    }

    /// The request for exactly this experiment, with every value written out, so that later changes of defaults have no effect.
    pub fn request(&self) -> Request {
        let (axes, points) = match &self.design.varied {
            Varied::Axes(axes) => (Some(axes.clone()), None),
            Varied::Points(points) => (None, Some(points.clone())),
        };
        let fixed = &self.design.fixed;
        Request {
            out: None,
            quantities: None,
            command: None,
            options: toml::Table::new(),
            axes,
            points,
            machine: self.machine_description(),
            set: self
                .fixed_parameters()
                .filter(|(parameter, _)| fixed.governing(*parameter).is_none())
                .map(|(parameter, value)| (parameter.name().to_owned(), value))
                .collect(),
            integration: self.settings.integration.into(),
            sampling: self.settings.sampling,
            device: self.device.clone(),
            checking: self.checking,
        }
    }

    /// The request without the device and the checks, as TOML; [`Request::from_toml`] reads it back. This text identifies the
    /// results: experiments with the same results have the same text.
    pub fn to_toml(&self) -> String {
        self.request().result_toml()
    }
}

/// # Errors
/// If the value of a setting is out of its range.
fn in_range(name: &'static str, value: f64, min: f64, max: f64) -> Result<(), ExperimentError> {
    if (min..=max).contains(&value) {
        Ok(())
    } else {
        Err(ExperimentError::Setting { name, value, min, max })
    }
}

/// Why an experiment is not valid.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages tell what each is")]
pub enum ExperimentError {
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    #[error(transparent)]
    Axis(#[from] AxisError),
    #[error(transparent)]
    Machine(#[from] MachineError),
    #[error(transparent)]
    Design(#[from] DesignError),
    #[error(transparent)]
    Points(#[from] PointsError),
    #[error("{name} = {value} is out of range: it must be from {min} to {max}")]
    Setting {
        name: &'static str,
        value: f64,
        min: f64,
        max: f64,
    },
    #[error("the initial box of {name} runs from {low} down to {high}: give the lower end first")]
    InitialBox { name: &'static str, low: f64, high: f64 },
    #[error("two axes are {name}: give each axis its own parameter")]
    SameAxes { name: &'static str },
    #[error("the experiment has axes and points: leave one of the two out")]
    AxesAndPoints,
    #[error("{name} is an axis and set to a value as well: leave one of the two out")]
    SetAxis { name: &'static str },
    #[error(
        "the scheme {scheme} holds the contact pressure at 1 and knows neither frictional heat nor wear: leave --scheme out, \
         or set gamma = 0 and k_w = 0 (of a machine, wear_energy_share = 1 and wear_coefficient = 0)"
    )]
    SchemeWithoutHeat { scheme: &'static str },
    #[error("a GPU integrates in f32: leave --precision f64 out, or use --backend cpu")]
    GpuF64,
    #[error(
        "epsilon_0 = {value} is too thin a friction layer for f32, whose numbers lie too far apart at a shaft speed of {speed} \
         (least: {least:.1e}): use --backend cpu --precision f64"
    )]
    LayerTooThinForF32 { value: f64, least: f64, speed: f64 },
    #[error(
        "with wear all motion is transient, and has no attractor to draw: set k_w = 0 (of a machine, wear_coefficient = 0)"
    )]
    Wears,
    #[error("{name} is varied: give initial states by --start, or use `map`, whose axes they can be")]
    StartVaried { name: &'static str },
    #[error("no experiment in TOML: {0}")]
    Toml(#[from] toml::de::Error),
}

#[cfg(test)]
mod tests;
