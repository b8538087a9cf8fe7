//! The common part of all outputs, in any format: the program's name, files that are written completely or not at all, and
//! tables of numbers.
//!
//! Owns no picture and no store, and needs neither feature. Each file knows only those before it in this order: [`whole`],
//! [`csv`], `parquet`; [`words`] knows none.

pub mod csv;
#[cfg(feature = "parquet")]
pub mod parquet;
#[cfg(test)]
pub(crate) mod samples;
pub mod whole;
pub mod words;

/// The program and its version, as outputs name it.
pub const PROGRAM: &str = concat!("tribochaos ", env!("CARGO_PKG_VERSION"));
