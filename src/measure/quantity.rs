//! The table of quantities: what a map holds of every point.
//!
//! Owns their names, labels and units, and how each is read from a measurement.

use serde::{Deserialize, Serialize};

use super::{Class, Measurement, Status};
use crate::backend::{BackendKind, Contact};
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

/// How a quantity's values are to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Values {
    /// A number; NaN where it does not apply.
    Number,
    /// An index into these names; NaN where it does not apply.
    Code(&'static [&'static str]),
}

/// What the table says of one quantity.
#[derive(Clone, Copy, Debug)]
pub struct QuantityInfo {
    /// Whose row this is.
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
    Lyapunov         "lyapunov"          "maximal Lyapunov exponent λ₁"            "1/tau" Values::Number;
    LyapunovError    "lyapunov_error"    "standard error of λ₁"                    "1/tau" Values::Number;
    SchemeError      "scheme_error"      "scheme's share in the error of λ₁"       "1/tau" Values::Number;
    LyapunovSecond   "lyapunov_second"   "second Lyapunov exponent λ₂"             "1/tau" Values::Number;
    Divergence       "divergence"        "mean divergence"                         "1/tau" Values::Number;
    LyapunovBirkhoff "lyapunov_birkhoff" "weighted Birkhoff average of λ₁"         "1/tau" Values::Number;
    LyapunovInterval "lyapunov_interval" "interval over which λ₁ is taken"         "tau"   Values::Number;
    Period           "period"            "period of the motion / forcing period"   "1"     Values::Number;
    X                "x"                 "last stroboscopic angle x"               "1"     Values::Number;
    Y                "y"                 "last stroboscopic angular speed y"       "1"     Values::Number;
    XMin             "x_min"             "least angle x"                           "1"     Values::Number;
    XMax             "x_max"             "greatest angle x"                        "1"     Values::Number;
    ChaoticFraction  "chaotic_fraction"  "fraction of initial states with chaos"   "1"     Values::Number;
    Attractors       "attractors"        "number of distinct attractors"           "1"     Values::Number;
    UnsettledFraction "unsettled_fraction" "fraction of initial states not settled" "1"    Values::Number;
    ContactStatus    "contact_status"    "whether contact is lost"                 "1"     Values::Code(Contact::NAMES);
    ContactTime      "contact_time"      "time at which contact is lost"           "tau"   Values::Number;
    PeakPressure     "peak_pressure"     "greatest contact pressure p"             "1"     Values::Number;
    PeakPressureTime "peak_pressure_time" "time of the greatest pressure"          "tau"   Values::Number;
    FinalWear        "final_wear"        "wear at the end of the run"              "1"     Values::Number;
    PeakTemperature  "peak_temperature"  "greatest surface temperature θ(1, τ)"    "1"     Values::Number;
    RunawayTime      "runaway_time"      "time of runaway"                         "tau"   Values::Number;
    IntegratedPeriods "integrated_periods" "forcing periods integrated"            "1"     Values::Number;
    Class            "class"             "kind of motion"                          "1"     Values::Code(Class::NAMES);
    Status           "status"            "how the integration ended"               "1"     Values::Code(Status::NAMES);
    Backend          "backend"           "where the point was integrated"          "1"     Values::Code(BackendKind::NAMES);
}

impl Quantity {
    /// Number of quantities.
    pub const COUNT: usize = QUANTITIES.len();

    /// What leads from the quantity to one in SI units, of quantities that a machine gives a dimension.
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

    /// Whether it is taken per unit of tau, as exponents are.
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

    /// What a map of instances that wear, or that do not, is drawn of unless asked otherwise.
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
