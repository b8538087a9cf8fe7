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

/// A text of the library: `--steps-per-period` becomes `steps_per_period`, and `--out` becomes `store`. Commands, which stand in
/// backticks, stay as they are, and so do names with dashes in them.
pub fn words(text: &str) -> String {
    let parts = text.split('`').enumerate();
    let parts = parts.map(|(index, part)| {
        if index % 2 == 0 {
            without_dashes(part)
        } else {
            part.to_owned()
        }
    });
    parts.collect::<Vec<_>>().join("`")
}

fn without_dashes(text: &str) -> String {
    let mut words = String::new();
    let mut rest = text;
    while let Some(at) = rest.find("--") {
        let (before, option) = (&rest[..at], &rest[at + 2..]);
        let length = option
            .find(|c: char| !(c.is_ascii_lowercase() || c == '-'))
            .unwrap_or(option.len());
        let (name, after) = option.split_at(length);
        let begins = before.is_empty() || before.ends_with([' ', '(']);
        words += before;
        match name {
            "out" if begins => words += "store",
            name if begins && name.starts_with(|c: char| c.is_ascii_lowercase()) => words += &name.replace('-', "_"),
            name => {
                words += "--";
                words += name;
            }
        }
        rest = after;
    }
    words + rest
}
