//! Text of figures: the font, subscripts, the width of a text, and line breaks.
//!
//! Owns the embedded font, so that figures need no system font; places nothing.
//!
//! `k_w` and `x_{max}` are written with a subscript wherever a figure has text. Other underscores stay as they are.

use std::fmt::Write as _;
use std::sync::{Arc, LazyLock};

use resvg::usvg::{self, fontdb};
use skrifa::instance::{LocationRef, Size};
use skrifa::metrics::GlyphMetrics;
use skrifa::{FontRef, MetadataProvider};

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

/// Width of a line of text in pixels: the sum of its glyphs' advances. Kerning makes some lines a little narrower.
pub fn width(text: &str, size: f64) -> f64 {
    runs(text)
        .map(|run| match run {
            Run::Subscript(text) => SUBSCRIPT_SIZE * advance(text, size),
            Run::Plain(text) => advance(text, size),
        })
        .sum()
}

/// The advances of the embedded font's glyphs, in units of its size.
static ADVANCES: LazyLock<(FontRef<'static>, GlyphMetrics<'static>)> = LazyLock::new(|| {
    let font = FontRef::new(dejavu::sans::regular()).expect("the embedded font is sound");
    let metrics = font.glyph_metrics(Size::new(1.0), LocationRef::default());
    (font, metrics)
});

fn advance(text: &str, size: f64) -> f64 {
    let (font, metrics) = &*ADVANCES;
    let glyphs = text
        .chars()
        .map(|character| font.charmap().map(character).unwrap_or_default());
    let advances = glyphs.map(|glyph| f64::from(metrics.advance_width(glyph).unwrap_or_default()));
    size * advances.sum::<f64>()
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

/// A part of a text.
#[derive(Clone, Copy)]
enum Run<'a> {
    /// On the baseline.
    Plain(&'a str),
    Subscript(&'a str),
}

/// The parts of a text, none of them empty.
fn runs(text: &str) -> impl Iterator<Item = Run<'_>> {
    let mut rest = text;
    let mut subscript = None;
    std::iter::from_fn(move || {
        if let Some(text) = subscript.take() {
            return Some(Run::Subscript(text));
        }
        if rest.is_empty() {
            return None;
        }
        let before;
        (before, subscript, rest) = split_at_subscript(rest).map_or((rest, None, ""), |(before, subscript, after)| {
            (before, Some(subscript), after)
        });
        Some(Run::Plain(before))
    })
}

/// Text as the content of an SVG element with a font size. Subscripts are smaller runs that are moved down; all viewers can do
/// this, whereas some cannot shift the baseline.
pub fn marked_up(text: &str, size: f64) -> String {
    let drop = SUBSCRIPT_DROP * size;
    let mut svg = String::new();
    let mut is_lowered = false;
    for run in runs(text) {
        let _ = match run {
            Run::Subscript(text) => {
                let small = SUBSCRIPT_SIZE * size;
                let text = escape(text);
                write!(svg, "<tspan dy=\"{drop:.2}\" font-size=\"{small:.2}\">{text}</tspan>")
            }
            // after a subscript, the text is moved up again
            Run::Plain(text) if is_lowered => write!(svg, "<tspan dy=\"{:.2}\">{}</tspan>", -drop, escape(text)),
            Run::Plain(text) => write!(svg, "{}", escape(text)),
        };
        is_lowered = matches!(run, Run::Subscript(_));
    }
    svg
}

/// Whether text has no subscripts.
pub fn is_plain(text: &str) -> bool {
    split_at_subscript(text).is_none()
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

    /// As wide as the text is drawn, but for kerning and the white borders of the first and the last glyph.
    #[test]
    fn widths_are_those_of_the_drawn_text() {
        let size = 20.0;
        for text in [
            "x",
            "zeta_k = 0..12 (300)",
            "u_w",
            "u_w after x_{max}",
            "λ₁ ≤ 10⁻³",
            "a longer line of plain text",
        ] {
            let content = format!("<text font-size=\"{size}\">{}</text>", marked_up(text, size));
            let tree = usvg::Tree::from_str(&document(1, 1, &content), options()).unwrap();
            let drawn = f64::from(tree.root().abs_bounding_box().width());
            let difference = width(text, size) - drawn;
            assert!(
                (0.0..0.2 * size + 0.01 * drawn).contains(&difference),
                "{text}: {drawn} {difference}"
            );
        }
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
