//! Results as arrays with labels: what an xarray Dataset is made of.
//!
//! Owns the layout, which is that of a store as xarray opens it.

use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use serde_json::{Map, Value};
use tribochaos::output::PROGRAM;
use tribochaos::results::{Column, Results, labels};

/// The arrays of a dataset: `dims` with `shape`; `coords` and `variables`, each a map from a name to its dimensions, its values
/// and its attributes in JSON; and `attrs`, in JSON.
pub fn of(py: Python<'_>, mut results: Results, attributes: Map<String, Value>) -> PyResult<Bound<'_, PyDict>> {
    let design = results.experiment.design.clone();
    let dims = PyList::new(py, labels::dimensions(&design))?;
    let shape: Vec<usize> = labels::sides(&design).into_iter().rev().collect();
    let (coords, variables) = (PyDict::new(py), PyDict::new(py));
    for labels in labels::coordinates(&design) {
        let dims = PyList::new(py, [labels.dimension])?;
        let values = PyArray1::from_vec(py, labels.values).into_any();
        coords.set_item(
            labels.coordinate.name(),
            labelled(py, &dims, values, labels.attributes)?,
        )?;
    }
    for quantity in results.quantities() {
        let info = quantity.info();
        let column = results.take(quantity).expect("the results hold it");
        let values = array(py, column, &shape)?;
        variables.set_item(info.name, labelled(py, &dims, values, labels::of_quantity(info))?)?;
    }
    for &scale in labels::scales(&results.experiment) {
        let column = labels::scale_values(&results.experiment, scale, 0..design.len());
        let values = array(py, column, &shape)?;
        variables.set_item(scale.name(), labelled(py, &dims, values, labels::of_scale(scale))?)?;
    }
    let dataset = PyDict::new(py);
    dataset.set_item("coords", coords)?;
    dataset.set_item("variables", variables)?;
    dataset.set_item("attrs", Value::Object(attributes).to_string())?;
    Ok(dataset)
}

/// The attributes of results that are in no store.
pub fn attributes(results: &Results) -> Map<String, Value> {
    let mut attributes = Map::new();
    attributes.insert("program".into(), PROGRAM.into());
    attributes.insert("experiment".into(), results.experiment.outline().into());
    attributes
}

/// A column as an array of this shape; its memory passes to numpy.
fn array<'py>(py: Python<'py>, column: Column, shape: &[usize]) -> PyResult<Bound<'py, PyAny>> {
    Ok(match column {
        Column::F64(values) => PyArray1::from_vec(py, values).reshape(shape)?.into_any(),
        Column::F32(values) => PyArray1::from_vec(py, values).reshape(shape)?.into_any(),
        Column::Code(codes) => PyArray1::from_vec(py, codes).reshape(shape)?.into_any(),
    })
}

/// An array with its dimensions, and its attributes in JSON.
fn labelled<'py>(
    py: Python<'py>,
    dims: &Bound<'py, PyList>,
    values: Bound<'py, PyAny>,
    attributes: Map<String, Value>,
) -> PyResult<Bound<'py, PyAny>> {
    let text = Value::Object(attributes).to_string();
    (dims, values, text).into_pyobject(py).map(Bound::into_any)
}
