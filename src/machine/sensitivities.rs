//! How the dimensionless groups and the scales change with each quantity.
//!
//! Owns the table; dual numbers give the exact derivatives of the formulas themselves.

use super::dual::Dual;
use super::groups::{self, Groups};
use super::{Machine, Scale, SiQuantity};
use crate::parameters::Parameter;

/// Logarithmic sensitivities d ln(group)/d ln(quantity): by how many per cent a group changes if a quantity changes by one per
/// cent.
#[derive(Clone, Debug)]
pub struct Sensitivities {
    /// Rows, in the table's order.
    pub quantities: Vec<SiQuantity>,
    /// Columns: the parameters that the machine determines, k*, and the scales.
    pub groups: Vec<Group>,
    /// By row and column; NaN where the group is 0, and 0 where the quantity is 0.
    pub values: Vec<Vec<f64>>,
}

/// A number that changes with the quantities.
#[derive(Clone, Copy, Debug)]
pub struct Group {
    /// The name of the parameter or of the scale, or `k_star`.
    pub name: &'static str,
    /// The symbol used in tables.
    pub symbol: &'static str,
    /// Its value for the machine: a parameter is dimensionless, k* and the scales are in SI units.
    pub value: f64,
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
        ("k_star", "k*", groups.spring),
        (Scale::Time.name(), "t*", groups.time),
        (Scale::Temperature.name(), "T*", groups.temperature),
        (Scale::Pressure.name(), "P*", groups.pressure),
        ("speed_scale", "V*", groups.speed),
    ];
    let columns: Vec<(&'static str, &'static str, Dual)> = groups
        .parameters
        .iter()
        .map(|(parameter, dual)| (parameter.name(), parameter.info().symbol, *dual))
        .chain(scales)
        .collect();
    let quantities: Vec<SiQuantity> = machine.quantities().collect();
    let values = quantities
        .iter()
        .map(|&quantity| {
            let logarithmic = |dual: &Dual| dual.slopes[quantity as usize] * machine.value(quantity) / dual.value;
            columns.iter().map(|(_, _, dual)| logarithmic(dual)).collect()
        })
        .collect();
    Sensitivities {
        quantities,
        groups: columns
            .iter()
            .map(|&(name, symbol, Dual { value, .. })| Group { name, symbol, value })
            .collect(),
        values,
    }
}
