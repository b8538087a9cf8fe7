//! A computation on other threads, which Python can follow and stop.
//!
//! Owns the exchange between the thread that called and those that compute: the one waits and lets signals through, the
//! others never need the interpreter.

use std::ops::ControlFlow;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;
use tribochaos::engine::Event;

use crate::pool;

/// How long the calling thread sleeps before it looks at signals and progress again.
const LOOK: Duration = Duration::from_millis(50);

/// How far a computation is.
#[derive(Default)]
pub struct Progress {
    /// Work done, in forcing periods of instances.
    done: AtomicU64,
    is_stopped: AtomicBool,
    is_over: AtomicBool,
}

impl Progress {
    /// Adds work that is done; breaks off once the computation is to stop.
    pub fn add(&self, work: u64) -> ControlFlow<()> {
        self.done.fetch_add(work, Ordering::Relaxed);
        if self.is_stopped.load(Ordering::Relaxed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    /// The same, told by an event of the engine.
    pub fn hear(&self, event: &Event<'_>) -> ControlFlow<()> {
        self.add(match event {
            Event::Advanced(work) => *work,
            Event::Found { instance_periods, .. } => *instance_periods,
            _ => 0,
        })
    }
}

/// The outcome of a computation, and the exception that stopped it, if one did.
pub struct Watched<T> {
    pub outcome: T,
    pub stopped_by: Option<PyErr>,
}

impl<T> Watched<T> {
    /// The outcome of a computation of which nothing is kept if it was stopped.
    ///
    /// # Errors
    /// The exception that stopped it.
    pub fn whole(self) -> PyResult<T> {
        match self.stopped_by {
            None => Ok(self.outcome),
            Some(exception) => Err(exception),
        }
    }
}

/// Runs `work` on the threads that compute, while the interpreter is free. About every twentieth of a second this thread
/// handles signals, and calls `observer(part)`, where `part` is the share of `total` that is done. An exception from either stops
/// the work.
///
/// # Errors
/// If there are no threads.
pub fn watch<T: Send>(
    py: Python<'_>,
    observer: Option<&Bound<'_, PyAny>>,
    total: u64,
    work: impl FnOnce(&Progress) -> T + Send,
) -> PyResult<Watched<T>> {
    let threads = pool::threads()?;
    let progress = Progress::default();
    let caller = thread::current();
    thread::scope(|scope| {
        let computing = scope.spawn(|| {
            let outcome = threads.install(|| work(&progress));
            progress.is_over.store(true, Ordering::Release);
            caller.unpark();
            outcome
        });
        let mut stopped_by = None;
        // a computation that panicked is not over, and finished
        while !progress.is_over.load(Ordering::Acquire) && !computing.is_finished() {
            py.detach(|| thread::park_timeout(LOOK));
            let part = progress.done.load(Ordering::Relaxed) as f64 / total.max(1) as f64;
            let told = py.check_signals().and_then(|()| match observer {
                Some(observer) if stopped_by.is_none() => observer.call1((part.min(1.0),)).map(|_| ()),
                _ => Ok(()),
            });
            if let Err(exception) = told {
                progress.is_stopped.store(true, Ordering::Relaxed);
                stopped_by.get_or_insert(exception);
            }
        }
        let outcome = py.detach(|| computing.join());
        Ok(Watched {
            outcome: outcome.unwrap_or_else(|panic| resume_unwind(panic)),
            stopped_by,
        })
    })
}
