//! The progress bar, and Ctrl-C.
//!
//! Owns what is shown while a run goes on; the run knows nothing of it.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

use indicatif::{HumanCount, ProgressBar, ProgressState, ProgressStyle};
use tribochaos::engine::Event;

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// From now on Ctrl-C asks a run to stop; a second one ends the program at once.
pub fn catch_interrupt() {
    let handler = || {
        if INTERRUPTED.swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
    };
    // a second handler is refused: the first one does the same
    let _ = ctrlc::set_handler(handler);
}

/// Break after Ctrl-C.
pub fn until_interrupted() -> ControlFlow<()> {
    if INTERRUPTED.load(Ordering::SeqCst) {
        ControlFlow::Break(())
    } else {
        ControlFlow::Continue(())
    }
}

/// A bar over instance-periods, shown as points.
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// `instance_periods` in all, for a map of `points`.
    pub fn new(instance_periods: u64, points: usize) -> Self {
        let per_point = instance_periods as f64 / points as f64;
        let bar = ProgressBar::new(instance_periods);
        let template = "{wide_bar} {percent:>3} %  {points} points/s  {eta} left";
        let style = ProgressStyle::with_template(template)
            .expect("the template is well-formed")
            .with_key("points", move |state: &ProgressState, out: &mut dyn std::fmt::Write| {
                let _ = write!(out, "{}", HumanCount((state.per_sec() / per_point) as u64));
            });
        bar.set_style(style);
        Self { bar }
    }

    /// Hears the events of a run; breaks it off after Ctrl-C.
    pub fn hear(&self, event: Event<'_>) -> ControlFlow<()> {
        match event {
            Event::Advanced(instance_periods) => self.bar.inc(instance_periods),
            Event::Found(instance_periods) => {
                // what is there already counts as progress, not as speed
                self.bar.inc(instance_periods);
                self.bar.reset_eta();
            }
            Event::FellBack { error, device } => {
                self.bar
                    .suspend(|| eprintln!("warning: {error}\nwarning: going on with {device}"));
            }
        }
        until_interrupted()
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
