//! Algorithms over the model: stepping, tangent vectors, Lyapunov exponents, stroboscopic periods, statistics.
//!
//! Owns how a number is obtained from the equations of motion; knows nothing of batches, threads or devices.

pub mod adaptive;
pub mod decay;
pub mod dense;
pub mod divergence_check;
pub mod drive;
pub mod floquet;
pub mod history;
pub mod matrix;
pub mod radau;
pub mod reference;
pub mod rk4;
pub mod spectrum;
pub mod statistics;
pub mod stroboscope;
pub mod tangent;
pub mod taylor;
