//! The table of quantities: what a map holds of every point.
//!
//! Owns their names, labels and units, and how each is read from a measurement.

use serde::{Deserialize, Serialize};

use super::{Class, Measurement, Status};
use crate::backend::{BackendKind, Contact};
use crate::experiment::Experiment;
use crate::machine::Scale;

/// A quantity that a map holds for every point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs, reason = "the rows of the table tell what each is")]
pub enum Quantity {
    Lyapunov,
    LyapunovError,
    SchemeError,
    LyapunovSecond,
    Divergence,
    LyapunovBirkhoff,
    LyapunovInterval,
    Period,
    X,
    Y,
    XMin,
    XMax,
    ChaoticFraction,
    Attractors,
    UnsettledFraction,
    ContactStatus,
    ContactTime,
    PeakPressure,
    PeakPressureTime,
    FinalWear,
    PeakTemperature,
    RunawayTime,
    IntegratedPeriods,
    Class,
    Status,
    Backend,
}

/// The type of a quantity's values, and how they are to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Values {
    /// Numbers in f64; NaN where the quantity does not apply.
    F64,
    /// Numbers in f32, whose seven digits are more than is known of them; NaN where the quantity does not apply.
    F32,
    /// An index into these names; NaN where it does not apply.
    Code(&'static [&'static str]),
}

impl Values {
    /// Bytes of a value in stores.
    pub fn bytes(self) -> u64 {
        match self {
            Self::F64 => 8,
            Self::F32 => 4,
            Self::Code(_) => 1,
        }
    }
}

/// What the table says of one quantity.
#[derive(Clone, Copy, Debug)]
pub struct QuantityInfo {
    /// The quantity that this row describes.
    pub quantity: Quantity,
    /// The name used in commands, files and data.
    pub name: &'static str,
    /// For axes and colour bars.
    pub label: &'static str,
    /// `tau`, `1/tau`, or `1` for a pure number: all are dimensionless.
    pub units: &'static str,
    /// Whether values are numbers or codes of names.
    pub values: Values,
}

macro_rules! quantity_table {
    ($($quantity:ident $name:literal $label:literal $units:literal $values:expr;)*) => {
        /// Every quantity, in the order of [`Quantity`].
        pub const QUANTITIES: &[QuantityInfo] = &[$(QuantityInfo {
            quantity: Quantity::$quantity, name: $name, label: $label, units: $units, values: $values,
        }),*];
    };
}

quantity_table! {
    Lyapunov         "lyapunov"          "maximal Lyapunov exponent λ₁"            "1/tau" Values::F64;
    LyapunovError    "lyapunov_error"    "standard error of λ₁"                    "1/tau" Values::F32;
    SchemeError      "scheme_error"      "scheme's share in the error of λ₁"       "1/tau" Values::F32;
    LyapunovSecond   "lyapunov_second"   "second Lyapunov exponent λ₂"             "1/tau" Values::F32;
    Divergence       "divergence"        "mean divergence"                         "1/tau" Values::F32;
    LyapunovBirkhoff "lyapunov_birkhoff" "weighted Birkhoff average of λ₁"         "1/tau" Values::F32;
    LyapunovInterval "lyapunov_interval" "interval over which λ₁ is taken"         "tau"   Values::F32;
    Period           "period"            "period of the motion / forcing period"   "1"     Values::F32;
    X                "x"                 "last stroboscopic angle x"               "1"     Values::F32;
    Y                "y"                 "last stroboscopic angular speed y"       "1"     Values::F32;
    XMin             "x_min"             "least angle x"                           "1"     Values::F32;
    XMax             "x_max"             "greatest angle x"                        "1"     Values::F32;
    ChaoticFraction  "chaotic_fraction"  "fraction of initial states with chaos"   "1"     Values::F32;
    Attractors       "attractors"        "number of distinct attractors"           "1"     Values::F32;
    UnsettledFraction "unsettled_fraction" "fraction of initial states not settled" "1"    Values::F32;
    ContactStatus    "contact_status"    "whether contact is lost"                 "1"     Values::Code(Contact::NAMES);
    ContactTime      "contact_time"      "time at which contact is lost"           "tau"   Values::F32;
    PeakPressure     "peak_pressure"     "greatest contact pressure p"             "1"     Values::F32;
    PeakPressureTime "peak_pressure_time" "time of the greatest pressure"          "tau"   Values::F32;
    FinalWear        "final_wear"        "wear at the end of the run"              "1"     Values::F32;
    PeakTemperature  "peak_temperature"  "greatest surface temperature θ(1, τ)"    "1"     Values::F32;
    RunawayTime      "runaway_time"      "time of runaway"                         "tau"   Values::F32;
    IntegratedPeriods "integrated_periods" "forcing periods integrated"            "1"     Values::F32;
    Class            "class"             "kind of motion"                          "1"     Values::Code(Class::NAMES);
    Status           "status"            "how the integration ended"               "1"     Values::Code(Status::NAMES);
    Backend          "backend"           "where the point was integrated"          "1"     Values::Code(BackendKind::NAMES);
}

impl Quantity {
    /// Number of quantities.
    pub const COUNT: usize = QUANTITIES.len();

    /// The scale that converts the quantity to SI units; None if a machine gives it no dimension.
    pub fn scale(self) -> Option<Scale> {
        match self {
            Self::ContactTime | Self::PeakPressureTime | Self::RunawayTime | Self::LyapunovInterval => {
                Some(Scale::Time)
            }
            Self::PeakPressure => Some(Scale::Pressure),
            Self::FinalWear => Some(Scale::Length),
            Self::PeakTemperature => Some(Scale::Temperature),
            _ => None,
        }
    }

