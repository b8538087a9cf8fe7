//! `melnikov`: Mel'nikov's function, its extremes and its thresholds.

use anyhow::anyhow;
use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::analysis::{self, Claim, OutArgs};
use super::request::Checked;
use super::request::SubjectArgs;
use super::{Failure, request};
use crate::analysis::melnikov::{Curve, CurveError, SEARCH_VALUES, default_search, sampled, threshold_curve};
use crate::design::{Axis, Coordinate, Design, Fixed, Points};
use crate::experiment::Request;
use crate::machine::units::si;
use crate::model::melnikov::{self, Extremes, Melnikov, Threshold};
use crate::output::PROGRAM;
use crate::parameters::Parameter;
use crate::picture::sheet::Sheet;
use crate::picture::{caption, charts};

/// The name of the command in files.
const COMMAND: &str = "melnikov";

/// Mel'nikov's function M measures the distance between the stable and the unstable manifold of the saddle, to first order in
/// epsilon and with dry friction as sgn. As in the paper, M is positive where the stable manifold has the greater energy. If M
/// changes sign, chaos may occur. M depends only on parameters of the reduced model, and not on epsilon, epsilon_0 and the
/// initial state.
#[derive(Args)]
#[command(after_long_help = request::parameter_table())]
pub struct MelnikovArgs {
    #[command(flatten)]
    subject: SubjectArgs,
    /// Several values of a parameter, a curve for each
    #[arg(long, value_name = "NAME=V1,V2,...", value_parser = analysis::values)]
    at: Option<Points>,
    #[command(flatten)]
    options: Options,
    #[command(flatten)]
    out: OutArgs,
}

#[derive(Args, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Options {
    /// Parameter or quantity of the machine whose threshold is looked for, and the range of the search. The threshold is the
    /// least value at which M begins or ceases to change sign [default: zeta_k=0:20, of a machine the shaft_speed_amplitude that
    /// gives it]
    #[arg(long, value_name = "NAME[=LOW:HIGH]", value_parser = sought)]
    threshold: Option<Sought>,
    /// Draw the threshold over a second parameter, or quantity of the machine
    #[arg(long, value_name = "NAME=START:STOP:COUNT", value_parser = request::axis)]
    over: Option<Axis>,
    /// Range of tau0 in the picture [default: a period to either side of 0]
    #[arg(long, value_name = "LOW:HIGH", value_parser = tau, allow_hyphen_values = true)]
    tau: Option<[f64; 2]>,
}

impl Checked for Options {
    fn check(&self) -> Result<(), String> {
        self.tau.map_or(Ok(()), check_tau)?;
        self.threshold.map_or(Ok(()), Sought::check)
    }
}

fn tau(text: &str) -> Result<[f64; 2], String> {
    let tau = request::range(text)?;
    check_tau(tau).map(|()| tau)
}

fn check_tau([low, high]: [f64; 2]) -> Result<(), String> {
    if low < high && low.is_finite() && high.is_finite() {
        Ok(())
    } else {
        Err(format!(
            "tau0 from {low} to {high} is no range: give the lower end first"
        ))
    }
}

/// Values of tau0 in a curve.
const SAMPLES: usize = 1201;

/// The coordinate whose threshold is looked for, and the range of the search.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Sought {
    coordinate: Coordinate,
    range: Option<[f64; 2]>,
}

fn sought(text: &str) -> Result<Sought, String> {
    let (name, range) = match text.split_once('=') {
        Some((name, range)) => (name, Some(request::range(range)?)),
        None => (text, None),
    };
    let coordinate = Coordinate::from_name(name.trim()).map_err(|error| error.to_string())?;
    let sought = Sought { coordinate, range };
    sought.check().map(|()| sought)
}

impl Sought {
    fn check(self) -> Result<(), String> {
        let Self { coordinate, range } = self;
        if let Some([low, high]) = range {
            for value in [low, high] {
                coordinate.check(value).map_err(|error| error.to_string())?;
            }
            if low >= high {
                return Err(format!(
                    "the search for a threshold in {coordinate} needs a range: from {low} to {high} is none; give LOW:HIGH, the \
                 lower one first"
                ));
            }
        }
        Ok(())
    }
}

