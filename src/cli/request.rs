//! Options that describe an experiment, shared by the commands that compute.
//!
//! Owns the conversion of strings to a [`Request`]; the library defines what a request means.

use std::fmt::{Display, Write as _};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use clap::Args;
use serde::de::value::{Error as ValueError, StrDeserializer};
use serde::de::{DeserializeOwned, IntoDeserializer};
use serde::{Deserialize, Serialize};

use super::{Failure, from};
use crate::design::{Axis, Coordinate};
use crate::dynamics::stroboscope::LEAST_WINDOW;
use crate::experiment::{
    BackendChoice, Device, Experiment, InitialBox, Integration, Precision, Preset, Request, Sampling, Scheme,
};
use crate::machine::{Description, governing};
use crate::measure::{CHAOTIC_GROWTH, DEFECT_BOUND, DEFECT_FLOOR, QUASI_PERIODIC_BOUND, QUASI_PERIODIC_ERROR};
use crate::model::motion::RUNAWAY_BOUND;
use crate::parameters::{PARAMETERS, Parameter};

/// What is computed: parameters, and the machine that gives most of them.
#[derive(Args, Clone)]
pub struct SubjectArgs {
    /// Value of a parameter or of a quantity of the machine, if it is not an axis; may be repeated
    #[arg(long, value_name = "NAME=VALUE", value_parser = assignment)]
    pub set: Vec<(Coordinate, f64)>,
    /// A machine in SI units, as `tribochaos machine --template` prints one. It gives the dimensionless parameters; its
    /// quantities can be set and be axes, and results are told in SI units as well
    #[arg(long, value_name = "FILE.TOML")]
    pub machine: Option<PathBuf>,
    /// Take the experiment from a file: TOML, as --print-experiment writes it, or a picture, a drawing, a table or a store of
    /// this program; options override it. If the file is of another command, that command's own options are ignored
    #[arg(long, value_name = "FILE|STORE.zarr")]
    pub from: Option<PathBuf>,
    /// Print the resolved experiment as TOML, and stop
    #[arg(long)]
    pub print_experiment: bool,
}

impl SubjectArgs {
    /// The request that a command (None for a map) starts from: the file of --from, completed by the command's own defaults. If
    /// the file is of another command, its options are ignored. Its lengths of runs are ignored, too, if this command has its
    /// own.
    ///
    /// # Errors
    /// If the file cannot be read, or holds no experiment.
    pub fn base(&self, command: Option<&str>, defaults: &Request) -> Result<Request, Failure> {
        let Some(path) = &self.from else {
            return Ok(defaults.clone());
        };
        let mut request = from::read(path, defaults.sampling).map_err(Failure::Input)?;
        if request.device == Device::default() {
            request.device = defaults.device.clone();
        }
        if request.command.as_deref() == command {
            return Ok(request);
        }
        if request.command.take().is_some() {
            // the points were given by --at, which has no meaning for a command with axes
            request.points = None;
        }
        request.options.clear();
        let lengths = |sampling: Sampling| {
            let Sampling {
                transient_periods,
                align_periods,
                periods,
                ..
            } = sampling;
            [transient_periods, align_periods, periods]
        };
        let own = &defaults.sampling;
        if lengths(*own) != lengths(Sampling::default()) {
            [
                request.sampling.transient_periods,
                request.sampling.align_periods,
                request.sampling.periods,
            ] = lengths(*own);
        }
        request.sampling.decide_early = own.decide_early;
        Ok(request)
    }

    /// Prints the resolved experiment if only that was asked for; returns whether it was.
    pub fn prints(&self, written: &Request) -> bool {
        if self.print_experiment {
            print_text!("{}", written.to_toml());
        }
        self.print_experiment
    }

    /// Overrides the values of `request` by the typed ones.
    ///
    /// # Errors
    /// If the machine's file cannot be read, or holds no machine.
    pub fn apply(&self, request: &mut Request) -> Result<(), Failure> {
        if let Some(path) = &self.machine {
            request.machine = Some(read_machine(path).map_err(Failure::Input)?);
            // the machine replaces the file's values of all parameters that a machine determines
            let is_free = |name: &str| Parameter::from_name(name).is_ok_and(|parameter| governing(parameter).is_none());
            request.set.retain(|name, _| is_free(name));
        }
        for &(coordinate, value) in &self.set {
            request.set.insert(coordinate.name().to_owned(), value);
        }
        Ok(())
    }
}

