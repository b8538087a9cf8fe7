//! A bush-shaft machine in SI units, and the dimensionless parameters and scales that follow from it.
//!
//! Owns which values make a machine and what follows from them; knows nothing of axes, and opens no file.
//!
//! ```
//! use tribochaos::machine::{self, Description};
//! use tribochaos::parameters::{Parameter, ParameterSet};
//!
//! let machine = Description::from_toml(machine::TEMPLATE)?.complete(&[])?;
//! let parameters = machine.parameters(&ParameterSet::default());
//! assert!((parameters[Parameter::Epsilon] - 0.1).abs() < 1e-3);
//! assert!((machine.scales().time - 0.01695).abs() < 1e-5);
//! # Ok::<(), tribochaos::machine::MachineError>(())
//! ```

mod description;
mod dual;
mod error;
mod groups;
mod materials;
mod plausibility;
mod quantities;
mod sensitivities;
#[cfg(test)]
mod tests;
pub mod units;

pub(crate) use description::check_range;
pub use description::{Description, TEMPLATE};
pub use error::MachineError;
use groups::Groups;
pub use groups::governing;
pub use materials::{CONSTANTS, MATERIALS, Material};
pub use plausibility::{Beyond, plausibility_warnings};
pub use quantities::{SI_QUANTITIES, SiQuantity, SiQuantityInfo};
pub use sensitivities::{Group, Sensitivities, sensitivities};

use crate::parameters::{Parameter, ParameterSet};

/// Temperatures and a strength with which results are compared; they enter no formula.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// T0 in K.
    pub ambient_temperature: f64,
    /// In K, if known.
    pub melting_point: Option<f64>,
    /// In Pa, if known.
    pub yield_strength: Option<f64>,
}

/// A machine: a value for every quantity. [`Description::complete`] makes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Machine {
    values: [f64; SiQuantity::COUNT],
    /// Whether values are those of whole parts. If not, they are per metre of contact length, and the contact length is 1.
    is_whole: bool,
    material: Option<&'static Material>,
    limits: Limits,
}

/// The factors that convert dimensionless results to SI units: equation (2.7).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales {
    /// t* in s.
    pub time: f64,
    /// T* in K.
    pub temperature: f64,
    /// P* in Pa.
    pub pressure: f64,
    /// U* in m.
    pub length: f64,
    /// V* in m/s.
    pub speed: f64,
}

/// A scale by its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// t*, which converts tau to time.
    Time,
    /// T*, which converts theta to the temperature above T0.
    Temperature,
    /// P*, which converts p to the contact pressure.
    Pressure,
    /// U*, which converts u_w to the depth of wear.
    Length,
}

impl Scale {
    /// Every kind. V* is not among them, because no quantity of a map is a speed in SI units.
    pub const ALL: [Self; 4] = [Self::Time, Self::Temperature, Self::Pressure, Self::Length];

    /// The unit of the converted result.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Time => "s",
            Self::Temperature => "K",
            Self::Pressure => "Pa",
            Self::Length => "m",
        }
    }

    /// The name in data files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Time => "time_scale",
            Self::Temperature => "temperature_scale",
            Self::Pressure => "pressure_scale",
            Self::Length => "length_scale",
        }
    }
}

impl Scales {
    /// The value of a scale, in the unit that [`Scale::unit`] gives.
    pub fn of(&self, scale: Scale) -> f64 {
        match scale {
            Scale::Time => self.time,
            Scale::Temperature => self.temperature,
            Scale::Pressure => self.pressure,
            Scale::Length => self.length,
        }
    }
}

impl Machine {
    /// The value of a quantity in the unit that [`Machine::unit`] gives.
    pub fn value(&self, quantity: SiQuantity) -> f64 {
        self.values[quantity as usize]
    }

    /// The machine with one value replaced (not checked).
    #[must_use]
    pub fn with(mut self, quantity: SiQuantity, value: f64) -> Self {
        self.values[quantity as usize] = value;
        self
    }

