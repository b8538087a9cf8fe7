//! The physics of the bush-shaft system, and nothing else: no integration, no threads, no GPU.
//!
//! Everything here is generic over the number type ([`crate::lanes::Real`]) and has a twin of the same name in
//! `shaders/model/`.

pub mod friction;
pub mod motion;
