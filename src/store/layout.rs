//! The arrays of a store: their names, types and fill values, with the labels of results.
//!
//! Owns what other readers see of an array; opens and writes nothing.

use std::sync::Arc;

use zarrs::array::codec::Crc32cCodec;
use zarrs::array::{ArrayBuilder, ArrayMetadataOptions, DataType, data_type};

use super::units::Units;
use crate::design::Design;
use crate::machine::Scale;
use crate::measure::{QuantityInfo, Values};
use crate::results::{NO_CODE, labels};

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

/// The coordinates of a design: the name of each, its array, and its values.
pub fn coordinates(design: &Design) -> Vec<(&'static str, ArrayBuilder, Vec<f64>)> {
    let coordinates = labels::coordinates(design).into_iter();
    let arrays = coordinates.map(|labelled| {
        let count = labelled.values.len() as u64;
        let mut array = array(vec![count], vec![count], Values::F64);
        array.dimension_names(Some([labelled.dimension]));
        array.attributes(labelled.attributes);
        (labelled.coordinate.name(), array, labelled.values)
    });
    arrays.collect()
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
    let mut array = array(
        slowest_first(&labels::sides(design)),
        slowest_first(units.block()),
        values,
    );
    array.dimension_names(Some(labels::dimensions(design)));
    array
}

/// The scale by which a dimensionless quantity is multiplied at each point to be one in SI units.
pub fn scale(scale: Scale, design: &Design, units: &Units) -> ArrayBuilder {
    let mut array = over(design, units, Values::F64);
    array.attributes(labels::of_scale(scale));
    array
}

/// A quantity.
pub fn variable(info: &QuantityInfo, design: &Design, units: &Units) -> ArrayBuilder {
    let mut array = over(design, units, info.values);
    array.attributes(labels::of_quantity(info));
    array
}
