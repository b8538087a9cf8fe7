//! `point`: everything about one point.

use clap::Args;
use serde_json::{Map, Value, json};

use super::analysis::OutArgs;
use super::lifetime::LifetimeArgs;
use super::request::{self, ExperimentArgs};
use super::{Failure, analysis, progress, si, words};
use crate::backend::cpu::CpuBackend;
use crate::dynamics::spectrum::{Spectrum, lyapunov_spectrum};
use crate::engine::{Backends, choice};
use crate::experiment::{Experiment, Integration, Precision, Request, Scheme, Settings};
use crate::measure::{Measurement, Status, is_scheme_to_blame};

/// The name of the command in files.
const COMMAND: &str = "point";

/// One point is integrated on the CPU unless a GPU is asked for, since one point would not use a GPU fully.
#[derive(Args)]
#[command(after_long_help = request::help())]
#[command(mut_arg("out", |arg| arg.help(OUT_HELP)))]
pub struct PointArgs {
    #[command(flatten)]
    experiment: ExperimentArgs,
    /// Also print all three exponents by the paper's procedure: three tangent vectors, orthonormalised by Gram and Schmidt in
    /// steps of rk4 (at constant pressure; takes many times as long)
    #[arg(long)]
    gram_schmidt: bool,
    #[command(flatten)]
    out: OutArgs,
    #[command(flatten)]
    lifetime: LifetimeArgs,
}

const OUT_HELP: &str =
    "What the names of the drawing and the table of --lifetime begin with [default: outputs/lifetime]";

pub fn run(args: &PointArgs) -> Result<(), Failure> {
    let request = args.experiment.request(Some(COMMAND), &Request::of_analysis(), [])?;
    let options = request::options(&args.lifetime, &request)?;
    let experiment = request.resolve_point().map_err(Failure::input)?;
    for warning in experiment.warnings() {
        eprintln!("warning: {warning}");
    }
    let written = request::written(COMMAND, &experiment, &options);
    if args.experiment.subject.prints(&written) {
        return Ok(());
    }
    if options.lifetime.is_none() && (args.out.out.is_some() || args.out.force) {
        return Err(Failure::Input(anyhow::anyhow!(
            "only --lifetime writes files: leave --out and --force out"
        )));
    }
    let plan = options.plan(&experiment, &written, &args.out)?;
    let mut backends = choice::choose(&experiment).map_err(Failure::backend)?.backends;
    progress::catch_signals();
    let measured = backends
        .measure(&experiment.design, &experiment.settings, &[0], &mut |_| {
            progress::until_stopped()
        })
        .map_err(Failure::backend)?
        .ok_or_else(|| Failure::Interrupted("nothing was measured".into()))?;
    let m = &measured[0];
    // the instance from the initial state whose exponent is reported
    let instance = experiment.design.point(0).with_initial_state(m.initial_state);
    // the paper's procedure holds only for constant pressure
    let spectrum = (args.gram_schmidt && m.status == Status::Ok && !instance.has_heat_or_wear())
        .then(|| lyapunov_spectrum(&instance, &experiment.settings))
        .flatten();
    let beyond = si::beyond(&experiment.design.fixed, &m.contact, m.x_min.abs().max(m.x_max.abs()));
    for warning in &beyond {
        eprintln!("warning: {warning}");
    }
    let lifetime = plan
        .map(|plan| plan.carry_out(&experiment, &mut backends))
        .transpose()?;
    let by_default = match m.status {
        Status::UnderResolved if !args.out.json.wanted() => by_default(&experiment)?,
        _ => None,
    };
    let warnings = experiment.warnings().into_iter().chain(beyond).collect();
    let object = object(&experiment, m, spectrum.as_ref(), warnings);
    let print = || print(&experiment, m, by_default.as_ref(), spectrum.as_ref());
    match lifetime {
        Some(lifetime) => lifetime.tell(&experiment, object, print),
        None if args.out.json.wanted() => args.out.json.print(&analysis::with_machine(object, &experiment)),
        None => print(),
    }
    Ok(())
}

fn object(experiment: &Experiment, m: &Measurement, spectrum: Option<&Spectrum>, warnings: Vec<String>) -> Value {
    let parameters: Map<String, Value> = experiment
        .fixed_parameters()
        .map(|(parameter, value)| (parameter.name().to_owned(), value.into()))
        .collect();
    let mut object = json!({
        "parameters": parameters,
        "settings": experiment.settings,
        "backend": m.backend.device_class(),
        "precision": m.backend.precision(),
        "status": m.status.name(),
        "class": m.class,
        "lyapunov": m.lyapunov,
        "lyapunov_error": m.lyapunov_error,
        "scheme_error": m.scheme_error,
        "lyapunov_interval": m.lyapunov_interval,
        "lyapunov_second": m.lyapunov_second,
        "divergence": m.divergence,
        "period": m.period,
        "x": m.x,
        "y": m.y,
        "x_min": m.x_min,
        "x_max": m.x_max,
        "contact_status": m.contact.status_name(),
        "contact_time": m.contact.lost,
        "peak_pressure": m.contact.peak_pressure,
        "peak_pressure_time": m.contact.peak_pressure_time,
        "final_wear": m.contact.final_wear,
        "peak_temperature": m.contact.peak_temperature,
    });
    if let Some(spectrum) = spectrum {
        object["gram_schmidt_spectrum"] = json!(spectrum.exponents);
        object["gram_schmidt_errors"] = json!(spectrum.errors);
    }
    if let Status::Runaway { time } = m.status {
        object["runaway_time"] = time.into();
    }
    if experiment.settings.sampling.initial_states > 1 {
        object["chaotic_fraction"] = m.chaotic_fraction.into();
        object["attractors"] = m.attractors.into();
        object["unsettled_fraction"] = m.unsettled_fraction.into();
    }
    let at = &experiment.design.fixed;
    if at.machine().is_some() {
        object["si"] = si::measurement(at, m);
        object["warnings"] = warnings.into();
    }
    object
}

