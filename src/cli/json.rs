//! Results as JSON.

use clap::Args;
use serde_json::Value;

/// Results for programs.
#[derive(Args, Clone, Copy)]
pub struct JsonArgs {
    /// Print one JSON object. Without --out nothing is written to disk
    #[arg(long)]
    json: bool,
    /// As --json, but in one line, for use in loops
    #[arg(long)]
    json_line: bool,
}

impl JsonArgs {
    /// Whether an object is wanted instead of words.
    pub fn wanted(self) -> bool {
        self.json || self.json_line
    }

    /// Prints an object.
    pub fn print(self, object: &Value) {
        if self.json_line {
            print_line!("{object}");
        } else {
            print_line!("{object:#}");
        }
    }
}
