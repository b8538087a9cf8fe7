//! Pictures: maps, and panels of curves and densities, as PNG and SVG.
//!
//! Computes only what a drawing needs. Each file knows only those before it in this list:
//!
//! - [`colour`], `ticks`, `text`, `svg`: colours, numbers, words and elements; `error`: what can be wrong;
//! - [`page`], [`png`], [`drawing`]: a finished page, and its files;
//! - `raster`, [`density`]: pixels within a page;
//! - [`caption`]: what captions say; [`axis_scale`], [`axis_label`]: axes and their words;
//! - [`layer`], [`panel`], [`sheet`]: what lies in a frame, the frame, and frames on a page;
//! - [`map`]: maps; [`charts`]: panels of the analyses.

pub mod axis_label;
pub mod axis_scale;
pub mod caption;
pub mod charts;
pub mod colour;
pub mod density;
pub mod drawing;
mod error;
pub mod layer;
pub mod map;
pub mod page;
pub mod panel;
pub mod png;
mod raster;
pub mod sheet;
mod svg;
mod text;
mod ticks;

pub use self::error::PictureError;
pub use self::map::{Overlay, Ramp, Shades, Style, check_size, draw, quantity_picture, shades};