/// Numerical settings and fixed parameters. An option that is left out keeps the value of the file, or else its default.
/// [`tell_defaults`] adds the defaults to the help.
#[derive(Args, Clone)]
pub struct ExperimentArgs {
    #[command(flatten)]
    pub subject: SubjectArgs,
    /// The paper's section 5, as reconstructed: biot 10, omega_tilde 0.1, no ramp, x0 = y0 = 0, h1 0.5, gamma 1.87, k_w 0.01.
    /// --set and the axes override it
    #[arg(long, value_name = "paper", value_parser = preset, conflicts_with = "machine")]
    pub preset: Option<Preset>,
    /// Stepping scheme: taylor (its steps end at the boundaries of the friction layer), rk4 (fixed steps, as in the paper) or
    /// radau (includes frictional heat and wear)
    #[arg(long, help_heading = "Numerical settings", value_parser = named::<Scheme>)]
    pub scheme: Option<Scheme>,
    /// Steps in a forcing period; for taylor and radau these are the longest steps
    #[arg(long, help_heading = "Numerical settings", value_name = "STEPS")]
    pub steps_per_period: Option<u32>,
    /// Heat modes of the shaft; one more (lumped) mode stands for all the rest
    #[arg(long, help_heading = "Numerical settings", value_name = "M")]
    pub modes: Option<u32>,
    /// Error that a step of radau may have: of the sliding velocity (in the friction layer, divided by its width), and of
    /// the pressure (relative)
    #[arg(long, help_heading = "Numerical settings", value_name = "ERROR")]
    pub tolerance: Option<f64>,
    /// Forcing periods before the measurement; none where the contact wears
    #[arg(long, help_heading = "Numerical settings", value_name = "PERIODS")]
    pub transient_periods: Option<u32>,
    /// Last periods of the transient, in which the tangent vectors turn to the directions of the exponents
    #[arg(long, help_heading = "Numerical settings", value_name = "PERIODS")]
    pub align_periods: Option<u32>,
    /// Measured forcing periods
    #[arg(long, help_heading = "Numerical settings", value_name = "PERIODS")]
    pub periods: Option<u32>,
    /// Steps of rk4 between renormalisations of the tangent vectors, besides one at each period's end
    #[arg(long, help_heading = "Numerical settings", value_name = "STEPS")]
    pub renormalise_every: Option<u32>,
    /// Two stroboscopic states are the same if x and y differ by less than this
    #[arg(long, help_heading = "Numerical settings", value_name = "DISTANCE")]
    pub period_tolerance: Option<f64>,
    /// Longest period of the motion to look for, in forcing periods (at most 1024); twice as many periods must be measured
    #[arg(long, help_heading = "Numerical settings", value_name = "PERIODS")]
    pub max_period: Option<u32>,
    /// Initial states for each point: (x0, y0), and others from the initial box
    #[arg(long, help_heading = "Numerical settings", value_name = "N")]
    pub initial_states: Option<u32>,
    /// Box of the other initial states, as X_MIN:X_MAX,Y_MIN:Y_MAX
    #[arg(long, help_heading = "Numerical settings", value_name = "BOX", value_parser = initial_box, allow_hyphen_values = true)]
    pub initial_box: Option<InitialBox>,
    /// Seed of the other initial states, which are the same at every point
    #[arg(long, help_heading = "Numerical settings")]
    pub seed: Option<u32>,
    /// Where to integrate: auto takes a hardware GPU if there is one, else the CPU
    #[arg(long, help_heading = "Devices", value_name = "auto|gpu|cpu", value_parser = named::<BackendChoice>)]
    pub backend: Option<BackendChoice>,
    /// Number type
    #[arg(long, help_heading = "Devices", value_name = "f32|f64", value_parser = named::<Precision>)]
    pub precision: Option<Precision>,
    /// Part of the name of the GPU adapter to use; `tribochaos devices` lists them
    #[arg(long, help_heading = "Devices", value_name = "NAME")]
    pub adapter: Option<String>,
}

