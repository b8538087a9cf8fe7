//! The one table of SI quantities of a bush-shaft machine: name, symbol, unit, dimension, ranges, meaning, source.
//!
//! Owns what a quantity is called, which values it may take and which ones machines have; knows no formula.

use std::fmt;

/// A quantity of the machine in SI units.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[allow(missing_docs, reason = "the rows of the table tell what each is")]
pub enum SiQuantity {
    ShaftRadius,
    BushRadius,
    SpringFreeLength,
    SpringLength,
    RadialStiffness,
    TangentStiffness,
    TangentCubicStiffness,
    Damping,
    Inertia,
    Interference,
    YoungsModulus,
    PoissonsRatio,
    ThermalExpansion,
    ThermalConductivity,
    ThermalDiffusivity,
    HeatTransfer,
    WearCoefficient,
    WearEnergyShare,
    FrictionDry,
    FrictionLinear,
    FrictionCubic,
    ShaftSpeedMean,
    ShaftSpeedAmplitude,
    ShaftSpeedFrequency,
    Length,
}

/// What the table says of one quantity.
#[derive(Clone, Copy, Debug)]
pub struct SiQuantityInfo {
    /// The quantity that this row describes.
    pub quantity: SiQuantity,
    /// The name used in commands, files and data.
    pub name: &'static str,
    /// The symbol used in pictures.
    pub symbol: &'static str,
    /// The unit; for an extensive quantity, the unit of its value per metre of contact length.
    pub unit: &'static str,
    /// For an extensive quantity, the unit of the whole part's value, which is used if the contact length is given.
    pub whole_unit: Option<&'static str>,
    /// Exponents of metre, kilogram, second and kelvin in the unit.
    pub dimension: [i32; 4],
    /// Least and greatest admissible value, both included.
    pub range: (f64, f64),
    /// Least and greatest magnitude that is usual in machines; a value far outside causes a warning.
    pub usual: (f64, f64),
    /// Where the quantity enters: equation of Awrejcewicz and Pyryev (2006).
    pub source: &'static str,
    /// What it is, in a few words.
    pub meaning: &'static str,
}

macro_rules! quantity_table {
    ($($quantity:ident $name:literal $symbol:literal $unit:literal $whole:expr, $dimension:expr,
       $range:expr, $usual:expr, $source:literal $meaning:literal;)*) => {
        /// Every quantity, in the order in which they are listed to users.
        pub const SI_QUANTITIES: &[SiQuantityInfo] = &[$(SiQuantityInfo {
            quantity: SiQuantity::$quantity,
            name: $name,
            symbol: $symbol,
            unit: $unit,
            whole_unit: $whole,
            dimension: $dimension,
            range: $range,
            usual: $usual,
            source: $source,
            meaning: $meaning,
        }),*];
    };
}

/// The range of a part's length.
const SIZE: (f64, f64) = (1e-9, 1e4);
const ANY: (f64, f64) = (-1e18, 1e18);
const NOT_NEGATIVE: (f64, f64) = (0.0, 1e18);
const POSITIVE: (f64, f64) = (1e-18, 1e18);

