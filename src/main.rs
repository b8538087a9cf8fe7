//! The command line program: parse, run, exit code.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    // graphics drivers look for the folder of a desktop session, and print a warning where there is none
    #[cfg(unix)]
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // SAFETY: no other thread runs yet that could read the environment at the same time.
        unsafe { std::env::set_var("XDG_RUNTIME_DIR", std::env::temp_dir()) };
    }
    cli::main()
}
