//! Analyses of the motion besides maps: orbits, bifurcation diagrams, sections, exponents over a line, thresholds, lifetimes of
//! chaos.
//!
//! Owns what is computed and in which order; integrates through [`crate::backend`] and [`crate::dynamics`] alone, and neither
//! draws nor prints.

pub mod bifurcation;
mod contour;
pub mod exponents;
pub mod lifetime;
pub mod melnikov;
pub mod onset;
pub mod orbits;
pub mod overview;
pub mod path;
pub mod section;
pub mod settling;
pub mod threshold;

use std::ops::ControlFlow;

pub use crate::dynamics::history::{History, Sample, follow, history};

/// A callback: it receives the number of instance-periods that were done since its last call, and may break the work off.
pub type Progress<'a> = dyn FnMut(u64) -> ControlFlow<()> + 'a;
