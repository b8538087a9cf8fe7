//! `lyapunov`: the exponents over one parameter, and the onset and the end of chaos.

use std::ops::Not;
use std::time::Instant;

use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::analysis::{self, Claim, OutArgs, StartArgs};
use super::onset::{Outcome, Search};
use super::request::{self, AskedAxis, Checked, ExperimentArgs};
use super::{Failure, words};
use crate::analysis::exponents::{Line, lines};
use crate::analysis::onset::STARTS;
use crate::design::Axis;
use crate::engine;
use crate::experiment::{Experiment, Request, Sampling, Settings};
use crate::measure::{Measurement, Status};
use crate::output::PROGRAM;
use crate::parameters::Parameter;
use crate::picture::sheet::Sheet;
use crate::picture::{caption, charts};

/// The name of the command in files.
const COMMAND: &str = "lyapunov";

/// The onset of chaos is the least chaotic value on a fine grid over the whole range of the axis, and the end is the greatest. A
/// value is chaotic if three conditions hold: the exponent is above 0.005 over 100 periods after 380; the motion is neither
/// regular nor quasi-periodic nor unstable; it is also chaotic over 2000 periods. The friction layer is resolved (rk4 takes at least 4000
/// steps a period). The number of values of the axis does not matter. Without an initial state by --start, --set or --preset,
/// three are tried: (0.1, 0), (1, 0) and (-1, 0).
#[derive(Args)]
#[command(after_long_help = request::help())]
#[command(mut_arg("start", |start| start.help(START_HELP)))]
pub struct LyapunovArgs {
    /// The parameter and its values, ends included [default: zeta_k=0:12:601]
    #[arg(long, value_name = "NAME=START:STOP:COUNT", value_parser = request::axis)]
    x: Option<Axis>,
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
    /// Spacing of the fine grid for onset and end; the grid has the multiples of the spacing [default: 0.0025 for zeta_k, for
    /// others the round number at or just below a thousandth of the range]
    #[arg(long, value_name = "STEP")]
    onset_spacing: Option<f64>,
    /// Do not look for the onset and the end of chaos
    #[arg(long, conflicts_with = "onset_spacing")]
    #[serde(default, skip_serializing_if = "Not::not")]
    no_onset: bool,
    /// Ends of the exponents' axis [default: from the data]
    #[arg(long, value_name = "LOW:HIGH", value_parser = request::limits, allow_hyphen_values = true)]
    limits: Option<[f64; 2]>,
    #[command(flatten)]
    #[serde(default, skip_serializing_if = "StartArgs::is_empty")]
    start: StartArgs,
}

impl Checked for Options {
    fn check(&self) -> Result<(), String> {
        self.limits.map_or(Ok(()), request::check_limits)?;
        self.start.check()
    }
}

const START_HELP: &str = "Initial state, x and y; may be repeated [default: that of x0 and y0 if one is set or the preset's, \
                          else 0.1,0 and 1,0 and -1,0]";

/// More exponents make a table and a picture that nobody opens.
const MOST_EXPONENTS: usize = 200_000;

