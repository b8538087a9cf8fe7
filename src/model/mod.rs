//! The physics of the bush-shaft system, and nothing else: no integration, no threads, no GPU.
//!
//! The equations of motion are generic over the number type ([`crate::lanes::Real`]) and have twins of the same names in
//! `shaders/model/`; Mel'nikov's function is evaluated in f64 alone.

pub mod friction;
pub mod melnikov;
pub mod motion;
