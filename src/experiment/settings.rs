//! The settings that, with a design, identify a result.

use serde::Serialize;

use super::{ExperimentError, Integration, Sampling, Scheme};

/// How instances are integrated, and what is sampled of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Settings {
    /// Scheme, steps, tolerance and number type.
    pub integration: Integration,
    /// Periods, initial states, and how the period of a motion is found.
    pub sampling: Sampling,
}

impl Settings {
    /// Checks that every value lies in its range.
    ///
    /// # Errors
    /// The first value that does not.
    pub fn check(&self) -> Result<(), ExperimentError> {
        self.integration.check()?;
        self.sampling.check()
    }
}

impl From<Scheme> for Settings {
    /// The defaults of a scheme.
    fn from(scheme: Scheme) -> Self {
        Self {
            integration: scheme.into(),
            ..Self::default()
        }
    }
}
