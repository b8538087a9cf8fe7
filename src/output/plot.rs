//! The plot of a map: places raster, axes, colour bar, legend and caption on a page.
//!
//! Owns positions and sizes; does not choose colours, limits or words.

use std::fmt::Write as _;

use super::caption::AxisLabel;
use super::colour::Rgb;
use super::colour_bar::Bar;
use super::figure::{Figure, FigureError};
use super::raster;
use super::svg::{hatch, hex, line, upright, words};
use super::text::{self, widest, width, wrap};
use super::ticks::{self, Tick, ticks};
use crate::design::{Axis, Spacing};
use crate::map::{Change, ParameterMap};

/// What a point of the map shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cell {
    NotComputed,
    /// A value on the colour bar.
    Value(f64),
    /// An index into the plot's kinds.
    Kind(usize),
}

/// A colour with a name.
#[derive(Clone, Debug)]
pub struct Kind {
    pub colour: Rgb,
    pub name: String,
}

impl Kind {
    pub fn new(colour: Rgb, name: &str) -> Self {
        Self {
            colour,
            name: name.to_owned(),
        }
    }
}

/// The content of a plot.
pub struct Plot {
    pub x: Axis,
    pub y: Axis,
    /// Of x and y.
    pub labels: [AxisLabel; 2],
    /// In the order of the map.
    pub cells: Vec<Cell>,
    pub kinds: Vec<Kind>,
    /// Stands before the legend.
    pub heading: String,
    pub bar: Option<Bar>,
    /// The border of chaos, as it is to be drawn.
    pub border: Vec<Change>,
    pub overlay: Option<Overlay>,
}

/// A curve from theory over a map, dashed.
#[derive(Clone, Debug)]
pub struct Overlay {
    /// For the legend.
    pub name: String,
    /// (x, y) in the axes' parameters; NaN parts its pieces.
    pub points: Vec<[f64; 2]>,
}

/// The most points along an axis, and pixels of the map: a picture of 128 million pixels takes half a gigabyte to draw.
const MAX_POINTS: usize = 16_384;
const MAX_PIXELS: u64 = 128_000_000;

/// Width of the border of chaos, in pixels.
const BORDER: f64 = 1.8;

