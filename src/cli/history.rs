//! `history`: one point over time.

use anyhow::anyhow;
use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::analysis::{self, Claim, OutArgs};
use super::request::{self, Checked, ExperimentArgs};
use super::{Failure, si};
use crate::analysis::path::ended;
use crate::analysis::{History, Sample, history};
use crate::backend::Contact;
use crate::design::Fixed;
use crate::experiment::{BackendChoice, Experiment, Precision, Request, Sampling, Scheme};
use crate::machine::{Machine, Scale};
use crate::measure::Status;
use crate::output::PROGRAM;
use crate::parameters::Parameter;
use crate::picture::caption;
use crate::picture::charts::histories;
use crate::picture::sheet::Sheet;

/// The name of the command in files.
const COMMAND: &str = "history";

/// The point is followed from its initial state by radau, on the CPU in f64, over 30 forcing periods (--periods); without
/// heat and wear the pressure stays 1.
#[derive(Args)]
#[command(after_long_help = request::parameter_table())]
pub struct HistoryArgs {
    /// Samples in a forcing period, in equal steps [default: 128]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(4..=4096))]
    samples: Option<u32>,
    #[command(flatten)]
    experiment: ExperimentArgs,
    #[command(flatten)]
    out: OutArgs,
}

/// Options of a history. Its number of periods is separate from that of the sampling, since a measurement needs more periods.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Options {
    periods: Option<u32>,
    samples: Option<u32>,
}

impl Checked for Options {
    fn check(&self) -> Result<(), String> {
        request::in_range("samples", self.samples, 4..=4096)
    }
}

/// Default number of forcing periods. With the preset, contact is lost after 23.
const PERIODS: u32 = 30;
const SAMPLES: u32 = 128;
/// More samples make a table that nobody opens.
const MOST_SAMPLES: u64 = 1_000_000;

/// The defaults of this command.
pub fn defaults() -> Request {
    let mut defaults = Request::of_analysis();
    defaults.integration.scheme = Some(Scheme::Radau);
    defaults.sampling.periods = PERIODS;
    defaults.sampling.transient_periods = 0;
    defaults.sampling.align_periods = 0;
    defaults
}

/// Options of experiments that are refused here, or mean nothing to a history.
pub const HIDDEN: &[&str] = &[
    "scheme",
    "transient_periods",
    "align_periods",
    "renormalise_every",
    "period_tolerance",
    "max_period",
    "initial_states",
    "initial_box",
    "seed",
    "backend",
    "precision",
    "adapter",
];

pub fn run(args: &HistoryArgs) -> Result<(), Failure> {
    let (experiment, options) = experiment(args)?;
    let written = request::written(COMMAND, &experiment, &options);
    if args.experiment.subject.prints(&written) {
        return Ok(());
    }
    let (periods, samples) = (options.periods.unwrap_or(PERIODS), options.samples.unwrap_or(SAMPLES));
    let at = experiment.design.fixed;
    let mut files = Claim::new(&args.out, "outputs/history", &[""], &written)?;

    let history = history(at.parameters(), &experiment.settings.integration, 0..periods, samples);
    let last = history.samples.last().expect("the first sample is the initial state");
    let status = ended(&history);
    let reason = reason(&history);
    if history.given_up {
        eprintln!(
            "warning: given up after tau = {:.4}, where what is shown ends: {reason}",
            last.tau
        );
    }
    let contact = Contact {
        lost: history.contact_lost,
        peak_pressure: history.peak_pressure,
        peak_pressure_time: history.peak_pressure_time,
        final_wear: last.wear,
        peak_temperature: history.peak_temperature,
    };
    let angle = history.samples.iter().map(|sample| sample.x.abs()).fold(0.0, f64::max);
    let beyond = si::beyond(&at, &contact, angle);
    for warning in &beyond {
        eprintln!("warning: {warning}");
    }
    let scales = at.machine().map(Machine::scales);
    let sheet = Sheet::stacked(
        histories::stacked(&history, scales.as_ref()),
        words(&experiment, periods, samples, &history),
    );
    files.draw("", &sheet, "History of the bush-shaft system")?;
    let mut notes = vec![
        "tau: time; x, y: angle phi of the bush and its speed phi-dot; v: sliding speed".to_owned(),
        "pressure: p, 0 in the gap; wear: u_w; temperature: theta(1, tau); all dimensionless".to_owned(),
    ];
    let mut columns = vec!["tau", "x", "y", "v", "pressure", "wear", "temperature"];
    if scales.is_some() {
        notes.push("and in SI units; temperature_rise_k above the ambient temperature".to_owned());
        columns.extend([
            "time_s",
            "angular_speed_rad_per_s",
            "sliding_speed_m_per_s",
            "pressure_pa",
            "wear_m",
            "temperature_rise_k",
        ]);
    }
    notes.extend(contact.lost.map(|lost| format!("contact lost at tau_c = {lost}")));
    if history.given_up {
        notes.push(format!("given up after the last row: {reason}"));
    }
    let rows = history.samples.iter().map(|sample| {
        let Sample {
            tau,
            x,
            y,
            v,
            pressure,
            wear,
            temperature,
        } = *sample;
        let mut row = vec![tau, x, y, v, pressure, wear, temperature];
        if let Some(s) = &scales {
            row.extend([
                s.time * tau,
                y / s.time,
                s.speed * v,
                s.pressure * pressure,
                s.length * wear,
                s.temperature * temperature,
            ]);
        }
        row
    });
    files.table("", &notes, columns, rows)?;
    let object = || {
        let mut object = object(&experiment, periods, last, status, &contact);
        if scales.is_some() {
            object["si"] = si::contact(&at, &contact);
            let warnings = experiment.machine_warnings().into_iter().chain(beyond);
            object["warnings"] = warnings.collect();
        }
        object
    };
    files.tell(&experiment, object, || print(&at, last.tau, &contact));
    Ok(())
}