pub fn run(args: &LyapunovArgs) -> Result<(), Failure> {
    let axis = AskedAxis {
        typed: args.x.as_ref(),
        default: analysis::default_axis(601),
    };
    let request = args
        .experiment
        .request(Some(COMMAND), &Request::of_analysis(), [axis])?;
    let mut options = request::options(&args.options, &request)?;
    let experiment = analysis::resolve(&request)?;
    let is_named = !options.start.is_empty() || analysis::gives_initial_state(&args.experiment, &request);
    options.start.start = if is_named {
        args.options
            .start
            .resolve(&options.start, &args.experiment, &experiment)?
    } else {
        STARTS.to_vec()
    };
    let (axis, starts) = (&experiment.design.axes()[0], &options.start.start);
    let exponents = axis.count() * starts.len();
    if exponents > MOST_EXPONENTS {
        return Err(Failure::Input(anyhow::anyhow!(
            "{exponents} exponents ({} values from {} initial states) are too many (at most {MOST_EXPONENTS}): use fewer values or \
             initial states, or `tribochaos map`",
            axis.count(),
            starts.len()
        )));
    }
    // each initial state has its own exponents here: they are not combined
    let settings = Settings {
        sampling: Sampling {
            initial_states: 1,
            ..experiment.settings.sampling
        },
        ..experiment.settings
    };
    if args.options.onset_spacing.is_some() {
        options.no_onset = false;
    }
    let search = if options.no_onset {
        Err("--no-onset")
    } else if experiment.wears() {
        Err("with wear all motion is transient, and its exponents of finite time tell no chaos")
    } else {
        Ok(Search::new(options.onset_spacing, &experiment, &settings)?)
    };
    options.onset_spacing = search.as_ref().ok().map(|search| search.spacing);
    let written = request::written(COMMAND, &experiment, &options);
    if args.experiment.subject.prints(&written) {
        return Ok(());
    }
    let starts = &options.start.start;
    let mut files = Claim::new(&args.out, "outputs/lyapunov", &[""], &written)?;
    let mut backends = analysis::choose(&experiment)?.backends;

    let started = Instant::now();
    let at = &experiment.design.fixed;
    let work = engine::instance_periods(&settings, exponents);
    let lines = analysis::compute(work, exponents, |observer| {
        lines(&mut backends, &settings, at, axis, starts, observer)
    })?;
    let onset = match search {
        Ok(search) => search.run(&experiment, starts, &mut backends)?,
        Err(reason) => Outcome::Left(reason),
    };
    let gaps = Gaps::of(&lines);
    draw(&mut files, options.limits, &experiment, &lines, &onset)?;
    table(&mut files, &experiment, &lines)?;
    files.tell(
        &experiment,
        || object(&experiment, starts, &onset, &gaps),
        || {
            print_line!(
                "{exponents} exponents in {}, each over {} periods after {}: {}",
                words::duration(started.elapsed()),
                settings.sampling.periods,
                settings.sampling.transient_periods,
                caption::scheme(&settings)
            );
            if gaps.under_resolved > 0 {
                print_line!(
                    "status: {} of {exponents} exponents were not measured, since their points are under-resolved: {}",
                    gaps.under_resolved,
                    words::remedy(&settings)
                );
            }
            if gaps.ran_away > 0 {
                print_line!(
                    "status: {} of {exponents} exponents were not measured, since the motion ran away",
                    gaps.ran_away
                );
            }
            print_line!("{}", onset.words(&experiment));
        },
    );
    Ok(())
}

/// Points without exponents.
struct Gaps {
    ran_away: usize,
    under_resolved: usize,
}

impl Gaps {
    fn of(lines: &[Line]) -> Self {
        let count = |matches: fn(Status) -> bool| {
            let measurements = lines.iter().flat_map(|line| &line.measurements);
            measurements.filter(|m| matches(m.status)).count()
        };
        Self {
            ran_away: count(|status| matches!(status, Status::Runaway { .. })),
            under_resolved: count(|status| status == Status::UnderResolved),
        }
    }
}

