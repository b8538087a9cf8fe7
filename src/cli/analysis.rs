//! What the commands for analyses share: initial states, the experiment over one axis or none, and the files they write.
//!
//! Owns the rule that drawings of something else are not overwritten; computes nothing.

use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::json::JsonArgs;
use super::progress::{self, Progress};
use super::request::{Checked, ExperimentArgs, SubjectArgs};
use super::{Failure, outputs};
use crate::backend::BackendError;
use crate::design::{Axis, Coordinate, Fixed, Points};
use crate::engine::choice::{self, Choice};
use crate::engine::{self, initial_states};
use crate::experiment::{Experiment, Request};
use crate::output::csv;
use crate::parameters::{PARAMETERS, Parameter, ParameterSet};
use crate::picture::sheet::Sheet;
use crate::picture::{charts, drawing, png};

/// Where results go.
#[derive(Args)]
pub struct OutArgs {
    /// What all output names begin with [default: outputs/ and the command's name]
    #[arg(long, value_name = "NAME")]
    pub out: Option<PathBuf>,
    /// Replace drawings of something else
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub json: JsonArgs,
}

impl OutArgs {
    /// Whether files are written: always, except with `--json` and no `--out`.
    pub fn draws(&self) -> bool {
        self.out.is_some() || !self.json.wanted()
    }
}

/// Initial states besides (x0, y0).
#[derive(Args, Clone, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct StartArgs {
    /// Initial state, x and y; may be repeated [default: that of x0 and y0]
    #[arg(long, value_name = "X,Y", value_parser = start, allow_hyphen_values = true)]
    pub start: Vec<[f64; 2]>,
}

impl Checked for StartArgs {
    fn check(&self) -> Result<(), String> {
        let mut values = self
            .start
            .iter()
            .flat_map(|[x, y]| [(Parameter::X0, *x), (Parameter::Y0, *y)]);
        values.try_for_each(|(parameter, value)| parameter.check(value).map_err(|error| error.to_string()))
    }
}

fn start(text: &str) -> Result<[f64; 2], String> {
    let malformed = || format!("`{text}` is no initial state: write X,Y, for example 0.1,0");
    let (x, y) = text.split_once(',').ok_or_else(malformed)?;
    let number = |parameter: Parameter, text: &str| {
        let value = text.trim().parse().map_err(|_| malformed())?;
        parameter.check(value).map_err(|error| error.to_string())?;
        Ok::<f64, String>(value)
    };
    Ok([number(Parameter::X0, x)?, number(Parameter::Y0, y)?])
}

impl StartArgs {
    pub fn is_empty(&self) -> bool {
        self.start.is_empty()
    }

    /// The initial states: those of `chosen`, which are the typed ones or else those of a file. If `chosen` has none, or if x0,
    /// y0 or `--initial-states` was typed, they are (x0, y0) and, with several initial states, others from the box.
    pub fn resolve(
        &self,
        chosen: &Self,
        args: &ExperimentArgs,
        experiment: &Experiment,
    ) -> Result<Vec<[f64; 2]>, Failure> {
        let are_set = sets_initial_state(args) || args.initial_states.is_some();
        if are_set && !self.start.is_empty() {
            return Err(Failure::Input(anyhow!(
                "--start gives the initial states: leave x0, y0 and --initial-states out"
            )));
        }
        if !chosen.start.is_empty() && !are_set {
            return Ok(chosen.start.clone());
        }
        let at = &experiment.design.fixed;
        let first = [at[Parameter::X0], at[Parameter::Y0]];
        let others = initial_states::offsets(&experiment.settings.sampling);
        Ok([first].into_iter().chain(others).collect())
    }
}

/// Whether the user chose the initial state: by an option, by a preset or by a file.
pub fn gives_initial_state(args: &ExperimentArgs, request: &Request) -> bool {
    args.initial_states.is_some()
        || [Parameter::X0, Parameter::Y0]
            .iter()
            .any(|parameter| request.set.contains_key(parameter.name()))
}

fn sets_initial_state(args: &ExperimentArgs) -> bool {
    args.subject.set.iter().any(|&(coordinate, _)| is_initial(coordinate))
}

fn is_initial(coordinate: Coordinate) -> bool {
    [Parameter::X0.into(), Parameter::Y0.into()].contains(&coordinate)
}

