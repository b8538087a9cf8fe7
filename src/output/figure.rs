//! A finished figure: SVG text, and its rendering to pixels.
//!
//! Owns the step from drawing to pixels; knows nothing of maps.

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::Tree;

use super::text;

/// A drawing. Its SVG names the font DejaVu Sans, which [`Figure::render`] brings along.
#[derive(Clone, Debug)]
pub struct Figure {
    pub svg: String,
    pub width: u32,
    pub height: u32,
}

impl Figure {
    /// The figure's pixels.
    ///
    /// # Errors
    /// [`FigureError::Drawing`] if the SVG cannot be drawn, or the pixels do not fit into memory.
    pub fn render(&self) -> Result<Pixmap, FigureError> {
        let tree =
            Tree::from_str(&self.svg, text::options()).map_err(|error| FigureError::Drawing(error.to_string()))?;
        let mut pixels = Pixmap::new(self.width, self.height)
            .ok_or_else(|| FigureError::Drawing(format!("no memory for {} x {} pixels", self.width, self.height)))?;
        resvg::render(&tree, Transform::identity(), &mut pixels.as_mut());
        Ok(pixels)
    }
}

#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    #[error(
        "a map of {columns} x {rows} points is too large for a picture (at most {most} points along an axis and \
         {most_pixels} pixels): draw a map with fewer points; the store can hold this one"
    )]
    TooLarge {
        columns: usize,
        rows: usize,
        most: usize,
        most_pixels: u64,
    },
    #[error("the colour limits {low} and {high} are no range: give two numbers, the lower one first")]
    Limits { low: f64, high: f64 },
    #[error("the figure cannot be drawn: {0}")]
    Drawing(String),
}
