//! `threshold`: the border of chaos in two or three parameters, by refinement.
//!
//! Owns where the results of each round are kept, and the words; the search is the library's.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context, anyhow};
use clap::Args;
use serde_json::json;

use super::json::JsonArgs;
use super::outputs::{self, Outputs};
use super::overlay::{self, Theory};
use super::progress::{self, Progress};
use super::request::{self, ExperimentArgs};
use super::stores;
use super::{Failure, words};
use crate::analysis::threshold::{self, Border, Plan, Round, ThresholdError, dimension};
use crate::design::{Axis, Side};
use crate::engine::{self, Backends, EngineError, Sink, Table, choice};
use crate::experiment::{Experiment, Request};
use crate::measure::Quantity;
use crate::output::{PROGRAM, csv};
use crate::picture::sheet::Sheet;
use crate::picture::{Style, caption, charts, drawing};
use crate::results::Results;
use crate::store::{self, Lock, Use, Wanted};

/// Begins with a coarse grid over a box of parameters, and refines it again and again where chaotic points lie beside others. Islands that
/// are smaller than a cell of the first grid can be missed. What is finished is kept: the same command goes on where an earlier one
/// stopped, and one with a smaller width goes on from the results of a greater one.
#[derive(Args)]
#[command(after_long_help = request::help())]
pub struct ThresholdArgs {
    /// The same as --from
    #[arg(value_name = "EXPERIMENT", conflicts_with = "from")]
    experiment_file: Option<PathBuf>,
    /// Horizontal side of the box [default: zeta_k=0:12]
    #[arg(long, value_name = "NAME=START:STOP", value_parser = side)]
    x: Option<Side>,
    /// Vertical side of the box [default: h1=0:2]
    #[arg(long, value_name = "NAME=START:STOP", value_parser = side)]
    y: Option<Side>,
    /// Third side of the box [default: none]
    #[arg(long, value_name = "NAME=START:STOP", value_parser = side)]
    z: Option<Side>,
    /// Distance of the points between which the border lies, as a part of each side
    #[arg(long, value_name = "PART", default_value_t = 1e-3, allow_negative_numbers = true)]
    width: f64,
    #[arg(long, value_name = "N", help = format!("Cells along each side to begin with [default: {}, with a third side {}]", Plan::FIRST[0], Plan::FIRST[1]))]
    first: Option<u32>,
    /// Points that may be computed at most
    #[arg(long, value_name = "N", default_value_t = Plan::MOST)]
    most_points: usize,
    #[command(flatten)]
    experiment: ExperimentArgs,
    /// What all output names begin with [default: outputs/threshold]
    #[arg(long, value_name = "NAME")]
    out: Option<PathBuf>,
    /// Replace results of another experiment
    #[arg(long)]
    force: bool,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
    /// Curve from theory over the picture: melnikov, the threshold of Mel'nikov's criterion
    #[arg(long, value_name = "melnikov", value_parser = request::named::<Theory>)]
    overlay: Option<Theory>,
    #[command(flatten)]
    json: JsonArgs,
}

/// The most points along a side of the picture.
const MOST_DRAWN: u32 = 2100;

/// The most planes of a third side that are drawn, how many beside each other, and the frame of each in pixels.
const PLANES: u32 = 9;
const COLUMNS: usize = 3;
const PLANE: [u32; 2] = [360, 260];

fn side(text: &str) -> Result<Side, String> {
    Side::parse(text).map_err(|error| error.to_string())
}

impl From<ThresholdError> for Failure {
    fn from(error: ThresholdError) -> Self {
        match error {
            ThresholdError::TooMany { .. } => Self::run(error),
            error => Self::input(error),
        }
    }
}

impl ThresholdArgs {
    /// The request without axes, and the sides of the box: the typed ones, or those of the file's axes, or the default ones.
    fn request(&self) -> Result<(Request, Vec<Side>), Failure> {
        let mut experiment = self.experiment.clone();
        experiment.subject.from = self.experiment_file.clone().or(experiment.subject.from);
        let mut request = experiment.subject.base(None, &Request::default())?;
        request.points = None;
        let of_file = request.axes.take().filter(|axes| (2..=3).contains(&axes.len()));
        let axes: Vec<Axis> = of_file.unwrap_or_else(|| Request::default_map().into());
        let typed = [&self.x, &self.y, &self.z];
        let third = typed[2].is_some() || axes.len() == 3;
        let sides: Vec<Side> = (0..if third { 3 } else { 2 })
            .map(|index| match (typed[index], axes.get(index)) {
                (Some(side), _) => *side,
                (None, Some(axis)) => Side::from(axis),
                (None, None) => unreachable!("a third side is typed or in the file"),
            })
            .collect();
        for side in &sides {
            // what becomes free loses the value that it had in the file
            request.set.remove(side.parameter.name());
        }
        experiment.apply(&mut request)?;
        request.out = self.out.clone().or(request.out);
        Ok((request, sides))
    }
}

