//! The progress of a run, and the signals that stop it.
//!
//! Owns what is shown while a run goes on; the run knows nothing of it.

use std::io::{IsTerminal, stderr};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock};
use std::time::{Duration, Instant, SystemTime};

use indicatif::{HumanCount, HumanDuration, ProgressBar, ProgressState, ProgressStyle};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use tribochaos::engine::Event;

/// The signal that asked a run to stop; 0 for none.
static CAUGHT: OnceLock<Arc<AtomicUsize>> = OnceLock::new();

fn caught() -> &'static Arc<AtomicUsize> {
    CAUGHT.get_or_init(Arc::default)
}

/// The signals that stop a run, with their names.
const STOPPING: &[(i32, &str)] = &[
    (SIGINT, "Ctrl-C"),
    (SIGTERM, "SIGTERM"),
    #[cfg(unix)]
    (signal_hook::consts::SIGHUP, "SIGHUP"),
];

/// From now on a signal asks a run to stop; a second one ends the program at once. A signal that was ignored when the program
/// began, as by `nohup`, stays ignored.
pub fn catch_signals() {
    let is_second = Arc::new(AtomicBool::new(false));
    for &(signal, _) in STOPPING {
        if is_ignored(signal) {
            continue;
        }
        // no handler means that the signal ends the program, as it did before
        let _ = flag::register_conditional_shutdown(signal, exit_code(signal).into(), Arc::clone(&is_second))
            .and_then(|_| flag::register(signal, Arc::clone(&is_second)))
            .and_then(|_| flag::register_usize(signal, Arc::clone(caught()), signal as usize));
    }
}

#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let mut action = std::mem::MaybeUninit::<libc::sigaction>::zeroed();
    // SAFETY: without a new action nothing changes, and the old one is written to a place of its size.
    let read = unsafe { libc::sigaction(signal, std::ptr::null(), action.as_mut_ptr()) };
    // SAFETY: it was zeroed, which is a value of the type, and written by the call if that succeeded.
    read == 0 && unsafe { action.assume_init() }.sa_sigaction == libc::SIG_IGN
}

#[cfg(not(unix))]
fn is_ignored(_signal: i32) -> bool {
    false
}

/// As shells have it: 128 and the signal's number.
fn exit_code(signal: i32) -> u8 {
    128 + signal as u8
}

/// Break after a signal.
pub fn until_stopped() -> ControlFlow<()> {
    if caught().load(Ordering::SeqCst) == 0 {
        ControlFlow::Continue(())
    } else {
        ControlFlow::Break(())
    }
}

/// The name of the signal that asked the run to stop, and the exit code for it.
pub fn stopped_by() -> (&'static str, u8) {
    let caught = caught().load(Ordering::SeqCst);
    let known = STOPPING.iter().find(|(signal, _)| *signal as usize == caught);
    let &(signal, name) = known.unwrap_or(&STOPPING[0]);
    (name, exit_code(signal))
}

/// How often there is a line where no terminal shows a bar.
const LINES_EVERY: Duration = Duration::from_secs(30);

/// What is known of a run's work, in instance-periods.
struct State {
    whole: u64,
    points: usize,
    began: Instant,
    /// Done by this run.
    done: AtomicU64,
    /// Found done by an earlier one: progress, but no speed.
    found: AtomicU64,
}

impl State {
    fn rate(&self) -> f64 {
        self.done.load(Ordering::Relaxed) as f64 / self.began.elapsed().as_secs_f64().max(1e-3)
    }

    fn points_per_second(&self) -> u64 {
        (self.rate() * self.points as f64 / self.whole.max(1) as f64) as u64
    }

    fn reached(&self) -> u64 {
        self.done.load(Ordering::Relaxed) + self.found.load(Ordering::Relaxed)
    }

    /// None before anything is known.
    fn left(&self) -> Option<Duration> {
        let rate = self.rate();
        (rate > 0.0).then(|| Duration::from_secs_f64(self.whole.saturating_sub(self.reached()) as f64 / rate))
    }

    fn words(&self) -> String {
        let left = self
            .left()
            .map_or_else(|| "?".to_owned(), |left| HumanDuration(left).to_string());
        format!(
            "{:.0} %, {} points/s, {left} left",
            100.0 * self.reached() as f64 / self.whole.max(1) as f64,
            HumanCount(self.points_per_second())
        )
    }
}

/// Progress over instance-periods, shown as points: a bar on a terminal, else a line with the time every half minute.
pub struct Progress {
    bar: ProgressBar,
    state: Arc<State>,
    /// When the last line was printed; none where there is a bar.
    line: Option<Mutex<Instant>>,
}

impl Progress {
    /// `instance_periods` in all, for a run over `points`.
    pub fn new(instance_periods: u64, points: usize) -> Self {
        let state = Arc::new(State {
            whole: instance_periods,
            points,
            began: Instant::now(),
            done: AtomicU64::new(0),
            found: AtomicU64::new(0),
        });
        let bar = ProgressBar::new(instance_periods);
        let (of_rate, of_left) = (Arc::clone(&state), Arc::clone(&state));
        let style = ProgressStyle::with_template("{wide_bar} {percent:>3} %  {points} points/s  {left} left")
            .expect("the template is well-formed")
            .with_key("points", move |_: &ProgressState, out: &mut dyn std::fmt::Write| {
                let _ = write!(out, "{}", HumanCount(of_rate.points_per_second()));
            })
            .with_key("left", move |_: &ProgressState, out: &mut dyn std::fmt::Write| {
                if let Some(left) = of_left.left() {
                    let _ = write!(out, "{}", HumanDuration(left));
                }
            });
        bar.set_style(style);
        Self {
            bar,
            line: (!stderr().is_terminal()).then(|| Mutex::new(state.began)),
            state,
        }
    }

    /// Hears the events of a run; breaks it off after a signal.
    #[expect(clippy::needless_pass_by_value, reason = "observers are given their events")]
    pub fn hear(&self, event: Event<'_>) -> ControlFlow<()> {
        match event {
            Event::Advanced(instance_periods) => {
                self.state.done.fetch_add(instance_periods, Ordering::Relaxed);
                self.bar.inc(instance_periods);
            }
            Event::Found(instance_periods) => {
                self.state.found.fetch_add(instance_periods, Ordering::Relaxed);
                self.bar.inc(instance_periods);
            }
            Event::FellBack { error, device } => {
                self.bar
                    .suspend(|| eprintln!("warning: {error}\nwarning: going on with {device}"));
            }
        }
        if let Some(line) = &self.line
            && let Ok(mut last) = line.lock()
            && last.elapsed() >= LINES_EVERY
        {
            *last = Instant::now();
            let now = humantime::format_rfc3339_seconds(SystemTime::now());
            eprintln!("{now} {}", self.state.words());
        }
        until_stopped()
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_found_is_progress_but_no_speed() {
        let state = State {
            whole: 1000,
            points: 100,
            began: Instant::now().checked_sub(Duration::from_secs(10)).unwrap(),
            done: AtomicU64::new(110),
            found: AtomicU64::new(500),
        };
        assert_eq!((state.reached(), state.points_per_second()), (610, 1));
        let left = state.left().unwrap().as_secs_f64();
        assert!((left - 390.0 / 11.0).abs() < 1.0, "{left}");
        assert!(state.words().starts_with("61 %, 1 points/s, "), "{}", state.words());
    }
}
