//! Numerical settings: their defaults and their limits.
//!
//! Owns what may be chosen of schemes, backends and lengths; knows nothing of axes.

use serde::{Deserialize, Serialize};

use super::ExperimentError;
use crate::parameters::Parameter;

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

impl BackendChoice {
    /// The name in files and commands.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Gpu => "gpu",
            Self::Cpu => "cpu",
        }
    }
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
    /// Heat modes of the shaft, besides the lumped one: by default 12, and more where heat is conducted slowly.
    /// [`Settings::modes`] resolves it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub modes: Option<u32>,
    /// Error of a step of radau (2e-4): of v in units of 1 outside the friction layer and of its half-width inside it, of
    /// the pressure relative.
    pub tolerance: f64,
    /// Forcing periods before the measurement (300).
    pub transient_periods: u32,
    /// The last periods of the transient, in which the tangent vectors turn to their directions (50).
    pub align_periods: u32,
    /// Measured forcing periods (250).
    pub periods: u32,
    /// Whether a point is left as soon as its motion shows what it is: an attracting cycle, by its multipliers, or chaos,
    /// by its mean growth (true). With heat or wear points are always run to their full length.
    pub decide_early: bool,
    /// Steps of rk4 between two renormalisations of the tangent vectors (314); one ends every period besides.
    pub renormalise_every: u32,
    /// Two stroboscopic states are the same where x and y differ by less (2e-4).
    pub period_tolerance: f64,
    /// The longest period of the motion that is looked for, in forcing periods (64).
    pub max_period: u32,
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
            modes: None,
            tolerance: 2e-4,
            transient_periods: 300,
            align_periods: 50,
            periods: 250,
            decide_early: true,
            renormalise_every: 314,
            period_tolerance: 2e-4,
            max_period: 64,
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

/// Heat modes where heat is conducted as fast as at the paper's preset.
pub const USUAL_MODES: u32 = 12;

/// Most heat modes: what the GPU's kernels hold.
pub const MAX_MODES: u32 = 64;

/// The longest period of the motion that can be looked for.
const LONGEST_PERIOD: u32 = 1024;

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

    /// Heat modes of the shaft, besides the lumped one. Where an experiment was resolved they are what its parameters take.
    pub fn modes(&self) -> u32 {
        self.modes.unwrap_or(USUAL_MODES)
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

    /// Whether every setting lies in its range.
    ///
    /// # Errors
    /// The first that does not.
    pub fn check(&self) -> Result<(), ExperimentError> {
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
        range("modes", self.modes().into(), 1.0, MAX_MODES.into())?;
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
        range("max_period", self.max_period.into(), 1.0, LONGEST_PERIOD.into())?;
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
