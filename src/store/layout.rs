//! The arrays of a store: their names, types, fill values and attributes, by the CF conventions.
//!
//! Owns what other readers see of an array; opens and writes nothing.

use serde_json::json;
use zarrs::array::{ArrayBuilder, ArrayMetadataOptions, DataType, data_type};

use crate::design::{Axis, Fixed};
use crate::experiment::Experiment;
use crate::machine::Scale;
use crate::measure::{QUANTITIES, QuantityInfo, Values};

/// Marks a group as a map.
pub const FORMAT: &str = "tribochaos map";
pub const FORMAT_VERSION: u64 = 1;

/// A code's fill value: not computed, or not applicable.
pub const NO_CODE: u8 = u8::MAX;

pub fn data_type(values: Values) -> DataType {
    match values {
        Values::Number => data_type::float64(),
        Values::Code(_) => data_type::uint8(),
    }
}

pub fn node(name: &str) -> String {
    format!("/{name}")
}

/// Without the note on zarrs itself, which other readers need not know.
pub fn plain_metadata() -> ArrayMetadataOptions {
    ArrayMetadataOptions::default().with_include_zarrs_metadata(false)
}

pub fn coordinate(axis: &Axis, fixed: &Fixed) -> ArrayBuilder {
    let coordinate = axis.coordinate;
    let count = axis.count() as u64;
    let mut array = ArrayBuilder::new(vec![count], vec![count], data_type(Values::Number), f64::NAN);
    array.dimension_names(Some([coordinate.name()]));
    let attributes = array.attributes_mut();
    attributes.insert("long_name".into(), coordinate.meaning().into());
    attributes.insert("symbol".into(), coordinate.symbol().into());
    attributes.insert("units".into(), fixed.unit(coordinate).into());
    array
}

/// What a dimensionless quantity is multiplied with at each point to be one in SI units.
pub fn scale(scale: Scale, x: &Axis, y: &Axis, tile: [usize; 2]) -> ArrayBuilder {
    let shape = vec![y.count() as u64, x.count() as u64];
    let chunk = tile.map(|count| count as u64).to_vec();
    let mut array = ArrayBuilder::new(shape, chunk, data_type(Values::Number), f64::NAN);
    array.dimension_names(Some([y.coordinate.name(), x.coordinate.name()]));
    let of: Vec<&str> = QUANTITIES
        .iter()
        .filter(|info| info.quantity.scale() == Some(scale))
        .map(|info| info.name)
        .collect();
    let attributes = array.attributes_mut();
    attributes.insert("long_name".into(), format!("scale of {}", of.join(", ")).into());
    attributes.insert("units".into(), scale.unit().into());
    array
}

pub fn variable(info: &QuantityInfo, x: &Axis, y: &Axis, tile: [usize; 2]) -> ArrayBuilder {
    let shape = vec![y.count() as u64, x.count() as u64];
    let chunk = tile.map(|count| count as u64).to_vec();
    let mut array = match info.values {
        Values::Number => ArrayBuilder::new(shape, chunk, data_type(info.values), f64::NAN),
        Values::Code(_) => ArrayBuilder::new(shape, chunk, data_type(info.values), NO_CODE),
    };
    array.dimension_names(Some([y.coordinate.name(), x.coordinate.name()]));
    let attributes = array.attributes_mut();
    attributes.insert("long_name".into(), info.label.into());
    attributes.insert("units".into(), info.units.into());
    if let Values::Code(names) = info.values {
        attributes.insert("flag_values".into(), json!((0..names.len()).collect::<Vec<_>>()));
        attributes.insert("flag_meanings".into(), names.join(" ").into());
        attributes.insert(
            "comment".into(),
            format!("{NO_CODE}: not computed, or not applicable").into(),
        );
    }
    array
}

/// The two axes of a map.
///
/// # Panics
/// If the experiment has not two axes.
pub fn axes(experiment: &Experiment) -> [&Axis; 2] {
    let [x, y] = experiment.design.axes() else {
        panic!("a map has two axes")
    };
    [x, y]
}
