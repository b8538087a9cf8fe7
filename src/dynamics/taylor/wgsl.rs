//! The series as a shader's text.
//!
//! Owns the number type whose operations print `let` bindings, and the text that the recurrences print with it;
//! `shaders/generated/taylor.wgsl` is a checked-in copy. Computes no number.

use std::cell::RefCell;
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::ops::{Add, Mul, Neg, Sub};

use super::growth::{LARGEST, RENEWAL_STEPS};
use super::number::Number;
use super::series::{self, Local, Series};
use super::{
    AT_BOUNDARY, BEYOND, COEFFICIENTS, FREE_STEP, LAYER_STEP, LEAST_TICKS, MAX_PASSES, MISSED, NO_LAYER, ON_BOUNDARY,
    OWN_SPEED, REACH, REFINEMENTS, SMALLEST_SLOPE_SQUARE, STIFF, STIFF_FREE_STEP, SWING, THIN, ticks_per_unit,
};
use crate::dynamics::tangent::{COMFORTABLE, Vector};
use crate::lanes::Real;

/// The text of one function's body: every operation adds a line.
#[derive(Default)]
struct Body {
    lines: RefCell<Vec<String>>,
    names: RefCell<Vec<String>>,
}

impl Body {
    /// A number that the text calls `name`.
    fn named(&self, name: &str) -> Symbol<'_> {
        let mut names = self.names.borrow_mut();
        names.push(name.to_owned());
        Symbol::Name(self, names.len() - 1)
    }

    fn bind(&self, expression: &str) -> Symbol<'_> {
        let mut lines = self.lines.borrow_mut();
        let name = format!("t{}", lines.len());
        lines.push(format!("    let {name} = {expression};\n"));
        drop(lines);
        self.named(&name)
    }

    fn text(&self) -> String {
        self.lines.borrow().concat()
    }
}

/// A number in the text: a constant, or what a name stands for.
#[derive(Clone, Copy)]
enum Symbol<'a> {
    Constant(f64),
    Name(&'a Body, usize),
}

impl<'a> Symbol<'a> {
    fn body(self) -> Option<&'a Body> {
        match self {
            Self::Constant(_) => None,
            Self::Name(body, _) => Some(body),
        }
    }

    fn text(self) -> String {
        match self {
            // Debug always writes a decimal point
            Self::Constant(value) => format!("{value:?}"),
            Self::Name(body, index) => body.names.borrow()[index].clone(),
        }
    }

    /// The text as an argument of a function. All arguments must have the number of lanes of a thread.
    fn argument(self) -> String {
        match self {
            Self::Constant(_) => format!("Real({})", self.text()),
            Self::Name(..) => self.text(),
        }
    }

    /// Prints the operation; computes it instead if all operands are constants.
    fn operation(operands: &[Self], text: &str, constant: impl Fn(&[f64]) -> f64) -> Self {
        if let Some(body) = operands.iter().find_map(|operand| operand.body()) {
            return body.bind(text);
        }
        let values: Vec<f64> = operands
            .iter()
            .map(|operand| match operand {
                Self::Constant(value) => *value,
                Self::Name(..) => unreachable!("a name has a body"),
            })
            .collect();
        Self::Constant(constant(&values))
    }
}

macro_rules! symbol_operator {
    ($trait:ident $method:ident $sign:literal) => {
        impl $trait for Symbol<'_> {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                let text = format!(concat!("{} ", $sign, " {}"), self.text(), other.text());
                Self::operation(&[self, other], &text, |v| v[0].$method(v[1]))
            }
        }
    };
}

symbol_operator!(Add add "+");
symbol_operator!(Sub sub "-");
symbol_operator!(Mul mul "*");

impl Neg for Symbol<'_> {
    type Output = Self;
    fn neg(self) -> Self {
        Self::operation(&[self], &format!("-{}", self.text()), |v| -v[0])
    }
}

impl Number for Symbol<'_> {
    fn constant(value: f64) -> Self {
        Self::Constant(value)
    }
    fn fused(self, factor: Self, addend: Self) -> Self {
        let text = format!("fma({}, {}, {})", self.argument(), factor.argument(), addend.argument());
        Self::operation(&[self, factor, addend], &text, |v| v[0] * v[1] + v[2])
    }
}

type SymbolSeries<'a> = Series<Symbol<'a>, COEFFICIENTS>;

const LOCAL_FIELDS: [&str; 12] = [
    "linear",
    "minus_b",
    "minus_damping",
    "a_0",
    "a_1",
    "a_2",
    "cubic",
    "drive",
    "drive_slope",
    "x",
    "w",
    "v",
];

/// The parts of a series: name and number of coefficients.
const SERIES_PARTS: [(&str, usize); 5] = [
    ("x", COEFFICIENTS),
    ("w", COEFFICIENTS),
    ("v", COEFFICIENTS),
    ("by_x", COEFFICIENTS - 1),
    ("by_w", COEFFICIENTS - 1),
];

fn series_fields() -> impl Iterator<Item = (&'static str, usize)> {
    SERIES_PARTS
        .into_iter()
        .flat_map(|(part, count)| (0..count).map(move |n| (part, n)))
}

fn part<'a, 'b>(series: &'b SymbolSeries<'a>, name: &str) -> &'b [Symbol<'a>] {
    match name {
        "x" => &series.x,
        "w" => &series.w,
        "v" => &series.v,
        "by_x" => &series.by_x,
        _ => &series.by_w,
    }
}

