//! Figures 3.1 and 3.2: bifurcation diagrams, exponents and the onset of chaos at contact pressure 1.
//!
//! Owns the panels' axes, the numerical settings and the paper's statements; the analyses are [`crate::analysis`]'s.

use std::fmt::Write as _;

use super::table::{Row, Value};
use super::{Breaker, Data, Effort, Outcome, PaperError};
use crate::analysis::bifurcation::{Columns, diagram};
use crate::analysis::exponents::lines;
use crate::analysis::onset::{Definition, Found, Scan, Way, fine_axis};
use crate::backend::BackendKind;
use crate::backend::cpu::CpuBackend;
use crate::design::{Axis, Fixed};
use crate::dynamics::spectrum::lyapunov_spectrum;
use crate::engine::{Backends, initial_states};
use crate::experiment::{Precision, Sampling, Settings};
use crate::output::PROGRAM;
use crate::parameters::{Parameter, ParameterSet};
use crate::picture::caption;
use crate::picture::charts::{self, Component};
use crate::picture::panel::Panel;
use crate::picture::sheet::{BESIDE, Sheet};

/// The paper's measured window begins at tau = 1200, after 382 forcing periods, and is 100 long.
const TRANSIENT: u32 = 382;
const MEASURED: u32 = 100;
/// The paper does not say where its orbits begin.
const START: [f64; 2] = [1.0, 0.0];
/// Initial states that are tried, since the paper names none.
const STARTS: [[f64; 2]; 3] = [[0.1, 0.0], [1.0, 0.0], [-1.0, 0.0]];
const ONSET_SPACING: f64 = 0.0025;

/// The paper's axes of zeta_k.
const WIDE: [f64; 2] = [0.0, 12.0];
const NARROW: [f64; 2] = [3.5, 4.0];

/// What an effort means in numbers.
struct Resolution {
    /// Values of zeta_k in a bifurcation diagram: two for each column of pixels.
    columns: usize,
    /// Stroboscopic states for each.
    states: u32,
    /// Values of zeta_k in a panel of exponents.
    exponents: usize,
    /// Total number of initial states that are tried where the paper's onset is not reproduced.
    tried: u32,
}

impl Resolution {
    fn new(effort: Effort) -> Self {
        match effort {
            Effort::Full => Self {
                columns: 2 * BESIDE[0] as usize,
                states: 200,
                exponents: 1201,
                tried: 24,
            },
            Effort::Quick => Self {
                columns: BESIDE[0] as usize / 4,
                states: 48,
                exponents: 121,
                tried: 8,
            },
        }
    }
}

fn axis([start, stop]: [f64; 2], count: usize) -> Axis {
    Axis::even(Parameter::ZetaK, start, stop, count).expect("the table of parameters admits the figure's axes")
}

fn damped(h1: f64) -> Fixed {
    ParameterSet::default().with(Parameter::H1, h1).into()
}

fn backends() -> Backends {
    Backends::new(Box::new(CpuBackend::new(Precision::F64)), None)
}

/// One panel with its data.
type Drawn = (Panel, Data);

fn bifurcation_panel(
    resolution: &Resolution,
    letter: &str,
    h1: f64,
    range: [f64; 2],
    limits: [f64; 2],
    observer: &mut Breaker<'_>,
) -> Result<Option<Drawn>, PaperError> {
    let settings = Settings {
        sampling: Sampling {
            transient_periods: TRANSIENT,
            periods: resolution.states,
            ..Sampling::default()
        },
        ..Settings::default()
    };
    let axis = axis(range, resolution.columns);
    let mut backend = CpuBackend::new(Precision::F64);
    let progress = &mut |_: u64| observer();
    let found = diagram(
        &mut backend,
        &settings,
        &damped(h1),
        &axis,
        &[START],
        Columns::Fresh,
        progress,
    )?;
    Ok(found.map(|diagram| {
        let title = format!("({letter}) {}", caption::assignment(Parameter::H1, h1));
        let rows = diagram.columns.iter().enumerate().flat_map(|(index, column)| {
            let value = axis.value(index);
            column.iter().map(move |&[x, y]| vec![value, x, y])
        });
        let data = Data {
            panel: letter.to_owned(),
            columns: ["zeta_k", "x", "y"].map(str::to_owned).to_vec(),
            rows: rows.collect(),
        };
        (
            charts::bifurcation(&title, &diagram, Component::X, Some(limits), BESIDE),
            data,
        )
    }))
}

