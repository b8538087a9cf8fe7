//! What the commands for analyses share: initial states, the experiment over one axis or none, and the files they write.
//!
//! Owns the rule that drawings of something else are not overwritten; computes nothing.

use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use clap::Args;
use serde_json::{Map, Value, json};
use tribochaos::design::{Axis, Coordinate, Fixed, Varied};
use tribochaos::engine::choice::{self, Choice};
use tribochaos::engine::initial_states;
use tribochaos::experiment::{BackendChoice, Experiment, Preset, Request};
use tribochaos::output::sheet::Sheet;
use tribochaos::output::{PROGRAM, charts, drawing, table};
use tribochaos::parameters::{PARAMETERS, Parameter, ParameterSet};

use super::json::JsonArgs;
use super::request::ExperimentArgs;
use super::{Failure, outputs};

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
    /// Whether files are written: not where an object is wanted and no name is given.
    pub fn draws(&self) -> bool {
        self.out.is_some() || !self.json.wanted()
    }
}

/// Initial states besides (x0, y0).
#[derive(Args)]
pub struct StartArgs {
    /// Initial state, x and y; may be repeated [default: that of x0 and y0]
    #[arg(long, value_name = "X,Y", value_parser = start, allow_hyphen_values = true)]
    pub start: Vec<[f64; 2]>,
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
    /// The initial states: those that were typed, or that of x0 and y0 and, with `--initial-states`, others from the box.
    pub fn resolve(&self, args: &ExperimentArgs, experiment: &Experiment) -> Result<Vec<[f64; 2]>, Failure> {
        if self.start.is_empty() {
            let at = &experiment.design.fixed;
            let first = [at[Parameter::X0], at[Parameter::Y0]];
            let others = initial_states::offsets(&experiment.settings);
            return Ok([first].into_iter().chain(others).collect());
        }
        if sets_initial_state(args) || args.initial_states.is_some() {
            return Err(Failure::Input(anyhow!(
                "--start gives the initial states: leave x0, y0 and --initial-states out"
            )));
        }
        Ok(self.start.clone())
    }
}

