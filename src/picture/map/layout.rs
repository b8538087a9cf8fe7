//! Sizes and places of the parts of a map's picture, in pixels.
//!
//! Owns the limits of its size; draws nothing.

use crate::picture::error::PictureError;

/// The most points along an axis, and the most pixels of the map: to draw 128 million pixels takes half a gigabyte of memory.
const MAX_POINTS: usize = 16_384;
const MAX_PIXELS: u64 = 128_000_000;

/// Pixels that a point takes along either axis, so that the map is about `size` large; at least 1.
pub fn cell_size(columns: usize, rows: usize, size: [u32; 2]) -> Result<[u32; 2], PictureError> {
    let cell = |count: usize, size: u32| ((f64::from(size) / count as f64).round() as u32).max(1);
    let [across, up] = [cell(columns, size[0]), cell(rows, size[1])];
    let pixels = columns as u64 * u64::from(across) * rows as u64 * u64::from(up);
    if columns.max(rows) > MAX_POINTS || pixels > MAX_PIXELS {
        return Err(PictureError::TooLarge {
            columns,
            rows,
            most: MAX_POINTS,
            most_pixels: MAX_PIXELS,
        });
    }
    Ok([across, up])
}

/// Sizes and places in pixels.
pub struct Layout {
    pub cell: [f64; 2],
    /// The map's left, top, width and height.
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
    /// The factor by which everything is enlarged in large pictures, so that they can be read when scaled down.
    pub unit: f64,
}

impl Layout {
    pub fn tick_size(&self) -> f64 {
        15.0 * self.unit
    }
    pub fn label_size(&self) -> f64 {
        17.0 * self.unit
    }
    pub fn caption_size(&self) -> f64 {
        14.0 * self.unit
    }
    pub fn margin(&self) -> f64 {
        16.0 * self.unit
    }
}
