//! The experiment: what is computed, validated and fully resolved, and its TOML form.
//!
//! Owns the numerical settings with their defaults and limits; opens no file and computes nothing.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::grid::{Axis, AxisError, Grid};
use crate::model::thermal_modes;
use crate::parameters::{PARAMETERS, Parameter, ParameterError, ParameterSet};

/// The stepping scheme.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scheme {
    /// Taylor series of order 8, in steps that end at the boundaries of the friction layer.
    Taylor,
    /// The classical Runge-Kutta scheme of order 4 with a fixed step, as in the paper.
    Rk4,
    /// Radau IIA of order 5 for frictional heat and wear: exact heat modes, steps by an error tolerance that end at the
    /// boundaries of the friction layer and where contact is lost.
    Radau,
}

impl Scheme {
    pub const ALL: [Self; 3] = [Self::Taylor, Self::Rk4, Self::Radau];

    /// The name in files and commands.
    pub fn name(self) -> &'static str {
        match self {
            Self::Taylor => "taylor",
            Self::Rk4 => "rk4",
            Self::Radau => "radau",
        }
    }

    /// Whether the scheme carries frictional heat and wear; the others hold the pressure at 1.
    pub fn carries_heat(self) -> bool {
        self == Self::Radau
    }

    /// Steps in a forcing period where none are asked for: of rk4 all, of the others the longest, to which the friction
    /// layer adds.
    pub fn default_steps_per_period(self) -> u32 {
        match self {
            Self::Taylor => 28,
            Self::Rk4 => 628,
            Self::Radau => 16,
        }
    }
}

/// Where instances are integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BackendChoice {
    /// A hardware GPU if there is one, else the CPU; never a software adapter.
    Auto,
    Gpu,
    Cpu,
}

/// The number type of the integration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Precision {
    F32,
    F64,
}

/// The box from which further initial states are drawn, uniformly.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InitialBox {
    pub x: [f64; 2],
    pub y: [f64; 2],
}

/// Numerical settings. Every field has a default; the doc of each gives it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Stepping scheme: `taylor`, `rk4` or `radau` (radau where there is frictional heat or wear, else taylor).
    /// [`Settings::for_model`] resolves it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scheme: Option<Scheme>,
    /// Steps in a forcing period: by default what suits the scheme. [`Settings::steps_per_period`] resolves it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps_per_period: Option<u32>,
    /// Heat modes of the shaft, besides the lumped one (12).
    pub modes: u32,
    /// Error of a step of radau (1e-4): of v in units of 1 outside the friction layer and of its half-width inside it, of
    /// the pressure relative.
    pub tolerance: f64,
    /// Forcing periods before the measurement (300).
    pub transient_periods: u32,
    /// The last periods of the transient, in which the tangent vectors turn to their directions (50).
    pub align_periods: u32,
    /// Measured forcing periods (250).
    pub periods: u32,
    /// Steps of rk4 between two renormalisations of the tangent vectors (314); one ends every period besides.
    pub renormalise_every: u32,
    /// Two stroboscopic states are the same where x and y differ by less (1e-4).
    pub period_tolerance: f64,
    /// Where instances are integrated: `auto`, `gpu` or `cpu` (auto).
    pub backend: BackendChoice,
    /// Number type: by default `f64` on the CPU and `f32` on a GPU.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub precision: Option<Precision>,
    /// Part of the name of the GPU adapter to use (the first suitable one).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adapter: Option<String>,
    /// Initial states for each point: (x0, y0), and others from `initial_box` (1).
    pub initial_states: u32,
    /// Box of the further initial states (x and y in -2..2).
    pub initial_box: InitialBox,
    /// Seed of the further initial states, which are the same at every point (1).
    pub seed: u32,
    /// Points recomputed on the CPU in f64 as an audit: by default 32 of a GPU map, none of a CPU map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub audit: Option<u32>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            scheme: None,
            steps_per_period: None,
            modes: 12,
            tolerance: 1e-4,
            transient_periods: 300,
            align_periods: 50,
            periods: 250,
            renormalise_every: 314,
            period_tolerance: 1e-4,
            backend: BackendChoice::Auto,
            precision: None,
            adapter: None,
            initial_states: 1,
            initial_box: InitialBox {
                x: [-2.0, 2.0],
                y: [-2.0, 2.0],
            },
            seed: 1,
            audit: None,
        }
    }
}

/// The heat has settled where the slowest mode has decayed by e to this power.
const SETTLED: f64 = 10.0;