fn exponents_panel(
    resolution: &Resolution,
    letter: &str,
    h1: f64,
    range: [f64; 2],
    limits: [f64; 2],
    onset: Option<&Found>,
    observer: &mut Breaker<'_>,
) -> Result<Option<Drawn>, PaperError> {
    let settings = Settings {
        sampling: Sampling {
            transient_periods: TRANSIENT,
            periods: MEASURED,
            decide_early: false,
            ..Sampling::default()
        },
        ..Settings::default()
    };
    let axis = axis(range, resolution.exponents);
    let marks: Vec<(&str, f64)> = onset.iter().map(|found| ("onset", found.value)).collect();
    let observer = &mut |_: crate::engine::Event<'_>| observer();
    let found = lines(&mut backends(), &settings, &damped(h1), &axis, &[START], observer)?;
    Ok(found.map(|lines| {
        let line = &lines[0];
        let title = format!("({letter}) {}", caption::assignment(Parameter::H1, h1));
        let rows = line.measurements.iter().enumerate().map(|(index, m)| {
            vec![
                axis.value(index),
                m.lyapunov,
                m.lyapunov_error,
                m.lyapunov_second,
                m.lyapunov_second_error,
                0.0,
            ]
        });
        let columns = [
            "zeta_k",
            "lambda_1",
            "lambda_1_error",
            "lambda_2",
            "lambda_2_error",
            "lambda_3",
        ];
        let data = Data {
            panel: letter.to_owned(),
            columns: columns.map(str::to_owned).to_vec(),
            rows: rows.collect(),
        };
        (charts::exponents(&title, line, &marks, Some(limits)), data)
    }))
}

/// The least zeta_k in a range at which one of the initial states leads to chaos. The outer None means that the observer broke it
/// off.
#[expect(clippy::option_option, reason = "broken off is not the same as nothing found")]
fn first_chaos(
    h1: f64,
    range: [f64; 2],
    starts: &[[f64; 2]],
    observer: &mut Breaker<'_>,
) -> Result<Option<Option<Found>>, PaperError> {
    let scan = Scan {
        definition: &Definition::new(&Settings::default()),
        at: &damped(h1),
        axis: fine_axis(&axis(range, 2), ONSET_SPACING),
        starts,
    };
    let observer = &mut |_: crate::engine::Event<'_>| observer();
    let scanned = scan.first(Way::Up, &mut backends(), observer)?;
    Ok(scanned.map(|scanned| scanned.found))
}

fn onset_value(found: Option<&Found>) -> Value {
    found.map_or(Value::Nothing, |found| Value::uncertain(found.value, ONSET_SPACING, 4))
}

fn from_words(found: Option<&Found>) -> String {
    found.map_or_else(String::new, |found| {
        format!("from (x, y) = ({}, {})", found.start[0], found.start[1])
    })
}

/// Unwraps a part of the work, or returns None from the figure if it was broken off.
macro_rules! finished {
    ($resolution:expr) => {
        match $resolution? {
            Some(done) => done,
            None => return Ok(None),
        }
    };
}

