//! `map`: from a request to a store, pictures and the border of chaos.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use serde_json::{Value, json};

use super::Failure;
use super::json::JsonArgs;
use super::outputs::Outputs;
use super::overlay::{self, Theory};
use super::progress::{self, Progress};
use super::request::{self, AskedAxis, ExperimentArgs};
use super::stores;
use super::words;
use crate::design::Axis;
use crate::engine::audit::{self, Audit};
use crate::engine::choice::{self, Choice};
use crate::engine::{self, Backends, EngineError, Sink, Table, Work};
use crate::experiment::{Experiment, Request};
use crate::map::ParameterMap;
use crate::measure::Quantity;
use crate::picture::{self, Style};
use crate::store::{Store, Wanted};

#[derive(Args)]
#[command(after_long_help = request::help())]
#[expect(clippy::struct_excessive_bools, reason = "each is a flag of the command line")]
pub struct MapArgs {
    /// The same as --from
    #[arg(value_name = "EXPERIMENT", conflicts_with = "from")]
    experiment_file: Option<PathBuf>,
    /// Horizontal axis, ends included [default: zeta_k=0:12:300]
    #[arg(long, value_name = "NAME=START:STOP:COUNT", value_parser = request::axis)]
    x: Option<Axis>,
    /// Vertical axis, ends included [default: h1=0:2:201]
    #[arg(long, value_name = "NAME=START:STOP:COUNT", value_parser = request::axis)]
    y: Option<Axis>,
    #[command(flatten)]
    experiment: ExperimentArgs,
    #[arg(long, value_name = "N", help = format!("Points computed again on the CPU in f64 to audit the map [default: {DEFAULT_AUDIT} of a GPU map, else 0]"))]
    audit: Option<u32>,
    /// Quantities that are stored [default: all that can differ from point to point]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = request::named::<Quantity>)]
    quantities: Vec<Quantity>,
    /// Run every point to its full length, even if the kind of its motion is clear early
    #[arg(long)]
    full_length: bool,
    /// What all output names begin with [default: outputs/map]
    #[arg(long, value_name = "NAME")]
    out: Option<PathBuf>,
    /// Replace results of another experiment, and compute those of the same one again
    #[arg(long)]
    force: bool,
    /// No other process uses the store: for file systems without locks
    #[arg(long)]
    alone: bool,
    /// Tell what would be done and about how long it takes, and stop
    #[arg(long)]
    dry_run: bool,
    /// Curve from theory over the pictures: melnikov, the threshold of Mel'nikov's criterion
    #[arg(long, value_name = "melnikov", value_parser = request::named::<Theory>)]
    overlay: Option<Theory>,
    #[command(flatten)]
    json: JsonArgs,
}

/// Points of a GPU map that are audited by default.
const DEFAULT_AUDIT: u32 = 32;

impl MapArgs {
    fn request(&self) -> Result<Request, Failure> {
        let mut experiment = self.experiment.clone();
        experiment.subject.from = self.experiment_file.clone().or(experiment.subject.from);
        let [x, y] = Request::default_map();
        let axes = [(&self.x, x), (&self.y, y)].map(|(typed, default)| AskedAxis {
            typed: typed.as_ref(),
            default,
        });
        let mut request = experiment.request(None, &Request::default(), axes)?;
        request.sampling.decide_early &= !self.full_length;
        request.checking.audit = self.audit.or(request.checking.audit);
        request.out = self.out.clone().or(request.out);
        Ok(request)
    }
}

