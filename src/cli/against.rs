//! `bench --against`: two builds of the program in turn.
//!
//! Owns the commands that are timed and how their times are compared; the builds run as processes of their own.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, bail};
use serde::Serialize;
use serde_json::json;

use super::Failure;
use super::json::JsonArgs;
use crate::output::PROGRAM;
use crate::studies::benchmark::median;

/// A command that is timed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Timed {
    /// Mostly the start of the program.
    Point,
    /// Start, files and pictures as well as work.
    SmallMap,
    /// Mostly regular points, decided early.
    Map,
    /// A third of the points is chaotic.
    ChaoticMap,
    /// The kernels, without decisions.
    FullLength,
    /// Frictional heat.
    HeatMap,
}

impl Timed {
    const ALL: [Self; 6] = [
        Self::Point,
        Self::SmallMap,
        Self::Map,
        Self::ChaoticMap,
        Self::FullLength,
        Self::HeatMap,
    ];

    /// Its arguments, which earlier versions know as well.
    fn arguments(self) -> &'static str {
        match self {
            Self::Point => "point --backend cpu --periods 100",
            Self::SmallMap => "map --backend cpu --x zeta_k=0:12:64 --y h1=0:2:64 --out map --force",
            Self::Map => "map --backend cpu --x zeta_k=0:12:200 --y h1=0:2:200 --out map --force",
            Self::ChaoticMap => "map --backend cpu --x zeta_k=3:5:150 --y h1=0:1.5:150 --out map --force",
            Self::FullLength => "map --backend cpu --x zeta_k=0:12:80 --y h1=0:2:80 --full-length --out map --force",
            Self::HeatMap => {
                "map --backend cpu --preset paper --x zeta_k=3:6:32 --y gamma=0:0.06:16 --set k_w=0 --out map --force"
            }
        }
    }
}

/// A command as both builds took it.
#[derive(Serialize)]
struct Comparison {
    command: &'static str,
    /// Medians, in seconds of wall-clock time.
    seconds: f64,
    seconds_against: f64,
    /// Time of this build over that of the other: the median of the rounds, the least and the greatest.
    ratio: f64,
    least: f64,
    greatest: f64,
}

impl Comparison {
    fn new(timed: Timed, rounds: &[[f64; 2]]) -> Self {
        let ratios = || rounds.iter().map(|[this, other]| this / other);
        Self {
            command: timed.arguments(),
            seconds: median(rounds.iter().map(|round| round[0])),
            seconds_against: median(rounds.iter().map(|round| round[1])),
            ratio: median(ratios()),
            least: ratios().fold(f64::INFINITY, f64::min),
            greatest: ratios().fold(0.0, f64::max),
        }
    }
}

/// A build of the program, with a folder of its own to work in.
struct Build {
    program: PathBuf,
    version: String,
    folder: PathBuf,
}

impl Build {
    fn new(program: &Path, folder: PathBuf) -> anyhow::Result<Self> {
        let program = program
            .canonicalize()
            .with_context(|| format!("{} is not there", program.display()))?;
        let output = Command::new(&program).arg("--version").output();
        let output = output.with_context(|| format!("{} cannot be run", program.display()))?;
        let version = String::from_utf8_lossy(&output.stdout).trim().to_owned();
        if !output.status.success() || !version.starts_with("tribochaos ") {
            bail!(
                "{} is no tribochaos: give the program of another build",
                program.display()
            );
        }
        fs::create_dir_all(&folder).with_context(|| format!("{} cannot be created", folder.display()))?;
        Ok(Self {
            program,
            version,
            folder,
        })
    }

    /// The time that a command takes, in seconds.
    fn time(&self, timed: Timed) -> anyhow::Result<f64> {
        let mut command = Command::new(&self.program);
        command.args(timed.arguments().split(' ')).current_dir(&self.folder);
        let started = Instant::now();
        let output = command.output()?;
        let elapsed = started.elapsed();
        if !output.status.success() {
            bail!(
                "`{} {}` failed: {}",
                self.program.display(),
                timed.arguments(),
                String::from_utf8_lossy(&output.stderr).trim()
            );
        }
        Ok(elapsed.as_secs_f64())
    }
}

/// A folder that is removed in the end.
struct Scratch(PathBuf);

impl Drop for Scratch {
    fn drop(&mut self) {
        // best effort: it is in the folder for temporary files
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Times commands of this build and of another one in turn, and prints the ratios.
pub fn run(other: &Path, only: &[Timed], rounds: u32, as_json: JsonArgs) -> Result<(), Failure> {
    let scratch = Scratch(std::env::temp_dir().join(format!("tribochaos-bench-{}", std::process::id())));
    let this = std::env::current_exe().map_err(Failure::run)?;
    let build = |program: &Path, name| Build::new(program, scratch.0.join(name)).map_err(Failure::Input);
    let builds = [build(&this, "this")?, build(other, "other")?];
    let timed: Vec<Timed> = Timed::ALL
        .into_iter()
        .filter(|timed| only.is_empty() || only.contains(timed))
        .collect();
    let mut times = vec![Vec::new(); timed.len()];
    for round in 0..rounds as usize {
        for (&timed, times) in timed.iter().zip(&mut times) {
            let mut pair = [f64::NAN; 2];
            // neither is always the first
            for index in [round % 2, (round + 1) % 2] {
                pair[index] = builds[index].time(timed).map_err(Failure::Run)?;
            }
            times.push(pair);
        }
    }
    let comparisons: Vec<Comparison> = timed
        .iter()
        .zip(&times)
        .map(|(&timed, times)| Comparison::new(timed, times))
        .collect();
    let [_, other] = &builds;
    if as_json.wanted() {
        let against = json!({ "program": other.program.display().to_string(), "version": other.version });
        as_json.print(&json!({ "program": PROGRAM, "against": against, "rounds": rounds, "commands": comparisons }));
        return Ok(());
    }
    print_line!(
        "{PROGRAM} against {} ({}): medians of {rounds} rounds in turn, and the ratio of the times by round",
        other.program.display(),
        other.version
    );
    print_line!("\n   this s  other s   ratio  least .. greatest");
    for row in &comparisons {
        print_line!(
            "  {:>7.3} {:>8.3} {:>7.3}  {:.3} .. {:.3}   {}",
            row.seconds,
            row.seconds_against,
            row.ratio,
            row.least,
            row.greatest,
            row.command
        );
    }
    Ok(())
}
