//! What is asked for, put together value by value.
//!
//! Owns which table of a request each setting belongs to; what a value may be is the library's.

use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use serde_json::Value;
use tribochaos::analysis::{bifurcation, section};
use tribochaos::design::{Axis, Coordinate, Points, Spacing};

use tribochaos::engine::{Backends, choice};
use tribochaos::experiment::{BackendChoice, Experiment, ExperimentError, Preset, Scheme};
use tribochaos::machine::Description;

use crate::{errors, pool};

/// The table of a setting.
#[derive(Clone, Copy)]
enum Table {
    Integration,
    Sampling,
    Device,
}

/// Every setting, and its table.
const SETTINGS: &[(&str, Table)] = &[
    ("scheme", Table::Integration),
    ("steps_per_period", Table::Integration),
    ("modes", Table::Integration),
    ("tolerance", Table::Integration),
    ("renormalise_every", Table::Integration),
    ("precision", Table::Integration),
    ("transient_periods", Table::Sampling),
    ("align_periods", Table::Sampling),
    ("periods", Table::Sampling),
    ("decide_early", Table::Sampling),
    ("period_tolerance", Table::Sampling),
    ("max_period", Table::Sampling),
    ("initial_states", Table::Sampling),
    ("initial_box", Table::Sampling),
    ("seed", Table::Sampling),
    ("backend", Table::Device),
    ("adapter", Table::Device),
];

/// A request for an experiment. Each method checks what it is given.
#[pyclass(module = "tribochaos._native")]
#[derive(Default)]
pub struct Request(pub tribochaos::Request);

#[pymethods]
impl Request {
    /// A request for a map or a list of points, or for one of the analyses `point`, `trajectory`, `section` and `bifurcation`,
    /// with its defaults.
    #[new]
    #[pyo3(signature = (analysis = None))]
    fn new(analysis: Option<&str>) -> PyResult<Self> {
        let Some(analysis) = analysis else {
            return Ok(Self::default());
        };
        let mut request = tribochaos::Request::of_analysis();
        match analysis {
            "point" => {}
            "trajectory" => request.integration.scheme = Some(Scheme::Radau),
            "section" => request.sampling.transient_periods = section::TRANSIENT_PERIODS,
            "bifurcation" => request.sampling.periods = bifurcation::PERIODS,
            other => return Err(errors::input(format!("there is no analysis `{other}`"))),
        }
        Ok(Self(request))
    }

    /// Takes the values of a preset.
    fn preset(&mut self, name: &str) -> PyResult<()> {
        let preset = Preset::from_name(name)
            .ok_or_else(|| errors::input(format!("there is no preset `{name}`: `paper` is the only one")))?;
        self.0.set_preset(preset);
        Ok(())
    }

    /// Takes a machine, written in TOML.
    fn machine(&mut self, text: &str) -> PyResult<()> {
        self.0.machine = Some(Description::from_toml(text).map_err(errors::input)?);
        Ok(())
    }

    /// Sets a parameter, or a quantity of the machine.
    fn set(&mut self, name: &str, value: f64) -> PyResult<()> {
        let coordinate = Coordinate::from_name(name).map_err(errors::input)?;
        coordinate.check(value).map_err(errors::input)?;
        coordinate.check_free(self.0.machine.is_some()).map_err(errors::input)?;
        self.0.set.insert(coordinate.name().to_owned(), value);
        Ok(())
    }

    /// Changes a setting; its value is written in JSON.
    fn setting(&mut self, name: &str, value: &str) -> PyResult<()> {
        let table = SETTINGS.iter().find(|(own, _)| *own == name).map(|(_, table)| *table);
        let table = table.ok_or_else(|| errors::input(format!("there is no setting `{name}`")))?;
        let value: Value = serde_json::from_str(value).map_err(errors::input)?;
        let refused = |error: serde_json::Error| errors::input(format!("the setting {name}: {error}"));
        match table {
            Table::Integration => self.0.integration = changed(&self.0.integration, name, value).map_err(refused)?,
            Table::Sampling => self.0.sampling = changed(&self.0.sampling, name, value).map_err(refused)?,
            Table::Device => self.0.device = changed(&self.0.device, name, value).map_err(refused)?,
        }
        Ok(())
    }

    /// Adds an axis. The first one varies fastest. Values that are bit for bit those of an even or logarithmic axis are kept as
    /// one.
    fn axis(&mut self, name: &str, values: PyReadonlyArray1<'_, f64>) -> PyResult<()> {
        let values: Vec<f64> = values.as_array().to_vec();
        let listed = Axis::listed(name, values).map_err(errors::input)?;
        self.add(spaced(listed));
        Ok(())
    }