/// The axis along which the threshold is looked for.
fn search(sought: Option<Sought>, at: &Fixed) -> Result<Axis, Failure> {
    let Sought { coordinate, range } = sought.unwrap_or_else(|| Sought {
        coordinate: at
            .governing(Parameter::ZetaK)
            .map_or(Parameter::ZetaK.into(), Coordinate::from),
        range: None,
    });
    check(coordinate, at)?;
    let Some([low, high]) = range else {
        return default_search(at, coordinate).ok_or_else(|| {
            let unit = at.unit(coordinate);
            Failure::Input(anyhow!(
                "where to look for a threshold in {coordinate}: give a range, --threshold {coordinate}=LOW:HIGH{}",
                if unit == "1" {
                    String::new()
                } else {
                    format!(", in {unit}")
                }
            ))
        });
    };
    Axis::even(coordinate, low, high, SEARCH_VALUES).map_err(Failure::input)
}

/// Checks that a coordinate may be varied, and that M varies with it.
fn check(coordinate: Coordinate, at: &Fixed) -> Result<(), Failure> {
    coordinate.check_free(at.machine().is_some()).map_err(Failure::input)?;
    melnikov::check_depends(at, coordinate).map_err(Failure::input)
}

/// Checks that the machine, if there is one, is valid everywhere along the axes.
fn check_machines(axes: Vec<Axis>, at: &Fixed) -> Result<(), Failure> {
    let design = Design::product(axes, *at);
    design.extents().map(|_| ()).map_err(Failure::input)
}

#[expect(
    clippy::too_many_lines,
    reason = "the code follows the command from its options to its files"
)]
pub fn run(args: &MelnikovArgs) -> Result<(), Failure> {
    let mut request = args.subject.base(Some(COMMAND), &Request::default())?;
    args.subject.apply(&mut request)?;
    analysis::at_points(&mut request, args.at.as_ref(), &args.subject)?;
    let mut options = request::options(&args.options, &request)?;
    let experiment = request.resolve().map_err(Failure::input)?;
    let at = experiment.design.fixed;
    let points = analysis::points(&experiment);
    if points.len() > charts::MOST_CURVES {
        return Err(Failure::Input(anyhow::anyhow!(
            "{} curves are too many for one picture (at most {}): give fewer values",
            points.len(),
            charts::MOST_CURVES
        )));
    }
    let functions = points
        .iter()
        .map(|point| Melnikov::new(point.parameters()))
        .collect::<Result<Vec<_>, _>>()
        .map_err(Failure::input)?;
    let varied = experiment.design.varied.coordinates();
    for &coordinate in &varied {
        check(coordinate, &at)?;
    }
    let along = search(options.threshold, &at)?;
    for point in &points {
        check_machines(vec![along.clone()], point)?;
    }
    if let Some(over) = &options.over {
        if over.coordinate == along.coordinate {
            let name = over.coordinate.name();
            return Err(Failure::input(CurveError::SameParameter { name }));
        }
        check(over.coordinate, &at)?;
        check_machines(vec![along.clone(), over.clone()], &at)?;
    }
    let period = functions[0].period();
    let [low, high] = *options.tau.get_or_insert([-period, period]);
    options.threshold = Some(Sought {
        coordinate: along.coordinate,
        range: Some([along.first(), along.last()]),
    });
    let written = request::written(COMMAND, &experiment, &options);
    if args.subject.prints(&written) {
        return Ok(());
    }
    let drawings: &[&str] = if options.over.is_some() {
        &["", "-threshold"]
    } else {
        &[""]
    };
    let mut files = Claim::new(&args.out, "outputs/melnikov", drawings, &written)?;

    let mut curves = Vec::new();
    let mut rows = Vec::new();
    let mut objects = Vec::new();
    for (point, function) in points.iter().zip(&functions) {
        let values: Vec<f64> = varied
            .iter()
            .map(|&coordinate| analysis::value_of(point, coordinate))
            .collect();
        let curve = sampled(point.parameters(), low, high, SAMPLES).map_err(Failure::input)?;
        let assigned = varied.iter().zip(&values);
        let name: Vec<String> = assigned
            .map(|(&coordinate, &value)| caption::assigned(point, coordinate, value))
            .collect();
        rows.extend(curve.iter().map(|sample| [&values[..], sample].concat()));
        curves.push((name.join(", "), curve));
        let summary = Summary {
            point,
            along: &along,
            extremes: function.extremes(),
            threshold: melnikov::threshold(point, &along).map_err(Failure::input)?,
            defect: defect(function, low, high),
        };
        if args.out.json.wanted() {
            objects.push(summary.object()?);
        } else {
            summary.print(&varied);
        }
    }
    let unseen = [Parameter::Epsilon, Parameter::Epsilon0, Parameter::X0, Parameter::Y0];
    let mut shown: Vec<Coordinate> = unseen.map(Coordinate::from).to_vec();
    shown.extend(&varied);
    let caption = |shown: &[Coordinate]| vec![caption::fixed(&at, shown), format!("{PROGRAM}.")];
    let sheet = Sheet::single(charts::melnikov("", &curves, None), caption(&shown));
    files.draw("", &sheet, "Mel'nikov's function of the bush-shaft system")?;
    let note = analysis::unit_note(&experiment, &varied, "");
    let notes: Vec<String> = [note].into_iter().filter(|note| !note.is_empty()).collect();
    let names = varied.iter().map(|coordinate| coordinate.name());
    let columns: Vec<&str> = names.chain(["tau_0", "melnikov"]).collect();
    files.table("", &notes, columns, rows.into_iter())?;

    // for a single point, the object is that of the point
    let mut object = match <[Value; 1]>::try_from(objects) {
        Ok([object]) => object,
        Err(objects) => json!({ "points": objects }),
    };
    if let Some(over) = &options.over {
        let curve = threshold_curve(&at, &along, over).map_err(Failure::input)?;
        shown.extend([along.coordinate, over.coordinate]);
        let sheet = Sheet::single(charts::threshold(&curve), caption(&shown));
        let title = format!("Mel'nikov's threshold in {}", along.coordinate);
        files.draw("-threshold", &sheet, &title)?;
        let rows = curve.thresholds.iter().enumerate();
        files.table(
            "-threshold",
            &[analysis::unit_note(
                &experiment,
                &[over.coordinate, along.coordinate],
                "empty: no threshold within the range that was searched; the last two columns: 1 where M changes sign below \
                 and above the threshold or, without one, everywhere in the range",
            )],
            [
                over.coordinate.name(),
                &format!("{}_threshold", along.coordinate),
                "changes_sign_below",
                "changes_sign_above",
            ],
            rows.map(|(index, threshold)| {
                let [below, above] = threshold.changes_sign().map(|changes| f64::from(u8::from(changes)));
                [over.value(index), threshold.value().unwrap_or(f64::NAN), below, above]
            }),
        )?;
        report_curve(&curve, args.out.json.wanted().then_some(&mut object));
    }
    files.tell(&experiment, || object, || {});
    Ok(())
}

