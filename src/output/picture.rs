//! Pictures of maps: which colour every point has, and what the colours mean.
//!
//! Owns the choice of colours, limits and legend for each quantity; the plot places and draws them.

use std::path::Path;

use super::caption;
use super::colour::{self, ColourScale, Rgb};
use super::colour_bar::Bar;
use super::figure::{Figure, FigureError};
pub use super::plot::Overlay;
use super::plot::{self, Cell, Kind, Plot};
use super::png::{self, PngError};
use super::ticks::{round_step, round_up};
use crate::experiment::Experiment;
use crate::machine::units::Unit;
use crate::map::{ParameterMap, drawn_border};
use crate::measure::{Class, Quantity, Values};

/// How a picture is drawn.
#[derive(Clone, Debug)]
pub struct Style {
    /// Values at the ends of the colour bar, in SI units without a prefix where it is in SI; by default they are taken from
    /// the data. A two-sided scale is always
    /// centred at zero: its colours reach as far as the larger of the two.
    pub limits: Option<(f64, f64)>,
    pub colours: ColourScale,
    /// Whether the border of chaos is drawn on the map of the exponent.
    pub border: bool,
    /// A curve from theory that is drawn over every map.
    pub overlay: Option<Overlay>,
    /// Width and height of the plotted map in pixels, met as nearly as whole pixels for each point allow.
    pub size: [u32; 2],
}

impl Default for Style {
    fn default() -> Self {
        Self {
            limits: None,
            colours: ColourScale::default(),
            border: true,
            overlay: None,
            size: [960, 640],
        }
    }
}

/// Checks, before anything is computed, that the map can be drawn.
///
/// # Errors
/// [`FigureError::TooLarge`].
///
/// # Panics
/// If the experiment has not two axes.
pub fn check_size(experiment: &Experiment, style: &Style) -> Result<(), FigureError> {
    let [x, y] = experiment.design.axes() else {
        panic!("a map has two axes")
    };
    plot::cell_size(x.count(), y.count(), style.size).map(|_| ())
}

/// Draws a quantity of a map into a PNG file that carries the experiment.
///
/// # Errors
/// [`PngError`]: if the picture cannot be drawn, or not be written.
pub fn draw(map: &ParameterMap, quantity: Quantity, style: &Style, path: &Path) -> Result<(), PngError> {
    let figure = quantity_picture(map, quantity, style)?;
    let title = format!("{} of the bush-shaft system", label(map, quantity));
    png::write_png(path, &figure, &map.experiment.to_toml(), &[("Title", &title)])
}

/// The map of any quantity; the exponent's and the period's are [`lyapunov_picture`] and [`period_picture`].
///
/// # Errors
/// [`FigureError::TooLarge`] or [`FigureError::Limits`].
pub fn quantity_picture(map: &ParameterMap, quantity: Quantity, style: &Style) -> Result<Figure, FigureError> {
    match quantity {
        Quantity::Lyapunov => lyapunov_picture(map, style),
        Quantity::Period => period_picture(map, style),
        Quantity::Attractors => attractors_picture(map, style),
        _ => match quantity.info().values {
            Values::Number => number_picture(map, quantity, style),
            Values::Code(names) => code_picture(map, quantity, names, style),
        },
    }
}

/// The map of the maximal exponent, with the undecided, quasi-periodic, unstable and runaway points in colours of their own and
/// the border of chaos.
///
/// # Errors
/// As [`quantity_picture`].
pub fn lyapunov_picture(map: &ParameterMap, style: &Style) -> Result<Figure, FigureError> {
    let kinds = vec![
        Kind::new(colour::QUASI_PERIODIC, "quasi-periodic"),
        Kind::new(colour::UNDECIDED, "undecided"),
        Kind::new(colour::RUNAWAY, "runaway"),
        Kind::new(colour::UNDER_RESOLVED, "under-resolved"),
        Kind::new(colour::UNSTABLE, "unstable"),
    ];
    let shown = Shown::of(map, Quantity::Lyapunov);
    let values = &shown.values;
    let cells = cells(map, |index| match map.class(index) {
        Some(Class::QuasiPeriodic) => Cell::Kind(0),
        Some(Class::Undecided) => Cell::Kind(1),
        Some(Class::Unstable) => Cell::Kind(4),
        Some(Class::Chaotic | Class::Regular) => Cell::Value(values[index]),
        None if map.is_under_resolved(index) => Cell::Kind(3),
        None if map.is_runaway(index) => Cell::Kind(2),
        // an exponent of finite time
        None => Cell::Value(values[index]),
    });
    let bar = bar(Quantity::Lyapunov, &shown, &cells, style)?;
    let border = if style.border { drawn_border(map) } else { Vec::new() };
    figure(
        map,
        style,
        Plot {
            cells,
            kinds,
            bar,
            border,
            ..Plot::of(map)
        },
    )
}

