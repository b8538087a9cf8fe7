//! `scan`: an experiment over any number of axes, or over any points, into a store.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, anyhow};
use clap::Args;
use serde_json::json;

use super::json::JsonArgs;
use super::progress::{self, Progress};
use super::request::{self, ExperimentArgs};
use super::stores;
use super::{Failure, outputs, words};
use crate::design::{Axis, Coordinate, Plan, Points, Sample, Side};
use crate::engine::{self, Backends, Part, Sink, choice};
use crate::experiment::{Experiment, Request};
use crate::measure::Quantity;
use crate::output::words::bytes;
use crate::store::{self, Store, Wanted};

/// Any number of axes, or any points. What is finished is kept: the same command goes on where an earlier one stopped, and several
/// processes that are given the same store share the work.
#[derive(Args)]
#[command(after_long_help = request::help())]
#[expect(clippy::struct_excessive_bools, reason = "each is a flag of the command line")]
pub struct ScanArgs {
    /// The same as --from
    #[arg(value_name = "EXPERIMENT", conflicts_with = "from")]
    experiment_file: Option<PathBuf>,
    /// An axis, ends included, or with --sample a side of the sampled box; may be repeated. The first axis varies fastest
    #[arg(long, value_name = "NAME=START:STOP:COUNT")]
    x: Vec<String>,
    /// Points from a table of comma-separated values: names of parameters, or of quantities of the machine, in the first line
    #[arg(long, value_name = "FILE.CSV", conflicts_with_all = ["x", "sample"])]
    points: Option<PathBuf>,
    /// A sample of the box that --x NAME=START:STOP spans: sobol:N, a scrambled Sobol sequence, or lhs:N, a Latin hypercube
    #[arg(long, value_name = "METHOD:N[:SEED]", requires = "x")]
    sample: Option<Plan>,
    /// Quantities that are stored [default: lyapunov, lyapunov_error, period, class, status, backend, and more with heat, wear or
    /// several initial states]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = request::named::<Quantity>)]
    quantities: Vec<Quantity>,
    #[command(flatten)]
    experiment: ExperimentArgs,
    /// Run every point to its full length, also where its motion has shown early what it is
    #[arg(long)]
    full_length: bool,
    /// The store [default: outputs/scan.zarr]
    #[arg(long, value_name = "STORE.zarr")]
    out: Option<PathBuf>,
    /// Compute this part of the units only, for processes that know nothing of each other
    #[arg(long, value_name = "I/N", default_value = "1/1")]
    part: Part,
    /// Points in a unit of a new store: what is computed, written and claimed at once [default: what fills the device for some
    /// seconds]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    unit_points: Option<u32>,
    /// Hardware GPUs that are used at once
    #[arg(long, value_name = "all|N", default_value = "all", value_parser = gpus)]
    gpus: usize,
    /// Replace results of another experiment, and compute those of the same one again
    #[arg(long)]
    force: bool,
    /// No other process uses the store: for file systems without locks
    #[arg(long)]
    alone: bool,
    /// Tell what would be done and about how long it takes, and stop
    #[arg(long)]
    dry_run: bool,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
    #[command(flatten)]
    json: JsonArgs,
}

/// A number of GPUs; `all` is more than a machine has.
fn gpus(text: &str) -> Result<usize, String> {
    match text.parse() {
        _ if text == "all" => Ok(usize::MAX),
        Ok(count) if count > 0 => Ok(count),
        _ => Err(format!(
            "`{text}` is no number of GPUs: write all, or a number from 1 on"
        )),
    }
}

impl ScanArgs {
    fn request(&self) -> Result<Request, Failure> {
        let mut experiment = self.experiment.clone();
        experiment.subject.from = self.experiment_file.clone().or(experiment.subject.from);
        let mut request = experiment.subject.base(None, &Request::default())?;
        self.set_design(&mut request)?;
        experiment.apply(&mut request)?;
        experiment.leave_free(&varied(&request), &mut request);
        if let (None, None) = (&request.axes, &request.points) {
            return Err(Failure::Input(anyhow!(
                "there is nothing to scan: give --x NAME=START:STOP:COUNT for each axis, --points FILE.CSV, or an experiment's file"
            )));
        }
        request.sampling.decide_early &= !self.full_length;
        request.out = self.out.clone().or(request.out);
        Ok(request)
    }

    /// Puts the design that is typed in place of the file's.
    fn set_design(&self, request: &mut Request) -> Result<(), Failure> {
        let (axes, points) = if let Some(path) = &self.points {
            let text = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()));
            let points = Points::from_csv(&text.map_err(Failure::Input)?);
            let points = points.with_context(|| format!("in {}", path.display()));
            (None, Some(points.map_err(Failure::Input)?))
        } else if let Some(plan) = self.sample {
            let sides = self
                .x
                .iter()
                .map(|text| Side::parse(text))
                .collect::<Result<Vec<_>, _>>();
            let sample = sides.and_then(|sides| Sample::new(plan, sides));
            (None, Some(Points::from(sample.map_err(Failure::input)?)))
        } else if self.x.is_empty() {
            return Ok(());
        } else {
            let axes = self
                .x
                .iter()
                .map(|text| Axis::parse(text))
                .collect::<Result<Vec<_>, _>>();
            (Some(axes.map_err(Failure::input)?), None)
        };
        (request.axes, request.points) = (axes, points);
        for coordinate in varied(request) {
            // what becomes free loses the value that it had in the file
            request.set.remove(coordinate.name());
        }
        Ok(())
    }
}

