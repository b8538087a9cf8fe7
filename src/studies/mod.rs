//! Studies made with the library; a user of the library does not call them.
//!
//! - [`benchmark`]: the cost of the kernels, and their accuracy;
//! - `paper`: the paper's figures and numbers, computed anew, and drawn.

pub mod benchmark;
#[cfg(feature = "pictures")]
pub mod paper;
