//! The scales of a machine in a store: what leads from its dimensionless values to SI units, point by point.
//!
//! Owns which scales a store has. Their arrays are for other readers: this program computes them.

use crate::experiment::Experiment;
use crate::machine::Scale;
use crate::results::Column;

/// The scales that the store of an experiment has; none without a machine.
pub fn of(experiment: &Experiment) -> &'static [Scale] {
    if experiment.design.fixed.machine().is_some() {
        &Scale::ALL
    } else {
        &[]
    }
}

/// A scale at some points.
pub fn values(experiment: &Experiment, scale: Scale, points: impl Iterator<Item = usize>) -> Column {
    let machine = |index| experiment.design.machine(index);
    Column::F64(
        points
            .map(|index| machine(index).map_or(f64::NAN, |machine| machine.scales().of(scale)))
            .collect(),
    )
}