/// What varies in the design of a request.
fn varied(request: &Request) -> Vec<Coordinate> {
    let axes = request.axes.iter().flatten().map(|axis| axis.coordinate);
    let points = request.points.iter().flat_map(Points::coordinates);
    axes.chain(points.copied()).collect()
}

/// A scan before it is run.
pub struct Prepared {
    pub path: PathBuf,
    /// The experiment with all options, as it is written.
    pub written: Request,
    experiment: Experiment,
    quantities: Vec<Quantity>,
    backends: Vec<Backends>,
    unit: usize,
    force: bool,
    alone: bool,
}

impl Prepared {
    fn wanted(&self) -> Wanted<'_> {
        Wanted {
            experiment: &self.experiment,
            quantities: &self.quantities,
            unit: self.unit,
            force: self.force,
            alone: self.alone,
        }
    }

    fn open(&self) -> Result<Store, Failure> {
        outputs::check_writable(&self.path).map_err(Failure::Input)?;
        stores::open(&self.wanted(), &self.path)
    }

    /// Creates the store if it is not there; returns the number of its units.
    ///
    /// # Errors
    /// As a scan, before it is run.
    pub fn create_store(&self) -> Result<usize, Failure> {
        Ok(self.open()?.units())
    }
}

impl ScanArgs {
    /// Whether results that are in the way are replaced.
    pub fn force(&self) -> bool {
        self.force
    }

    /// All but the run; None if nothing more is to be done, because the experiment was only to be printed.
    ///
    /// # Errors
    /// If the scan cannot be carried out.
    pub fn prepare(&self) -> Result<Option<Prepared>, Failure> {
        let request = self.request()?;
        let experiment = request.resolve().map_err(Failure::input)?;
        let quantities = stores::quantities(&self.quantities, &request)?;
        let quantities = quantities.unwrap_or_else(|| Quantity::of_scan(&experiment));
        let written = stores::written(&request, &experiment, &quantities);
        if self.experiment.subject.prints(&written) {
            return Ok(None);
        }
        for warning in experiment.warnings() {
            eprintln!("warning: {warning}");
        }
        let path = request.out.unwrap_or_else(|| "outputs/scan.zarr".into());
        outputs::name_of_store(&path).map_err(Failure::Input)?;
        let (mut backends, reason) = choice::choose_all(&experiment).map_err(Failure::backend)?;
        backends.truncate(self.gpus);
        let unit = self
            .unit_points
            .map_or_else(|| backends[0].points_per_unit(&experiment), |points| points as usize);
        if !self.json.wanted() {
            let size = store::size_bytes(&experiment, &quantities, unit);
            print_line!("{}\n{}", words::plan(&experiment), words::devices(&backends, &reason));
            print_line!("store:  {} for {} points", bytes(size), experiment.design.len());
        }
        Ok(Some(Prepared {
            path,
            written,
            experiment,
            quantities,
            backends,
            unit,
            force: self.force,
            alone: self.alone || !self.part.is_all(),
        }))
    }
}

pub fn run(args: &ScanArgs) -> Result<(), Failure> {
    let Some(mut prepared) = args.prepare()? else {
        return Ok(());
    };
    if args.dry_run {
        let mut backends = std::mem::take(&mut prepared.backends);
        let devices = backends.len();
        return stores::dry_run(&prepared.wanted(), &prepared.path, &mut backends[0], devices);
    }
    let mut store = prepared.open()?;
    let Prepared {
        path,
        experiment,
        mut backends,
        ..
    } = prepared;
    let units = args.part.units(store.units());
    if units.is_empty() {
        return Err(Failure::Input(anyhow!(
            "{} has {} units, and none is left for this part: use at most as many parts",
            path.display(),
            store.units()
        )));
    }

    progress::catch_signals();
    let started = Instant::now();
    let points: usize = units.iter().map(|&unit| store.points(unit).len()).sum();
    let progress = Progress::new(
        engine::instance_periods(&experiment.settings, points),
        points,
        args.quiet,
    );
    let ran = engine::run_on(&mut backends, &experiment, &mut store, &units, &mut |event| {
        progress.hear(event)
    });
    let tally = progress.tally();
    drop(progress);
    let work = ran.map_err(|error| stores::unfinished(error, &path))?;
    let elapsed = started.elapsed();
    if !args.json.wanted() {
        let rate = work.points as f64 / elapsed.as_secs_f64();
        print_line!(
            "{} points in {}, {rate:.0} points/s; {} were there already",
            work.points,
            words::duration(elapsed),
            points - work.points
        );
        print_line!("motion: {}", words::kinds(&tally));
        print_line!("wrote {}", path.display());
        return Ok(());
    }
    args.json.print(&json!({
        "store": path.display().to_string(),
        "points": points,
        "computed_now": work.points,
        "instance_periods": work.instance_periods,
        "seconds": elapsed.as_secs_f64(),
        "motion": tally,
    }));
    Ok(())
}
