//! The native part of the Python package: what needs the library, in the types of Python and numpy.
//!
//! Owns the passage between the two languages; computes nothing itself, and knows neither xarray nor pandas. Each file knows
//! only those before it in this list:
//!
//! - `errors`: which exception an error becomes;
//! - `pool`: threads that compute, also after a fork;
//! - `watch`: a computation that Python can follow and stop;
//! - `request`: what is asked for, put together value by value;
//! - `dataset`: results as arrays with labels;
//! - `compute`, `analyses`: runs and analyses;
//! - `tables`: parameters, quantities, devices; `shades`: the colours of maps.

#![allow(
    clippy::needless_pass_by_value,
    clippy::too_many_arguments,
    clippy::type_complexity,
    reason = "arguments and results of functions have the form in which Python passes them"
)]

mod analyses;
mod compute;
mod dataset;
mod errors;
mod pool;
mod request;
mod shades;
mod tables;
mod watch;

use std::ffi::OsString;

use pyo3::prelude::*;

/// Carries out a command line of the program, and returns its exit code.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| tribochaos::cli::main(arguments))
}

#[pymodule]
mod _native {
    #[pymodule_export]
    use super::analyses::{bifurcation, melnikov, melnikov_threshold, onset, section, trajectory};
    #[pymodule_export]
    use super::compute::{open, point, run};
    #[pymodule_export]
    use super::main;
    #[pymodule_export]
    use super::request::{Request, check_name, settings};
    #[pymodule_export]
    use super::shades::{ramp, shades};
    #[pymodule_export]
    use super::tables::{classes, devices, machine, machine_template, parameters, program, quantities};

    #[pymodule_init]
    fn init() {
        super::pool::remember_process();
    }
}
