//! Analyses of points and lines.
//!
//! Owns the shape of their arrays; the analyses are the library's.

use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Value, json};
use tribochaos::analysis::bifurcation as diagrams;
use tribochaos::analysis::bifurcation::Columns;
use tribochaos::analysis::melnikov::{SEARCH_VALUES, default_search};
use tribochaos::analysis::onset as onsets;
use tribochaos::analysis::onset::{Definition, Scan};
use tribochaos::analysis::path::ended;
use tribochaos::analysis::{follow, section as sections};
use tribochaos::design::{Axis, Coordinate};
use tribochaos::engine::{self, initial_states};
use tribochaos::experiment::Experiment;
use tribochaos::measure::Status;
use tribochaos::model::melnikov::{Melnikov, Threshold, threshold};
use tribochaos::parameters::Parameter;
use tribochaos::results::labels;

use crate::request::{self, Request};
use crate::watch::watch;
use crate::{errors, tables};

/// Follows the point of a request over time, `samples` times in each of `periods`. Returns an array for each column, and how it ended
/// in JSON.
#[pyfunction]
pub fn trajectory<'py>(
    py: Python<'py>,
    request: &Request,
    periods: u32,
    samples: u32,
) -> PyResult<(Bound<'py, PyDict>, String)> {
    let experiment = request.point().map_err(errors::input)?;
    let at = experiment.design.fixed;
    let run = watch(py, None, 1, |progress| {
        let integration = &experiment.settings.integration;
        follow(at.parameters(), integration, 0..periods, samples, &mut || {
            progress.add(0)
        })
    })?;
    let run = run
        .whole()?
        .ok_or_else(|| PyRuntimeError::new_err("nothing was computed"))?;
    let columns = PyDict::new(py);
    let column = |name: &str, of: &dyn Fn(&tribochaos::analysis::Sample) -> f64| {
        let values: Vec<f64> = run.samples.iter().map(of).collect();
        columns.set_item(name, PyArray1::from_vec(py, values))
    };
    column("tau", &|sample| sample.tau)?;
    column("x", &|sample| sample.x)?;
    column("y", &|sample| sample.y)?;
    column("v", &|sample| sample.v)?;
    column("p", &|sample| sample.pressure)?;
    column("u_w", &|sample| sample.wear)?;
    column("theta", &|sample| sample.temperature)?;
    let (status, runaway_time) = match ended(&run) {
        Status::Runaway { time } => ("runaway", Some(time)),
        Status::UnderResolved => ("under_resolved", None),
        Status::Ok => ("ok", None),
    };
    let end = json!({
        "status": status,
        "runaway_time": runaway_time,
        "contact_time": run.contact_lost,
        "peak_pressure": run.peak_pressure,
        "peak_pressure_time": run.peak_pressure_time,
        "peak_temperature": run.peak_temperature,
        "scales": at.machine().map(tables::scales),
    });
    Ok((columns, end.to_string()))
}

/// The initial states of an analysis: those given, or (x0, y0) with others from the box if several are asked for.
///
/// # Errors
/// ValueError if none is given, or one is out of range.
fn starts(experiment: &Experiment, given: Option<Vec<[f64; 2]>>) -> PyResult<Vec<[f64; 2]>> {
    let Some(given) = given else {
        let first = experiment.design.fixed.parameters().initial_state();
        let others = initial_states::offsets(&experiment.settings.sampling);
        return Ok([first].into_iter().chain(others).collect());
    };
    if given.is_empty() {
        return Err(errors::input("there are no initial states: give at least one (x, y)"));
    }
    for &[x, y] in &given {
        Parameter::X0.check(x).map_err(errors::input)?;
        Parameter::Y0.check(y).map_err(errors::input)?;
    }
    Ok(given)
}

/// At least so many stroboscopic states of the point of a request, from some orbits at once. Returns x, y, the number of orbits that
/// ran away or were given up, and the number of orbits.
#[pyfunction]
#[pyo3(signature = (request, points, observer))]
pub fn section<'py>(
    py: Python<'py>,
    request: &mut Request,
    points: u64,
    observer: Option<&Bound<'py, PyAny>>,
) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, usize, u32)> {
    let plan = sections::Plan::new(points);
    request.0.sampling.periods = plan.measured_periods();
    let experiment = request.point().map_err(errors::input)?;
    experiment.check_lasting().map_err(errors::input)?;
    let settings = experiment.settings;
    let at = *experiment.design.fixed.parameters();
    let mut backends = request::choose_one(py, experiment)?;
    let periods = settings.sampling.transient_periods + settings.sampling.periods;
    let work = u64::from(plan.orbits) * u64::from(periods);
    let section = watch(py, observer, work, |progress| {
        sections::section(backends.active_mut(), &settings, &at, plan.orbits, &mut |periods| {
            progress.add(periods)
        })
    })?;
    let section = section.whole()?.map_err(|error| errors::backend(&error))?;
    let mut section = section.ok_or_else(|| PyRuntimeError::new_err("nothing was computed"))?;
    section.points.truncate(usize::try_from(points).unwrap_or(usize::MAX));
    let column = |index: usize| PyArray1::from_iter(py, section.points.iter().map(|state| state[index]));
    Ok((column(0), column(1), section.runaways, plan.orbits))
}

