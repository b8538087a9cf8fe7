//! The physics, checked against what is known without this program: exact exponents, published figures, an independent
//! integrator, and relations that every correct result fulfils.

#[path = "../common/mod.rs"]
mod common;

mod classes;
mod convergence;
mod dual;
mod early;
mod edges;
mod exponents;
mod heat_modes;
mod heated_cycles;
mod lanes;
mod lifetime;
mod oracle;
mod periods;
mod rubbed;
mod statistics;
mod tangent;
mod taylor;
mod thermal_oracle;
