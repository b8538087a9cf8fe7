//! A request for a map as it is written in a file, and its resolution.

use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::{BackendChoice, Experiment, ExperimentError, Precision, Settings};
use crate::grid::{Axis, Coordinate, Fixed, Grid};
use crate::machine::{Description, SiQuantity};
use crate::parameters::{Parameter, ParameterSet};

/// A request as it is written in a file: everything may be left out. [`Request::resolve`] makes it an
/// [`Experiment`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Request {
    /// Where results go: the path all output names begin with. Not part of the experiment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub out: Option<PathBuf>,
    /// Horizontal axis (zeta_k = 0..12, 300 values).
    pub x: Axis,
    /// Vertical axis (h1 = 0..2, 201 values).
    pub y: Axis,
    /// A machine in SI units, which determines most parameters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub machine: Option<Description>,
    /// Values of parameters, and of quantities of the machine, that are no axis.
    #[serde(deserialize_with = "named_values")]
    pub set: BTreeMap<String, f64>,
    pub settings: Settings,
}

/// Names are checked as they are read, so that a misspelt one is reported with its line and a suggestion.
fn named_values<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<BTreeMap<String, f64>, D::Error> {
    let values = HashMap::<Coordinate, f64>::deserialize(deserializer)?;
    let named = values.into_iter().map(|(name, value)| (name.name().to_owned(), value));
    Ok(named.collect())
}

impl Default for Request {
    fn default() -> Self {
        Self {
            out: None,
            x: Axis {
                coordinate: Parameter::ZetaK.into(),
                start: 0.0,
                stop: 12.0,
                count: 300,
            },
            y: Axis {
                coordinate: Parameter::H1.into(),
                start: 0.0,
                stop: 2.0,
                count: 201,
            },
            machine: None,
            set: BTreeMap::new(),
            settings: Settings::default(),
        }
    }
}

impl Request {
    /// # Errors
    /// If the text is no TOML, has an unknown key, or a value of the wrong type.
    pub fn from_toml(text: &str) -> Result<Self, ExperimentError> {
        Ok(toml::from_str(text)?)
    }

    /// The map that the request asks for.
    ///
    /// # Errors
    /// If a value is out of its range, the axes are the same, what is set is an axis, or the machine is none, somewhere on
    /// the axes.
    pub fn resolve(&self) -> Result<Experiment, ExperimentError> {
        for axis in [&self.x, &self.y] {
            axis.check()?;
        }
        if self.x.coordinate == self.y.coordinate {
            return Err(ExperimentError::SameAxes {
                name: self.x.coordinate.name(),
            });
        }
        self.resolve_over(vec![self.x, self.y])
    }

    /// The one point that the request's `set` names; its axes are left aside.
    ///
    /// # Errors
    /// As [`Request::resolve`].
    pub fn resolve_point(&self) -> Result<Experiment, ExperimentError> {
        self.resolve_over(Vec::new())
    }

    /// The points over any axes, which must have been checked; the request's own are left aside.
    ///
    /// # Errors
    /// As [`Request::resolve`].
    pub fn resolve_over(&self, axes: Vec<Axis>) -> Result<Experiment, ExperimentError> {
        let grid = Grid {
            fixed: self.fixed(&axes)?,
            axes,
        };
        let mut experiment = Experiment {
            extents: grid.extents()?,
            grid,
            settings: self.settings.clone(),
        };
        experiment.settings = self.settings.for_model(experiment.is_rubbed())?;
        experiment.settings.check()?;
        if experiment.settings.scheme().carries_heat() {
            let modes = experiment.settings.modes.unwrap_or_else(|| experiment.enough_modes());
            experiment.settings.modes = Some(modes);
        }
        if experiment.settings.precision == Some(Precision::F32) || experiment.settings.backend == BackendChoice::Gpu {
            experiment.check_f32_anywhere()?;
        }
        Ok(experiment)
    }

    /// What holds at all points over the axes.
    fn fixed(&self, axes: &[Axis]) -> Result<Fixed, ExperimentError> {
        let mut parameters = ParameterSet::default();
        let mut machine = self.machine.clone();
        let mut si_axes: Vec<(SiQuantity, f64)> = Vec::new();
        for axis in axes {
            axis.coordinate.check_free(machine.is_some())?;
            if let Coordinate::Si(quantity) = axis.coordinate {
                si_axes.push((quantity, axis.start));
            }
        }
        for (name, &value) in &self.set {
            let coordinate = Coordinate::from_name(name)?;
            if axes.iter().any(|axis| axis.coordinate == coordinate) {
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
        let machine = machine.map(|machine| machine.complete(&si_axes)).transpose()?;
        Ok(Fixed::new(parameters, machine))
    }
}
