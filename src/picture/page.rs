//! A finished page: SVG text, and its rendering to pixels.
//!
//! Owns the step from drawing to pixels; knows neither maps nor panels.

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::Tree;

use super::error::PictureError;
use super::text;

/// A drawing on a white page. Its SVG names the font DejaVu Sans, which [`Page::render`] supplies.
#[derive(Clone, Debug)]
pub struct Page {
    /// A complete SVG document.
    pub svg: String,
    /// In pixels.
    pub width: u32,
    /// In pixels.
    pub height: u32,
}

impl Page {
    /// A page of a size in pixels with SVG elements on it.
    pub fn new(width: u32, height: u32, content: &str) -> Self {
        let background = format!("<rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n");
        Self {
            svg: text::document(width, height, &(background + content)),
            width,
            height,
        }
    }

    /// The page's pixels.
    ///
    /// # Errors
    /// [`PictureError::Drawing`] if the SVG cannot be drawn, or the pixels do not fit into memory.
    pub fn render(&self) -> Result<Pixmap, PictureError> {
        let tree =
            Tree::from_str(&self.svg, text::options()).map_err(|error| PictureError::Drawing(error.to_string()))?;
        let mut pixels = Pixmap::new(self.width, self.height)
            .ok_or_else(|| PictureError::Drawing(format!("no memory for {} x {} pixels", self.width, self.height)))?;
        resvg::render(&tree, Transform::identity(), &mut pixels.as_mut());
        Ok(pixels)
    }
}
