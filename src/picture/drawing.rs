//! Files of drawings: PNG and SVG of one page, with the experiment that they show.
//!
//! Owns the place of the experiment in an SVG file; the page comes from a sheet, the experiment from the caller.

use std::path::{Path, PathBuf};

use super::page::Page;
use super::png::{self, PngError};
use crate::output::whole::write_text;

/// The tags around an experiment in an SVG file.
const METADATA: [&str; 2] = ["<metadata>", "</metadata>\n"];

/// Appends an ending to `name`, for example `.png` to `outputs/phase`; dots in the name stay.
pub fn with_ending(name: &Path, ending: &str) -> PathBuf {
    let mut path = name.to_owned().into_os_string();
    path.push(ending);
    path.into()
}

/// Characters that XML text must escape, and how.
const ESCAPED: [(&str, &str); 3] = [("&", "&amp;"), ("<", "&lt;"), (">", "&gt;")];

/// Writes `NAME.svg` and then `NAME.png`; both hold the experiment, in TOML. If the PNG file exists, the SVG file exists as well.
///
/// # Errors
/// [`PngError::Picture`] if the page cannot be drawn, [`PngError::Write`] if a file cannot be written.
pub fn write_drawing(name: &Path, page: &Page, title: &str, experiment: &str) -> Result<[PathBuf; 2], PngError> {
    let svg = with_ending(name, ".svg");
    write_text(&svg, &with_metadata(&page.svg, experiment))?;
    let png = with_ending(name, ".png");
    png::write_png(&png, page, experiment, &[("Title", title)])?;
    Ok([png, svg])
}

/// The SVG text with an experiment after its opening tag.
fn with_metadata(svg: &str, experiment: &str) -> String {
    let escaped = ESCAPED.iter().fold(experiment.to_owned(), |text, (plain, escaped)| {
        text.replace(plain, escaped)
    });
    let (opening, content) = svg.split_once('\n').expect("an SVG text begins with a line of its own");
    let [begin, end] = METADATA;
    format!("{opening}\n{begin}{escaped}{end}{content}")
}

/// The experiment in an SVG text, if it has one.
pub fn experiment_in(svg: &str) -> Option<String> {
    let [begin, end] = METADATA;
    let (_, rest) = svg.split_once(begin)?;
    let (escaped, _) = rest.split_once(end.trim_end())?;
    let plain = ESCAPED.iter().rev().fold(escaped.to_owned(), |text, (plain, escaped)| {
        text.replace(escaped, plain)
    });
    Some(plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_files_are_written_and_the_experiment_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let page = Page::new(8, 8, "<rect width=\"8\" height=\"8\" fill=\"#00ff00\"/>");
        let name = folder.path().join("figure-3.1");
        let experiment = "command = \"phase\"\n# a < b & c > d\n";
        let [png, svg] = write_drawing(&name, &page, "a title", experiment).unwrap();
        assert!(png.ends_with("figure-3.1.png"));
        assert_eq!(png::read_experiment(&png).unwrap(), experiment);
        let svg = std::fs::read_to_string(svg).unwrap();
        assert_eq!(experiment_in(&svg).as_deref(), Some(experiment));
        assert_eq!(experiment_in(&page.svg), None);
    }
}
