//! `phase`: the phase plane of one or several orbits.

use clap::Args;
use serde_json::{Value, json};
use tribochaos::analysis::exponents::from;
use tribochaos::analysis::path::path;
use tribochaos::design::Coordinate;
use tribochaos::experiment::{Request, Settings};
use tribochaos::measure::Status;
use tribochaos::output::sheet::Sheet;
use tribochaos::output::{PROGRAM, caption, charts};
use tribochaos::parameters::Parameter;

use super::analysis::{self, Files, OutArgs, StartArgs, Values};
use super::request::{self, ExperimentArgs};
use super::{Failure, report};

/// Orbits are integrated on the CPU in f64, with frictional heat where gamma is not 0. The default is 32 measured periods after
/// 300.
#[derive(Args)]
#[command(after_long_help = request::parameter_table())]
pub struct PhaseArgs {
    /// Several values of a parameter, an orbit for each
    #[arg(long, value_name = "NAME=V1,V2,...", value_parser = analysis::values)]
    at: Option<Values>,
    #[command(flatten)]
    start: StartArgs,
    #[command(flatten)]
    experiment: ExperimentArgs,
    #[command(flatten)]
    out: OutArgs,
}

/// Points of a path in each forcing period.
const POINTS_PER_PERIOD: u32 = 157;
/// More orbits in one picture are a tangle.
const MOST_ORBITS: usize = charts::MOST_CURVES;

/// What holds where nothing else is asked for.
pub fn defaults() -> Request {
    let mut defaults = Request::default();
    defaults.settings.periods = 32;
    defaults
}

pub fn run(args: &PhaseArgs) -> Result<(), Failure> {
    let mut experiment = analysis::experiment(&args.experiment, None, defaults())?;
    let starts = args.start.resolve(&args.experiment, &experiment)?;
    let points = analysis::points(args.at.as_ref(), &experiment.design.fixed, &args.experiment.subject.set)?;
    analysis::check_lasting(points.iter().any(|point| point.parameters().wears()))?;
    // the scheme suits the points of --at, not the one whose value they replace
    let typed = Settings {
        scheme: args.experiment.scheme,
        steps_per_period: args.experiment.steps_per_period,
        ..experiment.settings
    };
    experiment.settings = typed
        .for_model(points.iter().any(|point| point.parameters().is_rubbed()))
        .map_err(Failure::input)?;
    let settings = &experiment.settings;
    let count = points.len() * starts.len();
    if count > MOST_ORBITS {
        return Err(Failure::Input(anyhow::anyhow!(
            "{count} orbits are too many for one picture (at most {MOST_ORBITS}): give fewer values or initial states"
        )));
    }
    let options = json!({
        "at": args.at.as_ref().map_or(Value::Array(vec![]), |values| json!([values.coordinate, values.values])),
        "starts": starts,
    });
    let recipe = analysis::recipe("phase", &experiment, options);
    let mut files = Files::claim(&args.out, "outputs/phase", &[""], recipe)?;

    let coordinate = Values::coordinate_of(args.at.as_ref());
    let mut orbits = Vec::new();
    let mut rows = Vec::new();
    let mut objects = Vec::new();
    for point in &points {
        for &start in &starts {
            let path = path(&from(point.parameters(), start), settings, POINTS_PER_PERIOD);
            let value = analysis::value_of(point, coordinate);
            rows.extend(path.points.iter().map(|p| {
                let is_stroboscopic = f64::from(u8::from(p.is_stroboscopic));
                [start[0], start[1], value, p.tau, p.x, p.y, is_stroboscopic]
            }));
            let [x, y] = start;
            let ending = match path.status {
                Status::Ok => None,
                Status::Runaway { time } => Some(format!("ran away at tau = {time:.3} of its run")),
                Status::UnderResolved => Some(format!("is under-resolved ({})", report::remedy(settings))),
            };
            if let Some(ending) = ending {
                eprintln!("warning: the orbit from ({x}, {y}) at {coordinate} = {value} {ending}: its path ends there");
            }
            let mut name: Vec<String> = args
                .at
                .iter()
                .map(|at| caption::assigned(point, at.coordinate, value))
                .collect();
            if starts.len() > 1 {
                name.push(format!("from {}", charts::start(start)));
            }
            let name = if name.is_empty() {
                "orbit".to_owned()
            } else {
                name.join(", ")
            };
            objects.push(json!({
                "parameters": analysis::parameters(&from(point.parameters(), start)),
                "last": path.points.last().map(|p| [p.x, p.y]),
                "status": path.status.name(),
            }));
            orbits.push((name, path.points));
        }
    }
    let mut shown: Vec<Coordinate> = args.at.iter().map(|at| at.coordinate).collect();
    if starts.len() > 1 {
        shown.extend([Parameter::X0, Parameter::Y0].map(Coordinate::from));
    }
    let caption = vec![
        caption::fixed(&experiment.design.fixed.from_state(starts[0]), &shown),
        format!(
            "{} forcing periods after {}. {}, integrated on CPU (f64). {PROGRAM}.",
            settings.periods,
            settings.transient_periods,
            caption::scheme(settings)
        ),
    ];
    let sheet = Sheet::single(charts::phase("", &orbits, None, None), caption);
    files.draw("", &sheet, "Phase plane of the bush-shaft system")?;
    files.table(
        "",
        &[analysis::unit_note(
            &experiment,
            &[coordinate],
            "tau from the end of the transient; stroboscopic: 1 at drive phase 0",
        )],
        ["x0", "y0", coordinate.name(), "tau", "x", "y", "stroboscopic"],
        rows.into_iter(),
    )?;
    files.report(
        args.out
            .json
            .wanted()
            .then(|| analysis::with_machine(json!({ "orbits": objects }), &experiment)),
    );
    Ok(())
}
