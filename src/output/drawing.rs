//! Files of drawings: PNG and SVG of one figure, with the recipe of what they show.
//!
//! Owns where the recipe is kept; the figure comes from a sheet, the recipe from whoever computed it.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use super::figure::Figure;
use super::png::{self, PngError};
use super::write_whole;

/// Keyword of the PNG text chunk that holds the recipe, in TOML: what was computed, with which parameters and settings.
pub const RECIPE_KEYWORD: &str = "tribochaos-analysis";

/// `name` with an ending, `outputs/phase` with `.png`; dots in the name stay.
pub fn with_ending(name: &Path, ending: &str) -> PathBuf {
    let mut path = name.to_owned().into_os_string();
    path.push(ending);
    path.into()
}

/// Writes `NAME.svg` and `NAME.png`, the latter last and with the recipe: where it is there, both are.
///
/// # Errors
/// [`PngError::Figure`] if the figure cannot be drawn, [`PngError::Write`] if a file cannot be written.
pub fn write_drawing(name: &Path, figure: &Figure, title: &str, recipe: &str) -> Result<[PathBuf; 2], PngError> {
    let svg = with_ending(name, ".svg");
    write_whole(&svg, |file| file.write_all(figure.svg.as_bytes())).map_err(|source| PngError::Write {
        path: svg.clone(),
        source,
    })?;
    let png = with_ending(name, ".png");
    png::write_png_with_texts(&png, figure, &[("Title", title), (RECIPE_KEYWORD, recipe)])?;
    Ok([png, svg])
}

/// The recipe in a drawing's PNG file, if it has one.
///
/// # Errors
/// As [`png::read_text`].
pub fn read_recipe(png: &Path) -> Result<Option<String>, PngError> {
    png::read_text(png, RECIPE_KEYWORD)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::text;

    #[test]
    fn both_files_are_written_and_the_recipe_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let figure = Figure {
            svg: text::document(8, 8, "<rect width=\"8\" height=\"8\" fill=\"#00ff00\"/>"),
            width: 8,
            height: 8,
        };
        let name = folder.path().join("figure-3.1");
        let [png, svg] = write_drawing(&name, &figure, "a title", "command = \"phase\"\n").unwrap();
        assert!(png.ends_with("figure-3.1.png") && std::fs::read_to_string(svg).unwrap() == figure.svg);
        assert_eq!(read_recipe(&png).unwrap().as_deref(), Some("command = \"phase\"\n"));
    }
}
