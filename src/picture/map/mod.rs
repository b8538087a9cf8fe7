//! Pictures of maps: a quantity in colours over two axes.
//!
//! Draws maps only from a [`ParameterMap`](crate::map::ParameterMap). Each file knows only those before it in this list:
//!
//! - `layout`: sizes and places; `axis_ticks`: which ticks fit; `paragraphs`: the caption;
//! - `bar`, `legend`: what explains the colours;
//! - `plot`: all of it on a page; `shades`: its colours alone;
//! - `style`: what a user chooses; `values`: values, units and limits;
//! - `quantity`: the colours of each quantity.

mod axis_ticks;
mod bar;
mod layout;
mod legend;
mod paragraphs;
mod plot;
mod quantity;
mod shades;
mod style;
#[cfg(test)]
mod tests;
mod values;

pub use self::plot::Overlay;
pub use self::quantity::{draw, quantity_picture, shades};
pub use self::shades::{Ramp, Shades};
pub use self::style::{Style, check_size};
pub use self::values::label;