/// Greatest difference between the closed form and the quadrature at some tau0: the program's check of itself.
fn defect(function: &Melnikov, low: f64, high: f64) -> f64 {
    (0..8)
        .map(|k| low + (high - low) * (f64::from(k) + 0.5) / 8.0)
        .map(|tau_0| (function.closed_form(tau_0) - function.quadrature(tau_0)).abs())
        .fold(0.0, f64::max)
}

/// The name of a kind of threshold in objects.
fn kind(threshold: Threshold) -> &'static str {
    match threshold {
        Threshold::Begins(_) => "begins",
        Threshold::Ceases(_) => "ceases",
        Threshold::Always => "always",
        Threshold::Never => "never",
    }
}

/// A value for people, with its unit.
fn written(at: &Fixed, coordinate: Coordinate, value: f64) -> String {
    match coordinate {
        Coordinate::Parameter(_) => value.to_string(),
        Coordinate::Si(_) => si(value, at.unit(coordinate)),
    }
}

/// `for zeta_k from 0 to 20`.
fn range(at: &Fixed, along: &Axis) -> String {
    let [low, high] = [along.first(), along.last()].map(|value| written(at, along.coordinate, value));
    format!("for {} from {low} to {high}", along.coordinate)
}

struct Summary<'a> {
    point: &'a Fixed,
    along: &'a Axis,
    extremes: Extremes,
    threshold: Threshold,
    defect: f64,
}