/// Most heat modes: what the GPU's kernels hold.
pub const MAX_MODES: u32 = 64;

/// Least half-width of the friction layer in f32: below, the tangent in the layer loses all digits.
pub const MIN_EPSILON_0_F32: f64 = 1e-4;

impl Settings {
    /// The stepping scheme.
    pub fn scheme(&self) -> Scheme {
        self.scheme.unwrap_or(Scheme::Taylor)
    }

    /// Steps in a forcing period.
    pub fn steps_per_period(&self) -> u32 {
        self.steps_per_period
            .unwrap_or_else(|| self.scheme().default_steps_per_period())
    }

    /// The settings with the scheme and its steps written out, so that a later default changes nothing, for instances
    /// with frictional heat or wear (`rubbed`) or without.
    ///
    /// # Errors
    /// If a scheme was asked for that does not carry heat and wear where there are some.
    pub fn for_model(&self, rubbed: bool) -> Result<Self, ExperimentError> {
        let scheme = match self.scheme {
            Some(scheme) if rubbed && !scheme.carries_heat() => {
                return Err(ExperimentError::SchemeWithoutHeat { scheme: scheme.name() });
            }
            Some(scheme) => scheme,
            None if rubbed => Scheme::Radau,
            None => Scheme::Taylor,
        };
        let steps_per_period = self.steps_per_period.unwrap_or(scheme.default_steps_per_period());
        Ok(Self {
            scheme: Some(scheme),
            steps_per_period: Some(steps_per_period),
            ..self.clone()
        })
    }

    fn check(&self) -> Result<(), ExperimentError> {
        let range = |name: &'static str, value: f64, min: f64, max: f64| {
            if (min..=max).contains(&value) {
                Ok(())
            } else {
                Err(ExperimentError::Setting { name, value, min, max })
            }
        };
        // the clock of radau holds no longer steps in f32
        let fewest = if self.scheme() == Scheme::Radau { 16.0 } else { 8.0 };
        range("steps_per_period", self.steps_per_period().into(), fewest, 100_000.0)?;
        range("modes", self.modes.into(), 1.0, MAX_MODES.into())?;
        range("tolerance", self.tolerance, 1e-9, 1e-2)?;
        range("transient_periods", self.transient_periods.into(), 0.0, 1e7)?;
        range(
            "align_periods",
            self.align_periods.into(),
            0.0,
            self.transient_periods.into(),
        )?;
        range("periods", self.periods.into(), 16.0, 1e7)?;
        range("renormalise_every", self.renormalise_every.into(), 1.0, 100_000.0)?;
        range("period_tolerance", self.period_tolerance, 1e-12, 0.1)?;
        range("initial_states", self.initial_states.into(), 1.0, 10_000.0)?;
        for (parameter, [low, high]) in [(Parameter::X0, self.initial_box.x), (Parameter::Y0, self.initial_box.y)] {
            parameter.check(low)?;
            parameter.check(high)?;
            if low > high {
                return Err(ExperimentError::InitialBox {
                    name: parameter.name(),
                    low,
                    high,
                });
            }
        }
        if self.precision == Some(Precision::F64) && self.backend == BackendChoice::Gpu {
            return Err(ExperimentError::GpuF64);
        }
        Ok(())
    }
}

/// A set of values by name, which a request starts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// Section 5 of the paper. It leaves out biot, omega_tilde, the fit and the initial state: these are reconstructed, as
    /// the values with which the paper's figures come out.
    Paper,
}

impl Preset {
    pub fn from_name(name: &str) -> Option<Self> {
        (name == "paper").then_some(Self::Paper)
    }

    /// The default parameters with the preset's values.
    pub fn parameters(self) -> ParameterSet {
        let mut set = ParameterSet::default();
        for &(parameter, value) in self.values() {
            set[parameter] = value;
        }
        set
    }

    pub fn values(self) -> &'static [(Parameter, f64)] {
        match self {
            Self::Paper => &[
                (Parameter::H1, 0.5),
                (Parameter::Gamma, 1.87),
                (Parameter::KW, 0.01),
                (Parameter::Biot, 10.0),
                (Parameter::OmegaTilde, 0.1),
                (Parameter::RampRate, f64::INFINITY),
                (Parameter::X0, 0.0),
                (Parameter::Y0, 0.0),
            ],
        }
    }
}