pub fn figure_3_1(effort: Effort, observer: &mut Breaker<'_>) -> Result<Option<Outcome>, PaperError> {
    let resolution = Resolution::new(effort);
    let found = finished!(first_chaos(0.0, WIDE, &STARTS, observer));
    let drawn = [
        finished!(bifurcation_panel(&resolution, "a", 0.0, WIDE, [-2.7, 1.4], observer)),
        finished!(bifurcation_panel(&resolution, "b", 0.0, NARROW, [-0.9, 1.1], observer)),
        finished!(exponents_panel(
            &resolution,
            "c",
            0.0,
            WIDE,
            [-2.0, 0.4],
            found.as_ref(),
            observer
        )),
        finished!(exponents_panel(
            &resolution,
            "d",
            0.0,
            NARROW,
            [-0.9, 0.25],
            found.as_ref(),
            observer
        )),
    ];
    let computed = onset_value(found.as_ref());
    let rows = vec![
        Row::new(
            "onset of chaos in zeta_k, h1 = 0",
            Value::number(3.78, 2),
            computed.clone(),
            &from_words(found.as_ref()),
        ),
        Row::new(
            "the same, as one of the panels is marked",
            Value::number(3.72, 2),
            computed,
            "the paper's text and its other panel say 3.78",
        ),
    ];
    Ok(Some(outcome(&resolution, &damped(0.0), drawn, &[found.as_ref()], rows)))
}

pub fn figure_3_2(effort: Effort, observer: &mut Breaker<'_>) -> Result<Option<Outcome>, PaperError> {
    let resolution = Resolution::new(effort);
    let half = finished!(first_chaos(0.5, WIDE, &STARTS, observer));
    let other = finished!(first_chaos(0.5, WIDE, &STARTS[..1], observer));
    let one = finished!(first_chaos(1.0, WIDE, &STARTS, observer));
    let tried = finished!(below(&resolution, 1.0, one.as_ref(), observer));
    let x = [-2.7, 1.4];
    let drawn = [
        finished!(bifurcation_panel(&resolution, "a", 0.5, WIDE, x, observer)),
        finished!(bifurcation_panel(&resolution, "b", 1.0, WIDE, x, observer)),
        finished!(exponents_panel(
            &resolution,
            "c",
            0.5,
            WIDE,
            [-2.0, 0.4],
            half.as_ref(),
            observer
        )),
        finished!(exponents_panel(
            &resolution,
            "d",
            1.0,
            WIDE,
            [-2.0, 0.4],
            one.as_ref(),
            observer
        )),
    ];
    let rows = vec![
        Row::new(
            "onset of chaos in zeta_k, h1 = 0.5",
            Value::number(3.8, 1),
            onset_value(half.as_ref()),
            &from_words(half.as_ref()),
        ),
        Row::new(
            "the same from (x, y) = (0.1, 0)",
            Value::Nothing,
            onset_value(other.as_ref()),
            "the paper names no initial state; attractors coexist",
        ),
        Row::new(
            "onset of chaos in zeta_k, h1 = 1",
            Value::number(4.25, 2),
            onset_value(one.as_ref()),
            &tried,
        ),
        trivial_exponent(effort),
    ];
    let onsets = [half.as_ref(), one.as_ref()];
    Ok(Some(outcome(&resolution, &damped(0.0), drawn, &onsets, rows)))
}

/// Searches for chaos below the onset that was found, from many initial states; the range begins a little below the paper's
/// value. Returns the remark on the result.
fn below(
    resolution: &Resolution,
    h1: f64,
    found: Option<&Found>,
    observer: &mut Breaker<'_>,
) -> Result<Option<String>, PaperError> {
    const DEPTH: u32 = 40;
    let Some(found) = found else {
        return Ok(Some("not reproduced".to_owned()));
    };
    let mut starts = STARTS.to_vec();
    let settings = Settings {
        sampling: Sampling {
            initial_states: resolution.tried - STARTS.len() as u32 + 1,
            ..Sampling::default()
        },
        ..Settings::default()
    };
    starts.extend(initial_states::offsets(&settings.sampling));
    let first = found.value - f64::from(DEPTH) * ONSET_SPACING;
    let last = found.value - ONSET_SPACING;
    let scanned = first_chaos(h1, [first, last], &starts, observer)?;
    Ok(scanned.map(|chaos| {
        let count = starts.len();
        match chaos {
            None => format!(
                "not reproduced by the paper's equations: none of {count} initial states leads to chaos at any of the \
                 {DEPTH} values from {first:.4} to {last:.4}"
            ),
            Some(chaos) => format!(
                "{}; of {count} initial states the first to lead to chaos, ({:.3}, {:.3}), does so at {:.4}",
                from_words(Some(found)),
                chaos.start[0],
                chaos.start[1],
                chaos.value
            ),
        }
    }))
}

