//! The one table of model parameters: name, symbol, default, range, meaning, source.
//!
//! Owns what a parameter is called and which values it may take; knows nothing of axes, files or numerics.

use std::fmt;
use std::ops::{Index, IndexMut};

use serde::{Deserialize, Serialize};

/// A dimensionless parameter of the bush-shaft system, or a component of its initial state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs, reason = "the rows of the table tell what each is")]
pub enum Parameter {
    ZetaK,
    H1,
    #[serde(rename = "omega_0")]
    Omega0,
    OmegaK,
    B,
    Epsilon,
    #[serde(rename = "f_0")]
    F0,
    Alpha,
    Beta,
    #[serde(rename = "epsilon_0")]
    Epsilon0,
    Gamma,
    KW,
    Biot,
    OmegaTilde,
    RampRate,
    X0,
    Y0,
}

/// What the table says of one parameter.
#[derive(Clone, Copy, Debug)]
pub struct ParameterInfo {
    /// The parameter that this row describes.
    pub parameter: Parameter,
    /// The name used in commands, files and data.
    pub name: &'static str,
    /// The symbol used in pictures.
    pub symbol: &'static str,
    /// The value where none is set.
    pub default: f64,
    /// Least and greatest admissible value, both included.
    pub range: (f64, f64),
    /// What it is, in a few words.
    pub meaning: &'static str,
    /// Where the parameter enters: equation of Awrejcewicz and Pyryev (2006).
    pub source: &'static str,
}

macro_rules! parameter_table {
    ($($parameter:ident $name:literal $symbol:literal $default:expr, [$min:expr, $max:expr], $source:literal $meaning:literal;)*) => {
        /// Every parameter, in the order in which they are listed to users.
        pub const PARAMETERS: &[ParameterInfo] = &[$(ParameterInfo {
            parameter: Parameter::$parameter,
            name: $name,
            symbol: $symbol,
            default: $default,
            range: ($min, $max),
            meaning: $meaning,
            source: $source,
        }),*];
    };
}

parameter_table! {
    ZetaK    "zeta_k"    "ζₖ" 3.9, [0.0, 1000.0],     "(2.1)" "amplitude of the shaft's speed";
    H1       "h1"        "h₁" 0.5, [-1000.0, 1000.0], "(3.2)" "viscous damping of the bush, 2h/epsilon";
    Omega0   "omega_0"   "ω₀" 2.0, [1e-3, 1000.0],    "(3.2)" "frequency of the shaft's speed";
    OmegaK   "omega_k"   "ωₖ" 0.4, [-1000.0, 1000.0], "(2.1)" "mean speed of the shaft";
    B        "b"         "b"  1.0, [-1000.0, 1000.0], "(2.1)" "cubic stiffness of the springs";
    Epsilon  "epsilon"   "ε"  0.1, [0.0, 1000.0],     "(2.1)" "strength of the friction, and of the damping epsilon h1";
    F0       "f_0"       "F₀" 0.3, [0.0, 1000.0],     "(3.2)" "dry part of the kinetic friction";
    Alpha    "alpha"     "α"  0.3, [-1000.0, 1000.0], "(3.2)" "linear fall of the friction with sliding speed";
    Beta     "beta"      "β"  0.3, [-1000.0, 1000.0], "(3.2)" "cubic rise of the friction with sliding speed";
    Epsilon0 "epsilon_0" "ε₀" 0.01, [1e-9, 10.0],      "(3.1)" "half-width of the regularised friction layer";
    Gamma    "gamma"    "γ" 0.0, [0.0, 1e6], "(2.6)" "frictional heating (1.87 for the paper's steel)";
    KW       "k_w"      "k_w" 0.0, [0.0, 1e6], "(2.3)" "wear coefficient";
    Biot     "biot"     "Bi" 10.0, [1e-4, 1e4], "(2.5)" "Biot number: cooling of the shaft at its surface";
    OmegaTilde "omega_tilde" "ω̃" 0.1, [1e-6, 1e6], "(2.6)" "rate of heat conduction in the shaft, the ratio of time scales";
    RampRate "ramp_rate" "δ" f64::INFINITY, [1e-12, f64::INFINITY], "(2.2)" "growth of the fit h_U = 1 - exp(-ramp_rate tau^2); inf for no ramp";
    X0       "x0"        "x₀" 0.1, [-100.0, 100.0],   "(2.1)" "initial angle of the bush";
    Y0       "y0"        "y₀" 0.0, [-100.0, 100.0],   "(2.1)" "initial angular speed of the bush";
}

impl Parameter {
    /// Number of parameters.
    pub const COUNT: usize = PARAMETERS.len();