impl ExperimentArgs {
    /// The request for a command (None for a map). Typed options have priority, then the file of --from, then the command's own
    /// defaults. The axes of the file are used only if there are as many as the command has.
    ///
    /// # Errors
    /// If a file cannot be read, or is not what it should be.
    pub fn request<const N: usize>(
        &self,
        command: Option<&str>,
        defaults: &Request,
        axes: [AskedAxis<'_>; N],
    ) -> Result<Request, Failure> {
        let mut request = self.subject.base(command, defaults)?;
        let of_file = request.axes.take().filter(|axes| axes.len() == N);
        let is_typed = axes.iter().all(|asked| asked.typed.is_some());
        if N > 0 && request.points.take().is_some() && !is_typed {
            return Err(Failure::Input(anyhow!(
                "the file holds a list of points, and this command computes over axes: give them"
            )));
        }
        let mut chosen = Vec::with_capacity(N);
        for (index, asked) in axes.into_iter().enumerate() {
            let axis = match (asked.typed, &of_file) {
                (None, Some(of_file)) => of_file[index].clone(),
                (typed, _) => {
                    let axis = typed.cloned().unwrap_or(asked.default);
                    // a parameter that becomes an axis loses the value it had in the file
                    request.set.remove(axis.coordinate.name());
                    axis
                }
            };
            chosen.push(axis);
        }
        self.apply(&mut request)?;
        let coordinates: Vec<Coordinate> = chosen.iter().map(|axis| axis.coordinate).collect();
        self.leave_free(&coordinates, &mut request);
        request.axes = Some(chosen);
        Ok(request)
    }

    /// Overrides the values of `request` by the typed ones.
    ///
    /// # Errors
    /// As [`SubjectArgs::apply`].
    pub fn apply(&self, request: &mut Request) -> Result<(), Failure> {
        if let Some(preset) = self.preset {
            request.set_preset(preset);
        }
        self.subject.apply(request)?;
        let Request {
            integration,
            sampling,
            device,
            ..
        } = request;
        if self.scheme.is_some() && self.scheme != integration.scheme {
            // a file's number of steps belongs to its scheme
            integration.steps_per_period = None;
        }
        macro_rules! apply {
            ($($field:ident)*) => { $(if let Some(value) = self.$field { sampling.$field = value; })* };
        }
        macro_rules! apply_optional {
            ($($field:ident)*) => { $(integration.$field = self.$field.or(integration.$field);)* };
        }
        apply!(transient_periods align_periods periods period_tolerance max_period initial_states initial_box seed);
        apply_optional!(scheme steps_per_period modes tolerance renormalise_every precision);
        if self.align_periods.is_none() {
            sampling.align_periods = sampling.align_periods.min(sampling.transient_periods);
        }
        device.backend = self.backend.unwrap_or(device.backend);
        device.adapter = self.adapter.clone().or(device.adapter.take());
        Ok(())
    }
}

/// An axis of a command.
pub struct AskedAxis<'a> {
    pub typed: Option<&'a Axis>,
    pub default: Axis,
}

/// A command's options: those of its file, overridden by the typed ones.
///
/// # Errors
/// If the file has an option that the command does not have, or a value out of its range.
pub fn options<O: Checked + Serialize + DeserializeOwned>(typed: &O, request: &Request) -> Result<O, Failure> {
    let mut table = request.options.clone();
    table.extend(toml::Table::try_from(typed).map_err(Failure::input)?);
    let read: Result<O, toml::de::Error> = table.try_into();
    let options = read.context("the options of the file").map_err(Failure::Input)?;
    options
        .check()
        .map_err(|reason| Failure::Input(anyhow!("the options of the file: {reason}")))?;
    Ok(options)
}

/// Options with limited values. The parser of the command line checks only typed values, so those of a file are checked here.
pub trait Checked {
    /// # Errors
    /// If a value is out of its range.
    fn check(&self) -> Result<(), String>;
}

