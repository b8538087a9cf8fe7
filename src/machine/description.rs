//! A machine as it is written in a file: values by name, a material's constants by its name.
//!
//! Owns the TOML form and which values may be left out; the formulas are [`super::groups`]'.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::{Error as _, MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Limits, Machine, MachineError, Material, SI_QUANTITIES, SiQuantity};
use crate::parameters;

/// A complete file, with comments: a machine that has the paper's preset, though it is not a realistic one.
pub const TEMPLATE: &str = include_str!("template.toml");

/// A machine as far as it is written down. [`Description::complete`] makes it a [`Machine`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Description {
    /// In SI units. If [`SiQuantity::Length`] is among them, the extensive values are those of the whole parts; otherwise they
    /// are per metre of contact length.
    pub values: BTreeMap<SiQuantity, f64>,
    /// Gives the constants that `values` leaves out, and the limits.
    pub material: Option<&'static Material>,
    /// T0 in K; 293.15 if left out.
    pub ambient_temperature: Option<f64>,
    /// In K; if left out, that of the material.
    pub melting_point: Option<f64>,
    /// In Pa; if left out, that of the material.
    pub yield_strength: Option<f64>,
}

/// T0 where none is given, in K: 20 degrees Celsius.
const AMBIENT_TEMPERATURE: f64 = 293.15;

const MATERIAL: &str = "material";
const AMBIENT: &str = "ambient_temperature";
const MELTING: &str = "melting_point";
const YIELD: &str = "yield_strength";

/// What a line of a file gives.
enum Key {
    Quantity(SiQuantity),
    Material,
    Ambient,
    Melting,
    Yield,
}

impl Key {
    /// # Errors
    /// [`MachineError::Unknown`] with the nearest known name, if one is near.
    fn from_name(name: &str) -> Result<Self, MachineError> {
        Ok(match name {
            MATERIAL => Self::Material,
            AMBIENT => Self::Ambient,
            MELTING => Self::Melting,
            YIELD => Self::Yield,
            _ => Self::Quantity(SiQuantity::from_name(name).ok_or_else(|| {
                let others = [MATERIAL, AMBIENT, MELTING, YIELD];
                let known = SI_QUANTITIES.iter().map(|info| info.name).chain(others);
                MachineError::Unknown {
                    name: name.to_owned(),
                    suggestion: parameters::nearest(name, known),
                }
            })?),
        })
    }
}

/// Checks that a quantity may have a value.
pub(crate) fn check_range(quantity: SiQuantity, value: f64, unit: &'static str) -> Result<(), MachineError> {
    let (min, max) = quantity.info().range;
    check(quantity.name(), value, unit, min, max)
}

fn check(name: &'static str, value: f64, unit: &'static str, min: f64, max: f64) -> Result<(), MachineError> {
    if (min..=max).contains(&value) {
        return Ok(());
    }
    Err(MachineError::Range {
        name,
        value,
        unit,
        min,
        max,
    })
}

impl Description {
    /// # Errors
    /// If the text is no TOML, or has an unknown name or a value of the wrong type.
    pub fn from_toml(text: &str) -> Result<Self, MachineError> {
        Ok(toml::from_str(text)?)
    }

    /// Sets a value; it replaces the one that is written.
    ///
    /// # Errors
    /// [`MachineError::NoLength`] for a contact length, if the values are not those of whole parts.
    pub fn set(&mut self, quantity: SiQuantity, value: f64) -> Result<(), MachineError> {
        if quantity == SiQuantity::Length && !self.values.contains_key(&quantity) {
            return Err(MachineError::NoLength(quantity));
        }
        self.values.insert(quantity, value);
        Ok(())
    }

