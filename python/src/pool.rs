//! The threads that compute.
//!
//! Owns one pool of threads for each process. A process that was made by fork inherits the memory of a pool without its
//! threads, so it begins a pool of its own.

use std::process;
use std::ptr;
use std::sync::atomic::{AtomicPtr, AtomicU32, Ordering};

use pyo3::PyErr;
use pyo3::exceptions::PyRuntimeError;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// The threads of one process.
struct Own {
    process: u32,
    pool: ThreadPool,
}

/// The newest pool, which may be that of the process from which this one was forked. A lock would not do: another thread could
/// hold it in the moment of a fork, and it would never be released in the new process.
static NEWEST: AtomicPtr<Own> = AtomicPtr::new(ptr::null_mut());

/// The process that imported the package.
static IMPORTED_BY: AtomicU32 = AtomicU32::new(0);

/// Remembers which process imports the package.
pub fn remember_process() {
    IMPORTED_BY.store(process::id(), Ordering::Relaxed);
}

/// Whether this process was made by fork after the import: drivers of GPUs do not work in it.
pub fn is_forked() -> bool {
    IMPORTED_BY.load(Ordering::Relaxed) != process::id()
}

/// The threads of this process.
///
/// # Errors
/// If the system gives no threads.
pub fn threads() -> Result<&'static ThreadPool, PyErr> {
    let process = process::id();
    let newest = NEWEST.load(Ordering::Acquire);
    // SAFETY: what the pointer is given was leaked, and is never freed
    if let Some(own) = unsafe { newest.as_ref() }.filter(|own| own.process == process) {
        return Ok(&own.pool);
    }
    let pool = ThreadPoolBuilder::new()
        .thread_name(|index| format!("tribochaos-{index}"))
        .build()
        .map_err(|error| PyRuntimeError::new_err(format!("the system gives no threads: {error}")))?;
    let own: &'static Own = Box::leak(Box::new(Own { process, pool }));
    // if another thread was faster, both pools are used: theirs from now on, this one for this call
    let _ = NEWEST.compare_exchange(
        newest,
        ptr::from_ref(own).cast_mut(),
        Ordering::AcqRel,
        Ordering::Relaxed,
    );
    Ok(&own.pool)
}
