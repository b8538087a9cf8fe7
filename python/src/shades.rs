//! The colours in which the program draws.
//!
//! Owns the map that stands for a table of values; the choice of colours is the library's.

use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use serde_json::json;
use tribochaos::design::Axis;
use tribochaos::map::ParameterMap;
use tribochaos::measure::{QUANTITIES, Quantity, Values};
use tribochaos::picture::colour::ColourScale;
use tribochaos::picture::{self, Style};

use crate::errors;

/// The colours of a quantity over two axes, as red, green, blue and opacity, and their meaning in JSON. `values`, `class_` and `status`
/// have a row for each y, and NaN where there is none.
#[pyfunction]
#[pyo3(signature = (quantity, values, class_, status, limits, colours))]
pub fn shades<'py>(
    py: Python<'py>,
    quantity: &str,
    values: PyReadonlyArray2<'py, f64>,
    class_: PyReadonlyArray2<'py, f64>,
    status: PyReadonlyArray2<'py, f64>,
    limits: Option<(f64, f64)>,
    colours: &str,
) -> PyResult<(Bound<'py, PyArray3<u8>>, String)> {
    let info = QUANTITIES.iter().find(|info| info.name == quantity);
    let info = info.ok_or_else(|| {
        errors::input(format!(
            "the program draws no `{quantity}`: draw it by xarray, ds[name].plot()"
        ))
    })?;
    let quantity = info.quantity;
    let &[rows, columns] = values.shape() else {
        unreachable!("an array of two dimensions")
    };
    for (name, quantity, codes) in [
        ("class", Quantity::Class, &class_),
        ("status", Quantity::Status, &status),
        (info.name, info.quantity, &values),
    ] {
        if codes.shape() != values.shape() {
            return Err(errors::input(format!("{name} does not have the shape of the map")));
        }
        if let Values::Code(names) = quantity.info().values
            && let Some(code) = codes.as_array().iter().find(|code| **code >= names.len() as f64)
        {
            return Err(errors::input(format!("{name} has no code {code}")));
        }
    }
    let axis = |name, count| Axis::even(name, 0.0, 1.0, count).map_err(errors::input);
    // what the axes are does not matter to colours
    let request = tribochaos::Request::over(vec![axis("zeta_k", columns)?, axis("h1", rows)?]);
    let mut map = ParameterMap::new(request.resolve().map_err(errors::input)?).map_err(errors::input)?;
    for (quantity, values) in [
        (Quantity::Status, &status),
        (Quantity::Class, &class_),
        (quantity, &values),
    ] {
        for (index, &value) in values.as_array().iter().enumerate() {
            map.set_value(quantity, index, value);
        }
    }
    let style = Style {
        limits,
        colours: scale(colours)?,
        border: false,
        ..Style::default()
    };
    let shades = picture::shades(&map, quantity, &style).map_err(errors::input)?;
    let pixels = shades
        .colours
        .iter()
        .flat_map(|colour| colour.map_or([0; 4], |[red, green, blue]| [red, green, blue, 255]));
    let pixels = PyArray1::from_iter(py, pixels).reshape([rows, columns, 4])?;
    let bar = shades.bar.map(|bar| {
        json!({
            "label": bar.label,
            "low": bar.low,
            "high": bar.high,
            "below": bar.below,
            "above": bar.above,
            "colours": bar.colours,
        })
    });
    let meaning = json!({ "heading": shades.heading, "legend": shades.legend, "bar": bar });
    Ok((pixels, meaning.to_string()))
}

/// The pair of scales with this name.
fn scale(name: &str) -> PyResult<ColourScale> {
    ColourScale::from_name(name).ok_or_else(|| {
        let names = ColourScale::ALL.map(ColourScale::name);
        errors::input(format!(
            "there are no colours `{name}`: there are {}",
            names.join(" and ")
        ))
    })
}

/// The colours of the sequential scale of this name, from low to high, as red, green and blue.
#[pyfunction]
pub fn ramp<'py>(py: Python<'py>, colours: &str, count: u32) -> PyResult<Bound<'py, PyArray2<u8>>> {
    let scale = scale(colours)?;
    let stops = f64::from(count.max(2) - 1);
    let pixels = (0..count).flat_map(|stop| scale.sequential(f64::from(stop) / stops));
    PyArray1::from_iter(py, pixels).reshape([count as usize, 3])
}