impl Summary<'_> {
    /// The parameter that the quantity of the threshold governs, and its value at the threshold; None without a machine.
    fn governed(&self) -> Option<(Parameter, f64)> {
        let Coordinate::Si(quantity) = self.along.coordinate else {
            return None;
        };
        let is_governed = |parameter: &&Parameter| self.point.governing(**parameter) == Some(quantity);
        let parameter = *melnikov::PARAMETERS.iter().find(is_governed)?;
        let value = self.threshold.value()?;
        Some((parameter, self.point.at([(quantity.into(), value)])[parameter]))
    }

    /// Where M changes sign, by the threshold.
    fn place(&self) -> String {
        let coordinate = self.along.coordinate;
        let at = |value: f64| match (coordinate, self.governed()) {
            (Coordinate::Parameter(_), _) => format!("{coordinate} = {value:.6}"),
            (_, None) => format!("{coordinate} = {}", written(self.point, coordinate, value)),
            (_, Some((parameter, governed))) => {
                let value = written(self.point, coordinate, value);
                format!("{coordinate} = {value} ({parameter} = {governed:.6})")
            }
        };
        match self.threshold {
            Threshold::Begins(value) => format!("M changes sign above {}", at(value)),
            Threshold::Ceases(value) => format!("M changes sign below {}", at(value)),
            Threshold::Always => format!("none: M changes sign everywhere {}", range(self.point, self.along)),
            Threshold::Never => format!("none: M changes sign nowhere {}", range(self.point, self.along)),
        }
    }

    fn print(&self, varied: &[Coordinate]) {
        for &coordinate in varied {
            print_line!("{coordinate} = {}", analysis::value_of(self.point, coordinate));
        }
        let e = &self.extremes;
        print_line!("least M             {:.6} at tau0 = {:.6}", e.minimum, e.minimum_at);
        print_line!("greatest M          {:.6} at tau0 = {:.6}", e.maximum, e.maximum_at);
        print_line!(
            "M changes sign      {}",
            if e.change_sign() { "yes: chaos may occur" } else { "no" }
        );
        print_line!("threshold           {}", self.place());
        print_line!("closed form less quadrature: {:.1e} at most\n", self.defect);
    }

    fn object(&self) -> Result<Value, Failure> {
        let mut object = serde_json::to_value(self.extremes).map_err(Failure::run)?;
        object["changes_sign"] = self.extremes.change_sign().into();
        object["threshold"] = self.threshold.value().into();
        object["threshold_kind"] = kind(self.threshold).into();
        object["threshold_parameter"] = self.along.coordinate.name().into();
        object["threshold_unit"] = self.point.unit(self.along.coordinate).into();
        if let Some((parameter, value)) = self.governed() {
            object["threshold_dimensionless"] = json!({ parameter.name(): value });
        }
        object["parameters"] = analysis::parameters(self.point.parameters());
        Ok(object)
    }
}

/// Reports a curve, as text or within an object; warns of a curve without any threshold.
fn report_curve(curve: &Curve, object: Option<&mut Value>) {
    let count = |sought: &str| {
        let kinds = curve.thresholds.iter().map(|threshold| kind(*threshold));
        kinds.filter(|kind| *kind == sought).count()
    };
    let [begins, ceases, always, never] = ["begins", "ceases", "always", "never"].map(count);
    let (name, values) = (curve.over.coordinate, curve.over.count());
    let range = range(&curve.fixed, &curve.along);
    if let Some(object) = object {
        object["curve"] = json!({
            "over": name, "values": values, "begins": begins, "ceases": ceases, "always": always, "never": never,
        });
    } else {
        let parts = [
            (begins, "M begins to change sign upward".to_owned()),
            (ceases, "M ceases to change sign upward".to_owned()),
            (always, format!("M changes sign everywhere {range}")),
            (never, format!("M changes sign nowhere {range}")),
        ];
        let told: Vec<String> = parts
            .into_iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("at {count} of {values} values {what}"))
            .collect();
        print_line!("over {name}: {}\n", told.join(", "));
    }
    if begins + ceases == 0 {
        let place = match (always, never) {
            (_, 0) => "everywhere",
            (0, _) => "nowhere",
            _ => "everywhere or nowhere",
        };
        eprintln!(
            "warning: no threshold at any of the {values} values of {name}, so that the curve is empty: M changes sign {place} \
             {range}; give --threshold another range"
        );
    }
}