/// A request as it is written in a file: everything may be left out. [`Request::resolve`] makes it an
/// [`Experiment`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Request {
    /// Where results go: the path all output names begin with. Not part of the experiment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub out: Option<PathBuf>,
    /// Horizontal axis (zeta_k = 0..12, 300 values).
    pub x: Axis,
    /// Vertical axis (h1 = 0..2, 201 values).
    pub y: Axis,
    /// Values of parameters that are no axis.
    #[serde(deserialize_with = "named_values")]
    pub set: BTreeMap<String, f64>,
    pub settings: Settings,
}

/// Parameter names are checked here, so that a misspelt one is reported with a suggestion.
fn named_values<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<BTreeMap<String, f64>, D::Error> {
    let values = BTreeMap::<String, f64>::deserialize(deserializer)?;
    for name in values.keys() {
        Parameter::from_name(name).map_err(serde::de::Error::custom)?;
    }
    Ok(values)
}

impl Default for Request {
    fn default() -> Self {
        Self {
            out: None,
            x: Axis {
                parameter: Parameter::ZetaK,
                start: 0.0,
                stop: 12.0,
                count: 300,
            },
            y: Axis {
                parameter: Parameter::H1,
                start: 0.0,
                stop: 2.0,
                count: 201,
            },
            set: BTreeMap::new(),
            settings: Settings::default(),
        }
    }
}

impl Request {
    /// # Errors
    /// If the text is no TOML, has an unknown key, or a value of the wrong type.
    pub fn from_toml(text: &str) -> Result<Self, ExperimentError> {
        Ok(toml::from_str(text)?)
    }

    /// The map that the request asks for.
    ///
    /// # Errors
    /// If a value is out of its range, the axes are the same parameter, or a set parameter is an axis.
    pub fn resolve(&self) -> Result<Experiment, ExperimentError> {
        for axis in [&self.x, &self.y] {
            axis.check()?;
        }
        if self.x.parameter == self.y.parameter {
            return Err(ExperimentError::SameAxes {
                name: self.x.parameter.name(),
            });
        }
        self.resolve_over(vec![self.x, self.y])
    }

    /// The one point that the request's `set` names; its axes are left aside.
    ///
    /// # Errors
    /// As [`Request::resolve`].
    pub fn resolve_point(&self) -> Result<Experiment, ExperimentError> {
        self.resolve_over(Vec::new())
    }

    /// The points over any axes, which must have been checked; the request's own are left aside.
    ///
    /// # Errors
    /// As [`Request::resolve`].
    pub fn resolve_over(&self, axes: Vec<Axis>) -> Result<Experiment, ExperimentError> {
        let mut fixed = ParameterSet::default();
        for (name, &value) in &self.set {
            let parameter = Parameter::from_name(name)?;
            if axes.iter().any(|axis| axis.parameter == parameter) {
                return Err(ExperimentError::SetAxis { name: parameter.name() });
            }
            parameter.check(value)?;
            fixed[parameter] = value;
        }
        let mut experiment = Experiment {
            grid: Grid { axes, fixed },
            settings: self.settings.clone(),
        };
        experiment.settings = self.settings.for_model(experiment.is_rubbed())?;
        experiment.settings.check()?;
        if experiment.settings.precision == Some(Precision::F32) || experiment.settings.backend == BackendChoice::Gpu {
            experiment.check_f32()?;
        }
        Ok(experiment)
    }
}

/// A validated, fully resolved experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    pub grid: Grid,
    pub settings: Settings,
}