/// The bifurcation diagram over the axis of a request. Returns the values of the axis, its attributes in JSON, x and y as tables with a
/// row for each value, padded with NaN, and the number of orbits that ran away or were given up.
#[pyfunction]
#[pyo3(signature = (request, starts, follow, observer))]
pub fn bifurcation<'py>(
    py: Python<'py>,
    request: &Request,
    starts: Option<Vec<[f64; 2]>>,
    follow: Option<&str>,
    observer: Option<&Bound<'py, PyAny>>,
) -> PyResult<(
    Bound<'py, PyArray1<f64>>,
    String,
    Bound<'py, PyAny>,
    Bound<'py, PyAny>,
    usize,
)> {
    let experiment = request.experiment().map_err(errors::input)?;
    experiment.check_lasting().map_err(errors::input)?;
    experiment.check_start_fixed().map_err(errors::input)?;
    let columns = match follow {
        None => Columns::Fresh,
        Some("up") => Columns::FollowUp,
        Some("down") => Columns::FollowDown,
        Some(other) => {
            return Err(errors::input(format!("`{other}` is no direction: up and down are")));
        }
    };
    let axis = only_axis(&experiment)?;
    let attributes = labels::coordinates(&experiment.design).swap_remove(0).attributes;
    let starts = self::starts(&experiment, starts)?;
    diagrams::check(&experiment, columns, starts.len()).map_err(errors::input)?;
    let (settings, fixed) = (experiment.settings, experiment.design.fixed);
    let mut backends = request::choose_one(py, experiment)?;
    let periods = u64::from(settings.sampling.transient_periods + settings.sampling.periods);
    let work = (axis.count() * starts.len()) as u64 * periods;
    let found = watch(py, observer, work, |progress| {
        diagrams::diagram(
            backends.active_mut(),
            &settings,
            &fixed,
            &axis,
            &starts,
            columns,
            &mut |periods| progress.add(periods),
        )
    })?;
    let found = found.whole()?.map_err(|error| errors::backend(&error))?;
    let found = found.ok_or_else(|| PyRuntimeError::new_err("nothing was computed"))?;
    let most = found.columns.iter().map(Vec::len).max().unwrap_or(0);
    let table = |index: usize| -> PyResult<Bound<'py, PyAny>> {
        let padded = found.columns.iter().flat_map(|column| {
            let states = column.iter().map(move |state| state[index]);
            states.chain(std::iter::repeat(f64::NAN)).take(most)
        });
        let values = PyArray1::from_vec(py, padded.collect());
        Ok(values.reshape([found.columns.len(), most])?.into_any())
    };
    Ok((
        PyArray1::from_vec(py, axis.values()),
        Value::Object(attributes).to_string(),
        table(0)?,
        table(1)?,
        found.runaways,
    ))
}

/// The axis of an experiment with one.
fn only_axis(experiment: &Experiment) -> PyResult<Axis> {
    match experiment.design.axes() {
        [axis] => Ok(axis.clone()),
        axes => Err(errors::input(format!(
            "one axis is needed, and there are {}",
            axes.len()
        ))),
    }
}

