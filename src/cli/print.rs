//! Prints to standard output, and records failures to write.
//!
//! Owns the rule that lost output is an error. A reader that closes the pipe early, as `head` does, is no error.

use std::fmt;
use std::io::{self, ErrorKind, Write};
use std::sync::Mutex;

/// The first failure to write.
static LOST: Mutex<Option<String>> = Mutex::new(None);

/// Prints. A failure to write does not stop the computation: it is recorded, and [`lost`] returns it later.
pub fn print(text: fmt::Arguments<'_>) {
    note(io::stdout().write_fmt(text));
}

/// Why output was lost, if it was.
pub fn lost() -> Option<String> {
    note(io::stdout().flush());
    LOST.lock().ok().and_then(|lost| lost.clone())
}

/// Records a failure to write; a pipe that its reader has closed is no failure.
pub fn note(written: io::Result<()>) {
    if let Err(error) = written
        && error.kind() != ErrorKind::BrokenPipe
        && let Ok(mut lost) = LOST.lock()
    {
        lost.get_or_insert_with(|| error.to_string());
    }
}
