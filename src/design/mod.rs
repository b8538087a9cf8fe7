//! Designs: which points are computed. A product of axes or a list of points, over dimensionless parameters or a machine's quantities.
//!
//! Owns the order of points (the first axis varies fastest); knows nothing of how points are computed.

mod axis;
mod coordinate;
mod error;
mod fixed;
mod points;
mod sample;

use std::ops::Index;

use rayon::prelude::*;

pub use axis::{Axis, Spacing};
pub use coordinate::Coordinate;
pub use error::{AxisError, DesignError};
pub use fixed::Fixed;
pub use points::{Points, PointsError};
pub(crate) use sample::uniform;
pub use sample::{Method, Plan, Sample, SampleError, Side};

use crate::machine::{self, Machine};
use crate::parameters::{PARAMETERS, Parameter, ParameterSet};

/// The points that are computed: what varies, and what all of them have in common.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    /// What differs from point to point.
    pub varied: Varied,
    /// The values that all points have in common, except for the coordinates that vary.
    pub fixed: Fixed,
}

/// What varies from point to point.
#[derive(Clone, Debug, PartialEq)]
pub enum Varied {
    /// Every combination of the values of the axes; the first axis varies fastest. Two axes make a map, one axis a line, no axis a
    /// single point.
    Axes(Vec<Axis>),
    /// Points one by one.
    Points(Points),
}

impl Varied {
    /// The coordinates that vary.
    pub fn coordinates(&self) -> Vec<Coordinate> {
        match self {
            Self::Axes(axes) => axes.iter().map(|axis| axis.coordinate).collect(),
            Self::Points(points) => points.coordinates().to_vec(),
        }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        match self {
            Self::Axes(axes) => axes.iter().map(Axis::count).product(),
            Self::Points(points) => points.len(),
        }
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The values of the coordinates at a point.
    pub fn values(&self, index: usize) -> Vec<(Coordinate, f64)> {
        match self {
            Self::Axes(axes) => {
                let mut index = index;
                let at = axes.iter().map(|axis| {
                    let value = axis.value(index % axis.count());
                    index /= axis.count();
                    (axis.coordinate, value)
                });
                at.collect()
            }
            Self::Points(points) => {
                let row = points.row(index).iter().copied();
                points.coordinates().iter().copied().zip(row).collect()
            }
        }
    }

    /// Least and greatest value of each coordinate.
    fn ends(&self) -> Vec<(Coordinate, [f64; 2])> {
        match self {
            Self::Axes(axes) => axes.iter().map(|axis| (axis.coordinate, axis.ends())).collect(),
            Self::Points(points) => (points.coordinates().iter().copied().zip(points.ends())).collect(),
        }
    }

    /// What varies of the machine: the axes that are quantities of it, or all columns of a list that has such a quantity.
    fn of_machine(&self) -> Self {
        let is_si = |coordinate: &Coordinate| matches!(coordinate, Coordinate::Si(_));
        match self {
            Self::Axes(axes) => Self::Axes(axes.iter().filter(|axis| is_si(&axis.coordinate)).cloned().collect()),
            Self::Points(points) if points.coordinates().iter().any(is_si) => self.clone(),
            Self::Points(_) => Self::Axes(Vec::new()),
        }
    }
}

/// Least and greatest value of every parameter over a design.
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

/// The first coordinate that occurs a second time.
pub fn first_twice(coordinates: &[Coordinate]) -> Option<Coordinate> {
    let mut rest = coordinates.iter().enumerate();
    let found = rest.find(|(index, coordinate)| coordinates[..*index].contains(coordinate));
    found.map(|(_, coordinate)| *coordinate)
}

impl Design {
    /// All combinations of the values of some axes.
    pub fn product(axes: Vec<Axis>, fixed: Fixed) -> Self {
        Self {
            varied: Varied::Axes(axes),
            fixed,
        }
    }

