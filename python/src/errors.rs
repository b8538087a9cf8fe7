//! Which Python exception an error of the library becomes.
//!
//! Owns the words: those of the library, with options as Python writes them.

use std::fmt::Display;

use pyo3::PyErr;
use pyo3::exceptions::{PyFileNotFoundError, PyOSError, PyRuntimeError, PyValueError};
use tribochaos::backend::BackendError;
use tribochaos::store::StoreError;

/// Input that cannot be carried out.
pub fn input(error: impl Display) -> PyErr {
    PyValueError::new_err(words(&error.to_string()))
}

/// A backend that cannot do what is asked, or that failed.
pub fn backend(error: &BackendError) -> PyErr {
    let text = words(&error.to_string());
    match error {
        BackendError::Unsupported(_) | BackendError::NoDevice(_) => PyValueError::new_err(text),
        _ => PyRuntimeError::new_err(text),
    }
}

/// A store that cannot be used.
pub fn store(error: &StoreError) -> PyErr {
    let text = words(&error.to_string());
    match error {
        StoreError::Missing { .. } => PyFileNotFoundError::new_err(text),
        StoreError::Write { .. }
        | StoreError::Read { .. }
        | StoreError::TakenAway { .. }
        | StoreError::NoRoom { .. } => PyOSError::new_err(text),
        _ => PyValueError::new_err(text),
    }
}

/// A text of the library: `--steps-per-period` becomes `steps_per_period`, and `--out` becomes `store`.
pub fn words(text: &str) -> String {
    let mut parts = text.split("--");
    let mut words = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let end = part
            .find(|c: char| !(c.is_ascii_lowercase() || c == '-'))
            .unwrap_or(part.len());
        let (name, rest) = part.split_at(end);
        match name.trim_end_matches('-') {
            // not an option but a dash
            "" => words += "--",
            "out" => words += "store",
            option => words += &option.replace('-', "_"),
        }
        words += &name[name.trim_end_matches('-').len()..];
        words += rest;
    }
    words
}