pub fn run(args: &ThresholdArgs) -> Result<(), Failure> {
    let (request, sides) = args.request()?;
    let plan = Plan::new(sides, args.width, args.first, args.most_points)?;
    let is_map = plan.sides().len() == 2;
    if args.overlay.is_some() && !is_map {
        return Err(Failure::Input(anyhow!(
            "--overlay draws a curve over two sides: leave it out, or give no third side"
        )));
    }
    // the grid of the picture stands for the whole box in files
    let drawn = plan.cells().into_iter().rev().find(|&cells| cells < MOST_DRAWN);
    let experiment = plan.over_grid(&request, drawn.unwrap_or(plan.cells()[0]))?;
    if args.experiment.subject.prints(&experiment.request()) {
        return Ok(());
    }
    for warning in experiment.warnings() {
        eprintln!("warning: {warning}");
    }
    let style = Style {
        overlay: overlay::curve(args.overlay, &experiment)?,
        ..Style::default()
    };
    let files = match &request.out {
        None if args.json.wanted() => None,
        name => {
            let name = name.clone().unwrap_or_else(|| "outputs/threshold".into());
            Some(Files::new(name, &experiment, args.force)?)
        }
    };
    let (backends, reason) = choice::choose_all(&experiment).map_err(Failure::backend)?;
    if !args.json.wanted() {
        print_line!("{}\n{}", describe(&plan), words::devices(&backends, &reason));
    }
    progress::catch_signals();
    let started = Instant::now();
    let mut rounds = Rounds {
        files: files.as_ref(),
        backends,
        args,
        computed: 0,
    };
    let border = threshold::search(&plan, &request, &mut |round| rounds.compute(round))?;
    let computed = rounds.computed;
    let written = match files {
        Some(files) => files.write(&border, &plan, &experiment, &style)?,
        None => Vec::new(),
    };
    if args.json.wanted() {
        args.json.print(&object(
            &border,
            &plan,
            &experiment,
            computed,
            started.elapsed(),
            &written,
        ));
        return Ok(());
    }
    print_text!("{}", summary(&border, &plan, computed, started.elapsed()));
    for file in written {
        print_line!("wrote {}", file.display());
    }
    Ok(())
}

/// Computes the rounds of a search, each into a store of its own, or in memory.
struct Rounds<'a> {
    files: Option<&'a Files>,
    backends: Vec<Backends>,
    args: &'a ThresholdArgs,
    /// Points that were computed now.
    computed: usize,
}

impl Rounds<'_> {
    fn compute(&mut self, round: &Round) -> Result<Results, Failure> {
        let experiment = &round.experiment;
        let unit = self.backends[0].points_per_unit(experiment);
        let Some(files) = self.files else {
            let mut table = Table::new(experiment.clone(), unit);
            let ran = self.run(experiment, &mut table);
            ran.map_err(|error| stores::not_kept(error.cause))?;
            return Ok(table.into_results());
        };
        let path = files.round(round.number);
        let wanted = Wanted {
            experiment,
            quantities: &Quantity::of_scan(experiment),
            unit,
            force: false,
            alone: false,
        };
        let mut store = stores::open(&wanted, &path)?;
        self.run(experiment, &mut store)
            .map_err(|error| stores::unfinished(error, &path))?;
        store.read().map_err(Failure::run)
    }

    fn run(&mut self, experiment: &Experiment, sink: &mut (dyn Sink + Send)) -> Result<(), EngineError> {
        let points = experiment.design.len();
        let periods = engine::instance_periods(&experiment.settings, points);
        let progress = Progress::new(periods, points, self.args.quiet);
        let units: Vec<usize> = (0..sink.units()).collect();
        let work = engine::run_on(&mut self.backends, experiment, sink, &units, &mut |event| {
            progress.hear(event)
        })?;
        self.computed += work.points;
        Ok(())
    }
}

/// The files of a search.
struct Files {
    name: PathBuf,
}

