//! Values with units for people: prefixes, and digits that can be read.

/// Prefixes of units, by their power of a thousand from 10^-12 on.
const PREFIXES: [&str; 9] = ["p", "n", "µ", "m", "", "k", "M", "G", "T"];

/// A unit with a prefix, and the factor that converts a value in the plain unit to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    /// 1000 for a prefix milli.
    pub factor: f64,
    /// Empty for pure numbers.
    pub name: String,
}

impl Unit {
    /// The unit as it is.
    pub fn plain(unit: &str) -> Self {
        Self {
            factor: 1.0,
            name: if unit == "1" { String::new() } else { unit.to_owned() },
        }
    }

    /// The unit with the prefix that suits values of this magnitude, if its first part may have a prefix: m, s, Pa, N.. and W..
    /// may have one, a power such as m² or s³ may not.
    pub fn suited(unit: &str, magnitude: f64) -> Self {
        let takes_prefix = ["m", "s", "Pa"].contains(&unit) || unit.starts_with('N') || unit.starts_with('W');
        if !takes_prefix || !magnitude.is_finite() || magnitude == 0.0 {
            return Self::plain(unit);
        }
        // a value of 999.9999 is 1 of the next unit
        let thousands = ((magnitude.abs() * (1.0 + 1e-9)).log10() / 3.0)
            .floor()
            .clamp(-4.0, 4.0);
        // nobody says kiloseconds
        let thousands = if unit == "s" || unit == "m" {
            thousands.min(0.0)
        } else {
            thousands
        };
        Self {
            factor: 10f64.powi(-3 * thousands as i32),
            name: format!("{}{unit}", PREFIXES[(thousands + 4.0) as usize]),
        }
    }

    /// ` (unit)` for labels; nothing for pure numbers.
    pub fn bracketed(&self) -> String {
        if self.name.is_empty() {
            String::new()
        } else {
            format!(" ({})", self.name)
        }
    }
}

/// A value with its unit, to five digits: `30.2 nm`.
pub fn si(value: f64, unit: &str) -> String {
    let unit = Unit::suited(unit, value);
    let text = five_digits_as_text(value * unit.factor);
    if unit.name.is_empty() {
        text
    } else {
        format!("{text} {}", unit.name)
    }
}

/// The value rounded to five digits.
pub fn five_digits(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}

/// The value without the digits that rounding errors fill.
pub fn rounded(value: f64) -> f64 {
    format!("{value:.9e}").parse().unwrap_or(value)
}

/// Five digits, without trailing zeros.
fn five_digits_as_text(value: f64) -> String {
    let five = five_digits(value);
    if five == 0.0 || (1e-3..1e6).contains(&five.abs()) || !five.is_finite() {
        five.to_string()
    } else {
        format!("{five:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prefixes_suit_the_magnitude_and_powers_have_none() {
        for (value, unit, text) in [
            (1e-9, "m", "1 nm"),
            (0.025, "m", "25 mm"),
            (12.0, "m", "12 m"),
            (5e3, "s", "5000 s"),
            (3.5094e7, "Pa", "35.094 MPa"),
            (1e-15, "m", "0.001 pm"),
            (6.12e5, "N/m²", "612 kN/m²"),
            (5.9e-6, "m²/s", "5.9e-6 m²/s"),
            (2.74e-14, "1/Pa", "2.74e-14 1/Pa"),
            (0.3, "1", "0.3"),
            (-0.5, "N/m", "-500 mN/m"),
            (0.0, "m", "0 m"),
            (1.0 / 3.0, "K", "0.33333 K"),
        ] {
            assert_eq!(si(value, unit), text);
        }
    }
}
