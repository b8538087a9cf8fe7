//! Figures 5.1 to 5.4: motion, contact pressure and wear with frictional heat and wear.
//!
//! Owns the curves' parameters, the panels' axes and the paper's statements; the motion is [`crate::dynamics`]'.

#![expect(clippy::unnecessary_wraps, reason = "all figures have one signature")]

use super::table::{Row, Value};
use super::{Breaker, Data, Effort, Outcome, PaperError};
use crate::analysis::path::path;
use crate::backend::BackendKind;
use crate::backend::cpu::CpuBackend;
use crate::design::Design;
use crate::dynamics::history::{History, Sample, history};
use crate::engine::Backends;
use crate::experiment::{Precision, Preset, Sampling, Scheme, Settings};
use crate::measure::{Class, Measurement};
use crate::output::PROGRAM;
use crate::parameters::{Parameter, ParameterSet};
use crate::picture::charts::histories::{self, Course, courses, curve};
use crate::picture::panel::Panel;
use crate::picture::sheet::Sheet;
use crate::picture::{caption, charts};

/// The paper's gamma of heated curves, and its k_w of worn ones.
const HEATED: f64 = 1.87;
const WORN: f64 = 0.01;
/// The paper's amplitudes of the shaft's speed.
const LOW: f64 = 3.5;
const HIGH: f64 = 3.9;

/// What an effort means in numbers.
struct Resolution {
    /// Samples of a history in each forcing period.
    samples: u32,
    /// Sampling for the exponents and periods in figure 5.1.
    sampling: Sampling,
    /// Forcing periods of a chaotic orbit that figure 5.1 shows.
    shown: u32,
}

impl Resolution {
    fn new(effort: Effort) -> Self {
        match effort {
            Effort::Full => Self {
                samples: 256,
                sampling: Sampling::default(),
                shown: 60,
            },
            Effort::Quick => Self {
                samples: 32,
                sampling: Sampling {
                    transient_periods: 150,
                    periods: 150,
                    ..Sampling::default()
                },
                shown: 20,
            },
        }
    }

    /// The history from the start. It is computed by the full model even without heat and wear.
    fn follow(&self, at: &ParameterSet, periods: u32) -> History {
        history(at, &Scheme::Radau.into(), 0..periods, self.samples)
    }
}

/// The parameters of the paper's section 5. Its curves differ in the three that are given.
fn curve_at(zeta_k: f64, gamma: f64, k_w: f64) -> ParameterSet {
    Preset::Paper
        .parameters()
        .with(Parameter::ZetaK, zeta_k)
        .with(Parameter::Gamma, gamma)
        .with(Parameter::KW, k_w)
}

/// The index of a curve's colour, the same in all figures.
fn colour(number: u32) -> usize {
    number as usize - 1
}

/// What the paper's numbers of curves mean, for captions.
fn numbering() -> String {
    let amplitude = |zeta_k| caption::assignment(Parameter::ZetaK, zeta_k);
    let heat = |gamma| caption::assignment(Parameter::Gamma, gamma);
    format!(
        "Curves are numbered as in the paper: 1 ({}) and 2 ({}) without frictional heat ({}), 3 and 4 at the same amplitudes \
         with it ({}).",
        amplitude(LOW),
        amplitude(HIGH),
        heat(0.0),
        heat(HEATED)
    )
}

/// The paper's number of a curve and its amplitude.
fn name(number: u32, zeta_k: f64) -> String {
    format!("{number}: {}", caption::assignment(Parameter::ZetaK, zeta_k))
}

fn words_of(zeta_k: f64, gamma: f64, k_w: f64) -> String {
    format!("zeta_k = {zeta_k}, gamma = {gamma}, k_w = {k_w}")
}

/// How a motion repeats, in the paper's words.
fn motion(m: &Measurement) -> Value {
    match m.period {
        Some(1) => Value::words("periodic"),
        Some(period) => Value::words(&format!("subharmonic, omega_0/{period}")),
        None => Value::words(m.class.map_or("-", Class::name)),
    }
}

/// Forcing periods before the part that the phase plane shows, and those that it shows of a motion that is not chaotic.
const TRANSIENT: u32 = 150;
const SHOWN: u32 = 4;