impl Files {
    /// # Errors
    /// If files of another experiment are in the way and `force` is not given, or the place cannot be written.
    fn new(name: PathBuf, experiment: &Experiment, force: bool) -> Result<Self, Failure> {
        let files = Self { name };
        let picture = files.picture(experiment);
        let is_other = |shown: &Experiment| {
            let sides = |experiment: &Experiment| experiment.design.axes().iter().map(Side::from).collect::<Vec<_>>();
            sides(shown) != sides(experiment)
                || shown.design.fixed != experiment.design.fixed
                || shown.settings != experiment.settings
        };
        // the same border to another width is none of another experiment; a map under this name is
        let is_own = files.round(0).exists() && outputs::shown(&picture).is_none_or(|shown| !is_other(&shown));
        let there = [picture.clone(), files.table()].into_iter().find(|path| path.exists());
        if let (Some(there), false, false) = (there, is_own, force) {
            return Err(Failure::Input(anyhow!(
                "{} belongs to another experiment: give another --out, or --force to replace it",
                there.display()
            )));
        }
        if force {
            files.remove_rounds().map_err(Failure::Input)?;
        }
        outputs::check_writable(&picture).map_err(Failure::Input)?;
        Ok(files)
    }

    fn picture(&self, experiment: &Experiment) -> PathBuf {
        match experiment.design.axes().len() {
            2 => Outputs::new(&self.name).picture(Quantity::Lyapunov),
            _ => drawing::with_ending(&self.name, ".png"),
        }
    }

    /// Removes the rounds of an earlier search, of which the new one may need fewer.
    fn remove_rounds(&self) -> anyhow::Result<()> {
        for number in (0..).take_while(|&number| self.round(number).exists()) {
            let round = self.round(number);
            store::check_replaceable(&round)?;
            // refused while another process writes it
            let _lock = Lock::of_store(&round, Use::Alone)?;
            std::fs::remove_dir_all(&round).with_context(|| format!("cannot remove {}", round.display()))?;
        }
        Ok(())
    }

    /// The store of a round.
    fn round(&self, number: usize) -> PathBuf {
        drawing::with_ending(&self.name, &format!(".rounds/{number}.zarr"))
    }

    fn table(&self) -> PathBuf {
        drawing::with_ending(&self.name, "-border.csv")
    }

    fn write(
        &self,
        border: &Border,
        plan: &Plan,
        experiment: &Experiment,
        style: &Style,
    ) -> Result<Vec<PathBuf>, Failure> {
        self.write_table(border, experiment)?;
        let mut files = if experiment.design.axes().len() == 2 {
            let (_, map) = border.maps(MOST_DRAWN, PLANES)?.swap_remove(0);
            let style = Style {
                note: Some(note(border, plan)),
                ..style.clone()
            };
            let picture = Outputs::new(&self.name).draw_quantity(&map, Quantity::Lyapunov, &style);
            vec![picture.map_err(Failure::Run)?]
        } else {
            self.draw_planes(border, plan, experiment)?
        };
        files.push(self.table());
        files.push(drawing::with_ending(&self.name, ".rounds"));
        Ok(files)
    }

    fn write_table(&self, border: &Border, experiment: &Experiment) -> Result<(), Failure> {
        let axes = experiment.design.axes();
        let names: Vec<&str> = axes.iter().map(|axis| axis.coordinate.name()).collect();
        let mut comments = vec![
            format!("border of chaos over {}, as lines", names.join(", ")),
            "line: its number; a closed line ends with its first place".to_owned(),
            "half_width: along the axis with this number, from 1 on, the border lies between the place - half_width and + half_width"
                .to_owned(),
        ];
        comments.extend(csv::experiment_comments(&experiment.to_toml()));
        let columns: Vec<&str> = ["line"]
            .into_iter()
            .chain(names)
            .chain(["along", "half_width"])
            .collect();
        let rows = border.lines().into_iter().enumerate().flat_map(|(number, line)| {
            line.into_iter().map(move |crossing| {
                let mut row = vec![(number + 1) as f64];
                row.extend(&crossing.place[..axes.len()]);
                row.extend([(crossing.along + 1) as f64, crossing.half_width]);
                row
            })
        });
        csv::write_rows(&self.table(), &comments, &columns, rows).map_err(Failure::run)
    }

