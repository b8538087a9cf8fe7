//! Text of figures: the font, how wide a text is, and its breaking into lines.
//!
//! Owns the embedded font, so that figures need none of the system's; places nothing.

use std::sync::{Arc, LazyLock};

use resvg::usvg::{self, fontdb};

const FONT_FAMILY: &str = "DejaVu Sans";

static OPTIONS: LazyLock<usvg::Options<'static>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    fonts.load_font_data(dejavu::sans::regular().to_vec());
    usvg::Options {
        font_family: FONT_FAMILY.to_owned(),
        fontdb: Arc::new(fonts),
        ..usvg::Options::default()
    }
});

/// How SVG is read: with the embedded font alone.
pub fn options() -> &'static usvg::Options<'static> {
    &OPTIONS
}

/// An SVG document around `content`.
pub fn document(width: u32, height: u32, content: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"{FONT_FAMILY}, sans-serif\">\n{content}</svg>\n"
    )
}

/// Width of a line of text in pixels.
pub fn width(text: &str, size: f64) -> f64 {
    let content = format!("<text font-size=\"{size}\">{}</text>", escape(text));
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

pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measurement::QUANTITIES;
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

    /// A glyph that the font has not is drawn as an empty box, without an error.
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
