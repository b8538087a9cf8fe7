//! A panel: curves, bands, marks and densities within a frame with axes.
//!
//! Owns what a panel holds and its drawing within given room; the sheet places panels, others choose what they show.

use std::fmt::Write as _;

use super::colour::Rgb;
use super::density::Density;
use super::figure::FigureError;
use super::svg::{hex, line, upright, words};
use super::text::{widest, width, wrap};
use super::ticks::{Tick, decades, thinned, ticks};

/// One axis: its words and its ends.
#[derive(Clone, Debug)]
pub struct Scale {
    pub label: String,
    pub low: f64,
    pub high: f64,
    /// Whether ticks have no numbers and the axis no words: a panel below has the same scale.
    pub is_bare: bool,
    /// Whether no value tells where the ends are: there are no ticks.
    pub is_blank: bool,
    /// Whether values are decadic logarithms of what the ticks say.
    pub is_logarithmic: bool,
    /// The ticks of an axis of listed values; empty for others.
    pub listed: Vec<Tick>,
}

impl Scale {
    pub fn new(label: &str, low: f64, high: f64) -> Self {
        Self {
            label: label.to_owned(),
            low,
            high,
            is_bare: false,
            is_blank: false,
            is_logarithmic: false,
            listed: Vec::new(),
        }
    }

    /// A logarithmic scale, between the decadic logarithms of two values.
    pub fn logarithmic(label: &str, low: f64, high: f64) -> Self {
        Self {
            is_logarithmic: true,
            ..Self::new(label, low, high)
        }
    }

    /// The same scale where a panel below shows its numbers and words.
    #[must_use]
    pub fn bare(self) -> Self {
        Self { is_bare: true, ..self }
    }

    /// Ends a little beyond the finite ones of the values; around a single value where there is no extent; blank without any.
    pub fn around(label: &str, values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values
            .filter(|value| value.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            });
        if low > high {
            return Self {
                is_blank: true,
                ..Self::new(label, 0.0, 1.0)
            };
        }
        let margin = if high > low {
            0.04 * (high - low)
        } else {
            0.5 * high.abs().max(1.0)
        };
        Self::new(label, low - margin, high + margin)
    }

    /// Position of a value, 0 at the lower end and 1 at the upper.
    fn part(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    /// Whether some value between two, which are no numbers where there is none, lies on the axis.
    fn meets(&self, [one, other]: [f64; 2]) -> bool {
        one.min(other) <= self.high && one.max(other) >= self.low
    }
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    pub colour: Rgb,
    /// In pixels.
    pub width: f64,
    pub is_dashed: bool,
}

impl Stroke {
    pub fn solid(colour: Rgb, width: f64) -> Self {
        Self {
            colour,
            width,
            is_dashed: false,
        }
    }

    pub fn dashed(colour: Rgb, width: f64) -> Self {
        Self {
            colour,
            width,
            is_dashed: true,
        }
    }

    fn attributes(&self) -> String {
        let dash = if self.is_dashed {
            format!(" stroke-dasharray=\"{} {}\"", 4.0 * self.width, 2.5 * self.width)
        } else {
            String::new()
        };
        format!(
            "fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"{dash}",
            hex(self.colour),
            self.width
        )
    }
}

/// What lies within a frame; layers are drawn in their order. A name appears in the legend; an empty one does not.
#[derive(Clone, Debug)]
pub enum Layer {
    /// A line through points; NaN parts its pieces.
    Curve {
        name: String,
        points: Vec<[f64; 2]>,
        stroke: Stroke,
    },
    /// The area between two curves, as [x, low, high].
    Band {
        name: String,
        points: Vec<[f64; 3]>,
        colour: Rgb,
    },
    /// Filled circles.
    Marks {
        name: String,
        points: Vec<[f64; 2]>,
        colour: Rgb,
        /// In pixels.
        radius: f64,
    },
    /// Hits per pixel over the whole frame.
    Density(Density),
    /// A line across the frame at a height.
    Level { y: f64, stroke: Stroke },
    /// A line up the frame, and words above it, where they hide nothing.
    Flag { x: f64, words: String, stroke: Stroke },
    /// An entry of the legend alone, for a curve whose layer does not stand in the legend's order.
    CurveKey { name: String, stroke: Stroke },
    /// An entry of the legend alone, for marks of several colours.
    MarkKey { name: String, colour: Rgb },
}

