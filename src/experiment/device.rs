//! The device that computes an experiment, and how the results are checked. Neither of them identifies a result.
//!
//! Owns the names of these choices; chooses nothing.

use serde::{Deserialize, Serialize};

/// Where instances are integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BackendChoice {
    /// A hardware GPU if there is one, else the CPU; never a software adapter.
    Auto,
    /// A GPU; a software adapter counts as one. Without a GPU the experiment fails.
    Gpu,
    /// The CPU, even if there is a GPU.
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

/// The device that computes an experiment.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Device {
    /// `auto`, `gpu` or `cpu` (auto).
    pub backend: BackendChoice,
    /// Part of the name of the GPU adapter to use (the first suitable one).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adapter: Option<String>,
}

impl Default for Device {
    fn default() -> Self {
        Self {
            backend: BackendChoice::Auto,
            adapter: None,
        }
    }
}

/// How an experiment is checked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Checking {
    /// Points that are computed again on the CPU in f64: by default 32 of a GPU map, none of a CPU map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub audit: Option<u32>,
}
