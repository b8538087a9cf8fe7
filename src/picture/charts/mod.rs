//! Panels of the analyses: which layers, words and colours each has.
//!
//! Neither computes a result nor places a panel. Each file draws one kind of result and knows none of the others; all know
//! `shared`.

mod border;
mod exponents;
pub mod histories;
mod melnikov;
mod overview;
mod shared;
mod states;
pub mod survival;

pub use self::border::border_planes;
pub use self::exponents::exponents;
pub use self::melnikov::{melnikov, threshold};
pub use self::overview::{pairs, shares};
pub use self::shared::{Ends, MOST_CURVES};
pub use self::states::{Component, bifurcation, outside, phase, section};
pub use super::caption::start;
pub use crate::machine::units::rounded;