/// Whether an option, if it is given, lies in its range.
///
/// # Errors
/// If it does not.
pub fn in_range<T: PartialOrd + Display>(name: &str, value: Option<T>, range: RangeInclusive<T>) -> Result<(), String> {
    match value {
        Some(value) if !range.contains(&value) => {
            let (least, most) = range.into_inner();
            Err(format!(
                "{name} = {value} is out of range: it must be from {least} to {most}"
            ))
        }
        _ => Ok(()),
    }
}

/// The resolved experiment of a command with all its options, as it is written into files and printed.
///
/// # Panics
/// If an option has no TOML form.
pub fn written(command: &str, experiment: &Experiment, options: &impl Serialize) -> Request {
    Request {
        command: Some(command.to_owned()),
        options: toml::Table::try_from(options).expect("options have a TOML form"),
        ..experiment.request()
    }
}

impl ExperimentArgs {
    /// Removes the preset's values of parameters that are axes from `request`. Values of --set stay, and are refused later.
    pub fn leave_free(&self, axes: &[Coordinate], request: &mut Request) {
        if self.preset.is_some() {
            for axis in axes {
                if self.subject.set.iter().all(|(coordinate, _)| coordinate != axis) {
                    request.set.remove(axis.name());
                }
            }
        }
    }
}

/// Adds the values of `defaults` to the help of a command's [`ExperimentArgs`], and hides the options in `hidden`: those that the
/// command refuses, or that have no meaning for it.
pub fn tell_defaults(command: clap::Command, defaults: &Request, hidden: &[&'static str]) -> clap::Command {
    let Request {
        integration,
        sampling,
        device,
        ..
    } = defaults;
    let usual = Integration::default();
    let scheme = integration
        .scheme
        .map_or("radau where gamma or k_w is not 0, else taylor", Scheme::name);
    let steps = Scheme::ALL.map(|scheme| format!("{} of {}", scheme.default_steps_per_period(), scheme.name()));
    let InitialBox { x, y } = sampling.initial_box;
    let defaults = [
        ("scheme", scheme.to_owned()),
        ("steps_per_period", steps.join(", ")),
        (
            "modes",
            format!("{}, and more where heat is conducted slowly", usual.modes),
        ),
        ("tolerance", format!("{:e}", usual.tolerance)),
        ("transient_periods", sampling.transient_periods.to_string()),
        (
            "align_periods",
            format!("{}, or the whole of a shorter transient", sampling.align_periods),
        ),
        ("periods", sampling.periods.to_string()),
        ("renormalise_every", usual.renormalise_every.to_string()),
        ("period_tolerance", format!("{:e}", sampling.period_tolerance)),
        ("max_period", sampling.max_period.to_string()),
        ("initial_states", sampling.initial_states.to_string()),
        ("initial_box", format!("{}:{},{}:{}", x[0], x[1], y[0], y[1])),
        ("seed", sampling.seed.to_string()),
        ("backend", device.backend.name().to_owned()),
        ("precision", "f64 on the CPU; a GPU has only f32".to_owned()),
    ];
    let told = defaults.into_iter().fold(command, |command, (option, default)| {
        command.mut_arg(option, |arg| {
            let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
            arg.help(format!("{help} [default: {default}]"))
        })
    });
    hidden
        .iter()
        .fold(told, |command, option| command.mut_arg(option, |arg| arg.hide(true)))
}

fn preset(text: &str) -> Result<Preset, String> {
    Preset::from_name(text).ok_or_else(|| format!("there is no preset `{text}`: the one there is, is `paper`"))
}

/// Reads a machine's file.
pub fn read_machine(path: &Path) -> anyhow::Result<Description> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    Description::from_toml(&text).with_context(|| format!("in {}", path.display()))
}

pub fn axis(text: &str) -> Result<Axis, String> {
    Axis::parse(text).map_err(|error| error.to_string())
}

/// Two numbers, LOW:HIGH.
pub fn range(text: &str) -> Result<[f64; 2], String> {
    let malformed = || format!("`{text}` is no range: write LOW:HIGH, for example -0.5:0.5");
    let (low, high) = text.split_once(':').ok_or_else(malformed)?;
    let number = |text: &str| text.trim().parse().map_err(|_| malformed());
    Ok([number(low)?, number(high)?])
}