    /// The parameter's row of the table.
    pub fn info(self) -> &'static ParameterInfo {
        &PARAMETERS[self as usize]
    }

    /// The name used in commands, files and data.
    pub fn name(self) -> &'static str {
        self.info().name
    }

    /// Finds a parameter by its name.
    ///
    /// # Errors
    /// [`ParameterError::Unknown`] with the nearest known name, if one is near.
    pub fn from_name(name: &str) -> Result<Self, ParameterError> {
        if let Some(info) = PARAMETERS.iter().find(|info| info.name == name) {
            return Ok(info.parameter);
        }
        Err(ParameterError::Unknown {
            name: name.to_owned(),
            suggestion: nearest(name, PARAMETERS.iter().map(|info| info.name)),
        })
    }

    /// Checks that the parameter may take `value`.
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`], also for NaN and infinities.
    pub fn check(self, value: f64) -> Result<(), ParameterError> {
        let (min, max) = self.info().range;
        if (min..=max).contains(&value) {
            Ok(())
        } else {
            Err(ParameterError::OutOfRange {
                name: self.name(),
                value,
                min,
                max,
            })
        }
    }
}

/// The known name that a typed name probably stands for; None if no known name is similar.
pub(crate) fn nearest(typed: &str, known: impl Iterator<Item = &'static str>) -> Option<&'static str> {
    let typed = typed.to_lowercase();
    known
        .map(|known| (strsim::jaro_winkler(&typed, known), known))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|(similarity, _)| *similarity > 0.8)
        .map(|(_, near)| near)
}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A value for every parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterSet([f64; Parameter::COUNT]);

impl Default for ParameterSet {
    fn default() -> Self {
        let mut values = [0.0; Parameter::COUNT];
        for info in PARAMETERS {
            values[info.parameter as usize] = info.default;
        }
        Self(values)
    }
}

impl ParameterSet {
    /// The set with one value replaced (not checked against the range).
    #[must_use]
    pub fn with(mut self, parameter: Parameter, value: f64) -> Self {
        self[parameter] = value;
        self
    }

    /// The set with the initial state (x0, y0).
    #[must_use]
    pub fn with_initial_state(self, [x, y]: [f64; 2]) -> Self {
        self.with(Parameter::X0, x).with(Parameter::Y0, y)
    }

    /// (x0, y0).
    pub fn initial_state(&self) -> [f64; 2] {
        [self[Parameter::X0], self[Parameter::Y0]]
    }
}

impl ParameterSet {
    /// Whether friction heats the shaft or wears it: the contact pressure is then not constant.
    pub fn has_heat_or_wear(&self) -> bool {
        self[Parameter::Gamma] > 0.0 || self[Parameter::KW] > 0.0
    }

    /// Whether the contact wears. The motion is then always transient, and its exponent is one of finite time.
    pub fn wears(&self) -> bool {
        self[Parameter::KW] > 0.0
    }

    /// Whether friction heats the shaft and nothing wears: the motion lasts, and the heat modes are a part of its state.
    pub fn is_heated(&self) -> bool {
        self.has_heat_or_wear() && !self.wears()
    }

    /// Whether the shaft's varying speed acts on the bush. If not, the system is autonomous, and nothing depends on omega_0.
    pub fn is_driven(&self) -> bool {
        use Parameter::{Alpha, Beta, Epsilon, F0, ZetaK};
        let rubs = [F0, Alpha, Beta].into_iter().any(|parameter| self[parameter] != 0.0);
        rubs && self[Epsilon] != 0.0 && self[ZetaK] != 0.0
    }

    /// The period of the drive in units of tau, 2 pi/omega_0.
    pub fn forcing_period(&self) -> f64 {
        std::f64::consts::TAU / self[Parameter::Omega0]
    }
}

impl Index<Parameter> for ParameterSet {
    type Output = f64;
    fn index(&self, parameter: Parameter) -> &f64 {
        &self.0[parameter as usize]
    }
}

impl IndexMut<Parameter> for ParameterSet {
    fn index_mut(&mut self, parameter: Parameter) -> &mut f64 {
        &mut self.0[parameter as usize]
    }
}

/// Why a name is not a parameter, or a number is not an admissible value of one.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages tell what each is")]
pub enum ParameterError {
    #[error(
        "unknown parameter `{name}`{}; `tribochaos map --help` lists the parameters, `tribochaos machine --help` the \
         quantities of a machine",
        suggestion.map(|near| format!(": did you mean `{near}`?")).unwrap_or_default()
    )]
    Unknown {
        name: String,
        suggestion: Option<&'static str>,
    },
    #[error(
        "{name} = {value} is out of range: it must be a number from {min} to {max}{}",
        if *max == f64::INFINITY { "; leave it out for none" } else { "" }
    )]
    OutOfRange {
        name: &'static str,
        value: f64,
        min: f64,
        max: f64,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_the_order_of_the_enum_and_agrees_with_the_file_names() {
        for (index, info) in PARAMETERS.iter().enumerate() {
            assert_eq!(info.parameter as usize, index, "{}", info.name);
            assert_eq!(serde_json::to_value(info.parameter).unwrap(), info.name);
            assert_eq!(Parameter::from_name(info.name), Ok(info.parameter));
            info.parameter.check(info.default).unwrap();
        }
    }

    #[test]
    fn near_misses_are_suggested_and_strangers_are_not() {
        let unknown = |name| Parameter::from_name(name).unwrap_err().to_string();
        assert!(unknown("zetak").contains("did you mean `zeta_k`?"));
        assert!(unknown("epsilon0").contains("did you mean `epsilon_0`?"));
        assert!(unknown("H1").contains("did you mean `h1`?"));
        assert!(!unknown("temperature").contains("did you mean"));
    }

    #[test]
    fn values_that_are_no_numbers_or_out_of_range_are_refused() {
        for value in [f64::NAN, f64::INFINITY, 0.0, -1.0] {
            assert!(Parameter::Epsilon0.check(value).is_err());
        }
        assert!(Parameter::H1.check(-0.8).is_ok());
    }
}