    /// Adds an axis in the form of the program, such as `0:12:300`, `log:1e-3:1:20` or `1,2,5`.
    fn axis_text(&mut self, name: &str, text: &str) -> PyResult<()> {
        self.add(Axis::parse(&format!("{name}={text}")).map_err(errors::input)?);
        Ok(())
    }

    /// Asks for points: a row of values for each, with names for the columns.
    fn points(&mut self, names: Vec<String>, rows: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        let coordinates: Result<Vec<Coordinate>, _> = names.iter().map(|name| Coordinate::from_name(name)).collect();
        let coordinates = coordinates.map_err(errors::input)?;
        let rows = rows.as_array();
        let contiguous = rows.as_standard_layout();
        let values = contiguous.as_slice().unwrap_or_default();
        let rows: Vec<&[f64]> = values.chunks(coordinates.len().max(1)).collect();
        for coordinate in &coordinates {
            self.0.set.remove(coordinate.name());
        }
        self.0.points = Some(Points::new(coordinates, &rows).map_err(errors::input)?);
        Ok(())
    }

    /// The request in TOML, as the program reads it.
    fn toml(&self) -> String {
        self.0.to_toml()
    }

    /// What the user should know of the experiment before it is run.
    fn warnings(&self) -> PyResult<Vec<String>> {
        let experiment = if self.0.axes.is_some() || self.0.points.is_some() {
            self.experiment()
        } else {
            self.point()
        };
        let warnings = experiment.map_err(errors::input)?.warnings();
        Ok(warnings.iter().map(|text| errors::words(text)).collect())
    }
}

impl Request {
    /// What varies loses the value that it had, as by a preset.
    fn add(&mut self, axis: Axis) {
        self.0.set.remove(axis.coordinate.name());
        self.0.axes.get_or_insert_default().push(axis);
    }

    /// The experiment over the axes or points.
    pub fn experiment(&self) -> Result<Experiment, ExperimentError> {
        self.0.resolve()
    }

    /// The experiment at the one point that is set.
    pub fn point(&self) -> Result<Experiment, ExperimentError> {
        self.0.resolve_point()
    }
}

/// The names of all settings.
#[pyfunction]
pub fn settings() -> Vec<&'static str> {
    SETTINGS.iter().map(|(name, _)| *name).collect()
}

/// Checks that there is a parameter or a quantity of this name.
#[pyfunction]
pub fn check_name(name: &str) -> PyResult<()> {
    Coordinate::from_name(name).map(|_| ()).map_err(errors::input)
}

/// A table with another value of one of its settings.
fn changed<T>(table: &T, name: &str, value: Value) -> serde_json::Result<T>
where
    T: serde::Serialize + serde::de::DeserializeOwned,
{
    let mut written = serde_json::to_value(table)?;
    written[name] = value;
    serde_json::from_value(written)
}

/// The axis as an even or logarithmic one, if that has the same values; else as it is.
fn spaced(listed: Axis) -> Axis {
    let Spacing::Listed(values) = listed.spacing() else {
        return listed;
    };
    let (name, first, last, count) = (listed.coordinate, values[0], values[values.len() - 1], values.len());
    if count < 3 {
        return listed;
    }
    let candidates = [
        Axis::even(name, first, last, count),
        Axis::logarithmic(name, first, last, count),
    ];
    let same = candidates.into_iter().flatten().find(|axis| axis.values() == *values);
    same.unwrap_or(listed)
}

/// The device that an experiment asks for. In a forked process `auto` is the CPU.
///
/// # Errors
/// ValueError if the device cannot be had.
pub fn choose(py: Python<'_>, mut experiment: Experiment) -> PyResult<Vec<Backends>> {
    if pool::is_forked() {
        match experiment.device.backend {
            BackendChoice::Gpu => {
                return Err(errors::input(
                    "a process made by fork cannot use a GPU: make processes by spawn (multiprocessing.set_start_method(\"spawn\"))",
                ));
            }
            BackendChoice::Auto => experiment.device.backend = BackendChoice::Cpu,
            BackendChoice::Cpu => {}
        }
    }
    py.detach(|| choice::choose_all(&experiment))
        .map(|(backends, _)| backends)
        .map_err(|error| errors::backend(&error))
}

/// The device for a single analysis.
///
/// # Errors
/// As [`choose`].
pub fn choose_one(py: Python<'_>, experiment: Experiment) -> PyResult<Backends> {
    let mut backends = choose(py, experiment)?;
    Ok(backends.swap_remove(0))
}
