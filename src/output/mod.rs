//! What every output has in common, whatever its format: the program's name, files that are there whole or not at all, and
//! tables of numbers.
//!
//! Owns no picture and no store, and needs neither feature. In their order, each file knows those before it: [`whole`],
//! [`csv`].

pub mod csv;
#[cfg(test)]
pub(crate) mod samples;
pub mod whole;

/// The program and its version, as outputs name it.
pub const PROGRAM: &str = concat!("tribochaos ", env!("CARGO_PKG_VERSION"));