/// Measures the point again by the default scheme, after another scheme did not resolve it.
fn by_default(experiment: &Experiment) -> Result<Option<Measurement>, Failure> {
    if experiment.settings.integration.scheme == Scheme::Taylor || experiment.design.point(0).has_heat_or_wear() {
        return Ok(None);
    }
    let settings = Settings {
        integration: Integration {
            precision: Some(Precision::F64),
            ..Scheme::Taylor.into()
        },
        ..experiment.settings
    };
    let mut backends = Backends::new(Box::new(CpuBackend::new(Precision::F64)), None);
    let measured = backends.measure(&experiment.design, &settings, &[0], &mut |_| progress::until_stopped());
    Ok(measured.map_err(Failure::backend)?.map(|measured| measured[0]))
}

/// The advice to the user, from the result of the default scheme.
fn tried(by_default: &Measurement) -> String {
    match by_default.status {
        Status::Ok => format!(
            "the default scheme, tried here, gives {:.6} +- {:.6}; leave --scheme out",
            by_default.lyapunov, by_default.lyapunov_error
        ),
        Status::Runaway { time } => {
            format!("by the default scheme, tried here, it runs away at tau = {time:.3}; leave --scheme out")
        }
        Status::UnderResolved => "the default scheme, tried here, does not resolve it either".to_owned(),
    }
}

fn print(experiment: &Experiment, m: &Measurement, by_default: Option<&Measurement>, spectrum: Option<&Spectrum>) {
    for (parameter, value) in experiment.fixed_parameters() {
        print_text!("{parameter} = {value}  ");
    }
    print_line!("\n");
    let settings = &experiment.settings;
    match m.status {
        Status::Ok => {}
        Status::Runaway { time } => {
            print_line!("ran away at tau = {time:.3}");
            return;
        }
        Status::UnderResolved => {
            let remedy = by_default.map_or_else(|| words::remedy(settings).to_owned(), tried);
            print_line!("under-resolved, nothing was measured: {remedy}");
            return;
        }
    }
    let at = &experiment.design.fixed;
    print_line!(
        "class               {}",
        m.class.map_or("-", crate::measure::Class::name)
    );
    if m.lyapunov_error.is_nan() {
        print_line!(
            "maximal exponent    {:.6}  (of finite time, over {:.4} tau)",
            m.lyapunov,
            m.lyapunov_interval
        );
    } else {
        print_line!("maximal exponent    {:.6} +- {:.6}", m.lyapunov, m.lyapunov_error);
    }
    if is_scheme_to_blame(m.scheme_error, m.lyapunov_error) {
        print_line!(
            "                    (most of the error is the scheme's: {})",
            words::finer(settings)
        );
    }
    if m.is_on_limit_cycle() {
        print_line!("                    (the mean divergence of a limit cycle; the zero along the flow is left out)");
    } else if !m.lyapunov_second.is_nan() {
        print_line!("second exponent     {:.6}", m.lyapunov_second);
    }
    if !m.is_on_limit_cycle() && !m.divergence.is_nan() {
        print_line!(
            "mean divergence     {:.6}  (sum of the exponents less this: {:.1e})",
            m.divergence,
            m.divergence_defect()
        );
    }
    if let Some(Spectrum { exponents, errors }) = spectrum {
        let exponents = std::array::from_fn::<_, 3, _>(|n| format!("{:.6} +- {:.6}", exponents[n], errors[n]));
        print_line!(
            "by Gram-Schmidt     {}  (the paper's procedure, in its own run: {} periods after {})",
            exponents.join(", "),
            settings.sampling.periods,
            settings.sampling.transient_periods
        );
    }
    print_line!(
        "period              {}{}",
        m.period.map_or("none found".to_owned(), |period| period.to_string()),
        si::frequency_behind(at, m.period)
    );
    print_line!("x, y                {:.9} {:.9}  (last stroboscopic state)", m.x, m.y);
    print_line!("extremes of x       {:.6} {:.6}", m.x_min, m.x_max);
    if settings.integration.scheme.carries_heat() {
        si::print_contact(at, &m.contact, "held to the end of the run");
    }
    if settings.sampling.initial_states > 1 {
        print_line!(
            "chaotic fraction    {} of {} initial states",
            m.chaotic_fraction,
            settings.sampling.initial_states
        );
        print_line!("attractors          {}", m.attractors);
        print_line!(
            "not settled         {:.0} % of the initial states",
            100.0 * m.unsettled_fraction
        );
    }
    print_line!(
        "integrated on       {}, {}",
        m.backend.device_class(),
        m.backend.precision()
    );
}
