//! A request for a map or another experiment, as it is written in a file, and the experiment that it gives.

use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::{
    BackendChoice, Checking, Device, Experiment, ExperimentError, IntegrationRequest, Precision, Preset, Sampling,
    Settings,
};
use crate::design::{Axis, Coordinate, Design, Fixed, Points, Varied, first_twice};
use crate::machine::{Description, SiQuantity};
use crate::parameters::{Parameter, ParameterSet};

/// A request as it is written in a file: everything may be left out. [`Request::resolve`] makes it an
/// [`Experiment`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Request {
    /// Where results go: the path with which all output names begin. It is not part of the experiment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub out: Option<PathBuf>,
    /// The command that wrote the experiment; None for a map. The command's own options are in `options`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub command: Option<String>,
    /// Names of the quantities that are stored. Not part of the experiment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quantities: Option<Vec<String>>,
    /// Axes; the first one varies fastest. For a map, they are the horizontal and the vertical axis. If neither axes nor points
    /// are given, each command uses its own default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axes: Option<Vec<Axis>>,
    /// Points one by one, instead of axes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<Points>,
    /// A machine in SI units, which determines most parameters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub machine: Option<Description>,
    /// Values of parameters, and of quantities of the machine, that are not axes.
    #[serde(deserialize_with = "named_values")]
    pub set: BTreeMap<String, f64>,
    /// Options of the command, which the library does not read.
    #[serde(skip_serializing_if = "toml::Table::is_empty")]
    pub options: toml::Table,
    /// How instances are integrated.
    #[serde(skip_serializing_if = "is_default")]
    pub integration: IntegrationRequest,
    /// What is sampled of each point.
    pub sampling: Sampling,
    /// The device that computes the experiment. It does not identify the results.
    #[serde(skip_serializing_if = "is_default")]
    pub device: Device,
    /// How the results are checked. The checks do not identify the results.
    #[serde(skip_serializing_if = "is_default")]
    pub checking: Checking,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// A file of version 0.1 in the present form: its tables `x` and `y` become axes, and each of its `settings` moves to the present
/// table for it. None if the text has no such tables.
fn of_version_0_1(text: &str) -> Option<toml::Table> {
    const INTEGRATION: [&str; 6] = [
        "scheme",
        "steps_per_period",
        "modes",
        "tolerance",
        "renormalise_every",
        "precision",
    ];
    let mut table: toml::Table = text.parse().ok()?;
    let has_axes = table.contains_key("x") || table.contains_key("y");
    let settings = table.remove("settings");
    if table.contains_key("axes") || !(has_axes || settings.is_some()) {
        return None;
    }
    if has_axes {
        let default = Request::default_map();
        let axes = ["x", "y"].into_iter().zip(default).map(|(name, default)| {
            table
                .remove(name)
                .unwrap_or_else(|| toml::Value::try_from(default).expect("an axis has a TOML form"))
        });
        let axes = axes.collect();
        table.insert("axes".to_owned(), toml::Value::Array(axes));
    }
    let settings = settings.and_then(|settings| settings.as_table().cloned());
    for (name, value) in settings.unwrap_or_default() {
        let part = match name.as_str() {
            name if INTEGRATION.contains(&name) => "integration",
            "backend" | "adapter" => "device",
            "audit" => "checking",
            _ => "sampling",
        };
        let part = table.entry(part).or_insert_with(|| toml::Table::new().into());
        part.as_table_mut()?.insert(name, value);
    }
    Some(table)
}

/// Names are checked as they are read, so that a misspelt one is reported with its line and a suggestion.
fn named_values<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<BTreeMap<String, f64>, D::Error> {
    let values = HashMap::<Coordinate, f64>::deserialize(deserializer)?;
    let named = values.into_iter().map(|(name, value)| (name.name().to_owned(), value));
    Ok(named.collect())
}

impl Request {
    /// # Errors
    /// If the text is no TOML, has an unknown key, or a value of the wrong type.
    pub fn from_toml(text: &str) -> Result<Self, ExperimentError> {
        Self::from_toml_over(text, Sampling::default())
    }

    /// Reads a request. Values of the sampling that the text leaves out come from `defaults`.
    ///
    /// # Errors
    /// As [`Request::from_toml`].
    #[expect(clippy::missing_panics_doc, reason = "numbers and truth values have a TOML form")]
    pub fn from_toml_over(text: &str, defaults: Sampling) -> Result<Self, ExperimentError> {
        let mut table = if let Some(table) = of_version_0_1(text) {
            table
        } else {
            // read from the text first, so that an error is reported with its line
            toml::from_str::<Self>(text)?;
            text.parse()?
        };
        let mut sampling = toml::Table::try_from(defaults).expect("sampling has a TOML form");
        if let Some(toml::Value::Table(own)) = table.remove("sampling") {
            sampling.extend(own);
        }
        table.insert("sampling".to_owned(), sampling.into());
        Ok(table.try_into()?)
    }

