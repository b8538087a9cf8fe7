//! `lyapunov`: the exponents over one parameter, and the onset of chaos.

use std::time::Instant;

use clap::Args;
use serde_json::{Value, json};
use tribochaos::analysis::exponents::{Line, lines};
use tribochaos::analysis::onset::{Definition, Found, Onset, onset};
use tribochaos::experiment::{Experiment, Request, Settings};
use tribochaos::grid::{Axis, Coordinate};
use tribochaos::output::sheet::Sheet;
use tribochaos::output::{PROGRAM, caption, charts};
use tribochaos::parameters::Parameter;
use tribochaos::sweep;

use super::analysis::{self, Files, OutArgs, StartArgs};
use super::progress::{self, Progress};
use super::request::{self, ExperimentArgs};
use super::{Failure, report};

/// The onset is the least value, on a fine grid within the bracket of the first upward change, with an exponent above 0.005
/// over 100 periods after 380, on motion that is neither regular nor quasi-periodic; the friction layer is resolved there
/// (rk4 takes at least 4000 steps a period). Without x0, y0 and --start, three initial states are tried: (0.1, 0), (1, 0) and (-1, 0).
#[derive(Args)]
#[command(after_help = request::help())]
pub struct LyapunovArgs {
    /// The parameter and its values, ends included [default: zeta_k=0:12:601]
    #[arg(long, value_name = "NAME=START:STOP:COUNT", value_parser = request::axis)]
    x: Option<Axis>,
    /// Spacing of the fine grid for the onset [default: 0.0025 for zeta_k; the axis' step if that is less, and for others a
    /// twentieth of it]
    #[arg(long, value_name = "STEP")]
    onset_spacing: Option<f64>,
    /// Do not look for the onset
    #[arg(long, conflicts_with = "onset_spacing")]
    no_onset: bool,
    /// Ends of the exponents' axis [default: from the data]
    #[arg(long, value_name = "LOW:HIGH", value_parser = request::range, allow_hyphen_values = true)]
    limits: Option<[f64; 2]>,
    #[command(flatten)]
    start: StartArgs,
    #[command(flatten)]
    experiment: ExperimentArgs,
    #[command(flatten)]
    out: OutArgs,
}

/// The grid by which the model's page defines the onset in zeta_k.
const ZETA_K_SPACING: f64 = 0.0025;

impl LyapunovArgs {
    fn spacing(&self, axis: &Axis) -> Result<f64, Failure> {
        let step = axis.step().abs();
        let Some(spacing) = self.onset_spacing else {
            return Ok(match axis.coordinate {
                Coordinate::Parameter(Parameter::ZetaK) => ZETA_K_SPACING.min(step),
                _ => step / 20.0,
            });
        };
        // written so that NaN fails
        if !(spacing > 0.0 && spacing <= step) {
            return Err(Failure::Input(anyhow::anyhow!(
                "--onset-spacing {spacing} is out of range: it must be positive, and no more than the axis' step {step}"
            )));
        }
        Ok(spacing)
    }
}

pub fn run(args: &LyapunovArgs) -> Result<(), Failure> {
    let axis = args.x.unwrap_or(Axis {
        coordinate: Parameter::ZetaK.into(),
        start: 0.0,
        stop: 12.0,
        count: 601,
    });
    let experiment = analysis::experiment(&args.experiment, Some(axis), Request::default())?;
    let named = !args.start.start.is_empty()
        || analysis::sets_initial_state(&args.experiment)
        || args.experiment.initial_states.is_some();
    let starts = if named {
        args.start.resolve(&args.experiment, &experiment)?
    } else {
        vec![[0.1, 0.0], [1.0, 0.0], [-1.0, 0.0]]
    };
    // initial states are told apart here, not combined
    let settings = Settings {
        initial_states: 1,
        ..experiment.settings.clone()
    };
    let definition = Definition::new(args.spacing(&axis)?, &settings);
    if let Some([low, high]) = args.limits
        && !(low < high && low.is_finite() && high.is_finite())
    {
        return Err(Failure::Input(anyhow::anyhow!(
            "the limits {low}:{high} are no range: give the lower one first"
        )));
    }
    let options = json!({
        "starts": starts,
        "onset_spacing": if args.no_onset { 0.0 } else { definition.spacing },
        "limits": args.limits.into_iter().collect::<Vec<_>>(),
    });
    let recipe = analysis::recipe("lyapunov", &experiment, options);
    let mut files = Files::claim(&args.out, "outputs/lyapunov", &[""], recipe)?;
    let mut choice = analysis::choose(&experiment)?;

    progress::catch_interrupt();
    let started = Instant::now();
    let at = &experiment.grid.fixed;
    let bar = Progress::new(
        sweep::instance_periods(&settings, axis.count * starts.len()),
        axis.count * starts.len(),
    );
    let interrupted = || Failure::Interrupted("nothing is drawn".into());
    let backends = &mut choice.backends;
    let lines = lines(backends, &settings, at, &axis, &starts, &mut |event| bar.hear(event))
        .map_err(Failure::backend)?
        .ok_or_else(interrupted)?;
    drop(bar);
    // with wear exponents are of finite time, and motion has no class
    let onset = if args.no_onset || analysis::wears(&experiment) {
        None
    } else {
        let observer = &mut |_: sweep::Event<'_>| progress::until_interrupted();
        let found = onset(backends, &definition, at, &lines, observer).map_err(Failure::backend)?;
        Some(found.ok_or_else(interrupted)?)
    };
    let found = match &onset {
        Some(Onset::Found(found)) => Some(found),
        _ => None,
    };
    let line = shown(&lines, found);
    draw(&mut files, args, &experiment, line, found)?;
    table(&mut files, &experiment, &lines)?;
    if args.out.json {
        files.report(Some(object(&experiment, &starts, onset.as_ref())));
        return Ok(());
    }
    say!(
        "{} exponents in {}",
        axis.count * starts.len(),
        report::duration(started.elapsed())
    );
    say!("{}", words(onset.as_ref(), &experiment, &definition));
    files.report(None);
    Ok(())
}

