//! Pictures of quantities: which colour every point of a map has, and what the colours mean.
//!
//! Owns the choice of colours and legend for each quantity; the plot places and draws them.

use std::path::Path;

use super::paragraphs;
use super::plot::{Cell, Kind, Plot};
use super::shades::Shades;
use super::style::Style;
use super::values::{Shown, bar, label};
use crate::map::{ParameterMap, drawn_border};
use crate::measure::{Class, Quantity, Values};
use crate::picture::caption;
use crate::picture::colour::{self, class_colour};
use crate::picture::error::PictureError;
use crate::picture::page::Page;
use crate::picture::png::{self, PngError};

/// Draws a quantity of a map into a PNG file that carries the experiment.
///
/// # Errors
/// [`PngError`] if the picture cannot be drawn or written.
pub fn draw(map: &ParameterMap, quantity: Quantity, style: &Style, path: &Path) -> Result<(), PngError> {
    let page = quantity_picture(map, quantity, style)?;
    let title = format!("{} of the bush-shaft system", label(map, quantity));
    png::write_png(path, &page, &map.experiment.to_toml(), &[("Title", &title)])
}

/// The map of any quantity, above its caption.
///
/// # Errors
/// [`PictureError::TooLarge`] or [`PictureError::Limits`].
pub fn quantity_picture(map: &ParameterMap, quantity: Quantity, style: &Style) -> Result<Page, PictureError> {
    let plot = plot(map, quantity, style)?;
    let mut caption = paragraphs::of(map);
    caption.extend(style.note.clone());
    if !plot.border.is_empty() {
        caption.push(paragraphs::border(map));
    }
    plot.draw(style.size, &caption)
}

/// The colours of a quantity at each point of a map, and their meaning: the map without axes, border and caption.
///
/// # Errors
/// [`PictureError::Limits`].
pub fn shades(map: &ParameterMap, quantity: Quantity, style: &Style) -> Result<Shades, PictureError> {
    Ok(Shades::of(&plot(map, quantity, style)?))
}

fn plot(map: &ParameterMap, quantity: Quantity, style: &Style) -> Result<Plot, PictureError> {
    let plot = match quantity {
        Quantity::Lyapunov => lyapunov_plot(map, style)?,
        Quantity::Period => period_plot(map),
        Quantity::Attractors => attractors_plot(map),
        _ => match quantity.info().values {
            Values::F64 | Values::F32 => number_plot(map, quantity, style)?,
            Values::Code(names) => code_plot(map, quantity, names),
        },
    };
    Ok(Plot {
        overlay: style.overlay.clone(),
        ..plot
    })
}

/// The maximal exponent, with the undecided, quasi-periodic, unstable and runaway points in colours of their own and the border of
/// chaos.
fn lyapunov_plot(map: &ParameterMap, style: &Style) -> Result<Plot, PictureError> {
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
        None if map.is_under_resolved(index) => Cell::Kind(3),
        None if map.is_runaway(index) => Cell::Kind(2),
        // other points without a class have an exponent of finite time
        Some(Class::Chaotic | Class::Regular) | None => Cell::Value(values[index]),
    });
    let bar = bar(Quantity::Lyapunov, &shown, &cells, style)?;
    let border = if style.border { drawn_border(map) } else { Vec::new() };
    Ok(Plot {
        cells,
        kinds,
        bar,
        border,
        ..Plot::of(map)
    })
}

/// The period of the motion.
fn period_plot(map: &ParameterMap) -> Plot {
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
    let period = |index| map.value(Quantity::Period, index);
    let cells = cells(map, |index| {
        Cell::Kind(match map.class(index) {
            Some(Class::Regular) if period(index).is_nan() => first_other,
            Some(Class::Regular) => count_kind(period(index)),
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
    Plot {
        cells,
        kinds,
        heading,
        ..Plot::of(map)
    }
}

fn attractors_plot(map: &ParameterMap) -> Plot {
    let mut kinds = count_kinds();
    let runaway = kinds.len();
    kinds.push(Kind::new(colour::RUNAWAY, "runaway"));
    kinds.push(Kind::new(colour::UNDER_RESOLVED, "under-resolved"));
    kinds.push(Kind::new(colour::UNDECIDED, "none settled on"));
    let count = |index| map.value(Quantity::Attractors, index);
    let kind = |index| {
        if map.is_runaway(index) {
            runaway
        } else if map.is_under_resolved(index) {
            runaway + 1
        } else if count(index) == 0.0 {
            runaway + 2
        } else {
            count_kind(count(index))
        }
    };
    let cells = cells(map, |index| Cell::Kind(kind(index)));
    Plot {
        cells,
        kinds,
        heading: heading(Quantity::Attractors),
        ..Plot::of(map)
    }
}

/// The kinds for whole numbers from 1 on; larger numbers form groups.
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

fn number_plot(map: &ParameterMap, quantity: Quantity, style: &Style) -> Result<Plot, PictureError> {
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
    Ok(Plot {
        cells,
        kinds,
        bar,
        ..Plot::of(map)
    })
}

fn code_plot(map: &ParameterMap, quantity: Quantity, names: &[&str]) -> Plot {
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
    // a point has no code where it ran away, is under-resolved, or where its motion is transient and has no class
    let cells = cells(map, |index| {
        Cell::Kind(match map.value(quantity, index) {
            code if !code.is_nan() => code as usize,
            _ if map.is_under_resolved(index) => names.len() + 1,
            _ if map.is_runaway(index) => names.len(),
            _ => names.len() + 2,
        })
    });
    let heading = heading(quantity);
    Plot {
        cells,
        kinds,
        heading,
        ..Plot::of(map)
    }
}

/// The name of a code as ordinary words.
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
