//! The few SVG elements that pictures consist of.
//!
//! Owns their text; places nothing.

use std::fmt::Write as _;

use super::colour::Rgb;
use super::text::{is_plain, marked_up, width, wrap};

/// A line of text with its anchor, `start`, `middle` or `end`, on the baseline `y`.
pub fn words(svg: &mut String, text: &str, x: f64, y: f64, size: f64, anchor: &str) {
    let (shift, anchor) = anchored(text, size, anchor);
    let text = marked_up(text, size);
    let x = x + shift;
    let _ = writeln!(
        svg,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" text-anchor=\"{anchor}\">{text}</text>"
    );
}

/// The shift of a text with the given anchor, and its anchor in the SVG. Some viewers anchor each run of a text by itself; a
/// text of several runs is therefore anchored at its start.
fn anchored<'a>(text: &str, size: f64, anchor: &'a str) -> (f64, &'a str) {
    match anchor {
        "middle" if !is_plain(text) => (-0.5 * width(text, size), "start"),
        "end" if !is_plain(text) => (-width(text, size), "start"),
        anchor => (0.0, anchor),
    }
}

/// Draws paragraphs below `y`, with their left end at `x`, in lines of at most `limit` pixels. Returns the last baseline.
pub fn paragraphs(svg: &mut String, paragraphs: &[String], [x, mut y]: [f64; 2], size: f64, limit: f64) -> f64 {
    for line in paragraphs.iter().flat_map(|paragraph| wrap(paragraph, size, limit)) {
        y += 1.4 * size;
        words(svg, &line, x, y, size, "start");
    }
    y
}

/// Text that runs upwards, with its middle at `y`.
pub fn upright(svg: &mut String, text: &str, x: f64, y: f64, size: f64) {
    let (shift, anchor) = anchored(text, size, "middle");
    let text = marked_up(text, size);
    let y = y - shift;
    let _ = writeln!(
        svg,
        "<text transform=\"translate({x:.1} {y:.1}) rotate(-90)\" font-size=\"{size}\" \
         text-anchor=\"{anchor}\">{text}</text>"
    );
}

pub fn line(svg: &mut String, [x1, y1, x2, y2]: [f64; 4], stroke: f64) {
    let _ = writeln!(
        svg,
        "<path d=\"M{x1:.2} {y1:.2}L{x2:.2} {y2:.2}\" stroke=\"#000000\" stroke-width=\"{stroke}\"/>"
    );
}

/// The SVG path of a line through places; a place that is not finite interrupts the line.
pub fn path(places: impl Iterator<Item = (f64, f64)>) -> String {
    let mut path = String::new();
    let mut is_drawing = false;
    for (x, y) in places {
        if !(x.is_finite() && y.is_finite()) {
            is_drawing = false;
            continue;
        }
        // far outside the frame coordinates would lose their digits
        let (x, y) = (x.clamp(-1e5, 1e5), y.clamp(-1e5, 1e5));
        let _ = write!(path, "{}{x:.2} {y:.2}", if is_drawing { 'L' } else { 'M' });
        is_drawing = true;
    }
    path
}

pub fn hatch(svg: &mut String, unit: f64) {
    let side = 8.0 * unit;
    let _ = writeln!(
        svg,
        "<pattern id=\"hatch\" width=\"{side}\" height=\"{side}\" patternUnits=\"userSpaceOnUse\" \
         patternTransform=\"rotate(45)\"><rect width=\"{side}\" height=\"{side}\" fill=\"#ffffff\"/>\
         <rect width=\"{unit}\" height=\"{side}\" fill=\"#707070\"/></pattern>"
    );
}

pub fn hex([red, green, blue]: Rgb) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}
