//! `phase`: the phase plane of one or several orbits.

use clap::Args;
use serde_json::{Value, json};
use tribochaos::analysis::exponents::from;
use tribochaos::analysis::path::path;
use tribochaos::experiment::Request;
use tribochaos::grid::Coordinate;
use tribochaos::output::sheet::Sheet;
use tribochaos::output::{PROGRAM, caption, charts};
use tribochaos::parameters::Parameter;

use super::Failure;
use super::analysis::{self, Files, OutArgs, StartArgs, Values};
use super::request::{self, ExperimentArgs};

/// Orbits are integrated on the CPU in f64. The default is 32 measured periods after 300.
#[derive(Args)]
#[command(after_help = request::parameter_table())]
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

pub fn run(args: &PhaseArgs) -> Result<(), Failure> {
    let mut defaults = Request::default();
    defaults.settings.periods = 32;
    let experiment = analysis::experiment(&args.experiment, None, defaults)?;
    let settings = &experiment.settings;
    let starts = args.start.resolve(&args.experiment, &experiment)?;
    let points = analysis::points(args.at.as_ref(), &experiment.grid.fixed, &args.experiment.subject.set)?;
    if points.iter().any(|point| point.parameters().is_rubbed()) {
        return Err(Failure::Input(anyhow::anyhow!(
            "the phase plane is drawn at constant contact pressure, without frictional heat and wear: set gamma = 0 and k_w = 0 \
             (of a machine, wear_energy_share = 1 and wear_coefficient = 0)"
        )));
    }
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
            rows.extend(path.iter().map(|p| {
                let is_stroboscopic = f64::from(u8::from(p.is_stroboscopic));
                [start[0], start[1], value, p.tau, p.x, p.y, is_stroboscopic]
            }));
            let ended = path.iter().filter(|p| p.is_stroboscopic).count() <= settings.periods as usize;
            if ended {
                eprintln!("warning: the orbit from {start:?} at {value} ran away: its path ends there");
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
                "last": path.last().map(|p| [p.x, p.y]),
                "ran_away": ended,
            }));
            orbits.push((name, path));
        }
    }
    let mut shown: Vec<Coordinate> = args.at.iter().map(|at| at.coordinate).collect();
    if starts.len() > 1 {
        shown.extend([Parameter::X0, Parameter::Y0].map(Coordinate::from));
    }
    let caption = vec![
        caption::fixed(&experiment.grid.fixed.from_state(starts[0]), &shown),
        format!(
            "{} forcing periods after {}. {}, integrated on CPU (f64). {PROGRAM}.",
            settings.periods,
            settings.transient_periods,
            caption::scheme(settings)
        ),
    ];
    let sheet = Sheet::single(charts::phase("", &orbits, None, None), caption);
    files.draw(
        "",
        &sheet.draw().map_err(Failure::run)?,
        "Phase plane of the bush-shaft system",
    )?;
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
            .then(|| analysis::with_machine(json!({ "orbits": objects }), &experiment)),
    );
    Ok(())
}
