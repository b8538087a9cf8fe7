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

use crate::engine::Event;
use crate::results::Tally;

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
        // if no handler can be installed, the signal ends the program, as it did before
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
    // SAFETY: `action` was zeroed, which is a valid value of its type, and the call has written to it if it succeeded.
    read == 0 && unsafe { action.assume_init() }.sa_sigaction == libc::SIG_IGN
}

#[cfg(not(unix))]
fn is_ignored(_signal: i32) -> bool {
    false
}

/// The exit code that shells use: 128 plus the number of the signal.
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

/// Time between two lines of progress, if there is no terminal for a bar.
const LINES_EVERY: Duration = Duration::from_secs(30);

/// The progress of a run. Work is counted in instance-periods.
struct State {
    whole: u64,
    points: usize,
    began: Instant,
    /// Done by this run.
    done: AtomicU64,
    /// Done by an earlier run: this counts as progress, but not for the speed.
    found: AtomicU64,
    /// Points of finished units, by their kind of motion.
    tally: Mutex<Tally>,
    /// Units that were found damaged.
    damaged: AtomicU64,
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

    /// The remaining time; None before there is any progress.
    fn left(&self) -> Option<Duration> {
        let rate = self.rate();
        (rate > 0.0).then(|| Duration::from_secs_f64(self.whole.saturating_sub(self.reached()) as f64 / rate))
    }

    fn count(&self, tally: &Tally) {
        if let Ok(mut all) = self.tally.lock() {
            all.add(tally);
        }
    }

    /// How many points there are of each kind, and damaged units, such as `512 regular, 30 chaotic`.
    fn counts(&self) -> String {
        let tally = self.tally.lock().map(|tally| tally.clone()).unwrap_or_default();
        let kinds = tally.kinds();
        let mut counts: Vec<String> = kinds
            .iter()
            .map(|(name, count)| format!("{} {}", HumanCount(*count), name.replace('_', "-")))
            .collect();
        let damaged = self.damaged.load(Ordering::Relaxed);
        if damaged > 0 {
            counts.push(format!("{damaged} damaged units"));
        }
        counts.join(", ")
    }

    fn words(&self) -> String {
        let left = self
            .left()
            .map_or_else(|| "?".to_owned(), |left| HumanDuration(left).to_string());
        let mut words = format!(
            "{:.0} %, {} points/s, {left} left",
            100.0 * self.reached() as f64 / self.whole.max(1) as f64,
            HumanCount(self.points_per_second())
        );
        let counts = self.counts();
        if !counts.is_empty() {
            words += "; ";
            words += &counts;
        }
        words
    }
}

/// Shows the progress of a run: a bar on a terminal, else a line with the time every half minute. Work is counted in
/// instance-periods, and its speed is shown in points per second.
pub struct Progress {
    bar: ProgressBar,
    state: Arc<State>,
    /// When the last line was printed; none where there is a bar.
    line: Option<Mutex<Instant>>,
}

impl Progress {
    /// For a run over `points` that takes `instance_periods` in all.
    pub fn new(instance_periods: u64, points: usize, quiet: bool) -> Self {
        let state = Arc::new(State {
            whole: instance_periods,
            points,
            began: Instant::now(),
            done: AtomicU64::new(0),
            found: AtomicU64::new(0),
            tally: Mutex::default(),
            damaged: AtomicU64::new(0),
        });
        let bar = if quiet {
            ProgressBar::hidden()
        } else {
            ProgressBar::new(instance_periods)
        };
        let (of_rate, of_left) = (Arc::clone(&state), Arc::clone(&state));
        let style = ProgressStyle::with_template("{wide_bar} {percent:>3} %  {points} points/s  {left} left  {counts}")
            .expect("the template is well-formed")
            .with_key("points", move |_: &ProgressState, out: &mut dyn std::fmt::Write| {
                let _ = write!(out, "{}", HumanCount(of_rate.points_per_second()));
            })
            .with_key("left", move |_: &ProgressState, out: &mut dyn std::fmt::Write| {
                if let Some(left) = of_left.left() {
                    let _ = write!(out, "{}", HumanDuration(left));
                }
            });
        let of_counts = Arc::clone(&state);
        let style = style.with_key("counts", move |_: &ProgressState, out: &mut dyn std::fmt::Write| {
            let _ = write!(out, "{}", of_counts.counts());
        });
        bar.set_style(style);
        Self {
            bar,
            line: (!quiet && !stderr().is_terminal()).then(|| Mutex::new(state.began)),
            state,
        }
    }

    /// Receives the events of a run; stops the run after a signal.
    #[expect(clippy::needless_pass_by_value, reason = "an observer receives its events by value")]
    pub fn hear(&self, event: Event<'_>) -> ControlFlow<()> {
        match event {
            Event::Advanced(instance_periods) => {
                self.state.done.fetch_add(instance_periods, Ordering::Relaxed);
                self.bar.inc(instance_periods);
            }
            Event::Found {
                tally,
                instance_periods,
            } => {
                self.state.found.fetch_add(instance_periods, Ordering::Relaxed);
                self.state.count(tally);
                self.bar.inc(instance_periods);
            }
            Event::Finished(tally) => self.state.count(tally),
            Event::Damaged { unit, what } => {
                self.state.damaged.fetch_add(1, Ordering::Relaxed);
                self.bar
                    .suspend(|| eprintln!("warning: unit {unit} is damaged ({what}), and is computed again"));
            }
            Event::Waiting => {}
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

    /// Points of finished units, by their kind of motion.
    pub fn tally(&self) -> Tally {
        self.state.tally.lock().map(|tally| tally.clone()).unwrap_or_default()
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use crate::backend::BackendKind;
    use crate::measure::Measurement;

    use super::*;

    #[test]
    fn what_was_found_is_progress_but_no_speed() {
        let state = State {
            whole: 1000,
            points: 100,
            began: Instant::now().checked_sub(Duration::from_secs(10)).unwrap(),
            done: AtomicU64::new(110),
            found: AtomicU64::new(500),
            tally: Mutex::default(),
            damaged: AtomicU64::new(0),
        };
        assert_eq!((state.reached(), state.points_per_second()), (610, 1));
        let left = state.left().unwrap().as_secs_f64();
        assert!((left - 390.0 / 11.0).abs() < 1.0, "{left}");
        assert!(state.words().starts_with("61 %, 1 points/s, "), "{}", state.words());
        let runaway = Measurement::runaway(1.0, BackendKind::CpuF64);
        state.count(&Tally::of(&[runaway, runaway]));
        assert!(state.words().ends_with(" left; 2 runaway"), "{}", state.words());
    }
}
