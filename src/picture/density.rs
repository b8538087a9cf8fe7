//! Densities of points: hits per pixel, on a logarithmic scale of colours.
//!
//! Owns counting, colours and the bar that explains them; places nothing.

use std::fmt::Write as _;

use image::{Rgba, RgbaImage};

use super::colour::{ColourScale, Rgb};
use super::error::PictureError;
use super::raster;
use super::svg::{hex, line, upright, words};
use super::text::width;

/// Start of the used part of the sequential scale: a single hit must be visible on white.
const PALEST: f64 = 0.22;

/// Hits in a raster of cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Density {
    columns: usize,
    rows: usize,
    /// The lowest row first.
    hits: Vec<u32>,
    /// Points outside the raster.
    outside: usize,
}

impl Density {
    /// Counts points (x, y) in `columns` by `rows` cells between the limits, which belong to the raster.
    pub fn new(points: impl Iterator<Item = [f64; 2]>, x: [f64; 2], y: [f64; 2], [columns, rows]: [usize; 2]) -> Self {
        let mut density = Self {
            columns,
            rows,
            hits: vec![0; columns * rows],
            outside: 0,
        };
        let cell = |value: f64, [low, high]: [f64; 2], count: usize| {
            (low..=high)
                .contains(&value)
                .then(|| (((value - low) / (high - low) * count as f64) as usize).min(count - 1))
        };
        for [px, py] in points {
            match (cell(px, x, columns), cell(py, y, rows)) {
                (Some(column), Some(row)) => density.hits[row * columns + column] += 1,
                _ => density.outside += 1,
            }
        }
        density
    }

    /// Points outside the raster.
    pub fn outside(&self) -> usize {
        self.outside
    }

    /// Cells that were hit.
    pub fn occupied(&self) -> usize {
        self.hits.iter().filter(|&&hits| hits > 0).count()
    }

    /// Hits of the cell that has the most; 0 if none was hit.
    pub fn most(&self) -> u32 {
        self.hits.iter().copied().max().unwrap_or(0)
    }

    /// The colour of a number of hits: lightness falls with its logarithm.
    fn colour(&self, hits: f64) -> Rgb {
        let most = f64::from(self.most().max(10));
        ColourScale::BlueRed.sequential(PALEST + (1.0 - PALEST) * hits.ln() / most.ln())
    }

    /// The raster as an SVG image; cells without a hit are transparent.
    pub(super) fn draw(&self, svg: &mut String, place: [f64; 4]) -> Result<(), PictureError> {
        let image = RgbaImage::from_fn(self.columns as u32, self.rows as u32, |column, row| {
            match self.hits[(self.rows - 1 - row as usize) * self.columns + column as usize] {
                0 => Rgba([0, 0, 0, 0]),
                hits => {
                    let [red, green, blue] = self.colour(f64::from(hits));
                    Rgba([red, green, blue, 255])
                }
            }
        });
        raster::draw(svg, &image, place)
    }

    /// Room that the colour bar takes to the right of a panel.
    pub(super) fn bar_room(&self, size: f64) -> f64 {
        20.0 + 16.0 + 10.0 + width(&self.most().max(10).to_string(), size) + 2.2 * size
    }

    /// The colour bar to the right of a panel; `id` distinguishes its gradient from others in the document.
    pub(super) fn draw_bar(&self, svg: &mut String, [left, top, height]: [f64; 3], size: f64, id: usize) {
        const STOPS: u32 = 32;
        let (left, bar_width) = (left + 20.0, 16.0);
        let most = f64::from(self.most().max(10));
        let _ = write!(
            svg,
            "<linearGradient id=\"hits{id}\" x1=\"0\" y1=\"1\" x2=\"0\" y2=\"0\">"
        );
        for stop in 0..=STOPS {
            let t = f64::from(stop) / f64::from(STOPS);
            let colour = hex(self.colour(most.powf(t)));
            let _ = write!(svg, "<stop offset=\"{t}\" stop-color=\"{colour}\"/>");
        }
        let _ = writeln!(
            svg,
            "</linearGradient>\n<rect x=\"{left}\" y=\"{top}\" width=\"{bar_width}\" height=\"{height}\" \
             fill=\"url(#hits{id})\" stroke=\"#000000\" stroke-width=\"1\"/>"
        );
        let place = |hits: f64| top + height * (1.0 - hits.ln() / most.ln());
        let right = left + bar_width;
        let decades = most.log10().floor() as i32;
        let fine = if decades < 2 { vec![1.0, 2.0, 5.0] } else { vec![1.0] };
        for decade in 0..=decades {
            for factor in &fine {
                let hits = factor * 10f64.powi(decade);
                if hits <= most {
                    let y = place(hits);
                    line(svg, [right, y, right + 5.0, y], 1.0);
                    words(svg, &format!("{hits:.0}"), right + 9.0, y + 0.36 * size, size, "start");
                }
            }
        }
        let x = right + 9.0 + width(&format!("{most:.0}"), size) + 1.5 * size;
        upright(svg, "states per pixel", x, top + 0.5 * height, size);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_is_counted_once() {
        let points = [
            [0.0, 0.0],
            [1.0, 1.0],
            [0.26, 0.9],
            [0.26, 0.9],
            [2.0, 0.5],
            [f64::NAN, 0.5],
        ];
        let density = Density::new(points.into_iter(), [0.0, 1.0], [0.0, 1.0], [4, 2]);
        assert_eq!(density.hits, [1, 0, 0, 0, 0, 2, 0, 1]);
        assert_eq!((density.outside(), density.occupied(), density.most()), (2, 3, 2));
    }

    #[test]
    fn more_hits_are_darker_and_one_is_seen() {
        let points = (0..1000).map(|_| [0.5, 0.5]);
        let density = Density::new(points, [0.0, 1.0], [0.0, 1.0], [1, 1]);
        let sum = |hits: f64| density.colour(hits).iter().map(|&value| u32::from(value)).sum::<u32>();
        assert!(sum(1.0) < 640 && sum(10.0) < sum(1.0) && sum(1000.0) < sum(100.0));
    }
}
