//! What there is: parameters, quantities, classes, devices, machines.
//!
//! Owns their form in JSON.

use pyo3::prelude::*;
use serde_json::{Map, Value, json};
use tribochaos::backend::cpu::{self, InstructionSet};
use tribochaos::backend::gpu::adapters;
use tribochaos::machine::{Description, Machine, TEMPLATE};
use tribochaos::measure::{Class, QUANTITIES};
use tribochaos::output::PROGRAM;
use tribochaos::parameters::PARAMETERS;
use tribochaos::results::labels;

use crate::request::{self, Request};
use crate::{errors, pool};

/// The name of the program and its version.
#[pyfunction]
pub fn program() -> &'static str {
    PROGRAM
}

/// The table of parameters, in JSON.
#[pyfunction]
pub fn parameters() -> String {
    let rows = PARAMETERS.iter().map(|info| {
        let [low, high] = [info.range.0, info.range.1].map(finite);
        let row = json!({
            "symbol": info.symbol,
            "default": finite(info.default),
            "low": low,
            "high": high,
            "source": info.source,
            "meaning": info.meaning,
        });
        (info.name.to_owned(), row)
    });
    Value::Object(rows.collect()).to_string()
}

/// Infinity as a text, since JSON has none.
fn finite(value: f64) -> Value {
    if value.is_finite() {
        value.into()
    } else {
        value.to_string().into()
    }
}

/// The table of quantities with their attributes, in JSON.
#[pyfunction]
pub fn quantities() -> String {
    let rows = QUANTITIES
        .iter()
        .map(|info| (info.name.to_owned(), Value::Object(labels::of_quantity(info))));
    Value::Object(rows.collect()).to_string()
}

/// The names of the classes, in the order of their codes.
#[pyfunction]
pub fn classes() -> Vec<&'static str> {
    Class::ALL.iter().map(|class| class.name()).collect()
}

/// The devices of this machine, in JSON.
#[pyfunction]
pub fn devices(py: Python<'_>) -> PyResult<String> {
    let sets = InstructionSet::available().into_iter().map(InstructionSet::name);
    let adapters = py.detach(|| if pool::is_forked() { Vec::new() } else { adapters() });
    let experiment = tribochaos::Request::default().resolve().map_err(errors::input)?;
    let auto = request::choose_one(py, experiment)?.active().device();
    Ok(json!({
        "cpu": cpu::threads(),
        "instruction_sets": sets.collect::<Vec<_>>(),
        "adapters": adapters.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "auto": auto,
    })
    .to_string())
}

/// A complete file of a machine.
#[pyfunction]
pub fn machine_template() -> &'static str {
    TEMPLATE
}

/// A machine that is written in TOML: its quantities, the parameters that follow, and what is not plausible, in JSON.
#[pyfunction]
pub fn machine(text: &str) -> PyResult<String> {
    let description = Description::from_toml(text).map_err(errors::input)?;
    let mut request = Request::default();
    request.0.machine = Some(description);
    let experiment = request.point().map_err(errors::input)?;
    let fixed = &experiment.design.fixed;
    let machine = fixed.machine().expect("the request has one");
    let quantities: Map<String, Value> = machine
        .quantities()
        .map(|quantity| {
            let value = json!({ "value": machine.value(quantity), "units": machine.unit(quantity) });
            (quantity.name().to_owned(), value)
        })
        .collect();
    let parameters: Map<String, Value> = experiment
        .fixed_parameters()
        .map(|(parameter, value)| (parameter.name().to_owned(), finite(value)))
        .collect();
    Ok(json!({
        "quantities": quantities,
        "parameters": parameters,
        "scales": scales(machine),
        "warnings": experiment.machine_warnings(),
    })
    .to_string())
}

/// What dimensionless numbers are multiplied by to be in SI units.
pub fn scales(machine: &Machine) -> Value {
    let scales = machine.scales();
    json!({
        "time": scales.time,
        "speed": scales.speed,
        "pressure": scales.pressure,
        "length": scales.length,
        "temperature": scales.temperature,
    })
}