/// The series that a function in the text has as its argument.
fn given(body: &Body) -> SymbolSeries<'_> {
    let coefficients = |name: &str| std::array::from_fn(|n| body.named(&format!("series.{name}_{n}")));
    Series {
        x: coefficients("x"),
        w: coefficients("w"),
        v: coefficients("v"),
        by_x: coefficients("by_x"),
        by_w: coefficients("by_w"),
    }
}

fn structure(name: &str, fields: impl Iterator<Item = String>) -> String {
    let fields: Vec<String> = fields.map(|field| format!("    {field}: Real,\n")).collect();
    format!("struct {name} {{\n{}}}\n\n", fields.concat())
}

fn constants() -> String {
    let mut text = String::new();
    for (name, value) in [
        ("LEAST_TICKS", LEAST_TICKS),
        ("REACH", REACH),
        ("LAYER_STEP", LAYER_STEP),
        ("FREE_STEP", FREE_STEP),
        ("STIFF_FREE_STEP", STIFF_FREE_STEP),
        ("STIFF", STIFF),
        ("SWING", SWING),
        ("OWN_SPEED", OWN_SPEED),
        ("BEYOND", BEYOND),
        ("AT_BOUNDARY", AT_BOUNDARY),
        ("ON_BOUNDARY", ON_BOUNDARY),
        ("THIN", THIN),
        ("MISSED", MISSED),
        ("NO_LAYER", NO_LAYER),
        ("TICKS_PER_UNIT", ticks_per_unit::<f32>()),
        ("SMALLEST_SLOPE_SQUARE", SMALLEST_SLOPE_SQUARE),
        ("MAX_PASSES", MAX_PASSES.into()),
        // times the unit of time, this is the forcing period in units of pi
        ("LONG_PER_UNIT", f64::from(series::UNITS_PER_PERIOD) / PI),
        ("COMFORTABLE", COMFORTABLE),
        ("LARGEST_LENGTH", LARGEST),
    ] {
        let _ = writeln!(text, "const {name}: f32 = {value:?};");
    }
    let _ = writeln!(text, "const TICKS_PER_PERIOD: u32 = {}u;", f32::PERIOD_TICKS as u32);
    let _ = writeln!(text, "const RENEWAL_STEPS: u32 = {RENEWAL_STEPS}u;");
    let _ = writeln!(text, "const REFINEMENTS: u32 = {REFINEMENTS}u;\n");
    text
}

fn series_new() -> String {
    let body = Body::default();
    let local = |index: usize| body.named(&format!("local.{}", LOCAL_FIELDS[index]));
    let series: SymbolSeries<'_> = Series::new(&Local {
        linear: local(0),
        minus_b: local(1),
        minus_damping: local(2),
        a_0: local(3),
        a_1: local(4),
        a_2: local(5),
        cubic: local(6),
        drive: local(7),
        drive_slope: local(8),
        x: local(9),
        w: local(10),
        v: local(11),
    });
    let fields: Vec<String> = series_fields()
        .map(|(name, n)| format!("        {},\n", part(&series, name)[n].text()))
        .collect();
    format!(
        "fn series_new(local: Local) -> Series {{\n{}    return Series(\n{}    );\n}}\n\n",
        body.text(),
        fields.concat()
    )
}

/// The text of a function of a series and of s.
fn evaluation<'a>(body: &'a Body, name: &str, value: impl Fn(&SymbolSeries<'a>, Symbol<'a>) -> Symbol<'a>) -> String {
    let result = value(&given(body), body.named("s")).text();
    format!(
        "fn {name}(series: Series, s: Real) -> Real {{\n{}    return {result};\n}}\n\n",
        body.text()
    )
}

fn vector_at() -> String {
    let body = Body::default();
    let start = Vector {
        x: body.named("vector.x"),
        y: body.named("vector.y"),
    };
    let end = given(&body).vector_at(start, body.named("s"));
    format!(
        "fn vector_at(series: Series, vector: Vector, s: Real) -> Vector {{\n{}    return Vector({}, {});\n}}\n",
        body.text(),
        end.x.text(),
        end.y.text()
    )
}

fn rotated() -> String {
    let body = Body::default();
    let (sin, cos) = series::rotated(body.named("sin_z"), body.named("cos_z"), body.named("s"));
    format!(
        "fn rotated(sin_z: Real, cos_z: Real, s: Real) -> Rotated {{\n{}    return Rotated({}, {});\n}}\n",
        body.text(),
        sin.text(),
        cos.text()
    )
}

/// The shader's text.
pub fn source() -> String {
    let mut text = "// Generated by src/dynamics/taylor/wgsl.rs from the recurrences in src/dynamics/taylor/series.rs: do not edit.\n\
                    // TRIBOCHAOS_UPDATE_SHADERS=1 cargo test --test shader_contract writes it anew.\n\n"
        .to_owned();
    text += &constants();
    text += &structure("Local", LOCAL_FIELDS.iter().map(|field| (*field).to_owned()));
    text += &structure("Series", series_fields().map(|(name, n)| format!("{name}_{n}")));
    text += &series_new();
    let body = Body::default;
    text += &evaluation(&body(), "x_at", Series::x_at);
    text += &evaluation(&body(), "w_at", Series::w_at);
    text += &evaluation(&body(), "v_at", Series::v_at);
    text += &evaluation(&body(), "v_slope_at", Series::v_slope_at);
    text += &evaluation(&body(), "divergence_to", Series::divergence_to);
    text += &vector_at();
    text += "\n";
    text += &rotated();
    text
}