pub fn run(args: &MapArgs) -> Result<(), Failure> {
    let request = args.request()?;
    let experiment = request.resolve().map_err(Failure::input)?;
    let quantities = stores::quantities(&args.quantities, &request)?;
    let quantities = quantities.unwrap_or_else(|| Quantity::of_map(&experiment));
    let written = stores::written(&request, &experiment, &quantities);
    if args.experiment.subject.prints(&written) {
        return Ok(());
    }
    for warning in experiment.warnings() {
        eprintln!("warning: {warning}");
    }
    let style = Style {
        overlay: overlay::curve(args.overlay, &experiment)?,
        ..Style::default()
    };
    if let Err(error) = picture::check_size(&experiment, &style) {
        eprintln!("warning: {error}");
    }
    let outputs = Outputs::new(request.out.as_deref().unwrap_or("outputs/map".as_ref()));
    let mut choice = choice::choose(&experiment).map_err(Failure::backend)?;
    let wanted = Wanted {
        experiment: &experiment,
        quantities: &quantities,
        unit: choice.backends.points_per_unit(&experiment),
        force: args.force,
        alone: args.alone,
    };
    if args.dry_run {
        outputs.check(&experiment, args.force).map_err(Failure::Input)?;
        print_line!("{}\n{}", words::plan(&experiment), words::device(&choice));
        return stores::dry_run(&wanted, &outputs.store(), &mut choice.backends, 1);
    }
    if args.json.wanted() && request.out.is_none() {
        return run_in_memory(&experiment, choice, args.json);
    }
    outputs.check(&experiment, args.force).map_err(Failure::Input)?;
    let mut store = stores::open(&wanted, &outputs.store())?;
    let is_for_people = !args.json.wanted();
    if is_for_people {
        print_line!("{}\n{}", words::plan(&experiment), words::device(&choice));
    }

    progress::catch_signals();
    let started = Instant::now();
    let work = compute(&experiment, &mut choice.backends, &mut store);
    let work = work.map_err(|error| stores::unfinished(error, &outputs.store()))?;
    let elapsed = started.elapsed();

    let map = store.read().map_err(Failure::run)?;
    let map = ParameterMap::try_from(map).map_err(Failure::run)?;
    let devices = store.devices().map_err(Failure::run)?;
    let audit = audit_map(&map, &experiment, &mut store)?;
    let mut files = outputs.draw(&map, &style).map_err(Failure::Run)?;
    files.push(outputs.store());
    for warning in map.beyond_limits() {
        eprintln!("warning: {warning}");
    }
    if is_for_people {
        print_text!("{}", words::summary(&map, &work, elapsed, &devices));
        if let Some(audit) = audit {
            print_text!("{}", words::audit(&audit));
        }
        for file in files {
            print_line!("wrote {}", file.display());
        }
        return Ok(());
    }
    let mut object = object(&map, &work, elapsed, &devices);
    object["audit"] = json!(audit);
    object["files"] = files.iter().map(|file| file.display().to_string()).collect();
    args.json.print(&object);
    Ok(())
}

/// Computes a map in memory, if only its object is printed.
fn run_in_memory(experiment: &Experiment, choice: Choice, json: JsonArgs) -> Result<(), Failure> {
    let mut backends = choice.backends;
    let mut table = Table::new(experiment.clone(), backends.points_per_unit(experiment));
    progress::catch_signals();
    let started = Instant::now();
    let work = compute(experiment, &mut backends, &mut table).map_err(|error| stores::not_kept(error.cause))?;
    let map = ParameterMap::try_from(table.into_results()).map_err(Failure::input)?;
    json.print(&object(&map, &work, started.elapsed(), &[backends.active().device()]));
    Ok(())
}

fn object(map: &ParameterMap, work: &Work, elapsed: Duration, devices: &[String]) -> Value {
    let mut object = words::object(map);
    object["computed_now"] = work.points.into();
    object["instance_periods"] = work.instance_periods.into();
    object["seconds"] = elapsed.as_secs_f64().into();
    object["devices"] = json!(devices);
    object
}

/// Computes the points that the sink lacks, and shows the progress; returns the work that was done.
fn compute(
    experiment: &Experiment,
    backends: &mut Backends,
    sink: &mut (dyn Sink + Send),
) -> Result<Work, EngineError> {
    let points = experiment.design.len();
    let progress = Progress::new(engine::instance_periods(&experiment.settings, points), points, false);
    let units: Vec<usize> = (0..sink.units()).collect();
    engine::run_on(std::slice::from_mut(backends), experiment, sink, &units, &mut |event| {
        progress.hear(event)
    })
}

/// Audits the map as the experiment asks, and stores the result.
fn audit_map(map: &ParameterMap, experiment: &Experiment, store: &mut Store) -> Result<Option<Audit>, Failure> {
    let points = experiment
        .checking
        .audit
        .unwrap_or(if map.has_gpu_points() { DEFAULT_AUDIT } else { 0 });
    if points == 0 {
        return Ok(None);
    }
    let interrupted = || {
        Failure::Interrupted(format!(
            "the map is finished, its audit is not: {}",
            store.path().display()
        ))
    };
    let audit = audit::audit(map, points as usize, &mut |_| progress::until_stopped())
        .map_err(Failure::backend)?
        .ok_or_else(interrupted)?;
    let value = serde_json::to_value(&audit).map_err(Failure::run)?;
    store.set_attribute("audit", value).map_err(Failure::run)?;
    Ok(Some(audit))
}
