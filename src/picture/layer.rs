//! The layers of a panel: curves, bands, marks, densities and lines, and their signs in a legend.
//!
//! Owns how each is drawn within a given frame; places no frame.

use std::fmt::Write as _;

use image::{Rgba, RgbaImage};

use super::axis_scale::AxisScale;
use super::colour::Rgb;
use super::density::Density;
use super::error::PictureError;
use super::raster;
use super::svg::{hex, path};

/// The width of a layer's sign in a legend, in pixels.
pub(super) const SWATCH: f64 = 30.0;

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Also used in the legend.
    pub colour: Rgb,
    /// In pixels.
    pub width: f64,
    /// Whether the line has gaps; they grow with the width.
    pub is_dashed: bool,
}

impl Stroke {
    /// A line without gaps, `width` pixels wide.
    pub fn solid(colour: Rgb, width: f64) -> Self {
        Self {
            colour,
            width,
            is_dashed: false,
        }
    }

    /// A line with gaps, `width` pixels wide.
    pub fn dashed(colour: Rgb, width: f64) -> Self {
        Self {
            colour,
            width,
            is_dashed: true,
        }
    }

    pub(super) fn attributes(&self) -> String {
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

/// One element within a frame; layers are drawn in their order. A name appears in the legend unless it is empty. Points are
/// [x, y] in values of the axes.
#[derive(Clone, Debug)]
#[allow(missing_docs, reason = "the docs of the type and of its variants explain the fields")]
pub enum Layer {
    /// A line through points; NaN interrupts it.
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
    /// A raster over the whole frame, row by row, the lowest first.
    Cells { columns: usize, colours: Vec<Rgb> },
    /// Hits per pixel over the whole frame.
    Density(Density),
    /// A horizontal line across the frame, at a height.
    Level { y: f64, stroke: Stroke },
    /// A vertical line across the frame, with words above the frame, where they hide nothing.
    Flag { x: f64, words: String, stroke: Stroke },
    /// Only an entry in the legend, for a curve whose place in the legend differs from its place among the layers.
    CurveKey { name: String, stroke: Stroke },
    /// Only an entry in the legend, for marks of several colours.
    MarkKey { name: String, colour: Rgb },
}

impl Layer {
    /// The layer's name in the legend.
    pub(super) fn name(&self) -> &str {
        match self {
            Self::Curve { name, .. }
            | Self::Band { name, .. }
            | Self::Marks { name, .. }
            | Self::CurveKey { name, .. }
            | Self::MarkKey { name, .. } => name,
            Self::Cells { .. } | Self::Density(_) | Self::Level { .. } | Self::Flag { .. } => "",
        }
    }

    /// Whether the layer has finite values, inside or outside the frame.
    pub(super) fn has_values(&self) -> bool {
        match self {
            Self::Curve { points, .. } | Self::Marks { points, .. } => {
                points.iter().any(|point| point.iter().all(|value| value.is_finite()))
            }
            Self::Band { points, .. } => points.iter().any(|point| point.iter().all(|value| value.is_finite())),
            Self::Density(density) => density.most() > 0 || density.outside() > 0,
            Self::Cells { .. } => true,
            Self::Level { .. } | Self::Flag { .. } | Self::CurveKey { .. } | Self::MarkKey { .. } => false,
        }
    }

    /// Whether a part of the layer lies within the frame of two scales. `Level` and `Flag` do not count: they only mark a place.
    pub(super) fn shows(&self, x: &AxisScale, y: &AxisScale) -> bool {
        let is_within = |[px, py]: [f64; 2]| x.meets([px, px]) && y.meets([py, py]);
        match self {
            Self::Curve { points, .. } => {
                points.iter().any(|&point| is_within(point))
                    || points.windows(2).any(|ends| {
                        ends.iter().flatten().all(|value| value.is_finite())
                            && [x, y]
                                .iter()
                                .enumerate()
                                .all(|(axis, scale)| scale.meets([ends[0][axis], ends[1][axis]]))
                    })
            }
            Self::Band { points, .. } => points
                .iter()
                .any(|&[px, low, high]| x.meets([px, px]) && y.meets([low, high])),
            Self::Marks { points, .. } => points.iter().any(|&point| is_within(point)),
            Self::Density(density) => density.most() > 0,
            Self::Cells { .. } => true,
            Self::Level { .. } | Self::Flag { .. } | Self::CurveKey { .. } | Self::MarkKey { .. } => false,
        }
    }

    /// Draws it into the frame at [left, top, width, height], whose axes have the scales `across` and `up`.
    pub(super) fn draw(
        &self,
        svg: &mut String,
        frame: [f64; 4],
        across: &AxisScale,
        up: &AxisScale,
    ) -> Result<(), PictureError> {
        let [left, top, frame_width, frame_height] = frame;
        let place = |[x, y]: [f64; 2]| {
            (
                left + across.part(x) * frame_width,
                top + (1.0 - up.part(y)) * frame_height,
            )
        };
        match self {
            Self::Curve { points, stroke, .. } => {
                let path = path(points.iter().map(|&point| place(point)));
                let _ = writeln!(svg, "<path d=\"{path}\" {}/>", stroke.attributes());
            }
            Self::Band { points, colour, .. } => {
                // each piece between gaps: forward along the upper curve, back along the lower one
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
            Self::Marks {
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
            Self::Cells { columns, colours } => {
                let rows = colours.len() / columns;
                let image = RgbaImage::from_fn(*columns as u32, rows as u32, |column, row| {
                    let [red, green, blue] = colours[(rows - 1 - row as usize) * columns + column as usize];
                    Rgba([red, green, blue, 255])
                });
                raster::draw(svg, &image, frame)?;
            }
            Self::Density(density) => density.draw(svg, frame)?,
            Self::Level { y, stroke } => {
                let (_, y) = place([across.low, *y]);
                let _ = writeln!(
                    svg,
                    "<path d=\"M{left} {y:.2}L{} {y:.2}\" {}/>",
                    left + frame_width,
                    stroke.attributes()
                );
            }
            Self::Flag { x, stroke, .. } => {
                let (x, _) = place([*x, up.low]);
                let _ = writeln!(
                    svg,
                    "<path d=\"M{x:.2} {top}L{x:.2} {}\" {}/>",
                    top + frame_height,
                    stroke.attributes()
                );
            }
            Self::CurveKey { .. } | Self::MarkKey { .. } => {}
        }
        Ok(())
    }

    /// Draws its sign in the legend, from `x` on.
    pub(super) fn draw_swatch(&self, svg: &mut String, x: f64, middle: f64) {
        match self {
            Self::Curve { stroke, .. } | Self::CurveKey { stroke, .. } => {
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
            Self::Band { colour, .. } => {
                let _ = writeln!(
                    svg,
                    "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"{SWATCH}\" height=\"12\" fill=\"{}\" fill-opacity=\"0.3\"/>",
                    middle - 6.0,
                    hex(*colour)
                );
            }
            Self::Marks { colour, .. } | Self::MarkKey { colour, .. } => {
                let _ = writeln!(
                    svg,
                    "<circle cx=\"{:.1}\" cy=\"{middle:.1}\" r=\"3.5\" fill=\"{}\" stroke=\"#808080\" stroke-width=\"0.5\"/>",
                    x + 0.5 * SWATCH,
                    hex(*colour)
                );
            }
            Self::Cells { .. } | Self::Density(_) | Self::Level { .. } | Self::Flag { .. } => {}
        }
    }
}
