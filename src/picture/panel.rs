//! A panel: layers within a frame with axes, and a legend below.
//!
//! Owns the room around a frame and what stands in it; the sheet places panels, others choose what they show.

use std::fmt::Write as _;

use super::axis_scale::{AxisScale, TICK_SIZE};
use super::density::Density;
use super::error::PictureError;
use super::layer::{Layer, SWATCH};
use super::svg::{line, upright, words};
use super::text::{widest, width, wrap};

/// A frame with axes and what lies within.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Words above the frame; empty for none.
    pub title: String,
    /// The axis below the frame.
    pub x: AxisScale,
    /// The axis to the left of the frame.
    pub y: AxisScale,
    /// In the order in which they are drawn.
    pub layers: Vec<Layer>,
    /// Why there are no values, if there are none.
    pub nothing: String,
}

const LABEL_SIZE: f64 = 16.0;
const LINE: f64 = 1.35 * LABEL_SIZE;
const LEGEND_ROW: f64 = 1.7 * TICK_SIZE;

/// Room around a frame, in pixels.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Room {
    /// For the words of the y axis; `numbers` is for the numbers at its ticks, between the words and the frame.
    pub label: f64,
    pub numbers: f64,
    pub right: f64,
    pub top: f64,
    pub bottom: f64,
}

impl Panel {
    /// Room that the panel needs around a frame of a size.
    pub(super) fn room(&self, [frame_width, frame_height]: [f64; 2]) -> Room {
        let y_ticks = self.y.ticks_up(frame_height);
        let tick_width = widest(y_ticks.iter().map(|tick| tick.label.as_str()), TICK_SIZE);
        let y_lines = wrap(&self.y.label, LABEL_SIZE, frame_height).len() as f64;
        let below = if self.x.is_bare {
            0.0
        } else {
            9.0 + TICK_SIZE + wrap(&self.x.label, LABEL_SIZE, frame_width).len() as f64 * LINE
        };
        let bar = self.density().map_or(18.0, |density| density.bar_room(TICK_SIZE));
        Room {
            label: y_lines * LINE,
            numbers: 10.0 + tick_width + 12.0,
            right: bar,
            top: if self.title.is_empty() { 12.0 } else { 1.9 * LABEL_SIZE },
            bottom: below + self.legend_rows(frame_width).len() as f64 * LEGEND_ROW + 12.0,
        }
    }

    fn flags(&self) -> impl Iterator<Item = (f64, &str)> {
        self.layers.iter().filter_map(|layer| match layer {
            Layer::Flag { x, words, .. } => Some((*x, words.as_str())),
            _ => None,
        })
    }

    fn density(&self) -> Option<&Density> {
        self.layers.iter().find_map(|layer| match layer {
            Layer::Density(density) if density.most() > 0 => Some(density),
            _ => None,
        })
    }

    /// The message in an empty frame; None if the frame is not empty.
    fn notice(&self) -> Option<String> {
        if self.layers.iter().any(|layer| layer.shows(&self.x, &self.y)) {
            return None;
        }
        let reason = if self.layers.iter().any(Layer::has_values) {
            "all of it lies outside the frame"
        } else {
            &self.nothing
        };
        Some(format!("nothing to draw: {reason}"))
    }

