//! Studies made with the library: no part of what a user calls.
//!
//! - [`benchmark`]: points to time kernels on, and how exact they are;
//! - `paper`: the paper's figures and numbers, computed anew, and drawn.

pub mod benchmark;
#[cfg(feature = "pictures")]
pub mod paper;
