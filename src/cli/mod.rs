//! The command line: strings to requests, results to people.
//!
//! Owns everything that is typed or printed; computes nothing itself.

/// Prints a line. A reader that has gone away is no reason to lose a computation.
macro_rules! say {
    ($($arguments:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stdout(), $($arguments)*);
    }};
}

/// As `say`, without an end of line.
macro_rules! say_on {
    ($($arguments:tt)*) => {{
        use std::io::Write as _;
        let _ = write!(std::io::stdout(), $($arguments)*);
    }};
}

mod analysis;
mod bench;
mod bifurcation;
mod devices;
mod history;
mod lifetime;
mod lyapunov;
mod machine;
mod map;
mod melnikov;
mod onset;
mod outputs;
mod overlay;
mod phase;
mod poincare;
mod point;
mod progress;
mod render;
mod report;
mod reproduce;
mod request;
mod si;

use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use tribochaos::backend::BackendError;
use tribochaos::experiment::{BackendChoice, Request};

/// Chaos-threshold maps of a rubbing oscillator (Awrejcewicz and Pyryev 2006): Lyapunov exponents and periods over a
/// plane of parameters, on a GPU or the CPU.
#[derive(Parser)]
#[command(version, max_term_width = 110)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Compute the maximal Lyapunov exponent, the period and the border of chaos over two parameters
    Map(map::MapArgs),
    /// Compute everything about one point
    Point(point::PointArgs),
    /// Draw pictures again from a store, without computing
    Render(render::RenderArgs),
    /// Draw stroboscopic states over one parameter: the bifurcation diagram
    Bifurcation(bifurcation::BifurcationArgs),
    /// Compute all Lyapunov exponents over one parameter, and where chaos begins and ends
    Lyapunov(lyapunov::LyapunovArgs),
    /// Draw orbits in the phase plane
    Phase(phase::PhaseArgs),
    /// Draw the stroboscopic section of an attractor
    Poincare(poincare::PoincareArgs),
    /// Follow one point over time: pressure, wear, temperature, angle and speed
    History(history::HistoryArgs),
    /// Evaluate Mel'nikov's function, its extremes and its thresholds
    Melnikov(melnikov::MelnikovArgs),
    /// Turn a machine in SI units into the dimensionless parameters, and tell how they move with each quantity
    Machine(machine::MachineArgs),
    /// Compute the paper's figures, and the table of what it says and what the program gets
    Reproduce(reproduce::ReproduceArgs),
    /// Time every kernel on this machine, and measure its accuracy
    Bench(bench::BenchArgs),
    /// Tell which GPU adapters and CPU instructions there are, and which one `auto` picks
    Devices(devices::DevicesArgs),
}

/// Why a command did not end well; decides the exit code.
#[derive(Debug)]
enum Failure {
    /// What was asked for cannot be done: exit code 2, before any long work.
    Input(anyhow::Error),
    /// Something broke on the way: exit code 1.
    Run(anyhow::Error),
    /// Ctrl-C: exit code 130.
    Interrupted(String),
}

impl Failure {
    fn input(error: impl Into<anyhow::Error>) -> Self {
        Self::Input(error.into())
    }

    /// What a backend cannot do is the request's fault, all else the machine's.
    fn backend(error: BackendError) -> Self {
        if matches!(error, BackendError::Unsupported(_)) {
            Self::Input(error.into())
        } else {
            Self::Run(error.into())
        }
    }

    fn run(error: impl Into<anyhow::Error>) -> Self {
        Self::Run(error.into())
    }
}

/// An error with its causes. Many tell their cause themselves, to say behind it what to do: no cause is told twice.
fn told(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if !text.contains(&cause) {
            text += if text.is_empty() { "" } else { ": " };
            text += &cause;
        }
    }
    text
}

/// The command line, with the defaults of each command in its help as the code has them.
fn command() -> clap::Command {
    let on_the_cpu = |mut defaults: Request| {
        defaults.settings.backend = BackendChoice::Cpu;
        defaults
    };
    let commands = [
        ("map", Request::default(), &[][..]),
        ("point", on_the_cpu(Request::default()), &[]),
        ("lyapunov", on_the_cpu(Request::default()), &[]),
        ("bifurcation", on_the_cpu(bifurcation::defaults()), &[]),
        ("phase", on_the_cpu(phase::defaults()), &[]),
        ("poincare", on_the_cpu(poincare::defaults()), poincare::HIDDEN),
        ("history", on_the_cpu(history::defaults()), history::HIDDEN),
    ];
    commands
        .into_iter()
        .fold(Cli::command(), |command, (name, defaults, hidden)| {
            command.mut_subcommand(name, |command| {
                request::tell_defaults(command, &defaults.settings, hidden)
            })
        })
}

pub fn main() -> ExitCode {
    let matches = command().get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    let result = match cli.command {
        Command::Map(args) => map::run(&args),
        Command::Point(args) => point::run(&args),
        Command::Render(args) => render::run(&args),
        Command::Bifurcation(args) => bifurcation::run(&args),
        Command::Lyapunov(args) => lyapunov::run(&args),
        Command::Phase(args) => phase::run(&args),
        Command::Poincare(args) => poincare::run(&args),
        Command::History(args) => history::run(&args),
        Command::Melnikov(args) => melnikov::run(&args),
        Command::Machine(args) => machine::run(&args),
        Command::Reproduce(args) => reproduce::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Devices(args) => devices::run(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Input(error)) => {
            eprintln!("error: {}", told(&error));
            ExitCode::from(2)
        }
        Err(Failure::Run(error)) => {
            eprintln!("error: {}", told(&error));
            ExitCode::from(1)
        }
        Err(Failure::Interrupted(message)) => {
            eprintln!("interrupted: {message}");
            ExitCode::from(130)
        }
    }
}