quantity_table! {
    ShaftRadius "shaft_radius" "R₁" "m" None, [1, 0, 0, 0], SIZE, (1e-3, 1.0), "(2.6)"
        "radius of the shaft";
    BushRadius "bush_radius" "R₂" "m" None, [1, 0, 0, 0], SIZE, (1e-3, 2.0), "(2.6)"
        "outer radius of the bush, where the springs and the damper act";
    SpringFreeLength "spring_free_length" "l₀" "m" None, [1, 0, 0, 0], SIZE, (1e-3, 2.0), "(2.7)"
        "length of the radial springs without load";
    SpringLength "spring_length" "l₁" "m" None, [1, 0, 0, 0], SIZE, (1e-3, 2.0), "(2.7)"
        "length of the compressed radial springs at angle 0";
    RadialStiffness "radial_stiffness" "k₁" "N/m²" Some("N/m"), [-1, 1, -2, 0], POSITIVE, (1e2, 1e10), "(2.7)"
        "stiffness of the radial springs, all together";
    TangentStiffness "tangent_stiffness" "k₂" "N/m²" Some("N/m"), [-1, 1, -2, 0], NOT_NEGATIVE, (1e2, 1e10), "(2.7)"
        "linear stiffness of the tangent springs, all together";
    TangentCubicStiffness "tangent_cubic_stiffness" "k₃" "N/m⁴" Some("N/m³"), [-3, 1, -2, 0], ANY, (1e4, 1e16), "(2.6)"
        "cubic stiffness of the tangent springs, all together";
    Damping "damping" "c" "N s/m²" Some("N s/m"), [-1, 1, -1, 0], NOT_NEGATIVE, (1e-3, 1e6), "(2.6)"
        "viscous coefficient of the damper";
    Inertia "inertia" "B₂" "kg m" Some("kg m²"), [1, 1, 0, 0], POSITIVE, (1e-9, 1e4), "(2.7)"
        "moment of inertia of the bush";
    Interference "interference" "U∗" "m" None, [1, 0, 0, 0], (1e-15, 1.0), (1e-6, 1e-3), "(2.7)"
        "interference of shaft and bush, radial";
    YoungsModulus "youngs_modulus" "E₁" "Pa" None, [-1, 1, -2, 0], POSITIVE, (1e9, 1e12), "(2.7)"
        "Young's modulus of the shaft";
    PoissonsRatio "poissons_ratio" "ν₁" "1" None, [0, 0, 0, 0], (-0.99, 0.499), (0.05, 0.5), "(2.7)"
        "Poisson's ratio of the shaft";
    ThermalExpansion "thermal_expansion" "α₁" "1/K" None, [0, 0, 0, -1], (1e-12, 1.0), (1e-6, 1e-4), "(2.7)"
        "coefficient of linear thermal expansion of the shaft";
    ThermalConductivity "thermal_conductivity" "λ₁" "W/(m K)" None, [1, 1, -3, -1], POSITIVE, (0.1, 500.0), "(2.6)"
        "thermal conductivity of the shaft";
    ThermalDiffusivity "thermal_diffusivity" "a₁" "m²/s" None, [2, 0, -1, 0], (1e-12, 1.0), (5e-8, 2e-4), "(2.6)"
        "thermal diffusivity of the shaft";
    HeatTransfer "heat_transfer" "α_T" "W/(m² K)" None, [0, 1, -3, -1], POSITIVE, (1.0, 1e5), "(2.6)"
        "heat transfer coefficient from the shaft to the bush";
    WearCoefficient "wear_coefficient" "K_w" "1/Pa" None, [1, -1, 2, 0], (0.0, 1.0), (1e-18, 1e-11), "(2.6)"
        "wear for each metre of sliding and pascal of pressure";
    WearEnergyShare "wear_energy_share" "η" "1" None, [0, 0, 0, 0], (0.0, 1.0), (1e-3, 1.0), "(2.6)"
        "part of the frictional work that goes into wear, not heat";
    FrictionDry "friction_dry" "f₀" "1" None, [0, 0, 0, 0], (0.0, 1e3), (1e-3, 2.0), "(3.2)"
        "dry part of the coefficient of friction f₀ sgn V − f₁ V + f₃ V³";
    FrictionLinear "friction_linear" "f₁" "s/m" None, [-1, 0, 1, 0], ANY, (1e-3, 1e2), "(3.2)"
        "linear fall of the coefficient of friction with sliding speed V";
    FrictionCubic "friction_cubic" "f₃" "s³/m³" None, [-3, 0, 3, 0], ANY, (1e-6, 1e6), "(3.2)"
        "cubic rise of the coefficient of friction with sliding speed V";
    ShaftSpeedMean "shaft_speed_mean" "Ωₖ" "rad/s" None, [0, 0, -1, 0], (-1e9, 1e9), (1e-3, 1e4), "(2.1)"
        "mean of the shaft's speed";
    ShaftSpeedAmplitude "shaft_speed_amplitude" "Ωₐ" "rad/s" None, [0, 0, -1, 0], (0.0, 1e9), (1e-3, 1e4), "(2.1)"
        "amplitude of the shaft's speed";
    ShaftSpeedFrequency "shaft_speed_frequency" "ω′" "rad/s" None, [0, 0, -1, 0], (1e-9, 1e9), (1e-2, 1e5), "(2.1)"
        "angular frequency of the shaft's speed";
    Length "length" "L" "m" None, [1, 0, 0, 0], SIZE, (1e-3, 10.0), "(2.7)"
        "contact length, where values are those of whole parts";
}