/// Initial states as captions name them, the first few of many.
pub fn starts_in_words(starts: &[[f64; 2]]) -> String {
    const NAMED: usize = 6;
    let named: Vec<String> = starts.iter().take(NAMED).map(|&start| charts::start(start)).collect();
    let named = named.join(", ");
    match starts.len().saturating_sub(NAMED) {
        0 => named,
        more => format!("{named} and {more} more"),
    }
}

/// The default axis of the analyses: zeta_k = 0..12.
pub fn default_axis(count: usize) -> Axis {
    Axis::even(Parameter::ZetaK, 0.0, 12.0, count).expect("the table of parameters admits the default axis")
}

/// The experiment of a request in which no initial state may vary. Prints the warnings of the experiment.
pub fn resolve(request: &Request) -> Result<Experiment, Failure> {
    let experiment = request.resolve().map_err(Failure::input)?;
    experiment.check_start_fixed().map_err(Failure::input)?;
    for warning in experiment.warnings() {
        eprintln!("warning: {warning}");
    }
    Ok(experiment)
}

pub fn choose(experiment: &Experiment) -> Result<Choice, Failure> {
    choice::choose(experiment).map_err(Failure::backend)
}

/// Several values of one coordinate, NAME=V1,V2,..., as points one by one.
pub fn values(text: &str) -> Result<Points, String> {
    let malformed = || format!("`{text}` gives no values: write NAME=V1,V2,..., for example zeta_k=3.5,3.9");
    let (name, list) = text.split_once('=').ok_or_else(malformed)?;
    let coordinate = Coordinate::from_name(name.trim()).map_err(|error| error.to_string())?;
    let values = list
        .split(',')
        .map(|text| {
            let value = text.trim().parse().map_err(|_| malformed())?;
            coordinate.check(value).map_err(|error| error.to_string())?;
            Ok::<[f64; 1], String>([value])
        })
        .collect::<Result<Vec<_>, String>>()?;
    Points::new(vec![coordinate], &values).map_err(|error| error.to_string())
}

/// Replaces the points of the file by those of --at, if any. Without points, there is the one point of the request's `set`.
///
/// # Errors
/// If --set gives a value to a coordinate of --at.
pub fn at_points(request: &mut Request, typed: Option<&Points>, subject: &SubjectArgs) -> Result<(), Failure> {
    if let Some(points) = typed {
        for coordinate in points.coordinates() {
            if subject.set.iter().any(|(name, _)| name == coordinate) {
                return Err(Failure::Input(anyhow!(
                    "{coordinate} is set and given by --at as well: leave one of the two out"
                )));
            }
            request.set.remove(coordinate.name());
        }
        request.points = Some(points.clone());
    }
    request.axes = request.points.is_none().then(Vec::new);
    Ok(())
}

/// The points of an experiment.
pub fn points(experiment: &Experiment) -> Vec<Fixed> {
    let design = &experiment.design;
    let points = (0..design.len()).map(|index| design.fixed.at(design.varied.values(index)));
    points.collect()
}

/// The value of a coordinate at a point.
pub fn value_of(point: &Fixed, coordinate: Coordinate) -> f64 {
    match (coordinate, point.machine()) {
        (Coordinate::Parameter(parameter), _) => point[parameter],
        (Coordinate::Si(quantity), Some(machine)) => machine.value(quantity),
        (Coordinate::Si(_), None) => f64::NAN,
    }
}

/// A note of a table, with the units of coordinates that have some.
pub fn unit_note(experiment: &Experiment, coordinates: &[Coordinate], note: &str) -> String {
    let units = coordinates.iter().filter_map(|coordinate| {
        let unit = experiment.design.fixed.unit(*coordinate);
        (unit != "1").then(|| format!("{coordinate} in {unit}"))
    });
    let parts: Vec<String> = units.chain([note.to_owned()]).filter(|part| !part.is_empty()).collect();
    parts.join("; ")
}

/// Adds the machine to an object of results, if there is one.
pub fn with_machine(mut object: Value, experiment: &Experiment) -> Value {
    if let Some(machine) = experiment.machine_description() {
        object["machine"] = json!(machine);
    }
    object
}

/// Parameters by their names. JSON has no infinity: without a ramp, `ramp_rate` is null.
pub fn parameters(at: &ParameterSet) -> Value {
    let names = PARAMETERS.iter().map(|info| info.parameter);
    let map: Map<String, Value> = names
        .map(|parameter| (parameter.name().to_owned(), at[parameter].into()))
        .collect();
    map.into()
}

/// The files into which a command writes its results: NAME.png, NAME.svg, NAME.csv, and others with longer names.
pub struct Claim {
    /// None where nothing is drawn.
    name: Option<PathBuf>,
    json: JsonArgs,
    /// The experiment that all of them carry, in TOML.
    experiment: String,
    written: Vec<PathBuf>,
}

