//! What is printed to standard output, and what becomes of it.
//!
//! Owns the rule that output which is lost is an error. A reader that has gone away, as `head` does, is none.

use std::fmt;
use std::io::{self, ErrorKind, Write};
use std::sync::Mutex;

/// The first failure to write.
static LOST: Mutex<Option<String>> = Mutex::new(None);

/// Prints; a failure is kept for [`lost`], since it is no reason to lose a computation.
pub fn print(text: fmt::Arguments<'_>) {
    note(io::stdout().write_fmt(text));
}

/// Why output was lost, if it was.
pub fn lost() -> Option<String> {
    note(io::stdout().flush());
    LOST.lock().ok().and_then(|lost| lost.clone())
}

/// Takes note of what became of output.
pub fn note(written: io::Result<()>) {
    if let Err(error) = written
        && error.kind() != ErrorKind::BrokenPipe
        && let Ok(mut lost) = LOST.lock()
    {
        lost.get_or_insert_with(|| error.to_string());
    }
}