/// The map of the period of the motion.
///
/// # Errors
/// [`FigureError::TooLarge`].
pub fn period_picture(map: &ParameterMap, style: &Style) -> Result<Figure, FigureError> {
    let mut kinds = count_kinds();
    let first_other = kinds.len();
    kinds.extend([
        Kind::new(colour::REGULAR, "regular, no period found"),
        Kind::new(colour::QUASI_PERIODIC, "quasi-periodic"),
        Kind::new(colour::CHAOTIC, "chaotic"),
        Kind::new(colour::UNDECIDED, "undecided"),
        Kind::new(colour::RUNAWAY, "runaway"),
        Kind::new(colour::UNDER_RESOLVED, "under-resolved"),
        Kind::new(colour::NOT_APPLICABLE, "transient, since the contact wears"),
        Kind::new(colour::UNSTABLE, "unstable"),
    ]);
    let periods = map.column(Quantity::Period);
    let cells = cells(map, |index| {
        Cell::Kind(match map.class(index) {
            Some(Class::Regular) if periods[index].is_nan() => first_other,
            Some(Class::Regular) => count_kind(periods[index]),
            Some(Class::QuasiPeriodic) => first_other + 1,
            Some(Class::Chaotic) => first_other + 2,
            Some(Class::Undecided) => first_other + 3,
            Some(Class::Unstable) => first_other + 7,
            None if map.is_under_resolved(index) => first_other + 5,
            None if map.is_runaway(index) => first_other + 4,
            None => first_other + 6,
        })
    });
    let heading = "Period of the motion, in forcing periods:".to_owned();
    figure(
        map,
        style,
        Plot {
            cells,
            kinds,
            heading,
            ..Plot::of(map)
        },
    )
}

fn attractors_picture(map: &ParameterMap, style: &Style) -> Result<Figure, FigureError> {
    let mut kinds = count_kinds();
    let runaway = kinds.len();
    kinds.push(Kind::new(colour::RUNAWAY, "runaway"));
    kinds.push(Kind::new(colour::UNDER_RESOLVED, "under-resolved"));
    kinds.push(Kind::new(colour::UNDECIDED, "none settled on"));
    let counts = map.column(Quantity::Attractors);
    let kind = |index| {
        if map.is_runaway(index) {
            runaway
        } else if map.is_under_resolved(index) {
            runaway + 1
        } else if counts[index] == 0.0 {
            runaway + 2
        } else {
            count_kind(counts[index])
        }
    };
    let cells = cells(map, |index| Cell::Kind(kind(index)));
    figure(
        map,
        style,
        Plot {
            cells,
            kinds,
            heading: heading(Quantity::Attractors),
            ..Plot::of(map)
        },
    )
}

/// Whole numbers from 1, the larger ones in groups.
fn count_kinds() -> Vec<Kind> {
    let single = (1..=8).map(|count: usize| count.to_string());
    let names = single.chain(["9–16", "17–32", "above 32"].map(str::to_owned));
    colour::PERIODS
        .iter()
        .zip(names)
        .map(|(colour, name)| Kind::new(*colour, &name))
        .collect()
}

/// The index of a whole number among [`count_kinds`].
fn count_kind(count: f64) -> usize {
    match count as usize {
        count @ 0..=8 => count.saturating_sub(1),
        9..=16 => 8,
        17..=32 => 9,
        _ => 10,
    }
}

fn heading(quantity: Quantity) -> String {
    format!("{}:", caption::capitalised(quantity.info().label))
}

