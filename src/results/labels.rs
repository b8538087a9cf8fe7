//! The labels of results as other readers see them, by the CF conventions: names of dimensions, coordinates, attributes.
//!
//! Owns what stores and datasets say of their arrays; writes nothing.

use serde_json::{Map, Value, json};

use super::{Column, NO_CODE};
use crate::design::{Axis, Coordinate, Design, Varied};
use crate::experiment::Experiment;
use crate::machine::Scale;
use crate::measure::{QUANTITIES, QuantityInfo, Values};

/// The dimension of a list of points.
pub const POINT: &str = "point";

/// Number of values along each dimension of a design, the fastest first: of each axis, or of a list of points.
pub fn sides(design: &Design) -> Vec<usize> {
    match &design.varied {
        Varied::Axes(axes) => axes.iter().map(Axis::count).collect(),
        Varied::Points(points) => vec![points.len()],
    }
}

/// Names of the dimensions, as arrays have them: the fastest last.
pub fn dimensions(design: &Design) -> Vec<&'static str> {
    match &design.varied {
        Varied::Axes(axes) => axes.iter().rev().map(|axis| axis.coordinate.name()).collect(),
        Varied::Points(_) => vec![POINT],
    }
}

/// A coordinate with its labels.
pub struct Labelled {
    /// What varies.
    pub coordinate: Coordinate,
    /// The dimension along which it does.
    pub dimension: &'static str,
    /// Its meaning, symbol and unit.
    pub attributes: Map<String, Value>,
    /// Its values.
    pub values: Vec<f64>,
}

/// The coordinates of a design.
pub fn coordinates(design: &Design) -> Vec<Labelled> {
    let labelled = |coordinate: Coordinate, dimension, values| {
        let mut attributes = Map::new();
        attributes.insert("long_name".into(), coordinate.meaning().into());
        attributes.insert("symbol".into(), coordinate.symbol().into());
        attributes.insert("units".into(), design.fixed.unit(coordinate).into());
        Labelled {
            coordinate,
            dimension,
            attributes,
            values,
        }
    };
    match &design.varied {
        Varied::Axes(axes) => axes
            .iter()
            .map(|axis| labelled(axis.coordinate, axis.coordinate.name(), axis.values()))
            .collect(),
        Varied::Points(points) => (points.coordinates().iter().enumerate())
            .map(|(column, &coordinate)| {
                let values = (0..points.len()).map(|index| points.row(index)[column]);
                labelled(coordinate, POINT, values.collect())
            })
            .collect(),
    }
}

/// The attributes of a quantity.
pub fn of_quantity(info: &QuantityInfo) -> Map<String, Value> {
    let mut attributes = Map::new();
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
    attributes
}

/// The scales by which the dimensionless results of a machine are multiplied to be in SI units; none without a machine.
pub fn scales(experiment: &Experiment) -> &'static [Scale] {
    if experiment.design.fixed.machine().is_some() {
        &Scale::ALL
    } else {
        &[]
    }
}

/// The attributes of a scale.
pub fn of_scale(scale: Scale) -> Map<String, Value> {
    let of: Vec<&str> = QUANTITIES
        .iter()
        .filter(|info| info.quantity.scale() == Some(scale))
        .map(|info| info.name)
        .collect();
    let mut attributes = Map::new();
    attributes.insert("long_name".into(), format!("scale of {}", of.join(", ")).into());
    attributes.insert("units".into(), scale.unit().into());
    attributes
}

/// A scale at some points.
pub fn scale_values(experiment: &Experiment, scale: Scale, points: impl Iterator<Item = usize>) -> Column {
    let machine = |index| experiment.design.machine(index);
    Column::F64(
        points
            .map(|index| machine(index).map_or(f64::NAN, |machine| machine.scales().of(scale)))
            .collect(),
    )
}
