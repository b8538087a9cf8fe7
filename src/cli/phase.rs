//! `phase`: the phase plane of one or several orbits.

use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::analysis::{self, Claim, OutArgs, StartArgs};
use super::request::{self, Checked, ExperimentArgs};
use super::{Failure, words};
use crate::analysis::path::{Path, path};
use crate::design::{Coordinate, Fixed, Points};
use crate::experiment::{Experiment, Request};
use crate::measure::Status;
use crate::output::PROGRAM;
use crate::parameters::Parameter;
use crate::picture::sheet::Sheet;
use crate::picture::{caption, charts};

/// The name of the command in files.
const COMMAND: &str = "phase";

/// Orbits are integrated on the CPU in f64, with frictional heat where gamma is not 0. The default is 32 measured periods after a
/// transient of 300.
#[derive(Args)]
#[command(after_long_help = request::parameter_table())]
pub struct PhaseArgs {
    /// Several values of a parameter, an orbit for each
    #[arg(long, value_name = "NAME=V1,V2,...", value_parser = analysis::values)]
    at: Option<Points>,
    #[command(flatten)]
    options: Options,
    #[command(flatten)]
    experiment: ExperimentArgs,
    #[command(flatten)]
    out: OutArgs,
}

#[derive(Args, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Options {
    #[command(flatten)]
    #[serde(default, skip_serializing_if = "StartArgs::is_empty")]
    start: StartArgs,
}

impl Checked for Options {
    fn check(&self) -> Result<(), String> {
        self.start.check()
    }
}

/// Points of a path in each forcing period.
const POINTS_PER_PERIOD: u32 = 157;
/// Most orbits in one picture: more cannot be told apart.
const MOST_ORBITS: usize = charts::MOST_CURVES;

/// The defaults of this command.
pub fn defaults() -> Request {
    let mut defaults = Request::of_analysis();
    defaults.sampling.periods = 32;
    defaults
}

pub fn run(args: &PhaseArgs) -> Result<(), Failure> {
    let mut request = args.experiment.request(Some(COMMAND), &defaults(), [])?;
    analysis::at_points(&mut request, args.at.as_ref(), &args.experiment.subject)?;
    let mut options = request::options(&args.options, &request)?;
    let experiment = analysis::resolve(&request)?;
    options.start.start = args
        .options
        .start
        .resolve(&options.start, &args.experiment, &experiment)?;
    let written = request::written(COMMAND, &experiment, &options);
    if args.experiment.subject.prints(&written) {
        return Ok(());
    }
    experiment.check_lasting().map_err(Failure::input)?;
    let (settings, starts) = (&experiment.settings, &options.start.start);
    let count = experiment.design.len() * starts.len();
    if count > MOST_ORBITS {
        return Err(Failure::Input(anyhow::anyhow!(
            "{count} orbits are too many for one picture (at most {MOST_ORBITS}): give fewer values or initial states"
        )));
    }
    let mut files = Claim::new(&args.out, "outputs/phase", &[""], &written)?;

    let varied = experiment.design.varied.coordinates();
    let orbits = followed(&experiment, starts);
    let mut shown = varied.clone();
    if starts.len() > 1 {
        shown.extend([Parameter::X0, Parameter::Y0].map(Coordinate::from));
    }
    let caption = vec![
        caption::fixed(&experiment.design.fixed.from_state(starts[0]), &shown),
        format!(
            "{} forcing periods after {}. {}, integrated on CPU (f64). {PROGRAM}.",
            settings.sampling.periods,
            settings.sampling.transient_periods,
            caption::scheme(settings)
        ),
    ];
    let curves: Vec<_> = orbits
        .iter()
        .map(|orbit| (orbit.name(&varied, starts.len() > 1), orbit.path.points.clone()))
        .collect();
    let sheet = Sheet::single(charts::phase("", &curves, None, None), caption);
    files.draw("", &sheet, "Phase plane of the bush-shaft system")?;
    let note = "tau from the end of the transient; stroboscopic: 1 at drive phase 0";
    let names = varied.iter().map(|coordinate| coordinate.name());
    let columns: Vec<&str> = ["x0", "y0"]
        .into_iter()
        .chain(names)
        .chain(["tau", "x", "y", "stroboscopic"])
        .collect();
    files.table(
        "",
        &[analysis::unit_note(&experiment, &varied, note)],
        columns,
        orbits.iter().flat_map(Orbit::rows),
    )?;
    let objects = || orbits.iter().map(Orbit::object).collect::<Vec<_>>();
    files.tell(&experiment, || json!({ "orbits": objects() }), || {});
    Ok(())
}

/// The orbit from one initial state at one point.
struct Orbit {
    point: Fixed,
    start: [f64; 2],
    /// Values of the coordinates that vary.
    values: Vec<f64>,
    path: Path,
}

/// Follows the orbits from all initial states at all points; warns of those that end before their time.
fn followed(experiment: &Experiment, starts: &[[f64; 2]]) -> Vec<Orbit> {
    let (settings, varied) = (&experiment.settings, experiment.design.varied.coordinates());
    let mut orbits = Vec::new();
    for point in analysis::points(experiment) {
        let values: Vec<f64> = varied
            .iter()
            .map(|&coordinate| analysis::value_of(&point, coordinate))
            .collect();
        for &start in starts {
            let from = point.parameters().with_initial_state(start);
            let path = path(&from, settings, POINTS_PER_PERIOD);
            let ending = match path.status {
                Status::Ok => None,
                Status::Runaway { time } => Some(format!("ran away at tau = {time:.3} of its run")),
                Status::UnderResolved => Some(format!("is under-resolved ({})", words::remedy(settings))),
            };
            if let Some(ending) = ending {
                let at = varied.iter().zip(&values);
                let at = at.map(|(coordinate, value)| format!(" at {coordinate} = {value}"));
                let at = at.collect::<Vec<_>>().concat();
                let [x, y] = start;
                eprintln!("warning: the orbit from ({x}, {y}){at} {ending}: its path ends there");
            }
            let values = values.clone();
            orbits.push(Orbit {
                point,
                start,
                values,
                path,
            });
        }
    }
    orbits
}

impl Orbit {
    /// The name in the legend: the values that vary, and the initial state if there are several.
    fn name(&self, varied: &[Coordinate], by_start: bool) -> String {
        let values = varied.iter().zip(&self.values);
        let mut parts: Vec<String> = values
            .map(|(&coordinate, &value)| caption::assigned(&self.point, coordinate, value))
            .collect();
        if by_start {
            parts.push(format!("from {}", charts::start(self.start)));
        }
        if parts.is_empty() {
            "orbit".to_owned()
        } else {
            parts.join(", ")
        }
    }

    /// Its rows of the table.
    fn rows(&self) -> impl Iterator<Item = Vec<f64>> + '_ {
        self.path.points.iter().map(|p| {
            let is_stroboscopic = f64::from(u8::from(p.is_stroboscopic));
            [&self.start[..], &self.values, &[p.tau, p.x, p.y, is_stroboscopic]].concat()
        })
    }

    fn object(&self) -> Value {
        json!({
            "parameters": analysis::parameters(&self.point.parameters().with_initial_state(self.start)),
            "last": self.path.points.last().map(|p| [p.x, p.y]),
            "status": self.path.status.name(),
        })
    }
}