fn number_picture(map: &ParameterMap, quantity: Quantity, style: &Style) -> Result<Figure, FigureError> {
    let missing = match quantity {
        Quantity::ContactTime => "contact held",
        _ => "not applicable",
    };
    let kinds = vec![
        Kind::new(colour::NOT_APPLICABLE, missing),
        Kind::new(colour::RUNAWAY, "runaway"),
        Kind::new(colour::UNDER_RESOLVED, "under-resolved"),
        Kind::new(colour::UNSTABLE, "unstable"),
    ];
    let shown = Shown::of(map, quantity);
    let values = &shown.values;
    let cells = cells(map, |index| match values[index] {
        _ if map.is_runaway(index) && quantity != Quantity::RunawayTime => Cell::Kind(1),
        _ if map.is_under_resolved(index) => Cell::Kind(2),
        value if value.is_finite() => Cell::Value(value),
        _ => Cell::Kind(0),
    });
    let bar = bar(quantity, &shown, &cells, style)?;
    figure(
        map,
        style,
        Plot {
            cells,
            kinds,
            bar,
            ..Plot::of(map)
        },
    )
}

fn code_picture(map: &ParameterMap, quantity: Quantity, names: &[&str], style: &Style) -> Result<Figure, FigureError> {
    let colours = match quantity {
        Quantity::Class => Class::ALL.map(class_colour).to_vec(),
        Quantity::ContactStatus => vec![colour::PERIODS[0], colour::PERIODS[1]],
        Quantity::Status => vec![colour::CHAOTIC, colour::RUNAWAY, colour::UNDER_RESOLVED],
        _ => colour::PERIODS.to_vec(),
    };
    let mut kinds: Vec<Kind> = colours
        .iter()
        .zip(names)
        .map(|(colour, name)| Kind::new(*colour, &spoken(name)))
        .collect();
    kinds.push(Kind::new(colour::RUNAWAY, "runaway"));
    kinds.push(Kind::new(colour::UNDER_RESOLVED, "under-resolved"));
    kinds.push(Kind::new(colour::NOT_APPLICABLE, "not applicable"));
    let codes = map.column(quantity);
    // a point has no code where it ran away, is under-resolved, or where its motion is transient and has no class
    let cells = cells(map, |index| {
        Cell::Kind(match codes[index] {
            code if !code.is_nan() => code as usize,
            _ if map.is_under_resolved(index) => names.len() + 1,
            _ if map.is_runaway(index) => names.len(),
            _ => names.len() + 2,
        })
    });
    let heading = heading(quantity);
    figure(
        map,
        style,
        Plot {
            cells,
            kinds,
            heading,
            ..Plot::of(map)
        },
    )
}

fn class_colour(class: Class) -> Rgb {
    match class {
        Class::Chaotic => colour::PERIODS[4],
        Class::Regular => colour::PERIODS[0],
        Class::QuasiPeriodic => colour::QUASI_PERIODIC,
        Class::Undecided => colour::UNDECIDED,
        Class::Unstable => colour::UNSTABLE,
    }
}

/// A code's name as it is read aloud.
fn spoken(name: &str) -> String {
    match name {
        "quasi_periodic" => "quasi-periodic".to_owned(),
        name => caption::backend(name).unwrap_or_else(|| name.replace('_', " ")),
    }
}

fn cells(map: &ParameterMap, cell: impl Fn(usize) -> Cell) -> Vec<Cell> {
    let points = 0..map.experiment.design.len();
    points
        .map(|index| {
            if map.is_computed(index) {
                cell(index)
            } else {
                Cell::NotComputed
            }
        })
        .collect()
}

/// Quantities whose zero separates two kinds of values.
fn is_two_sided(quantity: Quantity) -> bool {
    matches!(
        quantity,
        Quantity::Lyapunov | Quantity::LyapunovSecond | Quantity::LyapunovBirkhoff | Quantity::X | Quantity::Y
    )
}

/// The values of a quantity as they are drawn: in SI units where there is a machine and the quantity has one.
struct Shown {
    values: Vec<f64>,
    /// Words of the colour bar, with the unit.
    label: String,
    /// What a value in plain units is multiplied with.
    factor: f64,
}

