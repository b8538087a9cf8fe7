//! The table of materials of the shaft, with sources.
//!
//! Owns the values; knows no formula.

use super::quantities::SiQuantity;

/// Constants of a material near room temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// The name used in files.
    pub name: &'static str,
    /// What it is.
    pub title: &'static str,
    /// E1 in Pa, nu1, alpha1 in 1/K, lambda1 in W/(m K) and a1 in m^2/s.
    pub constants: [f64; 5],
    /// Where melting begins, in K.
    pub melting_point: f64,
    /// Yield strength in Pa; where a material has none, its tensile strength.
    pub yield_strength: f64,
    /// The books and data sheets that the values are from.
    pub source: &'static str,
}

/// The quantities that a material gives, in the order of [`Material::constants`].
pub const CONSTANTS: [SiQuantity; 5] = [
    SiQuantity::YoungsModulus,
    SiQuantity::PoissonsRatio,
    SiQuantity::ThermalExpansion,
    SiQuantity::ThermalConductivity,
    SiQuantity::ThermalDiffusivity,
];

impl Material {
    /// Finds a material by its name.
    pub fn from_name(name: &str) -> Option<&'static Self> {
        MATERIALS.iter().find(|material| material.name == name)
    }

    /// The value of a quantity, if it is one that a material gives.
    pub fn constant(&self, quantity: SiQuantity) -> Option<f64> {
        let place = CONSTANTS.iter().position(|constant| *constant == quantity)?;
        Some(self.constants[place])
    }
}

/// Every material, the paper's first. A diffusivity that the source does not list is the conductivity divided by density and
/// specific heat. The expansion is the mean from 20 to about 100 °C, for brass to 200 °C. The strengths of 304, 1020, grey iron
/// and titanium are specified minima; those of copper and aluminium are typical values; that of annealed brass is the least one.
pub const MATERIALS: &[Material] = &[
    Material {
        name: "paper_steel",
        title: "steel of Awrejcewicz and Pyryev",
        constants: [190e9, 0.3, 14e-6, 21.0, 5.9e-6],
        melting_point: 1670.0,
        yield_strength: 205e6,
        source: "Awrejcewicz and Pyryev (2006), section 5; melting point and yield strength, which they do not state, are \
                 those of stainless_304",
    },
    Material {
        name: "stainless_304",
        title: "stainless steel AISI 304, annealed",
        constants: [193e9, 0.3, 17.2e-6, 14.9, 3.95e-6],
        melting_point: 1670.0,
        yield_strength: 205e6,
        source: "Callister, Materials Science and Engineering, appendix B (modulus, expansion); ASTM A213 (yield); heat and \
                 melting: Incropera and DeWitt, Fundamentals of Heat and Mass Transfer, table A.1 (300 K)",
    },
    Material {
        name: "carbon_steel_1020",
        title: "plain carbon steel AISI 1020, hot rolled",
        constants: [207e9, 0.3, 11.7e-6, 51.9, 13.6e-6],
        melting_point: 1693.0,
        yield_strength: 210e6,
        source: "Callister, appendix B (modulus, expansion, yield; 7850 kg/m³) and table 19.1 (51.9 W/(m K) and \
                 486 J/(kg K), of 1025); melting: makeitfrom.com, SAE-AISI 1020 (solidus 1420 °C)",
    },
    Material {
        name: "grey_iron",
        title: "grey cast iron SAE G3000, as cast",
        constants: [101e9, 0.26, 11.4e-6, 52.0, 17.0e-6],
        melting_point: 1426.0,
        yield_strength: 207e6,
        source: "Callister, appendix B (middle of 90 to 113 GPa; expansion; tensile strength); heat: Heat and Mass Transfer \
                 Data Book, cast iron (7272 kg/m³, 420 J/(kg K)), within the 15.6e-6 to 20.0e-6 m²/s that Hecht, Dinwiddie and \
                 Wang (1999) measured of G3000; melting: eutectic of iron and graphite, 1153 °C",
    },
    Material {
        name: "aluminium_6061",
        title: "aluminium alloy 6061-T6",
        constants: [69e9, 0.33, 23.6e-6, 167.0, 69.0e-6],
        melting_point: 855.0,
        yield_strength: 276e6,
        source: "Callister, appendix B (modulus, expansion, yield); typical values of the Aluminum Association, as MatWeb \
                 gives them (2700 kg/m³, 896 J/(kg K), solidus 582 °C)",
    },
    Material {
        name: "copper",
        title: "copper C11000, electrolytic tough pitch, hot rolled",
        constants: [115e9, 0.33, 17.0e-6, 391.0, 114e-6],
        melting_point: 1338.0,
        yield_strength: 69e6,
        source: "Callister, appendix B (modulus, expansion, yield); Hussey Copper, C11000 (391 W/(m K), 8890 kg/m³, \
                 385 J/(kg K), solidus 1065 °C)",
    },
    Material {
        name: "brass",
        title: "cartridge brass C26000, annealed",
        constants: [110e9, 0.35, 19.9e-6, 120.0, 37.5e-6],
        melting_point: 1188.0,
        yield_strength: 76e6,
        source: "Callister, appendix B (expansion) and table 19.1 (120 W/(m K), 375 J/(kg K)); Olin Brass, C26000 (modulus, \
                 8530 kg/m³); melting: Incropera and DeWitt, table A.1; yield: AZoM, article 6341 (76 MPa)",
    },
    Material {
        name: "titanium_6al_4v",
        title: "titanium alloy Ti-6Al-4V, annealed",
        constants: [114e9, 0.34, 8.6e-6, 6.7, 2.87e-6],
        melting_point: 1877.0,
        yield_strength: 830e6,
        source: "Callister, appendix B (expansion, yield); ASM data sheet MTP641 (modulus, 4430 kg/m³); heat and melting: BTI \
                 Metals, Ti-6Al-4V (6.7 W/(m K), 526 J/(kg K), solidus 1604 °C)",
    },
];