    /// Whether the quantity is a rate per unit of tau, as exponents are.
    pub fn is_rate(self) -> bool {
        self.info().units == "1/tau"
    }

    /// For axes and colour bars in SI units.
    pub fn si_label(self) -> &'static str {
        match self {
            Self::PeakPressure => "greatest contact pressure P",
            Self::PeakTemperature => "greatest rise of the surface temperature, T − T₀",
            _ => self.info().label,
        }
    }

    /// Every quantity, in the order of the table.
    pub fn all() -> Vec<Self> {
        QUANTITIES.iter().map(|info| info.quantity).collect()
    }

    /// The rows of the quantities that results hold if these are asked for, in the order of the table: the status is always among them.
    pub fn held(quantities: &[Self]) -> impl Iterator<Item = &'static QuantityInfo> {
        let is_held = |info: &&QuantityInfo| info.quantity == Self::Status || quantities.contains(&info.quantity);
        QUANTITIES.iter().filter(is_held)
    }

    /// Whether the quantity is told by the contact, and constant where neither heat nor wear changes its pressure.
    fn is_of_contact(self) -> bool {
        matches!(
            self,
            Self::ContactStatus
                | Self::ContactTime
                | Self::PeakPressure
                | Self::PeakPressureTime
                | Self::FinalWear
                | Self::PeakTemperature
        )
    }

    /// Whether the quantity tells several initial states of a point apart.
    fn is_of_states(self) -> bool {
        matches!(self, Self::ChaoticFraction | Self::Attractors | Self::UnsettledFraction)
    }

    /// What the store of a map holds unless asked otherwise: all that can differ from point to point.
    pub fn of_map(experiment: &Experiment) -> Vec<Self> {
        let changes_pressure = experiment.has_heat_or_wear() || experiment.design.fixed.machine().is_some();
        let mut quantities = Self::all();
        quantities.retain(|quantity| match quantity {
            Self::LyapunovSecond | Self::Divergence => !experiment.has_heat_or_wear(),
            quantity if quantity.is_of_contact() => changes_pressure,
            quantity if quantity.is_of_states() => experiment.settings.sampling.initial_states > 1,
            _ => true,
        });
        quantities
    }

    /// What the store of a scan holds unless asked otherwise: what tells the motion of a point, and how surely.
    pub fn of_scan(experiment: &Experiment) -> Vec<Self> {
        let mut quantities = vec![Self::Lyapunov, Self::LyapunovError, Self::Period];
        if experiment.settings.sampling.initial_states > 1 {
            quantities.extend([Self::ChaoticFraction, Self::Attractors]);
        }
        if experiment.has_heat_or_wear() {
            quantities.extend([Self::ContactStatus, Self::ContactTime, Self::FinalWear]);
        }
        quantities.extend([Self::Class, Self::Status, Self::Backend]);
        quantities
    }

    /// The quantities that a map shows by default, for instances that wear or for instances that do not.
    pub fn drawn(wears: bool) -> &'static [Self] {
        if wears {
            &[Self::Lyapunov, Self::ContactTime, Self::FinalWear]
        } else {
            &[Self::Lyapunov, Self::Period]
        }
    }

    /// The quantity's row of the table.
    pub fn info(self) -> &'static QuantityInfo {
        &QUANTITIES[self as usize]
    }

    /// The quantity's value in a measurement; codes are indices into their names.
    pub fn of(self, measurement: &Measurement) -> f64 {
        let m = measurement;
        match self {
            Self::Lyapunov => m.lyapunov,
            Self::LyapunovError => m.lyapunov_error,
            Self::SchemeError => m.scheme_error,
            Self::LyapunovSecond => m.lyapunov_second,
            Self::Divergence => m.divergence,
            Self::LyapunovBirkhoff => m.lyapunov_birkhoff,
            Self::LyapunovInterval => m.lyapunov_interval,
            Self::Period => m.period.map_or(f64::NAN, f64::from),
            Self::X => m.x,
            Self::Y => m.y,
            Self::XMin => m.x_min,
            Self::XMax => m.x_max,
            Self::ChaoticFraction => m.chaotic_fraction,
            Self::Attractors => f64::from(m.attractors),
            Self::UnsettledFraction => m.unsettled_fraction,
            Self::ContactStatus => match m.status {
                Status::Runaway { .. } => f64::NAN,
                Status::Ok | Status::UnderResolved => f64::from(m.contact.status_code()),
            },
            Self::ContactTime => m.contact.lost.unwrap_or(f64::NAN),
            Self::PeakPressure => m.contact.peak_pressure,
            Self::PeakPressureTime => m.contact.peak_pressure_time,
            Self::FinalWear => m.contact.final_wear,
            Self::PeakTemperature => m.contact.peak_temperature,
            Self::RunawayTime => match m.status {
                Status::Runaway { time } => time,
                Status::Ok | Status::UnderResolved => f64::NAN,
            },
            Self::IntegratedPeriods => f64::from(m.integrated_periods),
            Self::Class => m.class.map_or(f64::NAN, |class| f64::from(class as u8)),
            Self::Status => f64::from(m.status.code()),
            Self::Backend => f64::from(m.backend as u8),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_the_order_of_its_enum() {
        for (index, info) in QUANTITIES.iter().enumerate() {
            assert_eq!(info.quantity as usize, index);
            assert_eq!(serde_json::to_value(info.quantity).unwrap(), info.name);
        }
    }
}
