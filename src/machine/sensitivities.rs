//! How the dimensionless groups and the scales move with each quantity.
//!
//! Owns the table; the derivatives come exactly from dual numbers through the formulas themselves.

use super::dual::Dual;
use super::groups::{self, Groups};
use super::{Machine, SiQuantity};
use crate::parameters::Parameter;

/// Logarithmic sensitivities d ln(group)/d ln(quantity): by how many per cent a group moves for one per cent of a quantity.
#[derive(Clone, Debug)]
pub struct Sensitivities {
    /// Rows, in the table's order.
    pub quantities: Vec<SiQuantity>,
    /// Columns: symbols of the parameters that the machine determines, of k* and of the scales t*, T*, P*, V*; with their
    /// values.
    pub groups: Vec<(&'static str, f64)>,
    /// By row and column; NaN where the group is 0, 0 where the quantity is.
    pub values: Vec<Vec<f64>>,
}

fn dual_groups(machine: &Machine) -> Groups<Dual> {
    groups::groups(|quantity| Dual::variable(quantity, machine.value(quantity)))
}

/// d(parameter)/d(quantity); 0 for a parameter that no machine determines.
pub(super) fn slope(machine: &Machine, quantity: SiQuantity, parameter: Parameter) -> f64 {
    let groups = dual_groups(machine);
    let group = groups.parameters.iter().find(|(name, _)| *name == parameter);
    group.map_or(0.0, |(_, dual)| dual.slopes[quantity as usize])
}

/// The table for a machine.
pub fn sensitivities(machine: &Machine) -> Sensitivities {
    let groups = dual_groups(machine);
    let scales = [
        ("k*", groups.spring),
        ("t*", groups.time),
        ("T*", groups.temperature),
        ("P*", groups.pressure),
        ("V*", groups.speed),
    ];
    let columns: Vec<(&'static str, Dual)> = groups
        .parameters
        .iter()
        .map(|(parameter, dual)| (parameter.info().symbol, *dual))
        .chain(scales)
        .collect();
    let quantities: Vec<SiQuantity> = machine.quantities().collect();
    let values = quantities
        .iter()
        .map(|&quantity| {
            let logarithmic = |dual: &Dual| dual.slopes[quantity as usize] * machine.value(quantity) / dual.value;
            columns.iter().map(|(_, dual)| logarithmic(dual)).collect()
        })
        .collect();
    Sensitivities {
        quantities,
        groups: columns.iter().map(|(symbol, dual)| (*symbol, dual.value)).collect(),
        values,
    }
}