/// Pixels that a point takes along either axis, so that the map is about `size` large; at least 1.
pub fn cell_size(columns: usize, rows: usize, size: [u32; 2]) -> Result<[u32; 2], FigureError> {
    let cell = |count: usize, size: u32| ((f64::from(size) / count as f64).round() as u32).max(1);
    let [across, up] = [cell(columns, size[0]), cell(rows, size[1])];
    let pixels = columns as u64 * u64::from(across) * rows as u64 * u64::from(up);
    if columns.max(rows) > MAX_POINTS || pixels > MAX_PIXELS {
        return Err(FigureError::TooLarge {
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
    /// Everything is enlarged by this in large pictures, so that they can be read when scaled down.
    pub unit: f64,
}

impl Layout {
    pub fn tick_size(&self) -> f64 {
        15.0 * self.unit
    }
    pub fn label_size(&self) -> f64 {
        17.0 * self.unit
    }
    fn caption_size(&self) -> f64 {
        14.0 * self.unit
    }
    fn margin(&self) -> f64 {
        16.0 * self.unit
    }
}

impl Plot {
    /// An empty plot with the axes of a map.
    pub fn of(map: &ParameterMap) -> Self {
        Self {
            x: map.x_axis().clone(),
            y: map.y_axis().clone(),
            labels: [map.x_axis(), map.y_axis()].map(|axis| AxisLabel::of(axis, &map.experiment.design.fixed)),
            cells: Vec::new(),
            kinds: Vec::new(),
            heading: String::new(),
            bar: None,
            border: Vec::new(),
            overlay: None,
        }
    }

    /// Draws the plot above the paragraphs of its caption.
    pub fn draw(&self, size: [u32; 2], caption: &[String]) -> Result<Figure, FigureError> {
        let cell = cell_size(self.x.count(), self.y.count(), size)?.map(f64::from);
        let (plot_width, plot_height) = (cell[0] * self.x.count() as f64, cell[1] * self.y.count() as f64);
        let unit = (plot_width / 960.0).min(plot_height / 640.0).clamp(1.0, 8.0);
        let mut layout = Layout {
            cell,
            left: 0.0,
            top: 0.0,
            width: plot_width,
            height: plot_height,
            unit,
        };

        let [x_label, y_label] = &self.labels;
        let x_room = |widest: f64| (widest + 20.0 * unit).max(95.0 * unit);
        let x_ticks = axis_ticks(&self.x, x_label, plot_width, x_room, layout.tick_size());
        let y_ticks = axis_ticks(&self.y, y_label, plot_height, |_| 60.0 * unit, layout.tick_size());
        let y_label = wrap(&y_label.words, layout.label_size(), plot_height);
        let y_tick_width = widest(y_ticks.iter().map(|tick| tick.label.as_str()), layout.tick_size());
        let label_line = 1.35 * layout.label_size();
        layout.left = (layout.margin() + y_label.len() as f64 * label_line + y_tick_width + 14.0 * unit).ceil();
        layout.top = (layout.margin() + 12.0 * unit).ceil();

        let mut svg = String::new();
        self.draw_map(&mut svg, &layout)?;
        let bottom = self.draw_axes(&mut svg, &layout, &x_ticks, &y_ticks, &y_label);
        let right = match &self.bar {
            Some(bar) => bar.draw(&mut svg, &layout),
            None => layout.left + layout.width + 24.0 * unit,
        };
        let page_width = (right + layout.margin()).ceil();
        let mut y = self.draw_legend(&mut svg, &layout, bottom, page_width);
        y += 8.0 * unit;
        for paragraph in caption {
            for line in wrap(paragraph, layout.caption_size(), page_width - 2.0 * layout.margin()) {
                y += 1.4 * layout.caption_size();
                words(&mut svg, &line, layout.margin(), y, layout.caption_size(), "start");
            }
        }
        let (page_width, page_height) = (page_width as u32, (y + layout.margin()).ceil() as u32);
        let background = format!("<rect width=\"{page_width}\" height=\"{page_height}\" fill=\"#ffffff\"/>\n");
        let svg = text::document(page_width, page_height, &(background + &svg));
        Ok(Figure {
            svg,
            width: page_width,
            height: page_height,
        })
    }

    fn draw_map(&self, svg: &mut String, layout: &Layout) -> Result<(), FigureError> {
        let Layout {
            left,
            top,
            width,
            height,
            unit,
            ..
        } = *layout;
        let place = format!("x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"");
        if self.cells.contains(&Cell::NotComputed) {
            hatch(svg, unit);
            let _ = writeln!(svg, "<rect {place} fill=\"url(#hatch)\"/>");
        }
        let data = raster::encode(self)?;
        let _ = writeln!(
            svg,
            "<image {place} preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" href=\"{data}\"/>"
        );
        let path = self.border_path(layout);
        if !path.is_empty() {
            for (colour, stroke) in [("#ffffff", 4.0 * unit), ("#000000", BORDER * unit)] {
                let _ = writeln!(
                    svg,
                    "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{stroke}\" \
                     stroke-linecap=\"round\"/>"
                );
            }
        }
        self.draw_overlay(svg, layout);
        let _ = writeln!(
            svg,
            "<rect {place} fill=\"none\" stroke=\"#000000\" stroke-width=\"{unit}\"/>"
        );
        Ok(())
    }

    fn draw_overlay(&self, svg: &mut String, layout: &Layout) {
        let Some(overlay) = &self.overlay else { return };
        let Layout {
            left,
            top,
            width,
            height,
            unit,
            ..
        } = *layout;
        let places: Vec<[f64; 2]> = overlay
            .points
            .iter()
            .map(|&[x, y]| [self.x_pixel(x, layout), self.y_pixel(y, layout)])
            .collect();
        let pieces = places.split(|place| place.iter().any(|pixel| !pixel.is_finite()));
        let path: String = pieces
            .map(|piece| super::panel::path(to_the_frame(piece, layout).map(|[x, y]| (x, y))))
            .collect();
        let _ = writeln!(
            svg,
            "<clipPath id=\"map\"><rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"/></clipPath>"
        );
        for (colour, stroke, dash) in [
            ("#ffffff", 5.0 * unit, String::new()),
            ("#000000", 2.4 * unit, dashes(unit)),
        ] {
            let _ = writeln!(
                svg,
                "<path d=\"{path}\" clip-path=\"url(#map)\" fill=\"none\" stroke=\"{colour}\" \
                 stroke-width=\"{stroke}\" stroke-linejoin=\"round\"{dash}/>"
            );
        }
    }

    /// A stroke as long as a point's side across each change; between neighbours they meet at the points' corners.
    fn border_path(&self, layout: &Layout) -> String {
        let mut path = String::new();
        for change in &self.border {
            let [x, y] = change.place;
            let (x, y) = (self.x_pixel(x, layout), self.y_pixel(y, layout));
            let half = 0.5 * layout.cell[1 - change.along];
            let _ = match change.along {
                0 => write!(path, "M{x:.2} {:.2}V{:.2}", y - half, y + half),
                _ => write!(path, "M{:.2} {y:.2}H{:.2}", x - half, x + half),
            };
        }
        path
    }

    /// Values rise to the right, whichever way the axis runs.
    fn x_pixel(&self, value: f64, layout: &Layout) -> f64 {
        layout.left + (self.x.place(value) + 0.5) * layout.cell[0]
    }

    fn y_pixel(&self, value: f64, layout: &Layout) -> f64 {
        layout.top + layout.height - (self.y.place(value) + 0.5) * layout.cell[1]
    }

    /// Draws ticks and labels; the y of the lowest.
    fn draw_axes(
        &self,
        svg: &mut String,
        layout: &Layout,
        x_ticks: &[Tick],
        y_ticks: &[Tick],
        y_label: &[String],
    ) -> f64 {
        let (unit, size) = (layout.unit, layout.tick_size());
        let bottom = layout.top + layout.height;
        for tick in x_ticks {
            let x = self.x_pixel(tick.value, layout);
            line(svg, [x, bottom, x, bottom + 6.0 * unit], unit);
            words(svg, &tick.label, x, bottom + 9.0 * unit + size, size, "middle");
        }
        for tick in y_ticks {
            let y = self.y_pixel(tick.value, layout);
            line(svg, [layout.left - 6.0 * unit, y, layout.left, y], unit);
            words(
                svg,
                &tick.label,
                layout.left - 10.0 * unit,
                y + 0.36 * size,
                size,
                "end",
            );
        }
        let label_line = 1.35 * layout.label_size();
        for (index, text) in y_label.iter().enumerate() {
            let x = layout.margin() + layout.label_size() + index as f64 * label_line;
            upright(svg, text, x, layout.top + 0.5 * layout.height, layout.label_size());
        }
        let mut y = bottom + 9.0 * unit + size;
        for text in wrap(&self.labels[0].words, layout.label_size(), layout.width) {
            y += label_line;
            words(
                svg,
                &text,
                layout.left + 0.5 * layout.width,
                y,
                layout.label_size(),
                "middle",
            );
        }
        y
    }

    /// Draws swatches of the kinds that occur, in rows; the y of the lowest row.
    fn draw_legend(&self, svg: &mut String, layout: &Layout, above: f64, page_width: f64) -> f64 {
        let (unit, size) = (layout.unit, layout.tick_size());
        let mut entries: Vec<(String, &str)> = Vec::new();
        if !self.heading.is_empty() {
            entries.push((String::new(), &self.heading));
        }
        for (index, kind) in self.kinds.iter().enumerate() {
            if self.cells.contains(&Cell::Kind(index)) {
                entries.push((hex(kind.colour), &kind.name));
            }
        }
        if self.cells.contains(&Cell::NotComputed) {
            entries.push(("url(#hatch)".to_owned(), "not computed"));
        }
        if !self.border.is_empty() {
            entries.push(("line".to_owned(), "border of chaos"));
        }
        if let Some(overlay) = &self.overlay {
            entries.push(("dashes".to_owned(), &overlay.name));
        }
        if entries.is_empty() {
            return above;
        }
        let (row, swatch) = (1.7 * size, 22.0 * unit);
        let (mut x, mut y) = (layout.margin(), above + 1.3 * row);
        for (fill, name) in entries {
            let mark = if fill.is_empty() { 0.0 } else { swatch + 7.0 * unit };
            let entry = mark + width(name, size);
            if x > layout.margin() && x + entry > page_width - layout.margin() {
                (x, y) = (layout.margin(), y + row);
            }
            let middle = y - 0.36 * size;
            match fill.as_str() {
                "" => {}
                "line" => line(svg, [x, middle, x + swatch, middle], BORDER * unit),
                "dashes" => {
                    let _ = writeln!(
                        svg,
                        "<path d=\"M{x:.1} {middle:.1}L{:.1} {middle:.1}\" stroke=\"#000000\" \
                         stroke-width=\"{}\"{}/>",
                        x + swatch,
                        2.4 * unit,
                        dashes(unit)
                    );
                }
                fill => {
                    let _ = writeln!(
                        svg,
                        "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"{swatch}\" height=\"{}\" fill=\"{fill}\" \
                         stroke=\"#000000\" stroke-width=\"{}\"/>",
                        middle - 7.0 * unit,
                        14.0 * unit,
                        0.7 * unit
                    );
                }
            }
            words(svg, name, x + mark, y, size, "start");
            x += entry + 22.0 * unit;
        }
        y
    }
}

/// A piece of a curve in pixels. Where it ends with the axes, at the middle of an outermost point, it goes on straight for a
/// point's size, which takes it to the frame.
fn to_the_frame(piece: &[[f64; 2]], layout: &Layout) -> impl Iterator<Item = [f64; 2]> {
    let (corner, size) = ([layout.left, layout.top], [layout.width, layout.height]);
    let ends_with_the_axes = |place: [f64; 2]| {
        (0..2).any(|axis| {
            let (from_low, half) = (place[axis] - corner[axis], 0.5 * layout.cell[axis]);
            from_low < half + 0.5 || from_low > size[axis] - half - 0.5
        })
    };
    let beyond = |before: Option<&[f64; 2]>, end: Option<&[f64; 2]>| {
        let (before, end) = (before?, end?);
        let step = [end[0] - before[0], end[1] - before[1]];
        let part = layout.cell[0].hypot(layout.cell[1]) / step[0].hypot(step[1]);
        (ends_with_the_axes(*end) && part.is_finite()).then(|| [end[0] + part * step[0], end[1] + part * step[1]])
    };
    let first = beyond(piece.get(1), piece.first());
    let last = beyond(piece.iter().rev().nth(1), piece.last());
    first.into_iter().chain(piece.iter().copied()).chain(last)
}

fn dashes(unit: f64) -> String {
    format!(" stroke-dasharray=\"{} {}\"", 9.0 * unit, 4.0 * unit)
}

/// Ticks of any axis of a map, by their values.
fn axis_ticks(axis: &Axis, label: &AxisLabel, length: f64, room: impl Fn(f64) -> f64, size: f64) -> Vec<Tick> {
    let fits = |ticks: &[Tick]| {
        let widest = widest(ticks.iter().map(|tick| tick.label.as_str()), size);
        ticks.len() as f64 * room(widest) <= length + room(widest)
    };
    match axis.spacing() {
        Spacing::Even { .. } => even_ticks(axis, label.factor, length, room, size),
        Spacing::Logarithmic { .. } => {
            let [low, high] = axis.ends().map(|end| (label.factor * end).log10());
            let ticks = ticks::thinned(ticks::decades(low, high), fits);
            let values = ticks.into_iter().map(|tick| Tick {
                value: 10f64.powf(tick.value) / label.factor,
                ..tick
            });
            values.collect()
        }
        Spacing::Listed(_) => {
            let rising = axis.rising();
            let ticks = ticks::thinned(label.listed(axis), fits);
            let values = ticks.into_iter().map(|tick| Tick {
                value: axis.value(rising[tick.value as usize]),
                ..tick
            });
            values.collect()
        }
    }
}

/// Ticks within the values of the axis, not within the half cells beyond: there the map says nothing. They are round numbers
/// once multiplied with `factor`. `room` is the least distance between ticks, given the width of the widest label; `length`
/// is that of the whole map.
fn even_ticks(axis: &Axis, factor: f64, length: f64, room: impl Fn(f64) -> f64, size: f64) -> Vec<Tick> {
    let [start, stop] = [axis.first(), axis.last()].map(|end| factor * end);
    let (low, high) = (start.min(stop), start.max(stop));
    let length = length * (axis.count() - 1) as f64 / axis.count() as f64;
    let most = (length / room(0.0)) as usize;
    let fits = |ticks: &Vec<Tick>| {
        let widest = widest(ticks.iter().map(|tick| tick.label.as_str()), size);
        ticks.len() as f64 * room(widest) <= length + room(widest)
    };
    let mut ticks = (1..=most)
        .rev()
        .map(|most| ticks(low, high, most))
        .find(fits)
        .unwrap_or_else(|| ticks(low, high, 1));
    for tick in &mut ticks {
        tick.value /= factor;
    }
    ticks
}
