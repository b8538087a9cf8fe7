//! The physics of the bush-shaft system, and nothing else: no integration, no threads, no GPU.
//!
//! What is evaluated at every step is generic over the number type ([`crate::lanes::Real`]) and has a twin of the same
//! name in `shaders/model/`; what is computed once per point is plain f64 on the host.

pub mod friction;
pub mod melnikov;
pub mod motion;
pub mod rubbing;
pub mod thermal_modes;
