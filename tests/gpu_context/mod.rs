//! A GPU for tests.
//!
//! Owns the rule of what happens where there is none: tests are skipped with a note, but never where
//! TRIBOCHAOS_REQUIRE_GPU is set.
//!
//! With Mesa's software driver, set MESA_SHADER_CACHE_DISABLE=true (its cache mixes up vector widths) and, against a
//! harmless message, NODEVICE_SELECT=1.

use tribochaos::backend::BackendError;
use tribochaos::backend::gpu::{GpuContext, adapters};

/// The best GPU, software adapters included; None, with a note, where there is none at all.
pub fn open() -> Option<GpuContext> {
    or_skip(GpuContext::open(None, true))
}

/// What could be opened; None, with a note, where there is no adapter at all.
pub fn or_skip(context: Result<GpuContext, BackendError>) -> Option<GpuContext> {
    match context {
        Ok(context) => Some(context),
        Err(error) if adapters().is_empty() && std::env::var_os("TRIBOCHAOS_REQUIRE_GPU").is_none() => {
            eprintln!("skipped: {error} (TRIBOCHAOS_REQUIRE_GPU would make this a failure)");
            None
        }
        Err(error) => panic!("{error}"),
    }
}