/// The paper notes that one of the three exponents is always zero. This row has the largest absolute value that the third vector
/// gives at some points, by the paper's own procedure.
fn trivial_exponent(effort: Effort) -> Row {
    let periods = match effort {
        Effort::Full => MEASURED,
        Effort::Quick => 16,
    };
    let settings = Settings {
        sampling: Sampling {
            transient_periods: TRANSIENT,
            periods,
            ..Sampling::default()
        },
        ..Settings::default()
    };
    let largest = [1.0, 3.5, 3.9, 6.0, 9.0]
        .into_iter()
        .filter_map(|zeta_k| {
            let point = damped(0.5).parameters().with(Parameter::ZetaK, zeta_k);
            lyapunov_spectrum(&point.with_initial_state(START), &settings)
        })
        .map(|spectrum| spectrum.exponents[2].abs())
        .fold(0.0, f64::max);
    Row::new(
        "one exponent is always zero: greatest of its absolute values at five zeta_k, h1 = 0.5",
        Value::number(0.0, 0),
        Value::number(largest, 6),
        "by the paper's procedure with three vectors",
    )
}

/// The initial states from which the marked onsets were found, to print after the list of those that were tried.
fn reached_from(onsets: &[Option<&Found>]) -> String {
    let starts: Vec<String> = onsets
        .iter()
        .flatten()
        .map(|found| charts::start(found.start))
        .collect();
    match &starts[..] {
        [] => String::new(),
        [first, rest @ ..] if rest.iter().all(|start| start == first) => format!(": that from {first}"),
        starts => format!(": those from {}", starts.join(" and ")),
    }
}

/// `onsets` are those that the panels are marked with, in the panels' order.
fn outcome(
    resolution: &Resolution,
    at: &Fixed,
    drawn: [Drawn; 4],
    onsets: &[Option<&Found>],
    rows: Vec<Row>,
) -> Outcome {
    let (panels, data): (Vec<Panel>, Vec<Data>) = drawn.into_iter().unzip();
    let outside: usize = panels.iter().map(charts::outside).sum();
    let mut numerics = format!(
        "Diagrams and exponents of orbits from (x, y) = {}, after {TRANSIENT} forcing periods; diagrams: {} states at each of {} \
         values; exponents: {MEASURED} measured periods at each of {} values. Dashed lines: the least ζₖ at which an orbit from one \
         of {} is chaotic{}. {}, {}. As in Awrejcewicz and Pyryev (2006). ",
        charts::start(START),
        resolution.states,
        resolution.columns,
        resolution.exponents,
        STARTS.map(charts::start).join(", "),
        reached_from(onsets),
        caption::scheme(&Settings::default()),
        caption::integrated_on([BackendKind::CpuF64].into_iter())
    );
    if outside > 0 {
        let _ = write!(numerics, "{outside} states lie outside the frames. ");
    }
    let shown = [Parameter::ZetaK, Parameter::H1, Parameter::X0, Parameter::Y0];
    let sheet = Sheet {
        panels,
        columns: 2,
        frame: BESIDE,
        caption: vec![caption::fixed(at, &shown), format!("{numerics}{PROGRAM}.")],
    };
    Outcome { sheet, rows, data }
}
