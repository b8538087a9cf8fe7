//! Whether a machine, and what it does, could exist.
//!
//! Owns the bounds and the words of the warnings; impossible values are refused elsewhere.

use std::f64::consts::PI;

use super::units::{five_digits, si};
use super::{Limits, Machine, SiQuantity};

/// There is a warning if a value lies outside the usual range by this factor...
const FAR: f64 = 10.0;

/// ...and if the mean density of the bush lies outside these bounds, in kg/m^3, by that factor: from plastic to tungsten.
const DENSITIES: (f64, f64) = (1e3, 2e4);

/// An ambient temperature below this, in K, is likely one in °C.
const COLD: f64 = 150.0;

/// Angles beyond this, in rad, are far from those for which the moment of the springs, taken to third order, holds.
const FAR_ANGLE: f64 = 1.5;

/// How far a magnitude lies outside a range, in orders of magnitude, negative below the range; None unless it is outside by the
/// factor [`FAR`].
fn orders(value: f64, (low, high): (f64, f64)) -> Option<f64> {
    let value = value.abs();
    if value > 0.0 && value * FAR <= low * (1.0 + 1e-9) {
        Some((value / low).log10())
    } else if value >= FAR * high * (1.0 - 1e-9) {
        Some((value / high).log10())
    } else {
        None
    }
}

fn far(orders: f64) -> String {
    let side = if orders < 0.0 { "below" } else { "above" };
    format!("{:.1} orders of magnitude {side}", orders.abs())
}

/// Warnings about unlikely machines, one sentence each. The machines are the corners of a region. The warnings concern values
/// outside the usual ranges by an order of magnitude or more, a bush of an impossible density, and an ambient temperature at
/// which no machine runs.
///
/// # Panics
/// If there is no machine.
pub fn plausibility_warnings(corners: &[Machine]) -> Vec<String> {
    let machine = corners.first().expect("a region has corners");
    let worst = |value: &dyn Fn(&Machine) -> f64, range| {
        let judged = corners.iter().filter_map(|corner| {
            let value = value(corner);
            orders(value, range).map(|orders| (value, orders))
        });
        judged.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
    };
    let mut warnings = Vec::new();
    for quantity in machine.quantities() {
        let info = quantity.info();
        // whole parts are judged per metre
        let value = |corner: &Machine| {
            let value = corner.value(quantity);
            let contact_length = corner.value(SiQuantity::Length);
            if quantity.is_extensive() {
                value / contact_length
            } else {
                value
            }
        };
        if let Some((value, orders)) = worst(&value, info.usual) {
            warnings.push(format!(
                "{} = {} is {} what machines have ({} to {})",
                info.name,
                si(value, info.unit),
                far(orders),
                si(info.usual.0, info.unit),
                si(info.usual.1, info.unit)
            ));
        }
    }
    if let Some((density, orders)) = worst(&density, DENSITIES) {
        warnings.push(format!(
            "inertia: a bush between the radii of shaft and bush would need a density of {density:.2e} kg/m³, {} what \
             materials have ({} to {} kg/m³); inertia is {} here",
            far(orders),
            DENSITIES.0,
            DENSITIES.1,
            match machine.unit(SiQuantity::Inertia) {
                "kg m" => "per metre of contact length (give `length` if it is the whole bush's)",
                _ => "the whole bush's",
            }
        ));
    }
    // the limits are the same at all corners, since they are no axes
    let limits = machine.limits();
    let ambient = limits.ambient_temperature;
    if ambient < COLD {
        warnings.push(format!(
            "ambient_temperature = {} is colder than where machines run: is it in °C? Then it is {} K",
            si(ambient, "K"),
            five_digits(ambient + 273.15)
        ));
    }
    if let Some(melting_point) = limits.melting_point.filter(|limit| ambient >= *limit) {
        warnings.push(format!(
            "ambient_temperature = {} is above the melting point of the shaft, {}: it melts before it turns",
            si(ambient, "K"),
            si(melting_point, "K")
        ));
    }
    warnings
}

/// The density of a tube from R1 to R2 with the bush's moment of inertia, B2 = (pi/2) rho (R2^4 - R1^4).
fn density(machine: &Machine) -> f64 {
    let value = |quantity| machine.value(quantity);
    let (r1, r2) = (value(SiQuantity::ShaftRadius), value(SiQuantity::BushRadius));
    let inertia = value(SiQuantity::Inertia) / value(SiQuantity::Length);
    2.0 * inertia / (PI * (r2.powi(4) - r1.powi(4)))
}

/// A limit of the material or of the model that is exceeded.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "each has what is reached and the limit that it passes")]
pub enum Beyond {
    /// The surface is hotter than this, in K.
    Melting { reached: f64, limit: f64 },
    /// The contact pressure is above the yield strength, in Pa.
    Yield { reached: f64, limit: f64 },
    /// The bush turns further than this, in rad.
    Angle { reached: f64, limit: f64 },
}

impl Beyond {
    /// The name in data.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Melting { .. } => "melting",
            Self::Yield { .. } => "yield",
            Self::Angle { .. } => "angle",
        }
    }

    /// The value that is reached, divided by the limit.
    pub fn factor(&self) -> f64 {
        match self {
            Self::Melting { reached, limit } | Self::Yield { reached, limit } | Self::Angle { reached, limit } => {
                reached / limit
            }
        }
    }
}

impl std::fmt::Display for Beyond {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Melting { reached, limit } => write!(
                f,
                "the surface would be at {}, and the shaft melts at {}",
                si(*reached, "K"),
                si(*limit, "K")
            ),
            Self::Yield { reached, limit } => write!(
                f,
                "the contact pressure would be {}, and the shaft yields at {}",
                si(*reached, "Pa"),
                si(*limit, "Pa")
            ),
            Self::Angle { reached, limit } => write!(
                f,
                "the bush would turn by {}, and the moment of the springs, taken to third order in the angle, is far off \
                 beyond {}",
                si(*reached, "rad"),
                si(*limit, "rad")
            ),
        }
    }
}

impl Machine {
    /// The limits that are exceeded, given the dimensionless peaks of the pressure p and of the surface temperature
    /// theta(1, tau), and the greatest magnitude of the angle x. Beyond a limit the model does not hold. NaN exceeds no limit.
    pub fn beyond(&self, peak_pressure: f64, peak_temperature: f64, angle: f64) -> Vec<Beyond> {
        let scales = self.scales();
        let Limits {
            ambient_temperature,
            melting_point,
            yield_strength,
        } = self.limits;
        let melting = melting_point.map(|limit| Beyond::Melting {
            reached: ambient_temperature + scales.temperature * peak_temperature,
            limit,
        });
        let pressed = yield_strength.map(|limit| Beyond::Yield {
            reached: scales.pressure * peak_pressure,
            limit,
        });
        let turned = Beyond::Angle {
            reached: angle,
            limit: FAR_ANGLE,
        };
        let all = melting.into_iter().chain(pressed).chain([turned]);
        all.filter(|beyond| beyond.factor() > 1.0).collect()
    }
}
