//! `melnikov`: Mel'nikov's function, its extremes and its thresholds.

use clap::Args;
use serde_json::{Value, json};
use tribochaos::analysis::melnikov::{CurveError, default_range, sampled, threshold_curve};
use tribochaos::experiment::{Experiment, Request};
use tribochaos::grid::{Axis, Coordinate, Fixed, Grid};
use tribochaos::machine::units::si;
use tribochaos::model::melnikov::{self, Extremes, Melnikov, Search, Threshold};
use tribochaos::output::sheet::Sheet;
use tribochaos::output::{PROGRAM, caption, charts};
use tribochaos::parameters::Parameter;

use super::analysis::{self, Files, OutArgs, Values};
use super::request::SubjectArgs;
use super::{Failure, request};

/// Mel'nikov's function measures, to first order in epsilon, the distance between the stable and the unstable manifold of the
/// saddle at rest, with dry friction as sgn; as in the paper it is positive where the stable one has the greater energy. Where
/// it changes sign, chaos may occur. Only parameters of the reduced model enter; epsilon, epsilon_0 and the initial state do
/// not.
#[derive(Args)]
#[command(after_help = request::parameter_table())]
pub struct MelnikovArgs {
    #[command(flatten)]
    subject: SubjectArgs,
    /// Several values of a parameter, a curve for each
    #[arg(long, value_name = "NAME=V1,V2,...", value_parser = analysis::values)]
    at: Option<Values>,
    /// Parameter whose threshold is looked for, and where: the least value at which M begins to change sign
    /// [default: zeta_k=0:20]
    #[arg(long, value_name = "NAME[=LOW:HIGH]", value_parser = search)]
    threshold: Option<Search>,
    /// Draw the threshold over a second parameter
    #[arg(long, value_name = "NAME=START:STOP:COUNT", value_parser = request::axis)]
    over: Option<Axis>,
    /// Range of tau0 in the picture [default: a period to either side of 0]
    #[arg(long, value_name = "LOW:HIGH", value_parser = request::range, allow_hyphen_values = true)]
    tau: Option<[f64; 2]>,
    #[command(flatten)]
    out: OutArgs,
}

/// Values of tau0 in a curve.
const SAMPLES: usize = 1201;

fn search(text: &str) -> Result<Search, String> {
    let (name, range) = match text.split_once('=') {
        Some((name, range)) => (name, Some(request::range(range)?)),
        None => (text, None),
    };
    let parameter = Parameter::from_name(name.trim()).map_err(|error| error.to_string())?;
    let (low, high) = range.map_or_else(|| default_range(parameter), |[low, high]| (low, high));
    for value in [low, high] {
        parameter.check(value).map_err(|error| error.to_string())?;
    }
    Search::new(parameter, low, high).map_err(|error| error.to_string())
}

pub fn run(args: &MelnikovArgs) -> Result<(), Failure> {
    let experiment = experiment(args)?;
    let at = experiment.grid.fixed;
    let points = analysis::points(args.at.as_ref(), &at, &args.subject.set)?;
    let functions = points
        .iter()
        .map(|point| Melnikov::new(point.parameters()))
        .collect::<Result<Vec<_>, _>>()
        .map_err(Failure::input)?;
    let period = functions[0].period();
    let [low, high] = args.tau.unwrap_or([-period, period]);
    if !(low < high && low.is_finite() && high.is_finite()) {
        return Err(Failure::Input(anyhow::anyhow!(
            "tau0 from {low} to {high} is no range: give the lower end first"
        )));
    }
    let (zeta_low, zeta_high) = default_range(Parameter::ZetaK);
    let search = match args.threshold {
        Some(search) => search,
        None => Search::new(Parameter::ZetaK, zeta_low, zeta_high).map_err(Failure::input)?,
    };
    if let Some(over) = args.over.filter(|over| over.coordinate == search.parameter.into()) {
        let name = over.coordinate.name();
        return Err(Failure::input(CurveError::SameParameter { name }));
    }
    if let Some(over) = args.over {
        over.coordinate
            .check_free(at.machine().is_some())
            .map_err(Failure::input)?;
        let grid = Grid {
            axes: vec![over],
            fixed: at,
        };
        grid.extents().map_err(Failure::input)?;
    }
    let options = json!({
        "at": args.at.as_ref().map_or(Value::Array(vec![]), |values| json!([values.coordinate, values.values])),
        "threshold": [json!(search.parameter), json!(search.low), json!(search.high)],
        "over": args.over.map_or(Value::Array(vec![]), |over| json!([over])),
        "tau": [low, high],
    });
    let recipe = analysis::recipe("melnikov", &experiment, options);
    let drawings: &[&str] = if args.over.is_some() {
        &["", "-threshold"]
    } else {
        &[""]
    };
    let mut files = Files::claim(&args.out, "outputs/melnikov", drawings, recipe)?;

    let coordinate = Values::coordinate_of(args.at.as_ref());
    let mut curves = Vec::new();
    let mut rows = Vec::new();
    for (point, function) in points.iter().zip(&functions) {
        let value = analysis::value_of(point, coordinate);
        let curve = sampled(point.parameters(), low, high, SAMPLES).map_err(Failure::input)?;
        let name = match &args.at {
            Some(_) => caption::assigned(point, coordinate, value),
            None => String::new(),
        };
        rows.extend(curve.iter().map(|&[tau_0, m]| [value, tau_0, m]));
        curves.push((name, curve));
        let found = melnikov::threshold(point.parameters(), &search).map_err(Failure::input)?;
        let summary = Summary {
            point,
            extremes: function.extremes(),
            threshold: found,
            defect: defect(function, low, high),
        };
        if args.out.json {
            continue;
        }
        summary.print(&search, args.at.as_ref());
    }
    let unseen = [Parameter::Epsilon, Parameter::Epsilon0, Parameter::X0, Parameter::Y0];
    let mut shown: Vec<Coordinate> = unseen.map(Coordinate::from).to_vec();
    shown.extend(args.at.as_ref().map(|values| values.coordinate));
    let caption = |shown: &[Coordinate]| vec![caption::fixed(&at, shown), format!("{PROGRAM}.")];
    let sheet = Sheet::single(charts::melnikov("", &curves, None), caption(&shown));
    files.draw(
        "",
        &sheet.draw().map_err(Failure::run)?,
        "Mel'nikov's function of the bush-shaft system",
    )?;
    let note = analysis::unit_note(&experiment, &[coordinate], "");
    let notes: Vec<String> = [note].into_iter().filter(|note| !note.is_empty()).collect();
    files.table("", &notes, [coordinate.name(), "tau_0", "melnikov"], rows.into_iter())?;

    if let Some(over) = args.over {
        let curve = threshold_curve(&at, &search, &over).map_err(Failure::input)?;
        shown.extend([search.parameter.into(), over.coordinate]);
        let sheet = Sheet::single(charts::threshold(&curve), caption(&shown));
        let title = format!("Mel'nikov's threshold in {}", search.parameter);
        files.draw("-threshold", &sheet.draw().map_err(Failure::run)?, &title)?;
        let rows = curve.thresholds.iter().enumerate();
        files.table(
            "-threshold",
            &[analysis::unit_note(
                &experiment,
                &[over.coordinate],
                "empty: no threshold within the range that was searched",
            )],
            [over.coordinate.name(), &format!("{}_threshold", search.parameter)],
            rows.map(|(index, threshold)| [over.value(index), threshold.value().unwrap_or(f64::NAN)]),
        )?;
    }
    let object = args
        .out
        .json
        .then(|| object(&points, &functions, &search))
        .transpose()?;
    files.report(object.map(|object| analysis::with_machine(object, &experiment)));
    Ok(())
}

