//! Algorithms over the model: stepping, tangent vectors, Lyapunov exponents, stroboscopic periods, statistics.
//!
//! Owns how a number is obtained from the equations of motion; knows nothing of batches, threads or devices.

pub mod drive;
pub mod reference;
pub mod rk4;
pub mod spectrum;
pub mod statistics;
pub mod stroboscope;
pub mod tangent;
pub mod taylor;
