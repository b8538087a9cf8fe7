//! The physics of the bush-shaft system, and nothing else: no integration, no threads, no GPU.
//!
//! The functions that are evaluated at every step are generic over the number type ([`crate::lanes::Real`]) and have a twin of
//! the same name in `shaders/model/`. The functions that are evaluated once per point are plain f64 on the host.

pub mod friction;
pub mod melnikov;
pub mod motion;
pub mod rubbing;
pub mod thermal_modes;