/// Whether the initial state was typed, or is that of a preset.
pub fn gives_initial_state(args: &ExperimentArgs) -> bool {
    let preset = args.preset.map_or(&[][..], Preset::values);
    sets_initial_state(args) || preset.iter().any(|&(parameter, _)| is_initial(parameter.into()))
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

/// The axis over which something is drawn unless another one is asked for: zeta_k = 0..12.
pub fn default_axis(count: usize) -> Axis {
    Axis::even(Parameter::ZetaK, 0.0, 12.0, count).expect("the table of parameters admits the default axis")
}

/// The experiment over an axis, or at one point; `defaults` come before what was typed. The CPU is taken unless a GPU is
/// asked for: orbits are read back every period, and f64 leaves no doubt about them.
pub fn experiment(args: &ExperimentArgs, axis: Option<Axis>, defaults: Request) -> Result<Experiment, Failure> {
    let mut request = defaults;
    args.apply(&mut request)?;
    args.leave_free(
        &axis.iter().map(|axis| axis.coordinate).collect::<Vec<_>>(),
        &mut request,
    );
    // few points, of which the errors are shown
    request.settings.decide_early = false;
    if request.settings.backend == BackendChoice::Auto {
        request.settings.backend = BackendChoice::Cpu;
    }
    if let Some(axis) = &axis
        && is_initial(axis.coordinate)
    {
        return Err(Failure::Input(anyhow!(
            "the axis is {}: give initial states by --start, or use `map`, whose axes they can be",
            axis.coordinate
        )));
    }
    let experiment = request
        .resolve_over(Varied::Axes(axis.into_iter().collect()))
        .map_err(Failure::input)?;
    for warning in experiment.warnings() {
        eprintln!("warning: {warning}");
    }
    Ok(experiment)
}

/// # Errors
/// If the contact wears: there is no attractor whose states could be shown.
pub fn check_lasting(wears: bool) -> Result<(), Failure> {
    if wears {
        return Err(Failure::Input(anyhow!(
            "with wear all motion is transient, and has no attractor to draw: set k_w = 0 (of a machine, wear_coefficient = 0)"
        )));
    }
    Ok(())
}

pub fn choose(experiment: &Experiment) -> Result<Choice, Failure> {
    choice::choose(experiment).map_err(Failure::backend)
}

/// Several values of one coordinate, NAME=V1,V2,...
#[derive(Clone, Debug)]
pub struct Values {
    pub coordinate: Coordinate,
    pub values: Vec<f64>,
}

pub fn values(text: &str) -> Result<Values, String> {
    let malformed = || format!("`{text}` gives no values: write NAME=V1,V2,..., for example zeta_k=3.5,3.9");
    let (name, list) = text.split_once('=').ok_or_else(malformed)?;
    let coordinate = Coordinate::from_name(name.trim()).map_err(|error| error.to_string())?;
    let values = list
        .split(',')
        .map(|text| {
            let value = text.trim().parse().map_err(|_| malformed())?;
            coordinate.check(value).map_err(|error| error.to_string())?;
            Ok::<f64, String>(value)
        })
        .collect::<Result<Vec<f64>, String>>()?;
    Ok(Values { coordinate, values })
}

impl Values {
    /// What the values are of, for tables: zeta_k where none are given.
    pub fn coordinate_of(values: Option<&Self>) -> Coordinate {
        values.map_or(Parameter::ZetaK.into(), |values| values.coordinate)
    }
}

/// The points with the values, or the point itself without any.
///
/// # Errors
/// If the coordinate is set to a value as well, or follows from a machine, or there is no machine at one of the values.
pub fn points(values: Option<&Values>, at: &Fixed, set: &[(Coordinate, f64)]) -> Result<Vec<Fixed>, Failure> {
    let Some(Values { coordinate, values }) = values else {
        return Ok(vec![*at]);
    };
    if set.iter().any(|(name, _)| name == coordinate) {
        return Err(Failure::Input(anyhow!(
            "{coordinate} is set and given by --at as well: leave one of the two out"
        )));
    }
    coordinate.check_free(at.machine().is_some()).map_err(Failure::input)?;
    let points: Vec<Fixed> = values.iter().map(|&value| at.at([(*coordinate, value)])).collect();
    for machine in points.iter().filter_map(Fixed::machine) {
        machine.check().map_err(Failure::input)?;
    }
    Ok(points)
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

/// Parameters by their names; JSON has no infinity, so that no ramp is null.
pub fn parameters(at: &ParameterSet) -> Value {
    let names = PARAMETERS.iter().map(|info| info.parameter);
    let map: Map<String, Value> = names
        .map(|parameter| (parameter.name().to_owned(), at[parameter].into()))
        .collect();
    map.into()
}

/// What a drawing shows, as TOML: equal recipes give equal drawings.
pub fn recipe(command: &str, experiment: &Experiment, options: Value) -> String {
    // TOML, unlike JSON, has infinities
    let names = PARAMETERS.iter().map(|info| info.parameter);
    let parameters: toml::Table = names
        .map(|parameter| {
            let value = experiment.design.fixed[parameter];
            (parameter.name().to_owned(), toml::Value::Float(value))
        })
        .collect();
    let table = |value: Result<toml::Value, toml::ser::Error>| value.expect("a recipe has a TOML form");
    let mut recipe = toml::Table::new();
    recipe.insert("command".to_owned(), command.into());
    recipe.insert("program".to_owned(), PROGRAM.into());
    recipe.insert("options".to_owned(), table(toml::Value::try_from(options)));
    recipe.insert(
        "axes".to_owned(),
        table(toml::Value::try_from(experiment.design.axes())),
    );
    recipe.insert("parameters".to_owned(), parameters.into());
    if let Some(machine) = experiment.machine_description() {
        recipe.insert("machine".to_owned(), table(toml::Value::try_from(machine)));
    }
    recipe.insert(
        "settings".to_owned(),
        table(toml::Value::try_from(&experiment.settings)),
    );
    recipe.to_string()
}

/// The files of one command: NAME.png, NAME.svg, NAME.csv, and others whose names go on.
pub struct Files {
    /// None where nothing is drawn.
    name: Option<PathBuf>,
    json: JsonArgs,
    recipe: String,
    written: Vec<PathBuf>,
}

impl Files {
    /// Claims the files of the given drawings before any work, each NAME and an ending such as `-threshold`.
    ///
    /// # Errors
    /// If the name names no file, nothing can be written there, or a drawing with another recipe is there and `force` is
    /// not given.
    pub fn claim(args: &OutArgs, default: &str, drawings: &[&str], recipe: String) -> Result<Self, Failure> {
        let name = args.draws().then(|| args.out.clone().unwrap_or_else(|| default.into()));
        if let Some(name) = &name {
            for drawing in drawings {
                check(&drawing::with_ending(name, drawing), &recipe, args.force).map_err(Failure::Input)?;
            }
            outputs::check_writable(&drawing::with_ending(name, ".png")).map_err(Failure::Input)?;
        }
        Ok(Self {
            name,
            json: args.json,
            recipe,
            written: Vec::new(),
        })
    }

    /// Draws a sheet and writes it, if there are to be files.
    pub fn draw(&mut self, drawing: &str, sheet: &Sheet, title: &str) -> Result<(), Failure> {
        let Some(name) = &self.name else { return Ok(()) };
        let name = drawing::with_ending(name, drawing);
        let figure = sheet.draw().map_err(Failure::run)?;
        let files = drawing::write_drawing(&name, &figure, title, &self.recipe).map_err(Failure::run)?;
        self.written.extend(files);
        Ok(())
    }

    /// Writes a table with the recipe in its comments, if there are to be files.
    pub fn table<'a>(
        &mut self,
        drawing: &str,
        notes: &[String],
        columns: impl AsRef<[&'a str]>,
        rows: impl Iterator<Item = impl AsRef<[f64]>>,
    ) -> Result<(), Failure> {
        let Some(name) = &self.name else { return Ok(()) };
        let path = drawing::with_ending(&drawing::with_ending(name, drawing), ".csv");
        let recipe = self.recipe.lines().filter(|line| !line.is_empty()).map(str::to_owned);
        let comments: Vec<String> = notes.iter().cloned().chain(recipe).collect();
        table::write_rows(&path, &comments, columns.as_ref(), rows).map_err(Failure::run)?;
        self.written.push(path);
        Ok(())
    }

    /// Says what was written: in words, or as the list `files` of an object.
    pub fn report(&self, object: Option<Value>) {
        match object {
            Some(mut object) => {
                object["files"] = self.written.iter().map(|path| path.display().to_string()).collect();
                self.json.print(&object);
            }
            None => {
                for path in &self.written {
                    print_line!("wrote {}", path.display());
                }
            }
        }
    }
}

fn check(name: &Path, recipe: &str, force: bool) -> anyhow::Result<()> {
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
        if drawing::read_recipe(&png).ok().flatten().as_deref() != Some(recipe) {
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