impl Shown {
    fn of(map: &ParameterMap, quantity: Quantity) -> Self {
        if let Some((values, unit)) = map.si_column(quantity) {
            let finite = values.iter().filter(|value| value.is_finite());
            let largest = finite.fold(0.0, |largest: f64, value| largest.max(value.abs()));
            let unit = Unit::suited(unit, largest);
            return Self {
                values: values.iter().map(|value| unit.factor * value).collect(),
                label: format!("{}{}", label(map, quantity), unit.bracketed()),
                factor: unit.factor,
            };
        }
        let units = match quantity.info().units {
            "1" => String::new(),
            units => format!(" ({})", units.replace("tau", "τ")),
        };
        Self {
            values: map.column(quantity).to_vec(),
            label: format!("{}{units}", label(map, quantity)),
            factor: 1.0,
        }
    }
}

/// What a quantity is called in pictures of a map.
pub fn label(map: &ParameterMap, quantity: Quantity) -> &'static str {
    let experiment = &map.experiment;
    match quantity {
        Quantity::Lyapunov if experiment.wears() => "Lyapunov exponent of finite time, λ₁",
        _ if experiment.design.fixed.machine().is_some() => quantity.si_label(),
        _ => quantity.info().label,
    }
}

/// The colour bar; none if there is no value that it would explain.
fn bar(quantity: Quantity, shown: &Shown, cells: &[Cell], style: &Style) -> Result<Option<Bar>, FigureError> {
    if let Some((low, high)) = style.limits
        && !(low < high && low.is_finite() && high.is_finite())
    {
        return Err(FigureError::Limits { low, high });
    }
    let mut values: Vec<f64> = cells
        .iter()
        .filter_map(|cell| {
            if let Cell::Value(value) = cell {
                Some(*value)
            } else {
                None
            }
        })
        .collect();
    if values.is_empty() {
        return Ok(None);
    }
    values.sort_unstable_by(f64::total_cmp);
    let (least, greatest) = (values[0], values[values.len() - 1]);
    let two_sided = is_two_sided(quantity);
    let limits = style
        .limits
        .map(|(low, high)| (shown.factor * low, shown.factor * high));
    let (low, high) = limits.unwrap_or_else(|| if two_sided { symmetric(&values) } else { span(&values) });
    let colours = style.colours;
    let reach = low.abs().max(high.abs());
    Ok(Some(Bar {
        label: shown.label.clone(),
        low,
        high,
        below: least < low,
        above: greatest > high,
        colour: Box::new(move |value| {
            let value = value.clamp(low, high);
            if two_sided {
                colours.two_sided(value / reach)
            } else {
                colours.sequential((value - low) / (high - low))
            }
        }),
    }))
}

/// Limits around zero, from sorted values. A few extremes must not pale all the rest; and where some values are
/// positive, they set the scale: a chaotic exponent is small beside those of strongly damped motion, which is no reason
/// to hide it.
fn symmetric(values: &[f64]) -> (f64, f64) {
    let positive = &values[values.partition_point(|value| *value <= 0.0)..];
    let reach = if positive.is_empty() {
        quantile(values, 0.01).abs()
    } else {
        1.25 * quantile(positive, 0.99)
    };
    // All values may be zero.
    let reach = if reach > 0.0 { round_up(reach) } else { 1.0 };
    (-reach, reach)
}

/// Round limits between which nearly all of the sorted values lie.
fn span(values: &[f64]) -> (f64, f64) {
    let (low, high) = (quantile(values, 0.01), quantile(values, 0.99));
    // A single value is given the middle of a scale around it.
    let width = if high > low {
        high - low
    } else {
        2.0 * low.abs().max(1.0)
    };
    let (low, high) = if high > low {
        (low, high)
    } else {
        (low - width / 2.0, low + width / 2.0)
    };
    let step = round_step(width / 10.0);
    ((low / step).floor() * step, (high / step).ceil() * step)
}

fn quantile(sorted: &[f64], fraction: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * fraction).round() as usize]
}

fn figure(map: &ParameterMap, style: &Style, mut plot: Plot) -> Result<Figure, FigureError> {
    plot.overlay = style.overlay.clone();
    let mut caption = caption::of(map);
    if !plot.border.is_empty() {
        caption.push(caption::border(map));
    }
    plot.draw(style.size, &caption)
}

#[cfg(test)]
#[path = "picture_tests.rs"]
mod tests;
