//! The command line: turns strings into requests, and shows the results to the user.
//!
//! Owns everything that is typed or printed; computes nothing itself.

/// Prints a line to standard output.
macro_rules! print_line {
    () => {
        $crate::cli::print::print(format_args!("\n"))
    };
    ($($arguments:tt)+) => {
        $crate::cli::print::print(format_args!("{}\n", format_args!($($arguments)+)))
    };
}

/// Prints text to standard output as it is.
macro_rules! print_text {
    ($($arguments:tt)*) => {
        $crate::cli::print::print(format_args!($($arguments)*))
    };
}

mod against;
mod analysis;
mod bench;
mod bifurcation;
mod completions;
mod devices;
mod export;
mod from;
mod history;
mod json;
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
mod print;
mod progress;
mod render;
mod report;
mod reproduce;
mod request;
mod scan;
mod si;
mod slice;
mod slurm;
mod status;
mod stores;
mod threshold;
mod words;

use std::ffi::OsString;

use anyhow::anyhow;
use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::backend::BackendError;
use crate::experiment::{BackendChoice, Request};

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
    /// Compute over any number of parameters, or over any points, into a store; goes on where it stopped
    Scan(scan::ScanArgs),
    /// Write a scan as a job array of Slurm, and submit it
    Slurm(slurm::SlurmArgs),
    /// Tell what a store has, what is missing or damaged, and how long the rest takes
    Status(status::StatusArgs),
    /// Check every value of a store; compute again what is damaged
    Verify(status::VerifyArgs),
    /// Draw a map out of a store of more than two axes
    Slice(slice::SliceArgs),
    /// Write what a store says as a page: shares of chaos, which parameters matter, how far a point is from chaos
    Report(report::ReportArgs),
    /// Write a store as a table
    Export(export::ExportArgs),
    /// Find the border of chaos in two or three parameters, by refinement
    Threshold(threshold::ThresholdArgs),
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
    /// Turn a machine in SI units into the dimensionless parameters, and tell how they change with each quantity
    Machine(machine::MachineArgs),
    /// Compute the paper's figures, and a table that compares the paper with the program
    Reproduce(reproduce::ReproduceArgs),
    /// Time every kernel on this machine, and measure its accuracy
    Bench(bench::BenchArgs),
    /// List the GPU adapters and the CPU instruction sets, and tell which device `auto` takes
    Devices(devices::DevicesArgs),
    /// Print the completions of a shell, or write a man page for each command
    Completions(completions::CompletionsArgs),
}

/// Why a command did not end well; decides the exit code.
#[derive(Debug)]
enum Failure {
    /// The request cannot be carried out: exit code 2, before any long work.
    Input(anyhow::Error),
    /// Something broke on the way: exit code 1.
    Run(anyhow::Error),
    /// A signal: exit code 128 and its number, 130 for Ctrl-C.
    Interrupted(String),
}

impl Failure {
    fn input(error: impl Into<anyhow::Error>) -> Self {
        Self::Input(error.into())
    }

    /// An unsupported request is an input error; every other error of a backend is a failure of the run.
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

/// An error with its causes. Many messages contain the text of their cause, followed by advice. Such a cause is not repeated.
fn with_causes(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if !text.contains(&cause) {
            text += if text.is_empty() { "" } else { ": " };
            text += &cause;
        }
    }
    text
}

