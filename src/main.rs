//! The command line program. What it does is in the library's `cli`, which the Python package calls, too.

use std::process::ExitCode;

fn main() -> ExitCode {
    // graphics drivers look for the folder of a desktop session, and print a warning where there is none
    #[cfg(unix)]
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // SAFETY: no other thread runs yet that could read the environment at the same time.
        unsafe { std::env::set_var("XDG_RUNTIME_DIR", std::env::temp_dir()) };
    }
    ExitCode::from(tribochaos::cli::main(std::env::args_os()))
}
