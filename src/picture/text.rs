//! Text of figures: the font, subscripts, the width of a text, and line breaks.
//!
//! Owns the embedded font, so that figures need no system font; places nothing.
//!
//! `k_w` and `x_{max}` are written with a subscript wherever a figure has text. Other underscores stay as they are.

use std::fmt::Write as _;
use std::sync::{Arc, LazyLock};

use resvg::usvg::{self, fontdb};

const FONT_FAMILY: &str = "DejaVu Sans";
/// The fonts that viewers of an SVG file use if this one is not installed: Verdana has the same widths.
const FALL_BACK: &str = "Verdana, sans-serif";

/// Size of subscripts and their distance below the baseline, relative to the text's size: the same as for the font's own ₖ and ₁.
const SUBSCRIPT_SIZE: f64 = 0.66;
const SUBSCRIPT_DROP: f64 = 0.17;

static OPTIONS: LazyLock<usvg::Options<'static>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    fonts.load_font_data(dejavu::sans::regular().to_vec());
    usvg::Options {
        font_family: FONT_FAMILY.to_owned(),
        fontdb: Arc::new(fonts),
        ..usvg::Options::default()
    }
});

/// Options with which SVG is read: only the embedded font is known.
pub fn options() -> &'static usvg::Options<'static> {
    &OPTIONS
}

/// An SVG document around `content`.
pub fn document(width: u32, height: u32, content: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"{FONT_FAMILY}, {FALL_BACK}\">\n{content}</svg>\n"
    )
}

/// Width of a line of text in pixels.
pub fn width(text: &str, size: f64) -> f64 {
    let content = format!("<text font-size=\"{size}\">{}</text>", marked_up(text, size));
    usvg::Tree::from_str(&document(1, 1, &content), options())
        .map_or(0.0, |tree| f64::from(tree.root().abs_bounding_box().width()))
}

/// Width of the widest of several lines.
pub fn widest<'a>(texts: impl Iterator<Item = &'a str>, size: f64) -> f64 {
    texts.map(|text| width(text, size)).fold(0.0, f64::max)
}

/// Breaks text between words into lines of at most `limit` pixels; a word that is longer has a line of its own.
pub fn wrap(text: &str, size: f64, limit: f64) -> Vec<String> {
    let mut lines = Vec::new();
    let mut line = String::new();
    for word in text.split(' ') {
        let longer = if line.is_empty() {
            word.to_owned()
        } else {
            format!("{line} {word}")
        };
        if !line.is_empty() && width(&longer, size) > limit {
            lines.push(std::mem::replace(&mut line, word.to_owned()));
        } else {
            line = longer;
        }
    }
    lines.push(line);
    lines
}

/// Text as the content of an SVG element with a font size. Subscripts are smaller runs that are moved down; all viewers can do
/// this, whereas some cannot shift the baseline.
pub fn marked_up(text: &str, size: f64) -> String {
    let drop = SUBSCRIPT_DROP * size;
    let mut svg = String::new();
    let mut rest = text;
    while let Some((before, subscript, after)) = split_at_subscript(rest) {
        let is_lowered = rest.len() < text.len();
        svg += &plain_run(before, drop, is_lowered);
        let small = SUBSCRIPT_SIZE * size;
        let _ = write!(
            svg,
            "<tspan dy=\"{drop:.2}\" font-size=\"{small:.2}\">{}</tspan>",
            escape(subscript)
        );
        rest = after;
    }
    svg + &plain_run(rest, drop, rest.len() < text.len())
}

/// Whether text has no subscripts.
pub fn is_plain(text: &str) -> bool {
    split_at_subscript(text).is_none()
}

/// Text on the baseline. After a subscript (`is_lowered`) it is moved up again.
fn plain_run(text: &str, drop: f64, is_lowered: bool) -> String {
    match (is_lowered, text) {
        (_, "") => String::new(),
        (true, text) => format!("<tspan dy=\"{:.2}\">{}</tspan>", -drop, escape(text)),
        (false, text) => escape(text),
    }
}

/// The text before the first subscript, the subscript, and the text after it. A subscript follows a letter and `_`; it is in
/// braces, or it is a single letter or digit at the end of the word.
fn split_at_subscript(text: &str) -> Option<(&str, &str, &str)> {
    let is_of_word = |character: char| character.is_alphanumeric() || character == '_';
    text.match_indices('_').find_map(|(at, _)| {
        let (before, after) = (&text[..at], &text[at + 1..]);
        if !before.ends_with(char::is_alphabetic) {
            return None;
        }
        if let Some((subscript, after)) = after.strip_prefix('{').and_then(|inner| inner.split_once('}')) {
            return Some((before, subscript, after));
        }
        let first = after.chars().next().filter(|first| first.is_alphanumeric())?;
        let (subscript, after) = after.split_at(first.len_utf8());
        (!after.starts_with(is_of_word)).then_some((before, subscript, after))
    })
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::QUANTITIES;
    use crate::parameters::PARAMETERS;

    #[test]
    fn lines_keep_within_the_limit_and_lose_nothing() {
        let text = "a text of several words, some of them long, and one & more <than> that";
        let lines = wrap(text, 15.0, 120.0);
        assert!(
            lines.len() > 3 && lines.iter().all(|line| width(line, 15.0) <= 120.0),
            "{lines:?}"
        );
        assert_eq!(lines.join(" "), text);
        assert_eq!(wrap("incomprehensibilities of it", 15.0, 20.0).len(), 3);
    }

    #[test]
    fn subscripts_are_smaller_runs_below_the_baseline() {
        assert_eq!(
            marked_up("wear u_w (m), u < 1", 10.0),
            "wear u<tspan dy=\"1.70\" font-size=\"6.60\">w</tspan><tspan dy=\"-1.70\"> (m), u &lt; 1</tspan>"
        );
        assert_eq!(
            marked_up("α_T", 10.0),
            "α<tspan dy=\"1.70\" font-size=\"6.60\">T</tspan>"
        );
        assert_eq!(
            marked_up("x_{max}", 10.0).replace("<tspan dy=\"1.70\" font-size=\"6.60\">", "["),
            "x[max</tspan>"
        );
        assert_eq!(marked_up("k_w, U_w", 10.0).matches("<tspan").count(), 3);
        for plain in ["ramp_rate", "_a", "a_", "a _b", "quasi_periodic k_", "1_000"] {
            assert_eq!(marked_up(plain, 10.0), plain);
        }
        assert!(width("u_w", 10.0) < width("uw", 10.0));
    }

    /// A glyph that the font lacks is drawn as an empty box, without an error.
    #[test]
    fn the_font_has_every_glyph_that_is_written() {
        let has = |glyph: char| {
            let content = format!("<text>{glyph}</text>");
            let tree = usvg::Tree::from_str(&document(1, 1, &content), options()).unwrap();
            let usvg::Node::Text(text) = &tree.root().children()[0] else {
                panic!("{glyph} is no text")
            };
            text.layouted()
                .iter()
                .flat_map(|span| &span.positioned_glyphs)
                .all(|glyph| glyph.id.0 != 0)
        };
        assert!(has('a') && !has('\u{4e00}'));
        let symbols = PARAMETERS.iter().flat_map(|info| info.symbol.chars());
        let labels = QUANTITIES.iter().flat_map(|info| info.label.chars());
        for glyph in symbols
            .chain(labels)
            .chain("−×⁰¹²³⁴⁵⁶⁷⁸⁹⁻≤≥τθφ\u{307}–".chars())
            .filter(|glyph| *glyph != ' ')
        {
            assert!(has(glyph), "{glyph}");
        }
    }
}