impl Experiment {
    /// The parameters that are not an axis, in the table's order.
    pub fn fixed_parameters(&self) -> impl Iterator<Item = (Parameter, f64)> + '_ {
        PARAMETERS
            .iter()
            .map(|info| info.parameter)
            .filter(|parameter| self.grid.axes.iter().all(|axis| axis.parameter != *parameter))
            .map(|parameter| (parameter, self.grid.fixed[parameter]))
    }

    /// Least and greatest value of a parameter over the grid.
    pub fn extent(&self, parameter: Parameter) -> (f64, f64) {
        match self.grid.axes.iter().find(|axis| axis.parameter == parameter) {
            Some(axis) => (axis.start.min(axis.stop), axis.start.max(axis.stop)),
            None => (self.grid.fixed[parameter], self.grid.fixed[parameter]),
        }
    }

    /// Whether there is frictional heat or wear anywhere in the grid: the pressure is then no constant.
    pub fn is_rubbed(&self) -> bool {
        self.extent(Parameter::Gamma).1 > 0.0 || self.extent(Parameter::KW).1 > 0.0
    }

    /// Whether the contact wears anywhere in the grid.
    pub fn wears(&self) -> bool {
        self.extent(Parameter::KW).1 > 0.0
    }

    /// Whether f32 can carry the experiment.
    ///
    /// # Errors
    /// If the friction layer is thinner than [`MIN_EPSILON_0_F32`] somewhere in the grid.
    pub fn check_f32(&self) -> Result<(), ExperimentError> {
        let value = self.extent(Parameter::Epsilon0).0;
        if value < MIN_EPSILON_0_F32 {
            return Err(ExperimentError::LayerTooThinForF32 { value });
        }
        Ok(())
    }

    /// What the user should know before a long run, each a sentence.
    pub fn warnings(&self) -> Vec<String> {
        match self.settings.scheme() {
            // its steps shorten themselves, and where they cannot, the point is under-resolved
            Scheme::Taylor => Vec::new(),
            Scheme::Rk4 => self.fixed_step_warnings(),
            Scheme::Radau => self.settling_warning().into_iter().collect(),
        }
    }

    fn fixed_step_warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        let steps_per_period = self.settings.steps_per_period();
        // RK4 is stable where (decay rate)*(step) is below 2.785; the layer's decay rate is eps*F0*2/eps0.
        let rate =
            self.extent(Parameter::Epsilon).1 * self.extent(Parameter::F0).1 * 2.0 / self.extent(Parameter::Epsilon0).0;
        let step = TAU / (self.extent(Parameter::Omega0).0 * f64::from(steps_per_period));
        if rate * step > 2.785 {
            let enough = (f64::from(steps_per_period) * rate * step / 2.0).ceil();
            warnings.push(format!(
                "the step is too long for the friction layer (rate {rate:.3} x step {step:.3e} is above 2.785, RK4's \
                 limit of stability): sticking will be wrong; use --steps-per-period {enough} or more"
            ));
        }
        // between two renormalisations the second tangent vector shrinks against the first by up to this exponent
        let every = self.settings.renormalise_every.min(steps_per_period);
        let shrinkage = rate * step * f64::from(every);
        let digits = match self.settings.precision {
            Some(Precision::F64) => -f64::EPSILON.ln(),
            Some(Precision::F32) | None => -f64::from(f32::EPSILON).ln(),
        };
        if shrinkage > digits {
            let enough = (f64::from(every) * 0.5 * digits / shrinkage).floor().max(1.0);
            warnings.push(format!(
                "between two renormalisations the friction layer may turn both tangent vectors into one direction, and the \
                 second exponent is lost: use --renormalise-every {enough}"
            ));
        }
        warnings
    }

    /// Whether the transient is long enough for the shaft to warm through where its heat is to reach a steady state: without
    /// wear. The slowest heat mode decays at the rate mu_1^2 omega-tilde.
    fn settling_warning(&self) -> Option<String> {
        if self.extent(Parameter::Gamma).1 == 0.0 || self.extent(Parameter::KW).0 > 0.0 {
            return None;
        }
        let (biot, omega_tilde) = (self.extent(Parameter::Biot).0, self.extent(Parameter::OmegaTilde).0);
        let slowest = thermal_modes::roots(biot, 1)[0].powi(2) * omega_tilde;
        let period = TAU / self.extent(Parameter::Omega0).1;
        let transient = f64::from(self.settings.transient_periods) * period;
        (slowest * transient < SETTLED).then(|| {
            let enough = (SETTLED / (slowest * period)).ceil();
            format!(
                "the shaft warms through in about {:.3} tau (1/(mu_1^2 omega_tilde), at biot = {biot} and omega_tilde = \
                 {omega_tilde}), and the transient of {transient:.4} tau is too short for its heat to settle: use \
                 --transient-periods {enough} or more",
                1.0 / slowest
            )
        })
    }

    /// The experiment as TOML; [`Request::from_toml`] reads it back. Only maps have a file form.
    ///
    /// # Panics
    /// If the experiment has not two axes.
    pub fn to_toml(&self) -> String {
        let [x, y] = self.grid.axes[..] else {
            panic!("an experiment file describes two axes")
        };
        let request = Request {
            out: None,
            x,
            y,
            set: self
                .fixed_parameters()
                .map(|(parameter, value)| (parameter.name().to_owned(), value))
                .collect(),
            settings: self.settings.clone(),
        };
        toml::to_string(&request).expect("a request has a TOML form")
    }
}