    /// The axes; empty for a list of points.
    pub fn axes(&self) -> &[Axis] {
        match &self.varied {
            Varied::Axes(axes) => axes,
            Varied::Points(_) => &[],
        }
    }

    /// Number of points from one value of each axis to the next; empty for a list of points.
    pub fn strides(&self) -> Vec<usize> {
        let strides = self.axes().iter().scan(1, |stride, axis| {
            let own = *stride;
            *stride *= axis.count();
            Some(own)
        });
        strides.collect()
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.varied.len()
    }

    /// Whether there is no point.
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
        self.fixed.at(self.varied.values(index))
    }

    /// The machines at the corners of a product of axes, or at all points of a list; empty without a machine.
    pub fn extreme_machines(&self) -> Vec<Machine> {
        let machines = |design: &Self| (0..design.len()).filter_map(|index| design.machine(index)).collect();
        match &self.varied {
            Varied::Axes(axes) => {
                let ends = axes.iter().map(Axis::between_ends).collect();
                machines(&Self::product(ends, self.fixed))
            }
            Varied::Points(_) => machines(self),
        }
    }

    /// The most points that a design may have over quantities of a machine: each is checked before the run.
    pub const MAX_MACHINES: usize = error::MOST_MACHINES;

    /// Least and greatest value of every parameter. A parameter need not be a monotone function of the quantities of a machine;
    /// it is therefore evaluated at every point over these quantities.
    ///
    /// # Errors
    /// [`DesignError`] if, somewhere in the design, the parameters of the machine do not exist or are out of range.
    #[expect(clippy::missing_panics_doc, reason = "a design has points")]
    pub fn extents(&self) -> Result<Extents, DesignError> {
        let machines = Self {
            varied: self.varied.of_machine(),
            fixed: self.fixed,
        };
        if machines.len() > Self::MAX_MACHINES {
            return Err(DesignError::TooMany { count: machines.len() });
        }
        let check = |index: usize| {
            let checked = machines.machine(index).map_or(Ok(()), |machine| machine.check_groups());
            checked.map_err(|error| DesignError::Machine {
                place: machines.place(index),
                error,
            })
        };
        let indices = || (0..machines.len()).into_par_iter();
        if let Some(error) = indices().find_map_first(|index| check(index).err()) {
            return Err(error);
        }
        let all = indices().map(|index| Extents::of(&machines.point(index)));
        let mut extents = all.reduce_with(Extents::joined).expect("a design has points");
        for (coordinate, [least, greatest]) in self.varied.ends() {
            if let Coordinate::Parameter(parameter) = coordinate {
                extents.0[parameter as usize] = (least, greatest);
            }
        }
        Ok(extents)
    }

    /// The values of the varied coordinates at a point, as text.
    pub fn place(&self, index: usize) -> String {
        let values = self.varied.values(index).into_iter().map(|(coordinate, value)| {
            let value = machine::units::si(value, self.fixed.unit(coordinate));
            format!("{coordinate} = {value}")
        });
        values.collect::<Vec<_>>().join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::SiQuantity;

    #[test]
    fn the_first_axis_varies_fastest_and_the_ends_are_met() {
        let axes = vec![
            Axis::parse("zeta_k=0:12:4").unwrap(),
            Axis::parse("h1=2:0.1:3").unwrap(),
        ];
        let grid = Design::product(axes, ParameterSet::default().into());
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

    fn with_machine(changes: &[(SiQuantity, f64)], axes: &[&str]) -> Design {
        let description = machine::Description::from_toml(machine::TEMPLATE).unwrap();
        let machine = description.complete(changes).unwrap();
        let axes = axes.iter().map(|axis| Axis::parse(axis).unwrap()).collect();
        Design::product(axes, Fixed::new(ParameterSet::default(), Some(machine)))
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

    /// Over the bush's radius, omega_0 first falls and then rises: its extremes need not lie at the ends of the axis.
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
        assert!(matches!(grid.extents(), Err(DesignError::TooMany { .. })));
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
