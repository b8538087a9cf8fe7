//! What is sampled of each point: how long, from which initial states, and how the period of the motion is found.
//!
//! Owns the defaults and limits of these; measures nothing.

use serde::{Deserialize, Serialize};

use super::{ExperimentError, in_range};
use crate::parameters::Parameter;

/// The box from which further initial states are drawn, uniformly.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InitialBox {
    /// Least and greatest angle.
    pub x: [f64; 2],
    /// Least and greatest angular speed.
    pub y: [f64; 2],
}

/// What is sampled of each point. The default of every field is in parentheses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sampling {
    /// Forcing periods before the measurement (300).
    pub transient_periods: u32,
    /// The last periods of the transient, in which the tangent vectors turn to their directions (50).
    pub align_periods: u32,
    /// Measured forcing periods (250).
    pub periods: u32,
    /// Whether the run of a point ends as soon as the kind of its motion is clear: an attracting cycle by its multipliers, chaos by
    /// its mean growth (true). With wear every point runs to its full length.
    pub decide_early: bool,
    /// Two stroboscopic states count as equal if both x and y differ by less than this (2e-4).
    pub period_tolerance: f64,
    /// The longest period of the motion that is looked for, in forcing periods (64).
    pub max_period: u32,
    /// Number of initial states for each point: first (x0, y0), then others from `initial_box` (1).
    pub initial_states: u32,
    /// Box of the further initial states (x and y in -2..2).
    pub initial_box: InitialBox,
    /// Seed of the further initial states, which are the same at every point (1).
    pub seed: u32,
}

impl Default for Sampling {
    fn default() -> Self {
        Self {
            transient_periods: 300,
            align_periods: 50,
            periods: 250,
            decide_early: true,
            period_tolerance: 2e-4,
            max_period: 64,
            initial_states: 1,
            initial_box: InitialBox {
                x: [-2.0, 2.0],
                y: [-2.0, 2.0],
            },
            seed: 1,
        }
    }
}

/// The longest period of the motion that can be looked for.
const LONGEST_PERIOD: u32 = 1024;

impl Sampling {
    /// Fewest measured forcing periods.
    pub const LEAST_PERIODS: u32 = 16;

    /// Checks that every value lies in its range.
    ///
    /// # Errors
    /// The first value that does not.
    pub(super) fn check(&self) -> Result<(), ExperimentError> {
        in_range("transient_periods", self.transient_periods.into(), 0.0, 1e7)?;
        in_range(
            "align_periods",
            self.align_periods.into(),
            0.0,
            self.transient_periods.into(),
        )?;
        in_range("periods", self.periods.into(), Self::LEAST_PERIODS.into(), 1e7)?;
        in_range("period_tolerance", self.period_tolerance, 1e-12, 0.1)?;
        in_range("max_period", self.max_period.into(), 1.0, LONGEST_PERIOD.into())?;
        in_range("initial_states", self.initial_states.into(), 1.0, 10_000.0)?;
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
        Ok(())
    }
}
