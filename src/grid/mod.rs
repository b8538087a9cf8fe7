//! Axes and grids: point index to named values, of dimensionless parameters or of a machine's quantities, in f64.
//!
//! Owns the order of points (the first axis varies fastest); knows nothing of how points are computed.

mod axis;
mod coordinate;
mod fixed;

use std::ops::Index;

use rayon::prelude::*;

pub use axis::{Axis, AxisError};
pub use coordinate::Coordinate;
pub use fixed::Fixed;

use crate::machine::{self, Machine, MachineError, SiQuantity};
use crate::parameters::{PARAMETERS, Parameter, ParameterSet};

/// Points of a scan: fixed values, and axes of which the first varies fastest. Without axes, one point.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    pub axes: Vec<Axis>,
    pub fixed: Fixed,
}

/// Least and greatest value of every parameter over a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extents([(f64, f64); Parameter::COUNT]);

impl Index<Parameter> for Extents {
    type Output = (f64, f64);
    fn index(&self, parameter: Parameter) -> &(f64, f64) {
        &self.0[parameter as usize]
    }
}

impl Extents {
    fn of(parameters: &ParameterSet) -> Self {
        Self(std::array::from_fn(|index| {
            let value = parameters[PARAMETERS[index].parameter];
            (value, value)
        }))
    }

    fn joined(self, other: Self) -> Self {
        Self(std::array::from_fn(|index| {
            let (a, b) = (self.0[index], other.0[index]);
            (a.0.min(b.0), a.1.max(b.1))
        }))
    }
}

impl Grid {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.axes.iter().map(|axis| axis.count).product()
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The parameters of point `index`.
    pub fn point(&self, index: usize) -> ParameterSet {
        *self.at(index).parameters()
    }

    /// The machine of point `index`, if there is one.
    pub fn machine(&self, index: usize) -> Option<Machine> {
        self.at(index).machine().copied()
    }

    fn at(&self, index: usize) -> Fixed {
        self.fixed.at(self.values(index))
    }

    /// The values of the axes at a point.
    fn values(&self, mut index: usize) -> impl Iterator<Item = (Coordinate, f64)> + '_ {
        self.axes.iter().map(move |axis| {
            let value = axis.value(index % axis.count);
            index /= axis.count;
            (axis.coordinate, value)
        })
    }

    /// The machines at the corners of the grid, which has one.
    pub fn corner_machines(&self) -> Vec<Machine> {
        let ends: Vec<Axis> = self.axes.iter().map(|axis| Axis { count: 2, ..*axis }).collect();
        let corners = Self {
            axes: ends,
            fixed: self.fixed,
        };
        (0..corners.len()).filter_map(|index| corners.machine(index)).collect()
    }

    /// The most points over quantities of a machine: each is checked beforehand.
    pub const MAX_MACHINES: usize = 200_000_000;

    /// Least and greatest value of every parameter. Over quantities of a machine parameters need not be monotone, so that
    /// each of its values counts.
    ///
    /// # Errors
    /// [`GridError`] if the machine has no parameters, or ones out of range, somewhere on the grid.
    pub fn extents(&self) -> Result<Extents, GridError> {
        let (si, plain): (Vec<Axis>, Vec<Axis>) = self
            .axes
            .iter()
            .partition(|axis| matches!(axis.coordinate, Coordinate::Si(_)));
        let machines = Self {
            axes: si,
            fixed: self.fixed,
        };
        if machines.len() > Self::MAX_MACHINES {
            return Err(GridError::TooMany { count: machines.len() });
        }
        let check = |index: usize| {
            let checked = machines.machine(index).map_or(Ok(()), |machine| machine.check_groups());
            checked.map_err(|error| GridError::Machine {
                place: machines.place(index),
                error,
            })
        };
        let indices = || (0..machines.len()).into_par_iter();
        if let Some(error) = indices().find_map_first(|index| check(index).err()) {
            return Err(error);
        }
        let all = indices().map(|index| Extents::of(&machines.point(index)));
        let mut extents = all.reduce_with(Extents::joined).expect("a grid has points");
        for axis in plain {
            if let Coordinate::Parameter(parameter) = axis.coordinate {
                extents.0[parameter as usize] = (axis.start.min(axis.stop), axis.start.max(axis.stop));
            }
        }
        Ok(extents)
    }

    /// The values of the axes at a point, in words.
    pub fn place(&self, index: usize) -> String {
        let values = self.values(index).map(|(coordinate, value)| {
            let value = machine::units::si(value, self.fixed.unit(coordinate));
            format!("{coordinate} = {value}")
        });
        values.collect::<Vec<_>>().join(", ")
    }
}

