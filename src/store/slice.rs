//! Maps out of a store of more dimensions: two axes stay, the others have one value each.
//!
//! Owns which points a cut has; reads only the units that hold some of them.

use std::collections::BTreeMap;

use super::error::StoreError;
use super::store::Store;
use crate::design::{Axis, Coordinate, Varied};
use crate::experiment::ExperimentError;
use crate::map::ParameterMap;
use crate::results::Results;

impl Store {
    /// The map over two of the store's axes, at one value of each other axis. Points that are not finished are not computed.
    ///
    /// # Errors
    /// If the store holds no product of axes, or not the axes, if an axis has no value or one that the store does not hold, and if the
    /// store cannot be read.
    #[expect(clippy::missing_panics_doc, reason = "the cut has two axes")]
    pub fn slice(&self, axes: [Coordinate; 2], at: &[(Coordinate, f64)]) -> Result<ParameterMap, SliceError> {
        let experiment = self.experiment();
        let Varied::Axes(all) = &experiment.design.varied else {
            return Err(SliceError::Points);
        };
        let place_of = |coordinate: Coordinate| {
            let place = all.iter().position(|axis| axis.coordinate == coordinate);
            place.ok_or_else(|| SliceError::NoAxis {
                name: coordinate.name(),
                axes: names(all),
            })
        };
        let kept = [place_of(axes[0])?, place_of(axes[1])?];
        if kept[0] == kept[1] {
            return Err(SliceError::OneAxis { name: axes[0].name() });
        }
        let mut fixed = BTreeMap::new();
        for &(coordinate, value) in at {
            let place = place_of(coordinate)?;
            if kept.contains(&place) {
                return Err(SliceError::Kept {
                    name: coordinate.name(),
                });
            }
            fixed.insert(place, index_of(&all[place], value)?);
        }
        let is_open = |place: &usize| !kept.contains(place) && !fixed.contains_key(place);
        if let Some(open) = (0..all.len()).find(is_open) {
            return Err(SliceError::Open {
                name: all[open].coordinate.name(),
            });
        }

        let mut request = experiment.request();
        request.axes = Some(kept.map(|place| all[place].clone()).to_vec());
        for (&place, &index) in &fixed {
            let axis = &all[place];
            request.set.insert(axis.coordinate.name().to_owned(), axis.value(index));
        }
        let mut results = Results::of(request.resolve()?, &self.quantities());
        let strides = experiment.design.strides();
        let base: usize = fixed.iter().map(|(&place, &index)| index * strides[place]).sum();
        let [columns, rows] = kept.map(|place| all[place].count());
        let mut by_unit: BTreeMap<usize, Vec<(usize, usize)>> = BTreeMap::new();
        for row in 0..rows {
            for column in 0..columns {
                let index = base + column * strides[kept[0]] + row * strides[kept[1]];
                let places = by_unit.entry(self.units.of_point(index)).or_default();
                places.push((index, row * columns + column));
            }
        }
        for (unit, places) in by_unit {
            let first = self.units.points(unit).start;
            for (quantity, values) in self.read_unit(unit)?.into_iter().flatten() {
                for &(index, here) in &places {
                    results.set_value(quantity, here, values.value(index - first));
                }
            }
        }
        Ok(ParameterMap::try_from(results).expect("it has two axes"))
    }
}

/// The index of a value of an axis.
fn index_of(axis: &Axis, value: f64) -> Result<usize, SliceError> {
    let distance = |index: usize| (axis.value(index) - value).abs();
    let nearest = (0..axis.count()).min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
    let nearest = nearest.unwrap_or(0);
    let [least, greatest] = axis.ends();
    if distance(nearest) <= 1e-9 * (greatest - least) {
        return Ok(nearest);
    }
    Err(SliceError::NoValue {
        name: axis.coordinate.name(),
        value,
        nearest: axis.value(nearest),
    })
}

fn names(axes: &[Axis]) -> String {
    let names: Vec<&str> = axes.iter().map(|axis| axis.coordinate.name()).collect();
    names.join(", ")
}

/// Why there is no such cut.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages tell what each is")]
pub enum SliceError {
    #[error("the store holds a list of points, which has no axes to cut along: export it as a table")]
    Points,
    #[error("{name} is no axis of the store: its axes are {axes}")]
    NoAxis { name: &'static str, axes: String },
    #[error("both axes are {name}: give two different ones")]
    OneAxis { name: &'static str },
    #[error("{name} is an axis of the cut and has a value as well: leave one of the two out")]
    Kept { name: &'static str },
    #[error("the axis {name} has no value: add --at {name}=VALUE")]
    Open { name: &'static str },
    #[error("the store has no {name} = {value}: the nearest value is {nearest}")]
    NoValue {
        name: &'static str,
        value: f64,
        nearest: f64,
    },
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
    #[error(transparent)]
    Store(#[from] StoreError),
}