/// The command line. The help of each command shows the defaults that the code has.
fn command() -> clap::Command {
    let on_the_cpu = |mut defaults: Request| {
        defaults.device.backend = BackendChoice::Cpu;
        defaults
    };
    let commands = [
        ("map", Request::default(), &[][..]),
        ("scan", Request::default(), &[]),
        ("slurm", Request::default(), &[]),
        ("threshold", Request::default(), &[]),
        ("point", on_the_cpu(Request::default()), &[]),
        ("lyapunov", on_the_cpu(Request::default()), &[]),
        ("bifurcation", on_the_cpu(bifurcation::defaults()), &[]),
        ("phase", on_the_cpu(phase::defaults()), &[]),
        ("poincare", on_the_cpu(poincare::defaults()), poincare::HIDDEN),
        ("history", on_the_cpu(history::defaults()), history::HIDDEN),
    ];
    let told = commands
        .into_iter()
        .fold(Cli::command(), |command, (name, defaults, hidden)| {
            command.mut_subcommand(name, |command| request::tell_defaults(command, &defaults, hidden))
        });
    // these write a store in any case
    let told = ["scan", "slurm"].into_iter().fold(told, |command, name| {
        command.mut_subcommand(name, |command| {
            command.mut_arg("json", |json| json.help("Print one JSON object, besides the store"))
        })
    });
    let described: [(&str, Describe); 14] = [
        ("point", describe::<point::PointArgs>),
        ("scan", describe::<scan::ScanArgs>),
        ("slurm", describe::<slurm::SlurmArgs>),
        ("threshold", describe::<threshold::ThresholdArgs>),
        ("report", describe::<report::ReportArgs>),
        ("bifurcation", describe::<bifurcation::BifurcationArgs>),
        ("lyapunov", describe::<lyapunov::LyapunovArgs>),
        ("phase", describe::<phase::PhaseArgs>),
        ("poincare", describe::<poincare::PoincareArgs>),
        ("history", describe::<history::HistoryArgs>),
        ("melnikov", describe::<melnikov::MelnikovArgs>),
        ("machine", describe::<machine::MachineArgs>),
        ("reproduce", describe::<reproduce::ReproduceArgs>),
        ("completions", describe::<completions::CompletionsArgs>),
    ];
    described
        .into_iter()
        .fold(told, |command, (name, describe)| command.mut_subcommand(name, describe))
}

/// What changes a command.
type Describe = fn(clap::Command) -> clap::Command;

/// The long help of a command begins with the line of the list of commands; then comes what its options are documented with.
fn describe<A: Args>(command: clap::Command) -> clap::Command {
    let own = A::augment_args(clap::Command::new(""));
    let line = command.get_about().map(ToString::to_string).unwrap_or_default();
    match own.get_long_about().or(own.get_about()) {
        Some(text) => command.long_about(format!("{line}\n\n{text}")),
        None => command,
    }
}

/// Carries out a command line, whose first argument is the name of the program, and returns the exit code: 0 if all is well, 1 after a
/// failure, 2 for what cannot be carried out, and 128 and its number after a signal.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let parsed = command()
        .try_get_matches_from(arguments)
        .and_then(|matches| Cli::from_arg_matches(&matches));
    let cli = match parsed {
        Ok(cli) => cli,
        Err(error) => return answer(&error),
    };
    let result = match cli.command {
        Command::Map(args) => map::run(&args),
        Command::Scan(args) => scan::run(&args),
        Command::Slurm(args) => slurm::run(&args),
        Command::Status(args) => status::status(&args),
        Command::Verify(args) => status::verify(&args),
        Command::Slice(args) => slice::run(&args),
        Command::Report(args) => report::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Threshold(args) => threshold::run(&args),
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
        Command::Completions(args) => completions::run(&args, command()),
    };
    let result = match (result, print::lost()) {
        (Ok(()), Some(reason)) => Err(Failure::Run(anyhow!(
            "standard output cannot be written: {reason}; what was computed is in its files, what was printed is lost"
        ))),
        (result, _) => result,
    };
    match result {
        Ok(()) => 0,
        Err(Failure::Input(error)) => {
            eprintln!("error: {}", with_causes(&error));
            2
        }
        Err(Failure::Run(error)) => {
            eprintln!("error: {}", with_causes(&error));
            1
        }
        Err(Failure::Interrupted(message)) => {
            let (name, code) = progress::stopped_by();
            eprintln!("stopped by {name}: {message}");
            code
        }
    }
}

/// Prints the help, the version, or the error in the command line; returns the exit code.
fn answer(error: &clap::Error) -> u8 {
    let written = error.print();
    if error.use_stderr() {
        return 2;
    }
    print::note(written);
    match print::lost() {
        None => 0,
        Some(reason) => {
            eprintln!("error: standard output cannot be written: {reason}");
            1
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_options_of_every_command_go_together() {
        command().debug_assert();
    }
}