/// The experiment, with the number of periods and samples.
fn experiment(args: &HistoryArgs) -> Result<(Experiment, Options), Failure> {
    let refused = |reason: String| Err(Failure::Input(anyhow!(reason)));
    let asked = &args.experiment;
    if asked.scheme.is_some_and(|scheme| scheme != Scheme::Radau) {
        return refused("histories are followed by radau alone: leave --scheme out".to_owned());
    }
    if asked.backend == Some(BackendChoice::Gpu) || asked.precision == Some(Precision::F32) {
        return refused("histories are followed on the CPU in f64: leave --backend and --precision out".to_owned());
    }
    if asked.transient_periods.is_some_and(|periods| periods > 0) {
        return refused(
            "a history shows the run from its initial state: leave --transient-periods out, and give as many --periods \
             as are to be followed"
                .to_owned(),
        );
    }
    if asked.initial_states.is_some_and(|states| states > 1) {
        return refused(
            "a history is that of one initial state: leave --initial-states out, and set x0 and y0".to_owned(),
        );
    }
    let mut request = asked.request(Some(COMMAND), &defaults(), [])?;
    let typed = Options {
        periods: asked.periods,
        samples: args.samples,
    };
    let options = request::options(&typed, &request)?;
    let (periods, samples) = (options.periods.unwrap_or(PERIODS), options.samples.unwrap_or(SAMPLES));
    let most = MOST_SAMPLES / u64::from(samples);
    if !(1..=most).contains(&u64::from(periods)) {
        return refused(format!(
            "periods = {periods} is out of range: it must be from 1 to {most} with {samples} samples in each"
        ));
    }
    // all other sampling settings have no meaning for a history
    request.sampling = Sampling::default();
    request.device = defaults().device;
    if request.integration.scheme != Some(Scheme::Radau) {
        // the number of steps of another scheme does not apply to radau
        request.integration.steps_per_period = asked.steps_per_period;
        request.integration.scheme = Some(Scheme::Radau);
    }
    request.integration.precision = None;
    let experiment = request.resolve_point().map_err(Failure::input)?;
    // no warning about the length of the transient: a history shows the transient
    for warning in experiment.machine_warnings() {
        eprintln!("warning: {warning}");
    }
    let options = Options {
        periods: Some(periods),
        samples: Some(samples),
    };
    Ok((experiment, options))
}

/// Why a run ended before its time.
fn reason(history: &History) -> &'static str {
    match ended(history) {
        Status::Runaway { .. } if history.pressure_ran_away => "the contact pressure ran away",
        Status::Runaway { .. } => "the motion ran away",
        Status::Ok | Status::UnderResolved => "the next sample needs more or shorter steps than there may be",
    }
}

fn words(experiment: &Experiment, periods: u32, samples: u32, history: &History) -> Vec<String> {
    let at = &experiment.design.fixed;
    // an infinite rate is no ramp
    let shown: Vec<Parameter> = [Parameter::RampRate]
        .into_iter()
        .filter(|&parameter| at[parameter].is_infinite())
        .collect();
    let settings = &experiment.settings;
    let contact = match history.contact_lost {
        // the panels say when
        Some(_) => "",
        None if history.given_up => "",
        None if at.parameters().has_heat_or_wear() => "Contact held to the end. ",
        None => "Constant contact pressure. ",
    };
    let ended = match history.samples.last().filter(|_| history.given_up) {
        Some(last) => format!("Given up after τ = {:.4}: {}. ", last.tau, reason(history)),
        None => String::new(),
    };
    vec![
        caption::fixed(at, &shown),
        format!(
            "{periods} forcing periods, {samples} samples in each. {contact}{ended}{}, {} heat modes, tolerance {}, integrated \
             on CPU (f64). {PROGRAM}.",
            caption::scheme(settings),
            settings.integration.modes,
            settings.integration.tolerance
        ),
    ]
}

fn object(experiment: &Experiment, periods: u32, last: &Sample, status: Status, contact: &Contact) -> Value {
    json!({
        "parameters": analysis::parameters(experiment.design.fixed.parameters()),
        "periods": periods,
        "status": status.name(),
        "end": last.tau,
        "x": last.x,
        "y": last.y,
        "contact_status": contact.status_name(),
        "contact_time": contact.lost,
        "peak_pressure": contact.peak_pressure,
        "peak_pressure_time": contact.peak_pressure_time,
        "final_wear": contact.final_wear,
        "peak_temperature": contact.peak_temperature,
    })
}

fn print(at: &Fixed, end: f64, contact: &Contact) {
    print_line!(
        "followed            to tau = {end:.4}{}",
        si::behind(at, end, Scale::Time)
    );
    si::print_contact(at, contact, "held");
}