    fn draw_planes(&self, border: &Border, plan: &Plan, experiment: &Experiment) -> Result<Vec<PathBuf>, Failure> {
        let axes = experiment.design.axes();
        let shown: Vec<_> = axes.iter().map(|axis| axis.coordinate).collect();
        let planes = border.maps(MOST_DRAWN, PLANES)?;
        let sheet = Sheet {
            panels: charts::border_planes(&planes, shown[2], COLUMNS),
            columns: COLUMNS,
            frame: PLANE,
            caption: vec![
                caption::fixed(&experiment.design.fixed, &shown),
                format!(
                    "{} {}. {PROGRAM}.",
                    note(border, plan),
                    caption::scheme(&experiment.settings)
                ),
            ],
        };
        let page = sheet.draw().map_err(Failure::run)?;
        let title = "Border of chaos of the bush-shaft system";
        let files = drawing::write_drawing(&self.name, &page, title, &experiment.to_toml());
        Ok(files.map_err(Failure::run)?.into())
    }
}

/// The box and the cells, in one line.
fn describe(plan: &Plan) -> String {
    let sides: Vec<String> = plan
        .sides()
        .iter()
        .map(|side| {
            let how = if side.log { ", logarithmic" } else { "" };
            format!("{} = {}..{}{how}", side.parameter, side.start, side.stop)
        })
        .collect();
    let cells = plan.cells();
    format!(
        "border of chaos over {}: from 1/{} to 1/{} of each side",
        sides.join(" by "),
        cells[0],
        cells[cells.len() - 1]
    )
}

/// What the picture's caption tells of the search.
fn note(border: &Border, plan: &Plan) -> String {
    format!(
        "Refined along the border of chaos: {} points are computed, {} of those of an even grid whose cells are 1/{} of each side. \
         Between them the nearest one is shown.",
        border.points(),
        percent(border.points() as f64 / plan.points_of_grid()),
        plan.cells()[plan.cells().len() - 1]
    )
}

fn percent(part: f64) -> String {
    format!("{:.2}\u{a0}%", 100.0 * part)
}

fn summary(border: &Border, plan: &Plan, computed: usize, elapsed: Duration) -> String {
    let lines = border.lines();
    let (cells, boxes) = (plan.cells(), border.boxes());
    let counted: Vec<String> = cells
        .iter()
        .zip(&boxes)
        .map(|(cells, boxes)| format!("{boxes} of 1/{cells}"))
        .collect();
    let of_curve = if plan.sides().len() == 2 {
        "a smooth curve has 1"
    } else {
        "a smooth surface has 2"
    };
    let dimension = dimension(&boxes).map_or_else(
        || "dimension: unknown, since there are too few widths, or no border".to_owned(),
        |found| {
            format!(
                "dimension: {:.2} +- {:.2} by counting boxes of 1/{} to 1/{} of a side; {of_curve}",
                found.value, found.error, cells[0], cells[found.level]
            )
        },
    );
    format!(
        "{} points in {}, {computed} of them computed now, in {}: {} of the {} points of a grid of this width\n\
         motion: {}\n\
         border: {} lines; boxes that it passes through: {}\n\
         {dimension}\n",
        border.points(),
        match border.rounds() {
            1 => "one round".to_owned(),
            rounds => format!("{rounds} rounds"),
        },
        words::duration(elapsed),
        percent(border.points() as f64 / plan.points_of_grid()),
        plan.points_of_grid(),
        words::kinds(&border.tally()),
        lines.len(),
        counted.join(", ")
    )
}

fn object(
    border: &Border,
    plan: &Plan,
    experiment: &Experiment,
    computed: usize,
    elapsed: Duration,
    files: &[PathBuf],
) -> serde_json::Value {
    let boxes = border.boxes();
    let boxes_of: Vec<_> = plan
        .cells()
        .iter()
        .zip(&boxes)
        .map(|(cells, boxes)| json!({ "cells_along_a_side": cells, "boxes": boxes }))
        .collect();
    let dimension = dimension(&boxes).map(|found| json!({ "value": found.value, "error": found.error }));
    json!({
        "experiment": experiment.to_toml(),
        "width": plan.width(),
        "points": border.points(),
        "points_of_grid": plan.points_of_grid(),
        "rounds": border.rounds(),
        "computed_now": computed,
        "seconds": elapsed.as_secs_f64(),
        "motion": border.tally(),
        "lines": border.lines().len(),
        "boxes": boxes_of,
        "dimension": dimension,
        "files": files.iter().map(|file| file.display().to_string()).collect::<Vec<_>>(),
    })
}