#[derive(Debug, thiserror::Error)]
pub enum ExperimentError {
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    #[error(transparent)]
    Axis(#[from] AxisError),
    #[error("{name} = {value} is out of range: it must be from {min} to {max}")]
    Setting {
        name: &'static str,
        value: f64,
        min: f64,
        max: f64,
    },
    #[error("the initial box of {name} runs from {low} down to {high}: give the lower end first")]
    InitialBox { name: &'static str, low: f64, high: f64 },
    #[error("both axes are {name}: give x and y different parameters")]
    SameAxes { name: &'static str },
    #[error("{name} is an axis and set to a value as well: leave one of the two out")]
    SetAxis { name: &'static str },
    #[error(
        "the scheme {scheme} holds the contact pressure at 1 and knows neither frictional heat nor wear: leave --scheme out, \
         or set gamma = 0 and k_w = 0"
    )]
    SchemeWithoutHeat { scheme: &'static str },
    #[error("a GPU integrates in f32: leave --precision f64 out, or use --backend cpu")]
    GpuF64,
    #[error(
        "epsilon_0 = {value} is too thin a friction layer for f32 (least: {MIN_EPSILON_0_F32}): \
         use --backend cpu --precision f64"
    )]
    LayerTooThinForF32 { value: f64 },
    #[error("no experiment in TOML: {0}")]
    Toml(#[from] toml::de::Error),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_experiment_survives_its_toml_form() {
        let mut request = Request::default();
        request.set.insert("omega_0".into(), 1.0 / 3.0);
        request.settings.adapter = Some("llvmpipe".into());
        let experiment = request.resolve().unwrap();
        let again = Request::from_toml(&experiment.to_toml()).unwrap().resolve().unwrap();
        assert_eq!(again, experiment);
    }

    #[test]
    fn the_default_number_of_steps_is_the_scheme_s() {
        let mut request = Request::default();
        let steps = |request: &Request| {
            let settings = request.resolve().unwrap().settings;
            (settings.scheme.unwrap(), settings.steps_per_period.unwrap())
        };
        assert_eq!(
            steps(&request),
            (Scheme::Taylor, Scheme::Taylor.default_steps_per_period())
        );
        request.settings.scheme = Some(Scheme::Rk4);
        assert_eq!(steps(&request), (Scheme::Rk4, 628));
        request.settings.steps_per_period = Some(100);
        assert_eq!(steps(&request), (Scheme::Rk4, 100));
    }

    #[test]
    fn names_of_schemes_are_those_in_files() {
        for scheme in Scheme::ALL {
            assert_eq!(serde_json::to_value(scheme).unwrap(), scheme.name());
        }
    }

    #[test]
    fn an_empty_file_is_the_default_experiment() {
        assert_eq!(Request::from_toml("").unwrap(), Request::default());
    }

    #[test]
    fn bad_requests_are_refused_with_a_reason() {
        for (toml, reason) in [
            ("stepz = 3", "unknown field"),
            ("[settings]\nsteps = 3", "unknown field"),
            ("[set]\nzetak = 3", "did you mean `zeta_k`"),
            ("[set]\nzeta_k = 3", "leave one of the two out"),
            ("[set]\nb = nan", "out of range"),
            ("[settings]\nsteps_per_period = 7", "from 8"),
            ("[settings]\nperiods = 0", "from 16"),
            ("[settings]\nalign_periods = 500", "from 0 to 300"),
            ("[settings]\nbackend = \"gpu\"\nprecision = \"f64\"", "f32"),
            ("[settings]\nbackend = \"gpu\"\n[set]\nepsilon_0 = 1e-5", "too thin"),
            ("[settings]\nscheme = \"euler\"", "rk4"),
            (
                "[y]\nparameter = \"zeta_k\"\nstart = 0\nstop = 1\ncount = 5",
                "different parameters",
            ),
            ("[settings.initial_box]\nx = [1, -1]\ny = [0, 1]", "lower end first"),
        ] {
            let message = Request::from_toml(toml)
                .and_then(|request| request.resolve())
                .unwrap_err()
                .to_string();
            assert!(message.contains(reason), "{toml}: {message}");
        }
    }

    #[test]
    fn steps_and_renormalisations_too_far_apart_for_the_layer_are_warned_of() {
        let mut request = Request::default();
        request.settings.scheme = Some(Scheme::Rk4);
        assert!(request.resolve().unwrap().warnings().is_empty());
        request.set.insert("epsilon_0".into(), 1e-5);
        let warnings = request.resolve().unwrap().warnings();
        assert!(warnings[0].contains("--steps-per-period"));
        assert!(warnings[1].contains("--renormalise-every"));
        request.settings.scheme = None;
        assert!(request.resolve().unwrap().warnings().is_empty());
    }
}