/// An experiment without axes, of which only the parameters count.
fn experiment(args: &MelnikovArgs) -> Result<Experiment, Failure> {
    let mut request = Request::default();
    args.subject.apply(&mut request)?;
    request.resolve_point().map_err(Failure::input)
}

/// Greatest difference between the closed form and the quadrature at some tau0: the program's check of itself.
fn defect(function: &Melnikov, low: f64, high: f64) -> f64 {
    (0..8)
        .map(|k| low + (high - low) * (f64::from(k) + 0.5) / 8.0)
        .map(|tau_0| (function.closed_form(tau_0) - function.quadrature(tau_0)).abs())
        .fold(0.0, f64::max)
}

struct Summary<'a> {
    point: &'a Fixed,
    extremes: Extremes,
    threshold: Threshold,
    defect: f64,
}

impl Summary<'_> {
    /// The amplitude of the shaft's speed that a threshold in zeta_k is, of a machine.
    fn amplitude(&self, search: &Search, value: f64) -> String {
        match self.point.machine() {
            Some(machine) if search.parameter == Parameter::ZetaK => format!(
                ", shaft_speed_amplitude = {}",
                si(value / machine.scales().time, "rad/s")
            ),
            _ => String::new(),
        }
    }

    fn print(&self, search: &Search, values: Option<&Values>) {
        if let Some(values) = values {
            let value = analysis::value_of(self.point, values.coordinate);
            say!("{} = {value}", values.coordinate);
        }
        let e = &self.extremes;
        say!("least M             {:.6} at tau0 = {:.6}", e.minimum, e.minimum_at);
        say!("greatest M          {:.6} at tau0 = {:.6}", e.maximum, e.maximum_at);
        say!(
            "M changes sign      {}",
            if e.change_sign() { "yes: chaos may occur" } else { "no" }
        );
        let (name, low, high) = (search.parameter, search.low, search.high);
        match self.threshold {
            Threshold::At(value) => say!(
                "threshold           {name} = {value:.6}{}",
                self.amplitude(search, value)
            ),
            Threshold::BelowRange => say!("threshold           below {name} = {low}, where M changes sign already"),
            Threshold::Never => say!("threshold           none for {name} from {low} to {high}"),
        }
        say!("closed form less quadrature: {:.1e} at most\n", self.defect);
    }
}

fn object(points: &[Fixed], functions: &[Melnikov], search: &Search) -> Result<Value, Failure> {
    let objects = points
        .iter()
        .zip(functions)
        .map(|(point, function)| {
            let extremes = function.extremes();
            let mut object = serde_json::to_value(extremes).map_err(Failure::run)?;
            object["changes_sign"] = extremes.change_sign().into();
            let found = melnikov::threshold(point.parameters(), search).map_err(Failure::input)?;
            object["threshold"] = found.value().map_or(Value::Null, Value::from);
            object["threshold_parameter"] = search.parameter.name().into();
            object["parameters"] = analysis::parameters(point.parameters());
            Ok(object)
        })
        .collect::<Result<Vec<Value>, Failure>>()?;
    // one point is the object itself
    Ok(match <[Value; 1]>::try_from(objects) {
        Ok([object]) => object,
        Err(objects) => json!({ "points": objects }),
    })
}