impl SiQuantity {
    /// Number of quantities.
    pub const COUNT: usize = SI_QUANTITIES.len();

    /// The quantity's row of the table.
    pub fn info(self) -> &'static SiQuantityInfo {
        &SI_QUANTITIES[self as usize]
    }

    /// The name used in commands, files and data.
    pub fn name(self) -> &'static str {
        self.info().name
    }

    /// Finds a quantity by its name.
    pub fn from_name(name: &str) -> Option<Self> {
        SI_QUANTITIES
            .iter()
            .find(|info| info.name == name)
            .map(|info| info.quantity)
    }

    /// Whether the quantity is extensive: its value for the whole part is proportional to the contact length.
    pub fn is_extensive(self) -> bool {
        self.info().whole_unit.is_some()
    }
}

impl fmt::Display for SiQuantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::PARAMETERS;

    #[test]
    fn the_table_is_in_the_order_of_the_enum_and_its_names_are_its_own() {
        for (index, info) in SI_QUANTITIES.iter().enumerate() {
            assert_eq!(info.quantity as usize, index, "{}", info.name);
            assert_eq!(SiQuantity::from_name(info.name), Some(info.quantity));
            assert!(PARAMETERS.iter().all(|parameter| parameter.name != info.name));
            assert!(info.range.0 < info.range.1 && info.usual.0 < info.usual.1);
            assert!(info.range.0 <= info.usual.0 && info.usual.1 <= info.range.1 + 0.01);
        }
    }

    /// Exponents of the base units in a product of powers such as `N s/m²`.
    fn exponents(unit: &str) -> [i32; 4] {
        let (above, below) = unit.split_once('/').unwrap_or((unit, ""));
        let mut total = [0; 4];
        for (part, sign) in [(above, 1), (below, -1)] {
            for factor in part.trim_matches(['(', ')']).split(' ') {
                let name = factor.trim_end_matches(['²', '³', '⁴']);
                let power = match &factor[name.len()..] {
                    "²" => 2,
                    "³" => 3,
                    "⁴" => 4,
                    _ => 1,
                };
                let base = match name {
                    "m" => [1, 0, 0, 0],
                    "kg" => [0, 1, 0, 0],
                    "s" => [0, 0, 1, 0],
                    "K" => [0, 0, 0, 1],
                    "N" => [1, 1, -2, 0],
                    "Pa" => [-1, 1, -2, 0],
                    "W" => [2, 1, -3, 0],
                    "1" | "rad" | "" => [0; 4],
                    other => panic!("unknown unit {other}"),
                };
                for (sum, exponent) in total.iter_mut().zip(base) {
                    *sum += sign * power * exponent;
                }
            }
        }
        total
    }

    #[test]
    fn the_dimension_is_that_of_the_unit_and_a_whole_part_has_a_metre_more() {
        for info in SI_QUANTITIES {
            assert_eq!(exponents(info.unit), info.dimension, "{}", info.name);
            if let Some(whole) = info.whole_unit {
                let mut expected = info.dimension;
                expected[0] += 1;
                assert_eq!(exponents(whole), expected, "{}", info.name);
            }
        }
    }
}
