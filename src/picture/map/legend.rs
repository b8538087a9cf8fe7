//! The legend below a map.
//!
//! Owns the signs and their rows; the plot chooses the entries.

use std::fmt::Write as _;

use super::layout::Layout;
use crate::picture::colour::Rgb;
use crate::picture::svg::{hex, line, words};
use crate::picture::text::width;

/// Width of the border of chaos, and of an overlay, in pixels.
pub const BORDER: f64 = 1.8;
pub const OVERLAY: f64 = 2.4;

/// The sign of an entry.
pub enum Sign {
    /// Words alone.
    None,
    Colour(Rgb),
    /// Of points that are not computed.
    Hatch,
    /// Of the border of chaos.
    Line,
    /// Of an overlay.
    Dashes,
}

/// The attribute of a dashed line.
pub fn dashes(unit: f64) -> String {
    format!(" stroke-dasharray=\"{} {}\"", 9.0 * unit, 4.0 * unit)
}

/// Draws the entries in rows below `above`. Returns the y of the lowest row.
pub fn draw(svg: &mut String, layout: &Layout, entries: &[(Sign, &str)], above: f64, page_width: f64) -> f64 {
    if entries.is_empty() {
        return above;
    }
    let (unit, size) = (layout.unit, layout.tick_size());
    let (row, swatch) = (1.7 * size, 22.0 * unit);
    let (mut x, mut y) = (layout.margin(), above + 1.3 * row);
    for (sign, name) in entries {
        let mark = if matches!(sign, Sign::None) {
            0.0
        } else {
            swatch + 7.0 * unit
        };
        let entry = mark + width(name, size);
        if x > layout.margin() && x + entry > page_width - layout.margin() {
            (x, y) = (layout.margin(), y + row);
        }
        let middle = y - 0.36 * size;
        let mut draw_swatch = |fill: &str| {
            let _ = writeln!(
                svg,
                "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"{swatch}\" height=\"{}\" fill=\"{fill}\" \
                 stroke=\"#000000\" stroke-width=\"{}\"/>",
                middle - 7.0 * unit,
                14.0 * unit,
                0.7 * unit
            );
        };
        match sign {
            Sign::None => {}
            Sign::Colour(colour) => draw_swatch(&hex(*colour)),
            Sign::Hatch => draw_swatch("url(#hatch)"),
            Sign::Line => line(svg, [x, middle, x + swatch, middle], BORDER * unit),
            Sign::Dashes => {
                let _ = writeln!(
                    svg,
                    "<path d=\"M{x:.1} {middle:.1}L{:.1} {middle:.1}\" stroke=\"#000000\" \
                     stroke-width=\"{}\"{}/>",
                    x + swatch,
                    OVERLAY * unit,
                    dashes(unit)
                );
            }
        }
        words(svg, name, x + mark, y, size, "start");
        x += entry + 22.0 * unit;
    }
    y
}