impl Claim {
    /// Checks before any work that the files of the given drawings may be written. Each drawing is an ending of NAME such as
    /// `-threshold`.
    ///
    /// # Errors
    /// If the name names no file, nothing can be written there, or a drawing of another experiment is there and `force` is
    /// not given.
    pub fn new(args: &OutArgs, default: &str, drawings: &[&str], written: &Request) -> Result<Self, Failure> {
        let experiment = written.result_toml();
        let name = args.draws().then(|| args.out.clone().unwrap_or_else(|| default.into()));
        if let Some(name) = &name {
            for drawing in drawings {
                check(&drawing::with_ending(name, drawing), &experiment, args.force).map_err(Failure::Input)?;
            }
            outputs::check_writable(&drawing::with_ending(name, ".png")).map_err(Failure::Input)?;
        }
        Ok(Self {
            name,
            json: args.json,
            experiment,
            written: Vec::new(),
        })
    }

    /// Draws a sheet and writes it, if there are to be files.
    pub fn draw(&mut self, drawing: &str, sheet: &Sheet, title: &str) -> Result<(), Failure> {
        let Some(name) = &self.name else { return Ok(()) };
        let name = drawing::with_ending(name, drawing);
        let figure = sheet.draw().map_err(Failure::run)?;
        let files = drawing::write_drawing(&name, &figure, title, &self.experiment).map_err(Failure::run)?;
        self.written.extend(files);
        Ok(())
    }

    /// Writes a table with the experiment in its comments, if there are to be files.
    pub fn table<'a>(
        &mut self,
        drawing: &str,
        notes: &[String],
        columns: impl AsRef<[&'a str]>,
        rows: impl Iterator<Item = impl AsRef<[f64]>>,
    ) -> Result<(), Failure> {
        let Some(name) = &self.name else { return Ok(()) };
        let path = drawing::with_ending(&drawing::with_ending(name, drawing), ".csv");
        let experiment = csv::experiment_comments(&self.experiment);
        let comments: Vec<String> = notes.iter().cloned().chain(experiment).collect();
        csv::write_rows(&path, &comments, columns.as_ref(), rows).map_err(Failure::run)?;
        self.written.push(path);
        Ok(())
    }

    /// Reports the results: as an object with the machine and the list `files`, or by `print` and the names of the files.
    pub fn tell(&self, experiment: &Experiment, object: impl FnOnce() -> Value, print: impl FnOnce()) {
        if self.json.wanted() {
            let mut object = with_machine(object(), experiment);
            object["files"] = self.written.iter().map(|path| path.display().to_string()).collect();
            self.json.print(&object);
            return;
        }
        print();
        for path in &self.written {
            print_line!("wrote {}", path.display());
        }
    }
}

/// Does the work of a command, which is `instance_periods` for `points`, and shows the progress.
///
/// # Errors
/// If the backend fails, or a signal broke the work off.
pub fn compute<T>(
    instance_periods: u64,
    points: usize,
    work: impl FnOnce(&mut engine::Observer<'_>) -> Result<Option<T>, BackendError>,
) -> Result<T, Failure> {
    progress::catch_signals();
    let bar = Progress::new(instance_periods, points, false);
    work(&mut |event| bar.hear(event))
        .map_err(Failure::backend)?
        .ok_or_else(|| Failure::Interrupted("nothing is drawn".into()))
}

fn check(name: &Path, experiment: &str, force: bool) -> anyhow::Result<()> {
    let text = name.to_string_lossy();
    if name.file_name().is_none() || text.ends_with(std::path::is_separator) {
        bail!("`{text}` names no file: give --out a name such as outputs/phase");
    }
    let [png, svg, csv] = [".png", ".svg", ".csv"].map(|ending| drawing::with_ending(name, ending));
    for file in [&png, &svg, &csv] {
        if file.is_dir() {
            bail!("{} is a folder: move it away, or give another --out", file.display());
        }
    }
    if force {
        return Ok(());
    }
    if png.exists() {
        if png::read_experiment(&png).ok().as_deref() != Some(experiment) {
            bail!(
                "{} shows something else: give another --out, or --force to replace it",
                png.display()
            );
        }
    } else if let Some(file) = [&svg, &csv].into_iter().find(|file| file.exists()) {
        bail!(
            "{} is there already: give another --out, or --force to replace it",
            file.display()
        );
    }
    Ok(())
}