    /// The machine. `axes` are the quantities that vary, each with the value that it has in this machine.
    ///
    /// # Errors
    /// [`MachineError::Missing`] with all quantities that are left out, [`MachineError::Range`], or [`MachineError::NoLength`] if
    /// the contact length is an axis of a machine whose values are not those of whole parts. This does not check that k* is
    /// positive; [`Machine::check_groups`] does.
    pub fn complete(&self, axes: &[(SiQuantity, f64)]) -> Result<Machine, MachineError> {
        let axis = |quantity| axes.iter().find(|(axis, _)| *axis == quantity).map(|(_, value)| *value);
        let is_whole = self.values.contains_key(&SiQuantity::Length);
        if !is_whole && axis(SiQuantity::Length).is_some() {
            return Err(MachineError::NoLength(SiQuantity::Length));
        }
        let mut values = [1.0; SiQuantity::COUNT];
        let mut missing = Vec::new();
        for info in SI_QUANTITIES {
            let quantity = info.quantity;
            let value = axis(quantity)
                .or_else(|| self.values.get(&quantity).copied())
                .or_else(|| self.material.and_then(|material| material.constant(quantity)));
            match value {
                Some(value) => values[quantity as usize] = value,
                None if quantity == SiQuantity::Length => {}
                None => missing.push(quantity),
            }
        }
        if !missing.is_empty() {
            return Err(MachineError::Missing { missing });
        }
        let limits = Limits {
            ambient_temperature: self.ambient_temperature.unwrap_or(AMBIENT_TEMPERATURE),
            melting_point: self
                .melting_point
                .or(self.material.map(|material| material.melting_point)),
            yield_strength: self
                .yield_strength
                .or(self.material.map(|material| material.yield_strength)),
        };
        check(AMBIENT, limits.ambient_temperature, "K", 0.0, 1e5)?;
        check(MELTING, limits.melting_point.unwrap_or(1.0), "K", 1.0, 1e5)?;
        check(YIELD, limits.yield_strength.unwrap_or(1.0), "Pa", 1.0, 1e15)?;
        let machine = Machine {
            values,
            is_whole,
            material: self.material,
            limits,
        };
        for quantity in machine.quantities() {
            machine.check_value(quantity, machine.value(quantity))?;
        }
        Ok(machine)
    }
}

impl Machine {
    /// The machine as it is written in a file, with every value except those of `axes`. A later change of the table of materials
    /// therefore changes nothing.
    pub fn description(&self, axes: &[SiQuantity]) -> Description {
        let values = self
            .quantities()
            // without a contact length, the other values would be read as values per metre
            .filter(|quantity| *quantity == SiQuantity::Length || !axes.contains(quantity))
            .map(|quantity| (quantity, self.value(quantity)))
            .collect();
        Description {
            values,
            material: self.material,
            ambient_temperature: Some(self.limits.ambient_temperature),
            melting_point: self.limits.melting_point,
            yield_strength: self.limits.yield_strength,
        }
    }
}

impl Serialize for Description {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (quantity, value) in &self.values {
            map.serialize_entry(quantity.name(), value)?;
        }
        if let Some(material) = self.material {
            map.serialize_entry(MATERIAL, material.name)?;
        }
        let limits = [
            (AMBIENT, self.ambient_temperature),
            (MELTING, self.melting_point),
            (YIELD, self.yield_strength),
        ];
        for (name, value) in limits {
            if let Some(value) = value {
                map.serialize_entry(name, &value)?;
            }
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Description {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Names)
    }
}

struct Names;

impl<'de> Visitor<'de> for Names {
    type Value = Description;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("quantities of a machine by their names")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Description, A::Error> {
        let mut description = Description::default();
        while let Some(key) = map.next_key::<Key>()? {
            match key {
                Key::Quantity(quantity) => {
                    description.values.insert(quantity, map.next_value()?);
                }
                Key::Material => description.material = Some(map.next_value::<Known>()?.0),
                Key::Ambient => description.ambient_temperature = Some(map.next_value()?),
                Key::Melting => description.melting_point = Some(map.next_value()?),
                Key::Yield => description.yield_strength = Some(map.next_value()?),
            }
        }
        Ok(description)
    }
}

// names are checked as they are read, so that an error points to its line

impl<'de> Deserialize<'de> for Key {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        Self::from_name(&name).map_err(D::Error::custom)
    }
}

/// A material of the table.
struct Known(&'static Material);

impl<'de> Deserialize<'de> for Known {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        let material = Material::from_name(&name);
        material
            .map(Self)
            .ok_or_else(|| D::Error::custom(MachineError::Material { name }))
    }
}