fn draw(
    files: &mut Claim,
    limits: Option<[f64; 2]>,
    experiment: &Experiment,
    lines: &[Line],
    onset: &Outcome,
) -> Result<(), Failure> {
    // the line that is drawn is the one that leads to chaos first
    let leads = |line: &&Line| onset.least().is_some_and(|found| found.start == line.start);
    let line = lines.iter().find(leads).unwrap_or(&lines[0]);
    let settings = &experiment.settings;
    let panel = charts::exponents("", line, &onset.marks(), limits);
    let shown = [line.axis.coordinate, Parameter::X0.into(), Parameter::Y0.into()];
    let from = charts::start(line.start);
    let from = if lines.len() == 1 {
        format!("each from (x, y) = {from}")
    } else {
        let starts: Vec<[f64; 2]> = lines.iter().map(|line| line.start).collect();
        format!(
            "each from {} initial states, (x, y) = {}; drawn is {}, {from}",
            starts.len(),
            analysis::starts_in_words(&starts),
            if onset.least().is_some() {
                "the first at the least value with chaos"
            } else {
                "the first of them"
            }
        )
    };
    let run = if experiment.wears() {
        format!(
            "exponents of finite time where the contact wears, over {} forcing periods from the start or until contact is lost",
            settings.sampling.periods
        )
    } else {
        format!(
            "{} measured forcing periods after {}",
            settings.sampling.periods, settings.sampling.transient_periods
        )
    };
    let gaps = match Gaps::of(std::slice::from_ref(line)) {
        Gaps {
            ran_away: 0,
            under_resolved: 0,
        } => String::new(),
        Gaps {
            ran_away,
            under_resolved,
        } => format!("Values without exponents: {ran_away} ran away, {under_resolved} under-resolved. "),
    };
    let caption = vec![
        caption::fixed(&line.fixed, &shown),
        format!(
            "{} values, {from}; {run}. {gaps}{}{}, {}. {PROGRAM}.",
            line.axis.count(),
            onset.caption(experiment),
            caption::scheme(settings),
            caption::integrated_on(line.measurements.iter().map(|m| m.backend))
        ),
    ];
    files.draw(
        "",
        &Sheet::single(panel, caption),
        "Lyapunov exponents of the bush-shaft system",
    )
}

fn table(files: &mut Claim, experiment: &Experiment, lines: &[Line]) -> Result<(), Failure> {
    let axis = &experiment.design.axes()[0];
    // if the contact wears at every value of the axis, there is only one exponent, of finite time
    let lasts = experiment.extent(Parameter::KW).0 == 0.0;
    // with heat there are more exponents than two, and the divergence is not their sum
    let has_divergence = lasts && experiment.extent(Parameter::Gamma).0 == 0.0;
    let columns: Vec<(&str, Column)> = [
        ("lambda_1", true, (|m| m.lyapunov) as Column),
        ("lambda_1_error", lasts, |m| m.lyapunov_error),
        ("lambda_2", lasts, |m| m.lyapunov_second),
        ("lambda_2_error", lasts, |m| m.lyapunov_second_error),
        (
            "lambda_3",
            true,
            |m| if m.status == Status::Ok { 0.0 } else { f64::NAN },
        ),
        ("divergence", has_divergence, |m| m.divergence),
        ("class", lasts, |m| {
            m.class.map_or(f64::NAN, |class| f64::from(class as u8))
        }),
    ]
    .into_iter()
    .filter_map(|(name, is_there, value)| is_there.then_some((name, value)))
    .collect();
    let rows = lines.iter().flat_map(|line| {
        line.measurements.iter().enumerate().map(|(index, m)| {
            let at = [line.start[0], line.start[1], axis.value(index)];
            let measured = columns.iter().map(|(_, value)| value(m));
            at.into_iter().chain(measured).collect::<Vec<f64>>()
        })
    });
    let mut notes = vec![analysis::unit_note(
        experiment,
        &[axis.coordinate],
        "exponents per unit of tau, empty where the motion ran away or is under-resolved; errors are standard errors; lambda_3 is \
         the trivial exponent along the flow",
    )];
    if experiment.wears() {
        notes.push("where the contact wears, lambda_1 is of finite time, and has neither error nor class".to_owned());
    }
    if lasts {
        notes.push("class: 0 chaotic, 1 regular, 2 quasi-periodic, 3 undecided, 4 unstable".to_owned());
    }
    let names = ["x0", "y0", axis.coordinate.name()];
    let names: Vec<&str> = names.into_iter().chain(columns.iter().map(|(name, _)| *name)).collect();
    files.table("", &notes, names, rows)
}

/// A column of the table.
type Column = fn(&Measurement) -> f64;

fn object(experiment: &Experiment, starts: &[[f64; 2]], onset: &Outcome, gaps: &Gaps) -> Value {
    let [onset, end] = onset.objects();
    json!({
        "parameters": analysis::parameters(experiment.design.fixed.parameters()),
        "axis": experiment.design.axes()[0],
        "starts": starts,
        "runaways": gaps.ran_away,
        "under_resolved": gaps.under_resolved,
        "onset": onset,
        "end": end,
    })
}
