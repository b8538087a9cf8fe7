//! Runs: of a point into words, of a design into memory or a store.
//!
//! Owns the order of a run and what is kept when it is stopped.

use std::path::PathBuf;

use pyo3::exceptions::{PyOSError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Map, Value, json};
use tribochaos::Store;
use tribochaos::engine::{self, Cause, EngineError, Sink, Table};
use tribochaos::experiment::Experiment;
use tribochaos::measure::{Measurement, QUANTITIES, Quantity, Status, Values};
use tribochaos::store::Wanted;

use crate::request::{self, Request};
use crate::watch::{Watched, watch};
use crate::{dataset, errors};

/// Runs the design of a request, and returns the arrays of a dataset with `finished`, the share of its units that are computed,
/// `stopped`, the exception that stopped the run or None, and `note`, what was done to a store or None. What was finished before a
/// stop is there.
#[pyfunction]
#[pyo3(signature = (request, quantities, as_map, observer, store, force, alone))]
pub fn run<'py>(
    py: Python<'py>,
    request: &Request,
    quantities: Option<Vec<String>>,
    as_map: bool,
    observer: Option<&Bound<'py, PyAny>>,
    store: Option<PathBuf>,
    force: bool,
    alone: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let experiment = request.experiment().map_err(errors::input)?;
    let quantities = match quantities {
        Some(names) => named(&names)?,
        None if as_map => Quantity::of_map(&experiment),
        None => Quantity::of_scan(&experiment),
    };
    let mut backends = request::choose(py, experiment.clone())?;
    let unit = backends[0].points_per_unit(&experiment);
    let (ran, dataset, note) = if let Some(path) = store {
        let wanted = Wanted {
            experiment: &experiment,
            quantities: &quantities,
            unit,
            force,
            alone,
        };
        let opened = wanted.open(&path).map_err(|error| errors::store(&error))?;
        let mut store = opened.store;
        let ran = carried_out(py, &experiment, &mut backends, &mut store, observer)?;
        (ran, read(py, &store, &quantities)?, opened.note)
    } else {
        let mut table = Table::of(experiment.clone(), &quantities, unit);
        let ran = carried_out(py, &experiment, &mut backends, &mut table, observer)?;
        let results = table.into_results();
        let attributes = dataset::attributes(&results);
        (ran, dataset::of(py, results, attributes)?, None)
    };
    dataset.set_item("finished", ran.finished)?;
    dataset.set_item("stopped", ran.stopped_by)?;
    dataset.set_item("note", note.map(|note| errors::words(&note)))?;
    Ok(dataset)
}

/// How a run ended.
struct Ran {
    /// The share of the units that are finished.
    finished: f64,
    stopped_by: Option<PyErr>,
}

/// Runs all units of an experiment.
///
/// # Errors
/// If a backend or the sink fails.
fn carried_out(
    py: Python<'_>,
    experiment: &Experiment,
    backends: &mut [engine::Backends],
    sink: &mut (dyn Sink + Send),
    observer: Option<&Bound<'_, PyAny>>,
) -> PyResult<Ran> {
    let units: Vec<usize> = (0..sink.units()).collect();
    let work = engine::instance_periods(&experiment.settings, experiment.design.len());
    let watched = watch(py, observer, work, |progress| {
        engine::run_on(backends, experiment, sink, &units, &mut |event| progress.hear(&event))
    })?;
    let Watched { outcome, stopped_by } = watched;
    match outcome {
        // an exception may have come when all was done
        Ok(_) => Ok(Ran {
            finished: 1.0,
            stopped_by,
        }),
        Err(EngineError { cause, finished, units }) => match cause {
            Cause::Stopped => Ok(Ran {
                finished: finished as f64 / units as f64,
                stopped_by,
            }),
            Cause::Backend(error) => Err(errors::backend(&error)),
            cause => Err(PyOSError::new_err(errors::words(&cause.to_string()))),
        },
    }
}

/// Reads a store, and returns the arrays of a dataset; quantities that are not named are all that the store has.
#[pyfunction]
#[pyo3(signature = (path, quantities))]
pub fn open(py: Python<'_>, path: PathBuf, quantities: Option<Vec<String>>) -> PyResult<Bound<'_, PyDict>> {
    let store = Store::open(&path).map_err(|error| errors::store(&error))?;
    let held = store.quantities();
    let quantities = match quantities {
        Some(names) => named(&names)?,
        None => held.clone(),
    };
    if let Some(quantity) = quantities.iter().find(|quantity| !held.contains(quantity)) {
        let names: Vec<&str> = held.iter().map(|quantity| quantity.info().name).collect();
        return Err(errors::input(format!(
            "{} does not hold {}: it has {}",
            path.display(),
            quantity.info().name,
            names.join(", ")
        )));
    }
    read(py, &store, &quantities)
}

fn read<'py>(py: Python<'py>, store: &Store, quantities: &[Quantity]) -> PyResult<Bound<'py, PyDict>> {
    let results = py.detach(|| store.read_some(quantities));
    let results = results.map_err(|error| errors::store(&error))?;
    let attributes = store.attributes().clone();
    dataset::of(py, results, attributes)
}

/// The quantities with these names.
fn named(names: &[String]) -> PyResult<Vec<Quantity>> {
    let known = |name: &String| {
        let found = QUANTITIES.iter().find(|info| info.name == name);
        found.map(|info| info.quantity).ok_or_else(|| {
            let known: Vec<&str> = QUANTITIES.iter().map(|info| info.name).collect();
            errors::input(format!("there is no quantity `{name}`: there are {}", known.join(", ")))
        })
    };
    names.iter().map(known).collect()
}

/// Measures the one point of a request, and returns everything about it in JSON. Numbers that do not apply are null.
#[pyfunction]
#[pyo3(signature = (request, observer))]
pub fn point(py: Python<'_>, request: &Request, observer: Option<&Bound<'_, PyAny>>) -> PyResult<String> {
    let experiment = request.point().map_err(errors::input)?;
    let mut backends = request::choose_one(py, experiment.clone())?;
    let work = engine::instance_periods(&experiment.settings, 1);
    let measured = watch(py, observer, work, |progress| {
        backends.measure(&experiment.design, &experiment.settings, &[0], &mut |event| {
            progress.hear(&event)
        })
    })?;
    let measured = measured.whole()?.map_err(|error| errors::backend(&error))?;
    let measured = measured.ok_or_else(|| PyRuntimeError::new_err("nothing was measured"))?;
    Ok(object(&experiment, &measured[0]).to_string())
}

fn object(experiment: &Experiment, m: &Measurement) -> Value {
    let parameters: Map<String, Value> = experiment
        .fixed_parameters()
        .map(|(parameter, value)| (parameter.name().to_owned(), value.into()))
        .collect();
    let mut object = Map::new();
    for info in QUANTITIES {
        let value = info.quantity.of(m);
        let value = match info.values {
            _ if value.is_nan() => Value::Null,
            Values::F64 | Values::F32 => value.into(),
            Values::Code(names) => names[value as usize].into(),
        };
        object.insert(info.name.to_owned(), value);
    }
    if let Status::Runaway { time } = m.status {
        object.insert("runaway_time".to_owned(), time.into());
    }
    json!({
        "parameters": parameters,
        "settings": experiment.settings,
        "measured": object,
    })
}