/// The line that is drawn: the one that chaos is reached on first.
fn shown<'a>(lines: &'a [Line], found: Option<&Found>) -> &'a Line {
    let is_first = |line: &&Line| found.is_some_and(|found| found.start == line.start);
    lines.iter().find(is_first).unwrap_or(&lines[0])
}

fn draw(
    files: &mut Files,
    args: &LyapunovArgs,
    experiment: &Experiment,
    line: &Line,
    found: Option<&Found>,
) -> Result<(), Failure> {
    let settings = &experiment.settings;
    let run = if analysis::wears(experiment) {
        format!(
            "{} forcing periods from the start, or until contact is lost",
            settings.periods
        )
    } else {
        format!(
            "{} measured forcing periods after {}",
            settings.periods, settings.transient_periods
        )
    };
    let panel = charts::exponents("", line, found, args.limits);
    let shown = [line.axis.coordinate, Parameter::X0.into(), Parameter::Y0.into()];
    let caption = vec![
        caption::fixed(&line.fixed, &shown),
        format!(
            "{} values, each from (x, y) = {}; {run}. {}, {}. {PROGRAM}.",
            line.axis.count,
            charts::start(line.start),
            caption::scheme(settings),
            caption::integrated_on(line.measurements.iter().map(|m| m.backend))
        ),
    ];
    let figure = Sheet::single(panel, caption).draw().map_err(Failure::run)?;
    files.draw("", &figure, "Lyapunov exponents of the bush-shaft system")
}

fn table(files: &mut Files, experiment: &Experiment, lines: &[Line]) -> Result<(), Failure> {
    let axis = &experiment.grid.axes[0];
    let rows = lines.iter().flat_map(|line| {
        line.measurements.iter().enumerate().map(|(index, m)| {
            [
                line.start[0],
                line.start[1],
                axis.value(index),
                m.lyapunov,
                m.lyapunov_error,
                m.lyapunov_second,
                m.lyapunov_second_error,
                0.0,
                m.divergence,
                m.class.map_or(f64::NAN, |class| f64::from(class as u8)),
            ]
        })
    });
    let notes = [
        analysis::unit_note(
            experiment,
            &[axis.coordinate],
            "exponents per unit of tau; errors are standard errors; lambda_3 is the trivial exponent along the flow",
        ),
        "class: 0 chaotic, 1 regular, 2 quasi-periodic, 3 undecided; empty: ran away or under-resolved".to_owned(),
    ];
    let columns = [
        "x0",
        "y0",
        axis.coordinate.name(),
        "lambda_1",
        "lambda_1_error",
        "lambda_2",
        "lambda_2_error",
        "lambda_3",
        "divergence",
        "class",
    ];
    files.table("", &notes, columns, rows)
}

fn words(onset: Option<&Onset>, experiment: &Experiment, definition: &Definition) -> String {
    let coordinate = experiment.grid.axes[0].coordinate;
    let unit = match experiment.grid.fixed.unit(coordinate) {
        "1" => String::new(),
        unit => format!(" {unit}"),
    };
    match onset {
        None => "onset: not looked for".to_owned(),
        Some(Onset::Never) => "onset: none of the initial states leads to chaos on the axis".to_owned(),
        Some(Onset::BelowAxis) => {
            "onset: below the axis, at whose lowest decided value the motion is chaotic already".to_owned()
        }
        Some(Onset::Found(found)) => format!(
            "onset: {coordinate} = {} +- {}{unit}, from (x, y) = ({}, {}), with exponent {:.4} +- {:.4}; by {} + {} periods of {} \
             {} steps on multiples of {}",
            charts::rounded(found.value),
            found.spacing,
            found.start[0],
            found.start[1],
            found.exponent,
            found.error,
            definition.settings.transient_periods,
            definition.settings.periods,
            definition.settings.steps_per_period(),
            definition.settings.scheme().name(),
            definition.spacing,
        ),
    }
}

fn object(experiment: &Experiment, starts: &[[f64; 2]], onset: Option<&Onset>) -> Value {
    let onset = match onset {
        Some(Onset::Found(found)) => json!({
            "value": charts::rounded(found.value),
            "uncertainty": found.spacing,
            "initial_state": found.start,
            "lyapunov": found.exponent,
            "lyapunov_error": found.error,
        }),
        Some(Onset::BelowAxis) => json!("below_axis"),
        Some(Onset::Never) => json!("never"),
        None => Value::Null,
    };
    let object = json!({
        "parameters": analysis::parameters(experiment.grid.fixed.parameters()),
        "axis": experiment.grid.axes[0],
        "starts": starts,
        "onset": onset,
    });
    analysis::with_machine(object, experiment)
}