/// Onset and end of chaos over the axis of a request, in JSON. Without `starts`, the initial states are the request's if `is_chosen`, and
/// else those that the library tries.
#[pyfunction]
#[pyo3(signature = (request, starts, is_chosen, spacing, observer))]
pub fn onset(
    py: Python<'_>,
    request: &Request,
    starts: Option<Vec<[f64; 2]>>,
    is_chosen: bool,
    spacing: Option<f64>,
    observer: Option<&Bound<'_, PyAny>>,
) -> PyResult<String> {
    let experiment = request.experiment().map_err(errors::input)?;
    experiment.check_lasting().map_err(errors::input)?;
    experiment.check_start_fixed().map_err(errors::input)?;
    let axis = only_axis(&experiment)?;
    let by_default = || (!is_chosen).then(|| onsets::STARTS.to_vec());
    let starts = self::starts(&experiment, starts.or_else(by_default))?;
    let spacing = onsets::checked_spacing(&axis, spacing).map_err(errors::input)?;
    let (settings, at) = (experiment.settings, experiment.design.fixed);
    let definition = Definition::new(&settings);
    let scan = Scan {
        definition: &definition,
        at: &at,
        axis: onsets::fine_axis(&axis, spacing),
        starts: &starts,
    };
    onsets::check_grid(&at, &scan.axis).map_err(errors::input)?;
    let mut backends = request::choose_one(py, experiment)?;
    let work = engine::instance_periods(&definition.settings, scan.axis.count() * starts.len());
    let bounds = watch(py, observer, work, |progress| {
        scan.bounds(&mut backends, &mut |event| progress.hear(&event))
    })?;
    let bounds = bounds.whole()?.map_err(|error| errors::backend(&error))?;
    let bounds = bounds.ok_or_else(|| PyRuntimeError::new_err("nothing was computed"))?;
    let [first, last] = bounds.map(|bound| words(&bound));
    Ok(json!({
        "coordinate": axis.coordinate.name(),
        "units": at.unit(axis.coordinate),
        "spacing": spacing,
        "confirming_periods": onsets::CONFIRMING_PERIODS,
        "onset": first,
        "end": last,
    })
    .to_string())
}

fn words(bound: &onsets::Bound) -> Value {
    let found = bound.scanned.found.map(|found| {
        json!({
            "value": found.value,
            "initial_state": found.start,
            "lyapunov": found.exponent,
            "lyapunov_error": found.error,
            "confirmed": found.again.lyapunov,
            "confirmed_error": found.again.lyapunov_error,
        })
    });
    json!({
        "found": found,
        "is_beyond": bound.is_beyond,
        "passed": bound.scanned.passed,
        "unmeasured": bound.scanned.unmeasured,
    })
}

/// Mel'nikov's function of the point of a request: its arguments tau_0 over a period, its values there, and its extremes in JSON.
#[pyfunction]
pub fn melnikov<'py>(
    py: Python<'py>,
    request: &Request,
    samples: u32,
) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, String)> {
    let point = request.point().map_err(errors::input)?;
    let function = Melnikov::new(point.design.fixed.parameters()).map_err(errors::input)?;
    let extremes = function.extremes();
    let evaluated = watch(py, None, 1, |progress| {
        let tau_0 = (0..samples).map(|index| function.period() * f64::from(index) / f64::from(samples));
        let going_on = tau_0.take_while(|_| progress.add(0).is_continue());
        going_on.map(|tau_0| (tau_0, function.closed_form(tau_0))).unzip()
    })?;
    let (tau_0, values): (Vec<f64>, Vec<f64>) = evaluated.whole()?;
    let rest = json!({
        "minimum": extremes.minimum,
        "minimum_at": extremes.minimum_at,
        "maximum": extremes.maximum,
        "maximum_at": extremes.maximum_at,
        "changes_sign": extremes.change_sign(),
    });
    Ok((
        PyArray1::from_vec(py, tau_0),
        PyArray1::from_vec(py, values),
        rest.to_string(),
    ))
}

/// Where Mel'nikov's function begins or ceases to change sign along a parameter, `within` a range or the one that the library searches:
/// which of `begins`, `ceases`, `always` and `never`, and the value.
#[pyfunction]
#[pyo3(signature = (request, along, within))]
pub fn melnikov_threshold(
    py: Python<'_>,
    request: &Request,
    along: &str,
    within: Option<(f64, f64)>,
) -> PyResult<(&'static str, Option<f64>)> {
    let at = request.point().map_err(errors::input)?.design.fixed;
    let axis = if let Some((low, high)) = within {
        Axis::even(along, low, high, SEARCH_VALUES).map_err(errors::input)?
    } else {
        let coordinate = Coordinate::from_name(along).map_err(errors::input)?;
        default_search(&at, coordinate).ok_or_else(|| {
            errors::input(format!(
                "the search along {along} needs a range: give within=(low, high)"
            ))
        })?
    };
    let found = py.detach(|| threshold(&at, &axis));
    Ok(match found.map_err(errors::input)? {
        Threshold::Begins(value) => ("begins", Some(value)),
        Threshold::Ceases(value) => ("ceases", Some(value)),
        Threshold::Always => ("always", None),
        Threshold::Never => ("never", None),
    })
}
