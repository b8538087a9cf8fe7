//! How instances are integrated: the stepping scheme, its steps and its tolerance, the number type.
//!
//! Owns their defaults and limits, and the step from requested to complete settings; integrates nothing.

use serde::{Deserialize, Serialize};

use super::{ExperimentError, in_range};

/// The stepping scheme.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scheme {
    /// Taylor series of order 8, in steps that end at the boundaries of the friction layer.
    Taylor,
    /// The classical Runge-Kutta scheme of order 4 with a fixed step, as in the paper.
    Rk4,
    /// Radau IIA of order 5 for frictional heat and wear, with exact heat modes. An error tolerance controls the steps; they end at
    /// the boundaries of the friction layer and where contact is lost.
    Radau,
}

impl Scheme {
    /// Every scheme, in the order in which users read of them.
    pub const ALL: [Self; 3] = [Self::Taylor, Self::Rk4, Self::Radau];

    /// The name in files and commands.
    pub fn name(self) -> &'static str {
        match self {
            Self::Taylor => "taylor",
            Self::Rk4 => "rk4",
            Self::Radau => "radau",
        }
    }

    /// The default scheme, with frictional heat or wear (`rubbed`) or without.
    pub fn suited(rubbed: bool) -> Self {
        if rubbed { Self::Radau } else { Self::Taylor }
    }

    /// Whether the scheme carries frictional heat and wear; the others hold the pressure at 1.
    pub fn carries_heat(self) -> bool {
        self == Self::Radau
    }

    /// Default number of steps in a forcing period. For rk4 it is the number of all steps; for the others it sets the longest step,
    /// and the friction layer adds further steps.
    pub fn default_steps_per_period(self) -> u32 {
        match self {
            Self::Taylor => 28,
            Self::Rk4 => 628,
            Self::Radau => 16,
        }
    }
}

/// The number type of the integration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Precision {
    /// Single precision: on a GPU or the CPU.
    F32,
    /// Double precision: on the CPU only.
    F64,
}

/// How instances are integrated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Integration {
    /// Stepping scheme.
    pub scheme: Scheme,
    /// Steps in a forcing period; for taylor and radau this sets the longest step.
    pub steps_per_period: u32,
    /// Heat modes of the shaft, besides the lumped one.
    pub modes: u32,
    /// Error that a step of radau may have. For v, its unit is 1 outside the friction layer and the layer's width inside; for
    /// the pressure, the error is relative.
    pub tolerance: f64,
    /// Steps of rk4 between two renormalisations of the tangent vectors. In addition, one renormalisation ends every period.
    pub renormalise_every: u32,
    /// Number type; None is f64 on the CPU and f32 on a GPU.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub precision: Option<Precision>,
}

/// Number of heat modes if heat is conducted as fast as in the paper's preset.
pub(super) const USUAL_MODES: u32 = 12;

/// Most heat modes: the GPU's kernels have no room for more.
pub const MAX_MODES: u32 = 64;

impl From<Scheme> for Integration {
    /// The defaults of a scheme.
    fn from(scheme: Scheme) -> Self {
        Self {
            scheme,
            steps_per_period: scheme.default_steps_per_period(),
            modes: USUAL_MODES,
            tolerance: 2e-4,
            renormalise_every: 314,
            precision: None,
        }
    }
}

impl Default for Integration {
    /// The default for a constant contact pressure.
    fn default() -> Self {
        Scheme::Taylor.into()
    }
}

impl Integration {
    /// Checks that the scheme can compute the model: with frictional heat or wear (`rubbed`), or at constant pressure.
    ///
    /// # Errors
    /// If it cannot.
    pub fn check_model(&self, rubbed: bool) -> Result<(), ExperimentError> {
        if rubbed && !self.scheme.carries_heat() {
            return Err(ExperimentError::SchemeWithoutHeat {
                scheme: self.scheme.name(),
            });
        }
        Ok(())
    }

    pub(super) fn check(&self) -> Result<(), ExperimentError> {
        // a longer step of radau has too many clock ticks to be exact in f32
        let fewest = if self.scheme == Scheme::Radau { 16.0 } else { 8.0 };
        in_range("steps_per_period", self.steps_per_period.into(), fewest, 100_000.0)?;
        in_range("modes", self.modes.into(), 1.0, MAX_MODES.into())?;
        in_range("tolerance", self.tolerance, 1e-9, 1e-2)?;
        in_range("renormalise_every", self.renormalise_every.into(), 1.0, 100_000.0)
    }
}

/// The requested integration; values that are left out are chosen to suit the experiment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct IntegrationRequest {
    /// `taylor`, `rk4` or `radau`: by default radau where there is frictional heat or wear, else taylor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scheme: Option<Scheme>,
    /// By default [`Scheme::default_steps_per_period`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps_per_period: Option<u32>,
    /// By default 12, and more where heat is conducted slowly.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub modes: Option<u32>,
    /// By default 2e-4.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// By default 314.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub renormalise_every: Option<u32>,
    /// By default `f64` on the CPU and `f32` on a GPU.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub precision: Option<Precision>,
}

impl IntegrationRequest {
    /// The integration of an experiment with frictional heat or wear (`rubbed`) or without. `enough_modes` gives the number of heat
    /// modes if the scheme computes heat and no number is requested.
    ///
    /// # Errors
    /// If the scheme cannot compute the model.
    pub(super) fn resolve(
        &self,
        rubbed: bool,
        enough_modes: impl FnOnce() -> u32,
    ) -> Result<Integration, ExperimentError> {
        let scheme = self.scheme.unwrap_or(Scheme::suited(rubbed));
        let default = Integration::from(scheme);
        let mut integration = Integration {
            scheme,
            steps_per_period: self.steps_per_period.unwrap_or(default.steps_per_period),
            modes: self.modes.unwrap_or(default.modes),
            tolerance: self.tolerance.unwrap_or(default.tolerance),
            renormalise_every: self.renormalise_every.unwrap_or(default.renormalise_every),
            precision: self.precision,
        };
        integration.check_model(rubbed)?;
        if self.modes.is_none() && scheme.carries_heat() {
            integration.modes = enough_modes();
        }
        Ok(integration)
    }
}

impl From<Integration> for IntegrationRequest {
    /// Requests every value, so that a later change of a default has no effect.
    fn from(integration: Integration) -> Self {
        Self {
            scheme: Some(integration.scheme),
            steps_per_period: Some(integration.steps_per_period),
            modes: Some(integration.modes),
            tolerance: Some(integration.tolerance),
            renormalise_every: Some(integration.renormalise_every),
            precision: integration.precision,
        }
    }
}
