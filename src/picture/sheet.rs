//! A sheet: panels beside and below each other above a caption.
//!
//! Owns where panels stand; what they hold is [`super::panel`]'s.

use super::error::PictureError;
use super::page::Page;
use super::panel::{Panel, Room};
use super::svg::paragraphs;

/// Panels in rows of `columns`, their frames all of one size.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// Row by row.
    pub panels: Vec<Panel>,
    /// Panels in a row.
    pub columns: usize,
    /// Width and height of a frame in pixels.
    pub frame: [u32; 2],
    /// Paragraphs below the panels.
    pub caption: Vec<String>,
}

/// The frame of a picture of one panel.
pub const SINGLE: [u32; 2] = [900, 560];
/// The frames of a picture with panels beside each other.
pub const BESIDE: [u32; 2] = [620, 400];
/// The frames of a picture with panels below each other that share an axis.
pub const STACKED: [u32; 2] = [900, 130];

const MARGIN: f64 = 16.0;
const CAPTION_SIZE: f64 = 14.0;

impl Sheet {
    /// One panel alone.
    pub fn single(panel: Panel, caption: Vec<String>) -> Self {
        Self {
            panels: vec![panel],
            columns: 1,
            frame: SINGLE,
            caption,
        }
    }

    /// Panels below each other.
    pub fn stacked(panels: Vec<Panel>, caption: Vec<String>) -> Self {
        Self {
            panels,
            columns: 1,
            frame: STACKED,
            caption,
        }
    }

    /// # Errors
    /// [`PictureError::Drawing`] if a density cannot be encoded.
    ///
    /// # Panics
    /// If there is no panel, or no column.
    pub fn draw(&self) -> Result<Page, PictureError> {
        let frame = self.frame.map(f64::from);
        let rooms: Vec<Room> = self.panels.iter().map(|panel| panel.room(frame)).collect();
        let columns = self.columns.min(self.panels.len());
        let widest = |side: fn(&Room) -> f64, column: usize| {
            let of_column = rooms.iter().skip(column).step_by(columns);
            of_column.map(side).fold(0.0, f64::max).ceil()
        };
        // the frames of a column are aligned, so that equal axes can be compared
        let mut lefts = Vec::new();
        let mut right = MARGIN;
        for column in 0..columns {
            let numbers = widest(|room| room.numbers, column);
            let left = right + widest(|room| room.label, column) + numbers;
            lefts.push((left, numbers));
            right = left + frame[0] + widest(|room| room.right, column);
        }
        let page_width = right + MARGIN;

        let mut svg = String::new();
        let mut y = MARGIN;
        let mut id = 0;
        for (panels, rooms) in self.panels.chunks(columns).zip(rooms.chunks(columns)) {
            let top = y + rooms.iter().map(|room| room.top).fold(0.0, f64::max).ceil();
            for (panel, &(left, numbers)) in panels.iter().zip(&lefts) {
                panel.draw(&mut svg, [left, top, frame[0], frame[1]], numbers, id)?;
                id += 1;
            }
            y = top + frame[1] + rooms.iter().map(|room| room.bottom).fold(0.0, f64::max).ceil();
        }
        let line = page_width - 2.0 * MARGIN;
        y = paragraphs(&mut svg, &self.caption, [MARGIN, y], CAPTION_SIZE, line);
        let (page_width, page_height) = (page_width.ceil() as u32, (y + MARGIN).ceil() as u32);
        Ok(Page::new(page_width, page_height, &svg))
    }
}

#[cfg(test)]
mod tests {
    use super::super::axis_scale::AxisScale;
    use super::super::colour;
    use super::super::density::Density;
    use super::super::layer::{Layer, Stroke};
    use super::super::text;
    use super::*;

    fn panel(title: &str) -> Panel {
        let points: Vec<[f64; 2]> = (0..100)
            .map(|k| [f64::from(k) * 0.1, (f64::from(k) * 0.1).sin()])
            .collect();
        Panel {
            title: title.to_owned(),
            x: AxisScale::new("time τ", 0.0, 10.0),
            y: AxisScale::around("angle x", points.iter().map(|point| point[1])),
            layers: vec![
                Layer::Density(Density::new(points.iter().copied(), [0.0, 10.0], [-1.0, 1.0], [62, 40])),
                Layer::Curve {
                    name: "a curve".to_owned(),
                    points,
                    stroke: Stroke::dashed(colour::PERIODS[4], 1.5),
                },
            ],
            nothing: String::new(),
        }
    }

    /// Every element lies on the page, and none on another panel's frame.
    #[test]
    fn nothing_is_clipped_at_the_page_s_edge() {
        let sheet = Sheet {
            panels: vec![panel("(a)"), panel("(b)"), panel("(c)")],
            columns: 2,
            frame: BESIDE,
            caption: vec!["A caption of several words that is long enough to be wrapped. ".repeat(8)],
        };
        let page = sheet.draw().unwrap();
        let tree = resvg::usvg::Tree::from_str(&page.svg, text::options()).unwrap();
        let bounds = tree.root().abs_layer_bounding_box();
        assert!(bounds.left() >= 0.0 && bounds.top() >= 0.0);
        assert!(bounds.right() <= page.width as f32 && bounds.bottom() <= page.height as f32);
        let pixels = page.render().unwrap();
        let inked = |x: u32, y: u32| pixels.pixel(x, y).unwrap().red() < 128;
        let edges = (0..page.height).any(|y| inked(0, y) || inked(page.width - 1, y));
        assert!(!edges && (0..page.width).any(|x| (0..page.height).any(|y| inked(x, y))));
    }

    #[test]
    fn an_empty_frame_says_so_and_has_neither_invented_ticks_nor_a_legend() {
        let nowhere = |y: AxisScale, points: Vec<[f64; 2]>| Panel {
            title: String::new(),
            x: AxisScale::new("time τ", 0.0, 10.0),
            y,
            layers: vec![
                Layer::Level {
                    y: 0.0,
                    stroke: Stroke::solid(colour::PERIODS[0], 1.0),
                },
                Layer::Density(Density::new([].into_iter(), [0.0, 10.0], [-1.0, 1.0], [62, 40])),
                Layer::Curve {
                    name: "a curve".to_owned(),
                    points,
                    stroke: Stroke::solid(colour::PERIODS[4], 1.5),
                },
            ],
            nothing: "every orbit ran away".to_owned(),
        };
        let svg = |panel: Panel| Sheet::single(panel, Vec::new()).draw().unwrap().svg;
        let empty = svg(nowhere(
            AxisScale::around("angle x", [f64::NAN].into_iter()),
            vec![[1.0, f64::NAN]; 3],
        ));
        assert!(empty.contains(">nothing to draw: every orbit ran away<"), "{empty}");
        assert!(!empty.contains("a curve") && !empty.contains("states per pixel"));
        // the ticks of the known axis alone
        assert!(empty.contains(">10<") && !empty.contains(">0.5<") && !empty.contains(">1.0<"));
        let outside = svg(nowhere(
            AxisScale::new("angle x", 5.0, 6.0),
            vec![[1.0, 1.0], [2.0, 4.0]],
        ));
        assert!(
            outside.contains(">nothing to draw: all of it lies outside the frame<") && !outside.contains("a curve")
        );
        // no point within, but the line crosses the frame
        let crossing = svg(nowhere(
            AxisScale::new("angle x", 5.0, 6.0),
            vec![[1.0, 1.0], [2.0, 9.0]],
        ));
        assert!(crossing.contains("a curve") && !crossing.contains("nothing to draw"));
    }
}