    /// The request as TOML; [`Request::from_toml`] reads it back.
    #[expect(clippy::missing_panics_doc, reason = "a request has a TOML form")]
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("a request has a TOML form")
    }

    /// The request without the device and the checks, as TOML. This text identifies the results.
    pub fn result_toml(&self) -> String {
        let request = Self {
            device: Device::default(),
            checking: Checking::default(),
            ..self.clone()
        };
        request.to_toml()
    }

    /// A request for all combinations of the values of some axes, with defaults for everything else.
    pub fn over(axes: Vec<Axis>) -> Self {
        Self {
            axes: Some(axes),
            ..Self::default()
        }
    }

    /// A request for an analysis, as far as it differs from that for a map. The backend is the CPU: few points do not use a GPU
    /// fully, and f64 leaves no doubt about them. Points are run to their full length, since their errors are shown.
    pub fn of_analysis() -> Self {
        let mut request = Self::default();
        request.device.backend = BackendChoice::Cpu;
        request.sampling.decide_early = false;
        request
    }

    /// Requests exactly these settings.
    pub fn set_settings(&mut self, settings: &Settings) {
        self.integration = settings.integration.into();
        self.sampling = settings.sampling;
    }

    /// Sets the values of a preset. They replace values that are already set.
    pub fn set_preset(&mut self, preset: Preset) {
        for &(parameter, value) in preset.values() {
            self.set.insert(parameter.name().to_owned(), value);
        }
    }

    /// The axes of a map if none are given: zeta_k = 0..12, 300 values, by h1 = 0..2, 201 values.
    #[expect(clippy::missing_panics_doc, reason = "the table of parameters admits these axes")]
    pub fn default_map() -> [Axis; 2] {
        let axis = |parameter: Parameter, stop, count| {
            Axis::even(parameter, 0.0, stop, count).expect("the table of parameters admits the default map")
        };
        [axis(Parameter::ZetaK, 12.0, 300), axis(Parameter::H1, 2.0, 201)]
    }

    /// The experiment that the request describes: over its axes or points, or over the default map if it has neither.
    ///
    /// # Errors
    /// If there are both axes and points, a value is out of its range, two axes are the same, an axis is also set to a value, or
    /// the machine is not valid somewhere on the axes.
    pub fn resolve(&self) -> Result<Experiment, ExperimentError> {
        let varied = match (&self.axes, &self.points) {
            (Some(_), Some(_)) => return Err(ExperimentError::AxesAndPoints),
            (Some(axes), None) => Varied::Axes(axes.clone()),
            (None, Some(points)) => Varied::Points(points.clone()),
            (None, None) => Varied::Axes(Self::default_map().into()),
        };
        self.resolve_over(varied)
    }

    /// The experiment with the single point that `set` gives; the request's axes and points are ignored.
    ///
    /// # Errors
    /// As [`Request::resolve`].
    pub fn resolve_point(&self) -> Result<Experiment, ExperimentError> {
        self.resolve_over(Varied::Axes(Vec::new()))
    }

    /// The experiment over `varied`; the request's own axes and points are ignored.
    ///
    /// # Errors
    /// As [`Request::resolve`].
    pub fn resolve_over(&self, varied: Varied) -> Result<Experiment, ExperimentError> {
        if let Some(twice) = first_twice(&varied.coordinates()) {
            return Err(ExperimentError::SameAxes { name: twice.name() });
        }
        let design = Design {
            fixed: self.fixed(&varied)?,
            varied,
        };
        let mut experiment = Experiment {
            extents: design.extents()?,
            design,
            settings: Settings {
                sampling: self.sampling,
                ..Settings::default()
            },
            device: self.device.clone(),
            checking: self.checking,
        };
        let integration = self
            .integration
            .resolve(experiment.has_heat_or_wear(), || experiment.enough_modes())?;
        experiment.settings.integration = integration;
        experiment.settings.check()?;
        let on_gpu = self.device.backend == BackendChoice::Gpu;
        if on_gpu && integration.precision == Some(Precision::F64) {
            return Err(ExperimentError::GpuF64);
        }
        if on_gpu || integration.precision == Some(Precision::F32) {
            experiment.check_f32_anywhere()?;
        }
        Ok(experiment)
    }

    /// The values that all points have in common.
    fn fixed(&self, varied: &Varied) -> Result<Fixed, ExperimentError> {
        let mut parameters = ParameterSet::default();
        let mut machine = self.machine.clone();
        // a machine needs a value of every quantity: for those that vary, the value at the first point will do
        let mut si_varied: Vec<(SiQuantity, f64)> = Vec::new();
        for (coordinate, value) in varied.values(0) {
            coordinate.check_free(machine.is_some())?;
            if let Coordinate::Si(quantity) = coordinate {
                si_varied.push((quantity, value));
            }
        }
        for (name, &value) in &self.set {
            let coordinate = Coordinate::from_name(name)?;
            if varied.coordinates().contains(&coordinate) {
                return Err(ExperimentError::SetAxis {
                    name: coordinate.name(),
                });
            }
            coordinate.check_free(machine.is_some())?;
            coordinate.check(value)?;
            match (coordinate, &mut machine) {
                (Coordinate::Parameter(parameter), _) => parameters[parameter] = value,
                (Coordinate::Si(quantity), Some(machine)) => machine.set(quantity, value)?,
                (Coordinate::Si(_), None) => unreachable!("a quantity is free only where there is a machine"),
            }
        }
        let machine = machine.map(|machine| machine.complete(&si_varied)).transpose()?;
        Ok(Fixed::new(parameters, machine))
    }
}