/// A frame with axes and what lies within.
#[derive(Clone, Debug)]
pub struct Panel {
    pub title: String,
    pub x: Scale,
    pub y: Scale,
    pub layers: Vec<Layer>,
    /// Why there are no values, if there are none.
    pub nothing: String,
}

const TICK_SIZE: f64 = 15.0;
const LABEL_SIZE: f64 = 16.0;
const LINE: f64 = 1.35 * LABEL_SIZE;
const LEGEND_ROW: f64 = 1.7 * TICK_SIZE;
const SWATCH: f64 = 30.0;

/// Room around a frame, in pixels.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Room {
    /// Words of the y axis, and the numbers at its ticks between them and the frame.
    pub label: f64,
    pub numbers: f64,
    pub right: f64,
    pub top: f64,
    pub bottom: f64,
}

impl Panel {
    /// Room that the panel needs around a frame of a size.
    pub(super) fn room(&self, [frame_width, frame_height]: [f64; 2]) -> Room {
        let y_ticks = y_ticks(&self.y, frame_height);
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

    /// Whether something of a layer lies within the frame; lines across it, which mark a place, do not count.
    fn shows(&self, layer: &Layer) -> bool {
        let is_within = |[x, y]: [f64; 2]| self.x.meets([x, x]) && self.y.meets([y, y]);
        match layer {
            Layer::Curve { points, .. } => {
                points.iter().any(|&point| is_within(point))
                    || points.windows(2).any(|ends| {
                        ends.iter().flatten().all(|value| value.is_finite())
                            && [&self.x, &self.y]
                                .iter()
                                .enumerate()
                                .all(|(axis, scale)| scale.meets([ends[0][axis], ends[1][axis]]))
                    })
            }
            Layer::Band { points, .. } => points
                .iter()
                .any(|&[x, low, high]| self.x.meets([x, x]) && self.y.meets([low, high])),
            Layer::Marks { points, .. } => points.iter().any(|&point| is_within(point)),
            Layer::Density(density) => density.most() > 0,
            Layer::Level { .. } | Layer::Flag { .. } | Layer::CurveKey { .. } | Layer::MarkKey { .. } => false,
        }
    }

    /// What is said within a frame in which there is nothing.
    fn notice(&self) -> Option<String> {
        if self.layers.iter().any(|layer| self.shows(layer)) {
            return None;
        }
        let reason = if self.layers.iter().any(has_values) {
            "all of it lies outside the frame"
        } else {
            &self.nothing
        };
        Some(format!("nothing to draw: {reason}"))
    }

    /// Draws the panel with its frame at [left, top, width, height], and the words of its y axis so far to the left that
    /// there is room for `numbers`; `id` is unique in the document.
    pub(super) fn draw(&self, svg: &mut String, frame: [f64; 4], numbers: f64, id: usize) -> Result<(), FigureError> {
        let [left, top, frame_width, frame_height] = frame;
        let place = format!("x=\"{left}\" y=\"{top}\" width=\"{frame_width}\" height=\"{frame_height}\"");
        let _ = writeln!(
            svg,
            "<clipPath id=\"frame{id}\"><rect {place}/></clipPath>\n<g clip-path=\"url(#frame{id})\">"
        );
        for layer in &self.layers {
            self.draw_layer(svg, frame, layer)?;
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
            // above its line, but for the title and the frame's end
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

    fn draw_layer(&self, svg: &mut String, frame: [f64; 4], layer: &Layer) -> Result<(), FigureError> {
        let [left, top, frame_width, frame_height] = frame;
        let place = |[x, y]: [f64; 2]| {
            (
                left + self.x.part(x) * frame_width,
                top + (1.0 - self.y.part(y)) * frame_height,
            )
        };
        match layer {
            Layer::Curve { points, stroke, .. } => {
                let path = path(points.iter().map(|&point| place(point)));
                let _ = writeln!(svg, "<path d=\"{path}\" {}/>", stroke.attributes());
            }
            Layer::Band { points, colour, .. } => {
                // pieces between gaps, there along the upper end and back along the lower
                let pieces = points.split(|point| point.iter().any(|value| !value.is_finite()));
                for piece in pieces.filter(|piece| !piece.is_empty()) {
                    let upper = piece.iter().map(|&[x, _, high]| place([x, high]));
                    let lower = piece.iter().rev().map(|&[x, low, _]| place([x, low]));
                    let path = path(upper.chain(lower));
                    let _ = writeln!(
                        svg,
                        "<path d=\"{path}\" fill=\"{}\" fill-opacity=\"0.3\" stroke=\"none\"/>",
                        hex(*colour)
                    );
                }
            }
            Layer::Marks {
                points, colour, radius, ..
            } => {
                for (x, y) in points.iter().map(|&point| place(point)) {
                    if x.is_finite() && y.is_finite() {
                        let _ = writeln!(
                            svg,
                            "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius}\" fill=\"{}\" stroke=\"#ffffff\" \
                             stroke-width=\"{}\"/>",
                            hex(*colour),
                            0.2 * radius
                        );
                    }
                }
            }
            Layer::Density(density) => density.draw(svg, frame)?,
            Layer::Level { y, stroke } => {
                let (_, y) = place([self.x.low, *y]);
                let _ = writeln!(
                    svg,
                    "<path d=\"M{left} {y:.2}L{} {y:.2}\" {}/>",
                    left + frame_width,
                    stroke.attributes()
                );
            }
            Layer::Flag { x, stroke, .. } => {
                let (x, _) = place([*x, self.y.low]);
                let _ = writeln!(
                    svg,
                    "<path d=\"M{x:.2} {top}L{x:.2} {}\" {}/>",
                    top + frame_height,
                    stroke.attributes()
                );
            }
            Layer::CurveKey { .. } | Layer::MarkKey { .. } => {}
        }
        Ok(())
    }

    fn draw_axes(&self, svg: &mut String, [left, top, frame_width, frame_height]: [f64; 4], numbers: f64) {
        let bottom = top + frame_height;
        for tick in x_ticks(&self.x, frame_width) {
            let x = left + self.x.part(tick.value) * frame_width;
            line(svg, [x, bottom, x, bottom + 6.0], 1.0);
            if !self.x.is_bare {
                words(svg, &tick.label, x, bottom + 9.0 + TICK_SIZE, TICK_SIZE, "middle");
            }
        }
        for tick in y_ticks(&self.y, frame_height) {
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
                draw_swatch(svg, layer, x, y - 0.36 * TICK_SIZE);
                words(svg, name(layer), x + SWATCH + 7.0, y, TICK_SIZE, "start");
                x += entry_width(layer);
            }
        }
    }

    /// The layers with a name of which there is something to see, in rows that fit under the frame.
    fn legend_rows(&self, frame_width: f64) -> Vec<Vec<&Layer>> {
        let mut rows: Vec<Vec<&Layer>> = Vec::new();
        let mut room = 0.0;
        let is_entry = |layer: &&Layer| {
            let is_key = matches!(layer, Layer::CurveKey { .. } | Layer::MarkKey { .. });
            !name(layer).is_empty() && (is_key || self.shows(layer))
        };
        for layer in self.layers.iter().filter(is_entry) {
            let entry = entry_width(layer);
            if rows.is_empty() || entry > room {
                rows.push(Vec::new());
                // the last entry of a row may use its own distance to the next
                room = frame_width + 22.0;
            }
            room -= entry;
            rows.last_mut().expect("a row was pushed").push(layer);
        }
        rows
    }
}

fn name(layer: &Layer) -> &str {
    match layer {
        Layer::Curve { name, .. }
        | Layer::Band { name, .. }
        | Layer::Marks { name, .. }
        | Layer::CurveKey { name, .. }
        | Layer::MarkKey { name, .. } => name,
        Layer::Density(_) | Layer::Level { .. } | Layer::Flag { .. } => "",
    }
}

/// Whether a layer has values, wherever they lie.
fn has_values(layer: &Layer) -> bool {
    match layer {
        Layer::Curve { points, .. } | Layer::Marks { points, .. } => {
            points.iter().any(|point| point.iter().all(|value| value.is_finite()))
        }
        Layer::Band { points, .. } => points.iter().any(|point| point.iter().all(|value| value.is_finite())),
        Layer::Density(density) => density.most() > 0 || density.outside() > 0,
        Layer::Level { .. } | Layer::Flag { .. } | Layer::CurveKey { .. } | Layer::MarkKey { .. } => false,
    }
}

fn entry_width(layer: &Layer) -> f64 {
    SWATCH + 7.0 + width(name(layer), TICK_SIZE) + 22.0
}

fn draw_swatch(svg: &mut String, layer: &Layer, x: f64, middle: f64) {
    match layer {
        Layer::Curve { stroke, .. } | Layer::CurveKey { stroke, .. } => {
            let stroke = Stroke {
                width: stroke.width.max(1.6),
                ..*stroke
            };
            let _ = writeln!(
                svg,
                "<path d=\"M{x:.1} {middle:.1}L{:.1} {middle:.1}\" {}/>",
                x + SWATCH,
                stroke.attributes()
            );
        }
        Layer::Band { colour, .. } => {
            let _ = writeln!(
                svg,
                "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"{SWATCH}\" height=\"12\" fill=\"{}\" fill-opacity=\"0.3\"/>",
                middle - 6.0,
                hex(*colour)
            );
        }
        Layer::Marks { colour, .. } | Layer::MarkKey { colour, .. } => {
            let _ = writeln!(
                svg,
                "<circle cx=\"{:.1}\" cy=\"{middle:.1}\" r=\"3.5\" fill=\"{}\"/>",
                x + 0.5 * SWATCH,
                hex(*colour)
            );
        }
        Layer::Density(_) | Layer::Level { .. } | Layer::Flag { .. } => {}
    }
}

/// Moves and lines through places; one that is not finite parts the line.
pub(super) fn path(places: impl Iterator<Item = (f64, f64)>) -> String {
    let mut path = String::new();
    let mut is_drawing = false;
    for (x, y) in places {
        if !(x.is_finite() && y.is_finite()) {
            is_drawing = false;
            continue;
        }
        // far outside the frame coordinates would lose their digits
        let (x, y) = (x.clamp(-1e5, 1e5), y.clamp(-1e5, 1e5));
        let _ = write!(path, "{}{x:.2} {y:.2}", if is_drawing { 'L' } else { 'M' });
        is_drawing = true;
    }
    path
}

/// As many ticks as their labels leave room for.
fn x_ticks(scale: &Scale, length: f64) -> Vec<Tick> {
    if scale.is_blank {
        return Vec::new();
    }
    let fits = |ticks: &[Tick]| {
        let widest = widest(ticks.iter().map(|tick| tick.label.as_str()), TICK_SIZE);
        ticks.len() as f64 * (widest + 22.0) <= length + widest
    };
    if !scale.listed.is_empty() {
        return thinned(scale.listed.clone(), fits);
    }
    if scale.is_logarithmic {
        return thinned(decades(scale.low, scale.high), fits);
    }
    (2..=(length / 60.0) as usize)
        .rev()
        .map(|most| ticks(scale.low, scale.high, most))
        .find(|ticks| fits(ticks))
        .unwrap_or_else(|| ticks(scale.low, scale.high, 2))
}

/// Ticks at a comfortable distance, or closer where a low frame would have fewer than three.
fn y_ticks(scale: &Scale, length: f64) -> Vec<Tick> {
    if scale.is_blank {
        return Vec::new();
    }
    if scale.is_logarithmic {
        return decades(scale.low, scale.high);
    }
    let comfortable = ((length / 48.0) as usize).max(2);
    let closest = ((length / (1.5 * TICK_SIZE)) as usize).max(comfortable);
    (comfortable..=closest)
        .map(|most| ticks(scale.low, scale.high, most))
        .min_by_key(|ticks| 3usize.saturating_sub(ticks.len()))
        .unwrap_or_default()
}
