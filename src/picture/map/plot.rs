//! The plot of a map: places points, axes, colour bar, legend and caption on a page.
//!
//! Owns what is drawn where; does not choose colours, limits or words.

use std::fmt::Write as _;

use image::{Rgba, RgbaImage};

use super::axis_ticks::axis_ticks;
use super::bar::Bar;
use super::layout::{Layout, cell_size};
use super::legend::{self, BORDER, OVERLAY, Sign};
use crate::design::Axis;
use crate::map::{Change, ParameterMap};
use crate::picture::axis_label::AxisLabel;
use crate::picture::colour::Rgb;
use crate::picture::error::PictureError;
use crate::picture::page::Page;
use crate::picture::raster;
use crate::picture::svg::{hatch, line, paragraphs, path, upright, words};
use crate::picture::text::{widest, wrap};
use crate::picture::ticks::Tick;

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
    /// (x, y) in the axes' parameters; NaN interrupts the curve.
    pub points: Vec<[f64; 2]>,
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
    pub fn draw(&self, size: [u32; 2], caption: &[String]) -> Result<Page, PictureError> {
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
        let y = legend::draw(&mut svg, &layout, &self.entries(), bottom, page_width);
        let (place, line) = ([layout.margin(), y + 8.0 * unit], page_width - 2.0 * layout.margin());
        let y = paragraphs(&mut svg, caption, place, layout.caption_size(), line);
        let (page_width, page_height) = (page_width as u32, (y + layout.margin()).ceil() as u32);
        Ok(Page::new(page_width, page_height, &svg))
    }

    fn draw_map(&self, svg: &mut String, layout: &Layout) -> Result<(), PictureError> {
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
        raster::draw(svg, &self.image(), [left, top, width, height])?;
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
            .map(|piece| path(to_the_frame(piece, layout).map(|[x, y]| (x, y))))
            .collect();
        let _ = writeln!(
            svg,
            "<clipPath id=\"map\"><rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"/></clipPath>"
        );
        for (colour, stroke, dash) in [
            ("#ffffff", 5.0 * unit, String::new()),
            ("#000000", OVERLAY * unit, legend::dashes(unit)),
        ] {
            let _ = writeln!(
                svg,
                "<path d=\"{path}\" clip-path=\"url(#map)\" fill=\"none\" stroke=\"{colour}\" \
                 stroke-width=\"{stroke}\" stroke-linejoin=\"round\"{dash}/>"
            );
        }
    }

    /// At each change, a stroke across its direction, as long as a point's side. Strokes of neighbours meet at the points' corners.
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

    /// The x of a value. Values rise to the right, even if the axis falls.
    fn x_pixel(&self, value: f64, layout: &Layout) -> f64 {
        layout.left + (self.x.place(value) + 0.5) * layout.cell[0]
    }

    fn y_pixel(&self, value: f64, layout: &Layout) -> f64 {
        layout.top + layout.height - (self.y.place(value) + 0.5) * layout.cell[1]
    }

    /// Draws ticks and labels. Returns the y of the lowest label.
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

    /// The map with a pixel for each point, values rising to the right and upwards; points that are not computed are
    /// transparent.
    fn image(&self) -> RgbaImage {
        let (columns, rows) = (self.x.count(), self.y.count());
        let (across, up) = (self.x.rising(), self.y.rising());
        RgbaImage::from_fn(columns as u32, rows as u32, |x, y| {
            let (column, row) = (across[x as usize], up[rows - 1 - y as usize]);
            let colour = match self.cells[row * columns + column] {
                Cell::NotComputed => return Rgba([0, 0, 0, 0]),
                Cell::Kind(kind) => self.kinds[kind].colour,
                Cell::Value(value) => self.bar.as_ref().map_or([0, 0, 0], |bar| (bar.colour)(value)),
            };
            Rgba([colour[0], colour[1], colour[2], 255])
        })
    }

    /// The entries of the legend, only for what occurs in the map.
    fn entries(&self) -> Vec<(Sign, &str)> {
        let mut entries: Vec<(Sign, &str)> = Vec::new();
        if !self.heading.is_empty() {
            entries.push((Sign::None, &self.heading));
        }
        for (index, kind) in self.kinds.iter().enumerate() {
            if self.cells.contains(&Cell::Kind(index)) {
                entries.push((Sign::Colour(kind.colour), &kind.name));
            }
        }
        if self.cells.contains(&Cell::NotComputed) {
            entries.push((Sign::Hatch, "not computed"));
        }
        if !self.border.is_empty() {
            entries.push((Sign::Line, "border of chaos"));
        }
        if let Some(overlay) = &self.overlay {
            entries.push((Sign::Dashes, &overlay.name));
        }
        entries
    }
}

/// A piece of a curve in pixels. If it ends where the axes end, at the middle of an outermost point, it is extended in a straight
/// line by the diagonal of a point, so that it reaches the frame.
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
