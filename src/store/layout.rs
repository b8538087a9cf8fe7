//! The arrays of a store: their names, types, fill values and attributes, by the CF conventions.
//!
//! Owns what other readers see of an array; opens and writes nothing.

use std::sync::Arc;

use serde_json::json;
use zarrs::array::codec::Crc32cCodec;
use zarrs::array::{ArrayBuilder, ArrayMetadataOptions, DataType, data_type};

use super::units::Units;
use crate::design::{Axis, Coordinate, Design, Varied};
use crate::machine::Scale;
use crate::measure::{QUANTITIES, QuantityInfo, Values};
use crate::results::NO_CODE;

/// The dimension of a list of points.
const POINT: &str = "point";

/// The type of a quantity's values.
pub fn data_type(values: Values) -> DataType {
    match values {
        Values::F64 => data_type::float64(),
        Values::F32 => data_type::float32(),
        Values::Code(_) => data_type::uint8(),
    }
}

/// The name of an array as a node of the store.
pub fn node(name: &str) -> String {
    format!("/{name}")
}

/// Without the note on zarrs itself, which other readers do not need.
pub fn plain_metadata() -> ArrayMetadataOptions {
    ArrayMetadataOptions::default().with_include_zarrs_metadata(false)
}

/// Number of values along each dimension of a design, the fastest first: of each axis, or of a list of points.
pub fn sides(design: &Design) -> Vec<usize> {
    match &design.varied {
        Varied::Axes(axes) => axes.iter().map(Axis::count).collect(),
        Varied::Points(points) => vec![points.len()],
    }
}

/// Names of the dimensions, as arrays have them: the fastest last.
fn dimensions(design: &Design) -> Vec<&'static str> {
    match &design.varied {
        Varied::Axes(axes) => axes.iter().rev().map(|axis| axis.coordinate.name()).collect(),
        Varied::Points(_) => vec![POINT],
    }
}

/// The coordinates of a design: the array of each, and its values.
pub fn coordinates(design: &Design) -> Vec<(Coordinate, ArrayBuilder, Vec<f64>)> {
    let array = |coordinate: Coordinate, dimension: &'static str, values: Vec<f64>| {
        let count = values.len() as u64;
        let mut array = array(vec![count], vec![count], Values::F64);
        array.dimension_names(Some([dimension]));
        let attributes = array.attributes_mut();
        attributes.insert("long_name".into(), coordinate.meaning().into());
        attributes.insert("symbol".into(), coordinate.symbol().into());
        attributes.insert("units".into(), design.fixed.unit(coordinate).into());
        (coordinate, array, values)
    };
    match &design.varied {
        Varied::Axes(axes) => axes
            .iter()
            .map(|axis| array(axis.coordinate, axis.coordinate.name(), axis.values()))
            .collect(),
        Varied::Points(points) => (points.coordinates().iter().enumerate())
            .map(|(column, &coordinate)| {
                let values = (0..points.len()).map(|index| points.row(index)[column]);
                array(coordinate, POINT, values.collect())
            })
            .collect(),
    }
}

/// An array of which nothing is computed, with a checksum on every chunk.
fn array(shape: Vec<u64>, chunk: Vec<u64>, values: Values) -> ArrayBuilder {
    let mut array = match values {
        Values::F64 => ArrayBuilder::new(shape, chunk, data_type(values), f64::NAN),
        Values::F32 => ArrayBuilder::new(shape, chunk, data_type(values), f32::NAN),
        Values::Code(_) => ArrayBuilder::new(shape, chunk, data_type(values), NO_CODE),
    };
    array.bytes_to_bytes_codecs(vec![Arc::new(Crc32cCodec::new())]);
    array
}

/// An array over a design, in chunks of a unit each.
fn over(design: &Design, units: &Units, values: Values) -> ArrayBuilder {
    let slowest_first = |counts: &[usize]| counts.iter().rev().map(|&count| count as u64).collect();
    let mut array = array(slowest_first(&sides(design)), slowest_first(units.block()), values);
    array.dimension_names(Some(dimensions(design)));
    array
}

/// The scale by which a dimensionless quantity is multiplied at each point to be one in SI units.
pub fn scale(scale: Scale, design: &Design, units: &Units) -> ArrayBuilder {
    let mut array = over(design, units, Values::F64);
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

/// A quantity.
pub fn variable(info: &QuantityInfo, design: &Design, units: &Units) -> ArrayBuilder {
    let mut array = over(design, units, info.values);
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