    /// Draws the panel with its frame at [left, top, width, height]. The words of the y axis stand `numbers` pixels to the left
    /// of the frame. `id` is unique in the document.
    pub(super) fn draw(&self, svg: &mut String, frame: [f64; 4], numbers: f64, id: usize) -> Result<(), PictureError> {
        let [left, top, frame_width, frame_height] = frame;
        let place = format!("x=\"{left}\" y=\"{top}\" width=\"{frame_width}\" height=\"{frame_height}\"");
        let _ = writeln!(
            svg,
            "<clipPath id=\"frame{id}\"><rect {place}/></clipPath>\n<g clip-path=\"url(#frame{id})\">"
        );
        for layer in &self.layers {
            layer.draw(svg, frame, &self.x, &self.y)?;
        }
        let _ = writeln!(
            svg,
            "</g>\n<rect {place} fill=\"none\" stroke=\"#000000\" stroke-width=\"1\"/>"
        );
        if !self.title.is_empty() {
            words(svg, &self.title, left, top - 0.55 * LABEL_SIZE, LABEL_SIZE, "start");
        }
        let mut clear = if self.title.is_empty() {
            left
        } else {
            left + width(&self.title, LABEL_SIZE) + 16.0
        };
        for (x, text) in self.flags() {
            // above its line, unless the title or the frame's end leaves no room there
            let room = left + frame_width - width(text, TICK_SIZE);
            let at = (left + self.x.part(x) * frame_width - 6.0).min(room).max(clear);
            words(svg, text, at, top - 0.55 * LABEL_SIZE, TICK_SIZE, "start");
            clear = at + width(text, TICK_SIZE) + 16.0;
        }
        if let Some(notice) = self.notice() {
            let lines = wrap(&notice, LABEL_SIZE, frame_width - 2.0 * LABEL_SIZE);
            let first = top + 0.5 * frame_height - 0.5 * (lines.len() - 1) as f64 * LINE;
            for (index, line) in lines.iter().enumerate() {
                let y = first + index as f64 * LINE + 0.36 * LABEL_SIZE;
                words(svg, line, left + 0.5 * frame_width, y, LABEL_SIZE, "middle");
            }
        }
        self.draw_axes(svg, frame, numbers);
        if let Some(density) = self.density() {
            density.draw_bar(svg, [left + frame_width, top, frame_height], TICK_SIZE, id);
        }
        Ok(())
    }

    fn draw_axes(&self, svg: &mut String, [left, top, frame_width, frame_height]: [f64; 4], numbers: f64) {
        let bottom = top + frame_height;
        for tick in self.x.ticks_across(frame_width) {
            let x = left + self.x.part(tick.value) * frame_width;
            line(svg, [x, bottom, x, bottom + 6.0], 1.0);
            if !self.x.is_bare {
                words(svg, &tick.label, x, bottom + 9.0 + TICK_SIZE, TICK_SIZE, "middle");
            }
        }
        for tick in self.y.ticks_up(frame_height) {
            let y = bottom - self.y.part(tick.value) * frame_height;
            line(svg, [left - 6.0, y, left, y], 1.0);
            words(svg, &tick.label, left - 10.0, y + 0.36 * TICK_SIZE, TICK_SIZE, "end");
        }
        let y_lines = wrap(&self.y.label, LABEL_SIZE, frame_height);
        for (index, text) in y_lines.iter().enumerate() {
            let x = left - numbers - (y_lines.len() - 1 - index) as f64 * LINE;
            upright(svg, text, x, top + 0.5 * frame_height, LABEL_SIZE);
        }
        let mut y = bottom;
        if !self.x.is_bare {
            y += 9.0 + TICK_SIZE;
            for text in wrap(&self.x.label, LABEL_SIZE, frame_width) {
                y += LINE;
                words(svg, &text, left + 0.5 * frame_width, y, LABEL_SIZE, "middle");
            }
        }
        for row in self.legend_rows(frame_width) {
            y += LEGEND_ROW;
            let mut x = left;
            for layer in row {
                layer.draw_swatch(svg, x, y - 0.36 * TICK_SIZE);
                words(svg, layer.name(), x + SWATCH + 7.0, y, TICK_SIZE, "start");
                x += entry_width(layer);
            }
        }
    }

    /// The entries of the legend, in rows that fit under the frame: layers that have a name and are visible, and keys.
    fn legend_rows(&self, frame_width: f64) -> Vec<Vec<&Layer>> {
        let mut rows: Vec<Vec<&Layer>> = Vec::new();
        let mut room = 0.0;
        let is_entry = |layer: &&Layer| {
            let is_key = matches!(layer, Layer::CurveKey { .. } | Layer::MarkKey { .. });
            !layer.name().is_empty() && (is_key || layer.shows(&self.x, &self.y))
        };
        for layer in self.layers.iter().filter(is_entry) {
            let entry = entry_width(layer);
            if rows.is_empty() || entry > room {
                rows.push(Vec::new());
                // the last entry of a row needs no distance to a next entry
                room = frame_width + 22.0;
            }
            room -= entry;
            rows.last_mut().expect("a row was pushed").push(layer);
        }
        rows
    }
}

fn entry_width(layer: &Layer) -> f64 {
    SWATCH + 7.0 + width(layer.name(), TICK_SIZE) + 22.0
}