/// A curve of figure 5.1: its number, amplitude and gamma, and what the paper calls its motion.
type Orbit = (u32, f64, f64, &'static str);

const ORBITS: [Orbit; 4] = [
    (1, LOW, 0.0, "regular"),
    (2, HIGH, 0.0, "chaotic"),
    (3, LOW, HEATED, "subharmonic, omega_0/2"),
    (4, HIGH, HEATED, "periodic"),
];

/// Digits that are written of an exponent.
const DIGITS: usize = 4;

pub fn figure_5_1(effort: Effort, observer: &mut Breaker<'_>) -> Result<Option<Outcome>, PaperError> {
    let resolution = Resolution::new(effort);
    let (mut orbits, mut rows, mut columns) = (Vec::new(), Vec::new(), table(&["curve", "tau", "x", "y"]));
    for (number, zeta_k, gamma, said) in ORBITS {
        let point = curve_at(zeta_k, gamma, 0.0);
        let Some(m) = measured(&resolution, &point, observer)? else {
            return Ok(None);
        };
        let is_chaotic = m.class == Some(Class::Chaotic);
        let shown = if is_chaotic { resolution.shown } else { SHOWN };
        let settings = Settings {
            integration: Scheme::Radau.into(),
            sampling: Sampling {
                transient_periods: TRANSIENT,
                periods: shown,
                ..Sampling::default()
            },
        };
        let path = path(&point, &settings, resolution.samples).points;
        if observer().is_break() {
            return Ok(None);
        }
        let table_rows = path
            .iter()
            .map(|point| vec![f64::from(number), point.tau, point.x, point.y]);
        columns.rows.extend(table_rows);
        let heat = caption::assignment(Parameter::Gamma, gamma);
        orbits.push((format!("{}, {heat}", name(number, zeta_k)), path));
        let what = words_of(zeta_k, gamma, 0.0);
        let (computed, remark) = if gamma > 0.0 {
            (motion(&m), "of the full state, with the heat modes")
        } else {
            (Value::words(m.class.map_or("-", Class::name)), "")
        };
        rows.push(Row::new(&format!("motion, {what}"), Value::words(said), computed, ""));
        // if all written digits are certain, no uncertainty is written
        let exponent = if m.lyapunov_error < 0.5e-4 {
            Value::number(m.lyapunov, DIGITS)
        } else {
            Value::uncertain(m.lyapunov, m.lyapunov_error, DIGITS)
        };
        rows.push(Row::new(
            &format!("maximal exponent, {what}"),
            Value::Nothing,
            exponent,
            remark,
        ));
    }
    let numerics = format!(
        "After {TRANSIENT} forcing periods; {} of a chaotic orbit, {SHOWN} of others. ",
        resolution.shown
    );
    let panel = charts::phase("", &orbits, Some(ANGLES), Some(SPEEDS));
    let caption = words(&curve_at(HIGH, 0.0, 0.0), &[Parameter::Gamma], "5.1", &numerics);
    Ok(Some(single(panel, caption, rows, columns)))
}

/// The paper's axes of phi and phi-dot, whose ticks end at 2 and at 4; curve 4 goes further.
const ANGLES: [f64; 2] = [-2.5, 2.5];
const SPEEDS: [f64; 2] = [-4.5, 4.5];

fn measured(
    resolution: &Resolution,
    point: &ParameterSet,
    observer: &mut Breaker<'_>,
) -> Result<Option<Measurement>, PaperError> {
    let design = Design::product(Vec::new(), (*point).into());
    let mut backends = Backends::new(Box::new(CpuBackend::new(Precision::F64)), None);
    let observer = &mut |_: crate::engine::Event<'_>| observer();
    let settings = Settings {
        integration: Scheme::suited(point.has_heat_or_wear()).into(),
        sampling: resolution.sampling,
    };
    let measured = backends.measure(&design, &settings, &[0], observer)?;
    Ok(measured.map(|measured| measured[0]))
}

/// Forcing periods after which pressure and wear are nearer than 0.01 to their limits.
const SETTLING: u32 = 100;
/// Distance at which pressure and wear count as near their limits.
const NEAR: f64 = 0.01;

pub fn figure_5_2(effort: Effort, observer: &mut Breaker<'_>) -> Result<Option<Outcome>, PaperError> {
    let resolution = Resolution::new(effort);
    let (mut drawn, mut rows, mut columns) = (Vec::new(), Vec::new(), table(&["curve", "tau", "pressure", "wear"]));
    for (number, zeta_k) in [(1, LOW), (2, HIGH)] {
        let history = resolution.follow(&curve_at(zeta_k, 0.0, WORN), SETTLING);
        if observer().is_break() {
            return Ok(None);
        }
        let samples = &history.samples;
        let name = name(number, zeta_k);
        for (quantity, is_dashed, value) in [
            ("p", false, (|sample| sample.pressure) as fn(&Sample) -> f64),
            ("u_w", true, |sample| sample.wear),
        ] {
            drawn.push(Course {
                name: format!("{quantity} of {name}"),
                points: until(samples, PRESSURES_END, value),
                colour: colour(number),
                is_dashed,
            });
        }
        let table_rows = samples
            .iter()
            .take_while(|sample| sample.tau <= PRESSURES_END)
            .map(|sample| vec![f64::from(number), sample.tau, sample.pressure, sample.wear]);
        columns.rows.extend(table_rows);
        let what = words_of(zeta_k, 0.0, WORN);
        let (pressure, wear) = samples.last().map_or((f64::NAN, f64::NAN), |s| (s.pressure, s.wear));
        let is_near = pressure.abs() < NEAR && (wear - 1.0).abs() < NEAR;
        rows.push(Row::new(
            &format!("where p and u_w tend at {what}"),
            Value::words("p to 0, u_w to 1"),
            if is_near {
                Value::words("p to 0, u_w to 1")
            } else {
                Value::words("elsewhere")
            },
            &format!("p = {pressure:.4}, u_w = {wear:.4} after {SETTLING} forcing periods"),
        ));
        for tau in [72.0, 120.0] {
            rows.push(Row::new(
                &format!("u_w at tau = {tau}, {what}"),
                Value::Nothing,
                number_or_nothing(at_time(samples, tau, |sample| sample.wear), 4),
                "",
            ));
        }
    }
    let panel = courses(
        "pressure p, wear u_w",
        &drawn,
        Some([0.0, PRESSURES_END]),
        Some([0.0, 1.0]),
    );
    let caption = words(&curve_at(HIGH, 0.0, WORN), &[], "5.2", "");
    Ok(Some(single(panel, caption, rows, columns)))
}

/// The end of figure 5.2's axis of time.
const PRESSURES_END: f64 = 120.0;
/// The end of the axis of time of figures 5.3 and 5.4; their ticks end at 60, and their curves go on to 72.
const CONTACT_END: f64 = 75.0;

/// Forcing periods that reach beyond an end of an axis of time.
fn beyond(end: f64) -> u32 {
    (end / ParameterSet::default().forcing_period()).ceil() as u32
}

pub fn figure_5_3(effort: Effort, observer: &mut Breaker<'_>) -> Result<Option<Outcome>, PaperError> {
    let resolution = Resolution::new(effort);
    let (mut drawn, mut rows, mut columns) = (Vec::new(), Vec::new(), table(&["tau", "pressure"]));
    for (zeta_k, tau_c, digits) in [(HIGH, 72.0, 0), (LOW, 65.8, 1)] {
        let history = resolution.follow(&curve_at(zeta_k, HEATED, WORN), beyond(CONTACT_END));
        if observer().is_break() {
            return Ok(None);
        }
        // the paper draws the pressure of one curve only
        if zeta_k == HIGH {
            drawn.push(Course {
                name: name(4, zeta_k),
                points: until(&history.samples, CONTACT_END, |sample| sample.pressure),
                colour: colour(4),
                is_dashed: false,
            });
            columns.rows.extend(
                curve(&history.samples, |sample| sample.pressure)
                    .iter()
                    .map(|pair| pair.to_vec()),
            );
        }
        let what = words_of(zeta_k, HEATED, WORN);
        rows.push(Row::new(
            &format!("contact lost at tau_c, {what}"),
            Value::number(tau_c, digits),
            number_or_nothing(history.contact_lost, 2),
            "",
        ));
        rows.push(Row::new(
            &format!("peak pressure, {what}"),
            Value::Nothing,
            Value::number(history.peak_pressure, 2),
            &format!("at tau = {:.3}", history.peak_pressure_time),
        ));
        rows.push(Row::new(
            &format!("peak temperature theta(1, tau), {what}"),
            Value::Nothing,
            Value::number(history.peak_temperature, 0),
            "",
        ));
    }
    let panel = courses(
        histories::PRESSURE,
        &drawn,
        Some([0.0, CONTACT_END]),
        Some([0.0, 100.0]),
    );
    let caption = words(&curve_at(HIGH, HEATED, WORN), &[], "5.3", "");
    Ok(Some(single(panel, caption, rows, columns)))
}

pub fn figure_5_4(effort: Effort, observer: &mut Breaker<'_>) -> Result<Option<Outcome>, PaperError> {
    let resolution = Resolution::new(effort);
    let (mut drawn, mut rows, mut columns) = (Vec::new(), Vec::new(), table(&["curve", "tau", "wear"]));
    let mut cold = None;
    for (number, zeta_k, gamma) in [(2, HIGH, 0.0), (3, LOW, HEATED), (4, HIGH, HEATED)] {
        let periods = if gamma > 0.0 { beyond(CONTACT_END) } else { SETTLING };
        let history = resolution.follow(&curve_at(zeta_k, gamma, WORN), periods);
        if observer().is_break() {
            return Ok(None);
        }
        let points = until(&history.samples, CONTACT_END, |sample| sample.wear);
        columns
            .rows
            .extend(points.iter().map(|&[tau, wear]| vec![f64::from(number), tau, wear]));
        drawn.push(Course {
            name: format!(
                "{}, {}",
                name(number, zeta_k),
                caption::assignment(Parameter::Gamma, gamma)
            ),
            points,
            colour: colour(number),
            is_dashed: false,
        });
        let last = history.samples.last().map_or(f64::NAN, |sample| sample.wear);
        if gamma == 0.0 {
            cold = Some((history, last));
            continue;
        }
        rows.push(Row::new(
            &format!("final wear, {}", words_of(zeta_k, gamma, WORN)),
            Value::Nothing,
            Value::number(last, 3),
            "",
        ));
        if let Some((cold, tended)) = &cold
            && zeta_k == HIGH
        {
            let meanwhile = history
                .contact_lost
                .and_then(|lost| at_time(&cold.samples, lost, |sample| sample.wear));
            rows.push(Row::new(
                &format!("final wear over that of curve 2 in the long run, zeta_k = {zeta_k}"),
                Value::number(30.0, 0),
                Value::number(last / tended, 1),
                &meanwhile.map_or_else(String::new, |wear| {
                    format!("{:.1} times that of curve 2 at tau_c", last / wear)
                }),
            ));
        }
    }
    let panel = courses(histories::WEAR, &drawn, Some([0.0, CONTACT_END]), Some([0.0, 32.0]));
    let caption = words(&curve_at(HIGH, HEATED, WORN), &[Parameter::Gamma], "5.4", "");
    Ok(Some(single(panel, caption, rows, columns)))
}

fn table(columns: &[&str]) -> Data {
    Data {
        panel: String::new(),
        columns: columns.iter().map(|&column| column.to_owned()).collect(),
        rows: Vec::new(),
    }
}

fn number_or_nothing(value: Option<f64>, digits: usize) -> Value {
    value.map_or(Value::Nothing, |value| Value::number(value, digits))
}

/// A quantity over time up to the end of an axis.
fn until(samples: &[Sample], end: f64, value: fn(&Sample) -> f64) -> Vec<[f64; 2]> {
    let shown = samples.partition_point(|sample| sample.tau <= end);
    // the first one beyond, so that the curve reaches the frame
    curve(&samples[..(shown + 1).min(samples.len())], value)
}

/// A quantity at the time `tau`, interpolated between samples.
fn at_time(samples: &[Sample], tau: f64, value: fn(&Sample) -> f64) -> Option<f64> {
    let next = samples.partition_point(|sample| sample.tau < tau);
    let (before, after) = (samples.get(next.checked_sub(1)?)?, samples.get(next)?);
    let part = (tau - before.tau) / (after.tau - before.tau);
    Some(value(before) + part * (value(after) - value(before)))
}

/// A figure of one panel.
fn single(panel: Panel, caption: Vec<String>, rows: Vec<Row>, data: Data) -> Outcome {
    Outcome {
        sheet: Sheet::single(panel, caption),
        rows,
        data: vec![data],
    }
}

/// The caption of a figure whose curves differ in zeta_k and in the `varied` parameters. It explains the numbers of all curves,
/// since a number means the same curve in all figures.
fn words(at: &ParameterSet, varied: &[Parameter], id: &str, numerics: &str) -> Vec<String> {
    let settings = Settings::from(Scheme::Radau);
    // there is no ramp
    let mut shown = vec![Parameter::ZetaK, Parameter::RampRate];
    shown.extend(varied);
    vec![
        caption::fixed(&(*at).into(), &shown),
        numbering(),
        format!(
            "{numerics}Biot number, ω̃ and the initial state are not in the paper, and reconstructed. {}, {} heat modes, {}. As \
             figure {id} of Awrejcewicz and Pyryev (2006). {PROGRAM}.",
            caption::scheme(&settings),
            settings.integration.modes,
            caption::integrated_on([BackendKind::CpuF64].into_iter())
        ),
    ]
}