#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GridError {
    #[error(
        "{parameter} follows from the machine: set {governing} ({}) instead, or make that an axis",
        governing.info().meaning
    )]
    Determined {
        parameter: Parameter,
        governing: SiQuantity,
    },
    #[error("{name} is a quantity of a machine, and there is none: give one by --machine, or in the table `machine`")]
    NoMachine { name: &'static str },
    #[error("{}{error}", if place.is_empty() { String::new() } else { format!("at {place}: ") })]
    Machine { place: String, error: MachineError },
    #[error("{count} points over quantities of a machine are too many (at most {max}): use fewer", max = Grid::MAX_MACHINES)]
    TooMany { count: usize },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_axis_varies_fastest_and_the_ends_are_met() {
        let axes = vec![
            Axis::parse("zeta_k=0:12:4").unwrap(),
            Axis::parse("h1=2:0.1:3").unwrap(),
        ];
        let grid = Grid {
            axes,
            fixed: ParameterSet::default().into(),
        };
        assert_eq!(grid.len(), 12);
        assert_eq!(
            (grid.point(3)[Parameter::ZetaK], grid.point(3)[Parameter::H1]),
            (12.0, 2.0)
        );
        assert_eq!(
            (grid.point(8)[Parameter::ZetaK], grid.point(11)[Parameter::H1]),
            (0.0, 0.1)
        );
    }

    fn with_machine(changes: &[(SiQuantity, f64)], axes: &[&str]) -> Grid {
        let description = machine::Description::from_toml(machine::TEMPLATE).unwrap();
        let machine = description.complete(changes).unwrap();
        Grid {
            axes: axes.iter().map(|axis| Axis::parse(axis).unwrap()).collect(),
            fixed: Fixed::new(ParameterSet::default(), Some(machine)),
        }
    }

    #[test]
    fn points_over_quantities_are_those_of_their_machines() {
        let grid = with_machine(
            &[],
            &["shaft_speed_amplitude=0:300:4", "x0=-1:1:3", "inertia=1e-3:9e-3:5"],
        );
        let index = 3 + 4 * (2 + 3 * 4);
        let machine = grid.machine(index).unwrap();
        assert_eq!(machine.value(SiQuantity::ShaftSpeedAmplitude), 300.0);
        assert_eq!(machine.value(SiQuantity::Inertia), 9e-3);
        let point = grid.point(index);
        assert_eq!(
            point,
            machine.parameters(&ParameterSet::default().with(Parameter::X0, 1.0))
        );
        assert_eq!(point[Parameter::ZetaK], 300.0 * machine.scales().time);
    }

    /// omega_0 falls and rises again over the bush's radius: the ends of an axis do not tell the extremes.
    #[test]
    fn extents_are_those_of_all_points() {
        let changes = [
            (SiQuantity::TangentStiffness, 2.295e5),
            (SiQuantity::TangentCubicStiffness, 0.0),
        ];
        let axes = [
            "bush_radius=0.005:0.04:40",
            "spring_free_length=0.031:0.03125:30",
            "x0=2:-1:3",
        ];
        let grid = with_machine(&changes, &axes);
        let extents = grid.extents().unwrap();
        for info in PARAMETERS {
            let values = || (0..grid.len()).map(|index| grid.point(index)[info.parameter]);
            let expected = (
                values().fold(f64::INFINITY, f64::min),
                values().fold(f64::NEG_INFINITY, f64::max),
            );
            assert_eq!(extents[info.parameter], expected, "{}", info.name);
        }
        let ends = [0, 39, 29 * 40, 30 * 40 - 1].map(|index| grid.point(index)[Parameter::Omega0]);
        assert!(
            ends.iter().all(|end| extents[Parameter::Omega0].0 < 0.9 * end),
            "{ends:?}"
        );
    }

    #[test]
    fn a_machine_that_is_none_on_a_part_of_an_axis_is_refused_with_its_place() {
        let grid = with_machine(&[], &["spring_length=0.02:0.04:21", "damping=0:100:3"]);
        let message = grid.extents().unwrap_err().to_string();
        assert!(
            message.starts_with("at spring_length = 32 mm, damping = 0 N s/m²: k* = -"),
            "{message}"
        );
        let grid = with_machine(&[], &["shaft_speed_frequency=100:1e6:21"]);
        let message = grid.extents().unwrap_err().to_string();
        assert!(
            message.contains("omega_0 = ") && message.contains("change shaft_speed_frequency"),
            "{message}"
        );
        let grid = with_machine(&[], &["damping=0:100:1000000", "inertia=1e-3:2e-3:1000000"]);
        assert!(matches!(grid.extents(), Err(GridError::TooMany { .. })));
    }

    #[test]
    fn what_follows_from_a_machine_is_not_free_and_without_one_its_quantities_are_not() {
        for info in PARAMETERS {
            let coordinate = Coordinate::from(info.parameter);
            assert!(coordinate.check_free(false).is_ok());
            let is_free = ["epsilon_0", "ramp_rate", "x0", "y0"].contains(&info.name);
            assert_eq!(coordinate.check_free(true).is_ok(), is_free, "{}", info.name);
        }
        let damping = Coordinate::from(SiQuantity::Damping);
        assert!(damping.check_free(true).is_ok() && damping.check_free(false).is_err());
    }
}
