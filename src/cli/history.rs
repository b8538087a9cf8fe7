//! `history`: one point over time.

use anyhow::anyhow;
use clap::Args;
use serde_json::{Value, json};
use tribochaos::analysis::path::ended;
use tribochaos::backend::Contact;
use tribochaos::design::Fixed;
use tribochaos::dynamics::history::{History, Sample, history};
use tribochaos::experiment::{BackendChoice, Experiment, Precision, Request, Scheme};
use tribochaos::machine::{Machine, Scale};
use tribochaos::measure::Status;
use tribochaos::output::sheet::Sheet;
use tribochaos::output::{PROGRAM, caption, histories};
use tribochaos::parameters::Parameter;

use super::analysis::{self, Files, OutArgs};
use super::request::{self, ExperimentArgs};
use super::{Failure, si};

/// The point is followed from its initial state by radau, on the CPU in f64, over 30 forcing periods (--periods); without
/// heat and wear the pressure stays 1.
#[derive(Args)]
#[command(after_long_help = request::parameter_table())]
pub struct HistoryArgs {
    /// Samples in a forcing period, in equal steps
    #[arg(long, value_name = "N", default_value_t = 128, value_parser = clap::value_parser!(u32).range(4..=4096))]
    samples: u32,
    #[command(flatten)]
    experiment: ExperimentArgs,
    #[command(flatten)]
    out: OutArgs,
}

/// Forcing periods where none are asked for: contact at the preset is lost after 23.
const PERIODS: u32 = 30;
/// More samples make a table that nobody opens.
const MOST_SAMPLES: u64 = 1_000_000;

/// What holds where nothing else is asked for.
pub fn defaults() -> Request {
    let mut defaults = Request::default();
    let settings = &mut defaults.settings;
    settings.scheme = Some(Scheme::Radau);
    settings.periods = PERIODS;
    settings.transient_periods = 0;
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
    let (experiment, periods) = experiment(args)?;
    let at = experiment.design.fixed;
    let options = json!({ "periods": periods, "samples": args.samples });
    let recipe = analysis::recipe("history", &experiment, options);
    let mut files = Files::claim(&args.out, "outputs/history", &[""], recipe)?;

    let history = history(at.parameters(), &experiment.settings, 0..periods, args.samples);
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
        words(&experiment, args, periods, &history),
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
    if args.out.json.wanted() {
        let mut object = object(&experiment, periods, last, status, &contact);
        if scales.is_some() {
            object["si"] = si::contact(&at, &contact);
            let warnings = experiment.machine_warnings().into_iter().chain(beyond);
            object["warnings"] = warnings.collect();
        }
        files.report(Some(analysis::with_machine(object, &experiment)));
    } else {
        print(&at, last.tau, &contact);
        files.report(None);
    }
    Ok(())
}

/// The experiment and the forcing periods that are followed.
fn experiment(args: &HistoryArgs) -> Result<(Experiment, u32), Failure> {
    let refused = |reason: String| Err(Failure::Input(anyhow!(reason)));
    let mut request = defaults();
    args.experiment.apply(&mut request)?;
    let settings = &mut request.settings;
    if settings.scheme != Some(Scheme::Radau) {
        return refused("histories are followed by radau alone: leave --scheme out".to_owned());
    }
    if settings.backend == BackendChoice::Gpu || settings.precision == Some(Precision::F32) {
        return refused("histories are followed on the CPU in f64: leave --backend and --precision out".to_owned());
    }
    if settings.transient_periods > 0 {
        return refused(
            "a history shows the run from its initial state: leave --transient-periods out, and give as many --periods \
             as are to be followed"
                .to_owned(),
        );
    }
    if settings.initial_states > 1 {
        return refused(
            "a history is that of one initial state: leave --initial-states out, and set x0 and y0".to_owned(),
        );
    }
    let periods = settings.periods;
    let most = MOST_SAMPLES / u64::from(args.samples);
    if !(1..=most).contains(&u64::from(periods)) {
        return refused(format!(
            "periods = {periods} is out of range: it must be from 1 to {most} with {} samples in each",
            args.samples
        ));
    }
    settings.backend = BackendChoice::Cpu;
    // measurements need more periods than a history, which has its own number of them
    settings.periods = Request::default().settings.periods;
    let experiment = request.resolve_point().map_err(Failure::input)?;
    // none of the transient's length: a history shows the transient
    for warning in experiment.machine_warnings() {
        eprintln!("warning: {warning}");
    }
    Ok((experiment, periods))
}

/// Why a run ended before its time.
fn reason(history: &History) -> &'static str {
    match ended(history) {
        Status::Runaway { .. } if history.pressure_ran_away => "the contact pressure ran away",
        Status::Runaway { .. } => "the motion ran away",
        Status::Ok | Status::UnderResolved => "the next sample needs more or shorter steps than there may be",
    }
}

fn words(experiment: &Experiment, args: &HistoryArgs, periods: u32, history: &History) -> Vec<String> {
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
        None if at.parameters().is_rubbed() => "Contact held to the end. ",
        None => "Constant contact pressure. ",
    };
    let ended = match history.samples.last().filter(|_| history.given_up) {
        Some(last) => format!("Given up after τ = {:.4}: {}. ", last.tau, reason(history)),
        None => String::new(),
    };
    vec![
        caption::fixed(at, &shown),
        format!(
            "{periods} forcing periods, {} samples in each. {contact}{ended}{}, {} heat modes, tolerance {}, integrated \
             on CPU (f64). {PROGRAM}.",
            args.samples,
            caption::scheme(settings),
            settings.modes(),
            settings.tolerance
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