/// The ends of a drawn axis, LOW:HIGH, the lower one first.
pub fn limits(text: &str) -> Result<[f64; 2], String> {
    let limits = range(text)?;
    check_limits(limits).map(|()| limits)
}

/// # Errors
/// If an end is not a finite number, or the ends are in the wrong order.
pub fn check_limits([low, high]: [f64; 2]) -> Result<(), String> {
    if low < high && low.is_finite() && high.is_finite() {
        Ok(())
    } else {
        Err(format!(
            "the limits {low}:{high} are no range: give the lower one first"
        ))
    }
}

pub fn initial_box(text: &str) -> Result<InitialBox, String> {
    let (x, y) = text
        .split_once(',')
        .ok_or("write X_MIN:X_MAX,Y_MIN:Y_MAX, for example -2:2,-2:2")?;
    Ok(InitialBox {
        x: range(x)?,
        y: range(y)?,
    })
}

pub fn assignment(text: &str) -> Result<(Coordinate, f64), String> {
    let malformed = || format!("`{text}` sets nothing: write NAME=VALUE, for example h1=0.5");
    let (name, value) = text.split_once('=').ok_or_else(malformed)?;
    let coordinate = Coordinate::from_name(name.trim()).map_err(|error| error.to_string())?;
    let value = value.trim();
    let value = value
        .parse()
        .map_err(|_| format!("`{value}` is no number: write {coordinate}=VALUE, for example {coordinate}=0.5"))?;
    coordinate.check(value).map_err(|error| error.to_string())?;
    Ok((coordinate, value))
}

/// Parses a value from the name that it has in files.
pub fn named<T: for<'de> Deserialize<'de>>(text: &str) -> Result<T, String> {
    let deserializer: StrDeserializer<'_, ValueError> = text.into_deserializer();
    T::deserialize(deserializer).map_err(|error| error.to_string())
}

/// The table of parameters, for the end of a command's help.
pub fn parameter_table() -> String {
    let mut help = String::from(
        "Parameters (dimensionless; any of them can be an axis or be set). An axis is\n\
         NAME=START:STOP:COUNT, NAME=log:START:STOP:COUNT or NAME=V1,V2,...:\n",
    );
    for info in PARAMETERS {
        let (min, max) = info.range;
        let _ = writeln!(
            help,
            "  {:<12} default {:<5} range {min}..{max}\n      {}: {} {}",
            info.name, info.default, info.symbol, info.meaning, info.source
        );
    }
    help.push_str(
        "\nWith --machine most of them follow from quantities in SI units, which can then\n\
         be axes or be set; `tribochaos machine --template` lists those. epsilon_0,\n\
         ramp_rate, x0 and y0 stay free.\n",
    );
    help
}

/// The table of parameters and the definition of the classes, for the end of a command's help.
pub fn help() -> String {
    let mut help = parameter_table();
    let _ = write!(
        help,
        "\nClasses, by the maximal exponent L (the larger non-trivial one) and its standard\n\
         error S, in this order:\n  \
         regular         on a cycle that attracts, of at most --max-period over the last\n                  \
                         {LEAST_WINDOW} periods, and twice over\n  \
         unstable        on a cycle, or at rest, where disturbances grow at the same rate\n                  \
                         in every period: no attractor\n  \
         chaotic         L - 3 S > 0, and a disturbance grew by more than {growth} over the\n                  \
                         measurement\n  \
         regular         L + 3 S < 0\n  \
         quasi_periodic  no such cycle, |L| < {QUASI_PERIODIC_BOUND:e} by a weighted Birkhoff average, and\n                  \
                         S < {QUASI_PERIODIC_ERROR:e}\n  \
         undecided       all else\n\
         Without a class are orbits that run away to |x| + |y| >= {RUNAWAY_BOUND:e}, and points\n\
         whose exponents miss the mean divergence D by more than\n\
         {DEFECT_BOUND:e} |D| + {DEFECT_FLOOR:e} (under-resolved).\n",
        growth = match CHAOTIC_GROWTH {
            1.0 => "e".to_owned(),
            power => format!("e^{power}"),
        },
    );
    help
}