    /// The unit of a quantity's value: the unit of the whole part if the contact length is given.
    pub fn unit(&self, quantity: SiQuantity) -> &'static str {
        let info = quantity.info();
        match info.whole_unit {
            Some(whole) if self.is_whole => whole,
            _ => info.unit,
        }
    }

    /// The quantities that this machine has; the contact length is among them only if it is given.
    pub fn quantities(&self) -> impl Iterator<Item = SiQuantity> + use<> {
        let is_whole = self.is_whole;
        SI_QUANTITIES
            .iter()
            .map(|info| info.quantity)
            .filter(move |quantity| is_whole || *quantity != SiQuantity::Length)
    }

    /// The material by whose name the machine was described, if any.
    pub fn material(&self) -> Option<&'static Material> {
        self.material
    }

    /// What [`Machine::beyond`] compares results with.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    fn groups(&self) -> Groups<f64> {
        groups::groups(|quantity| self.value(quantity))
    }

    /// k* in N/m^2, per metre of contact length.
    pub fn spring(&self) -> f64 {
        self.groups().spring
    }

    /// The scales to SI units. Where k* is not positive, t* and what depends on it are no numbers.
    pub fn scales(&self) -> Scales {
        let groups = self.groups();
        Scales {
            time: groups.time,
            temperature: groups.temperature,
            pressure: groups.pressure,
            length: groups.length,
            speed: groups.speed,
        }
    }

    /// The dimensionless parameters. The machine does not determine `epsilon_0`, `ramp_rate`, `x0` and `y0`; these are taken from
    /// `free`. Where k* is not positive, the parameters that depend on t* are no numbers.
    pub fn parameters(&self, free: &ParameterSet) -> ParameterSet {
        let groups = self.groups();
        groups
            .parameters
            .iter()
            .fold(*free, |set, &(parameter, value)| set.with(parameter, value))
    }

    /// Checks that the machine has parameters, all within their ranges.
    ///
    /// # Errors
    /// [`MachineError::Range`] for a value out of its range, [`MachineError::Radii`] unless U* < R1 < R2,
    /// [`MachineError::Spring`] where k* is not positive,
    /// [`MachineError::Group`] for a parameter out of its range.
    pub fn check(&self) -> Result<(), MachineError> {
        for quantity in self.quantities() {
            self.check_value(quantity, self.value(quantity))?;
        }
        self.check_groups()
    }

    /// Checks that a quantity may have a value.
    ///
    /// # Errors
    /// [`MachineError::Range`], also for NaN and infinities.
    pub fn check_value(&self, quantity: SiQuantity, value: f64) -> Result<(), MachineError> {
        description::check_range(quantity, value, self.unit(quantity))
    }

    /// As [`Machine::check`], for a machine whose single values are known to be within their ranges.
    ///
    /// # Errors
    /// As [`Machine::check`].
    #[expect(clippy::missing_panics_doc, reason = "every group has a governing quantity")]
    pub fn check_groups(&self) -> Result<(), MachineError> {
        let radii = [
            SiQuantity::Interference,
            SiQuantity::ShaftRadius,
            SiQuantity::BushRadius,
        ];
        for pair in radii.windows(2) {
            let [smaller, larger] = [pair[0], pair[1]].map(|quantity| self.value(quantity));
            if smaller >= larger {
                return Err(MachineError::Radii {
                    names: [pair[0].name(), pair[1].name()],
                    values: [smaller, larger],
                });
            }
        }
        let groups = self.groups();
        let k_star = groups.spring;
        if k_star <= 0.0 {
            let value = |quantity| self.value(quantity);
            let (l0, l1) = (value(SiQuantity::SpringFreeLength), value(SiQuantity::SpringLength));
            let lever = 1.0 + l1 / value(SiQuantity::BushRadius);
            let ratio = value(SiQuantity::TangentStiffness) / value(SiQuantity::RadialStiffness);
            return Err(MachineError::Spring {
                k_star,
                l0,
                l1,
                least: l1 * (1.0 + ratio / lever),
            });
        }
        for (parameter, value) in groups.parameters {
            if let Err(error) = parameter.check(value) {
                return Err(MachineError::Group {
                    error,
                    governing: governing(parameter).expect("a machine determines its groups"),
                });
            }
        }
        Ok(())
    }

    /// Whether a parameter changes with a quantity, to first order around this machine.
    pub fn moves(&self, quantity: SiQuantity, parameter: Parameter) -> bool {
        sensitivities::slope(self, quantity, parameter) != 0.0
    }
}
