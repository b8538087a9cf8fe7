//! The colour bar beside a map.
//!
//! Owns its ticks and drawing; others choose its limits and colours.

use std::fmt::Write as _;

use super::layout::Layout;
use crate::machine::units::rounded;
use crate::picture::colour::Rgb;
use crate::picture::svg::{hex, line, upright, words};
use crate::picture::text::{widest, wrap};
use crate::picture::ticks::{Tick, number, ticks};

/// A colour bar from `low` to `high`.
pub struct Bar {
    pub label: String,
    pub low: f64,
    pub high: f64,
    /// Whether there are values below `low`, and above `high`.
    pub below: bool,
    pub above: bool,
    pub colour: Box<dyn Fn(f64) -> Rgb>,
}

impl Bar {
    /// Draws the colour bar to the right of the map. Returns the x of its right end, with numbers and words.
    pub fn draw(&self, svg: &mut String, layout: &Layout) -> f64 {
        const STOPS: u32 = 64;
        let (unit, size) = (layout.unit, layout.tick_size());
        let right = layout.left + layout.width;
        let (left, bar_width) = (right + 24.0 * unit, 22.0 * unit);
        let (top, bottom) = (layout.top, layout.top + layout.height);
        let _ = write!(svg, "<linearGradient id=\"scale\" x1=\"0\" y1=\"1\" x2=\"0\" y2=\"0\">");
        for stop in 0..=STOPS {
            let t = f64::from(stop) / f64::from(STOPS);
            let colour = hex((self.colour)(self.low + (self.high - self.low) * t));
            let _ = write!(svg, "<stop offset=\"{t}\" stop-color=\"{colour}\"/>");
        }
        let _ = writeln!(
            svg,
            "</linearGradient>\n<rect x=\"{left}\" y=\"{top}\" width=\"{bar_width}\" height=\"{}\" \
             fill=\"url(#scale)\" stroke=\"#000000\" stroke-width=\"{unit}\"/>",
            layout.height
        );
        // A triangular tip shows that values lie beyond the limit.
        let tips = [
            (self.above, self.high, top, -12.0),
            (self.below, self.low, bottom, 12.0),
        ];
        for (_, value, y, rise) in tips.into_iter().filter(|(shown, ..)| *shown) {
            let _ = writeln!(
                svg,
                "<path d=\"M{left} {y}L{} {}L{} {y}Z\" fill=\"{}\" stroke=\"#000000\" stroke-width=\"{unit}\" \
                 stroke-linejoin=\"round\"/>",
                left + 0.5 * bar_width,
                y + rise * unit,
                left + bar_width,
                hex((self.colour)(value))
            );
        }
        let scale = self.ticks(layout);
        for (tick, y) in &scale {
            line(svg, [left + bar_width, *y, left + bar_width + 6.0 * unit, *y], unit);
            words(
                svg,
                &tick.label,
                left + bar_width + 10.0 * unit,
                y + 0.36 * size,
                size,
                "start",
            );
        }
        let tick_width = widest(scale.iter().map(|(tick, _)| tick.label.as_str()), size);
        let mut x = left + bar_width + 10.0 * unit + tick_width;
        for text in wrap(&self.label, layout.label_size(), layout.height) {
            x += 1.4 * layout.label_size();
            upright(svg, &text, x, 0.5 * (top + bottom), layout.label_size());
        }
        x + 0.3 * layout.label_size()
    }

    /// Ticks of the bar with their y. Both limits have one, with a sign of inequality if values lie beyond.
    fn ticks(&self, layout: &Layout) -> Vec<(Tick, f64)> {
        let place = |value: f64| layout.top + layout.height * (self.high - value) / (self.high - self.low);
        let most = (layout.height / (60.0 * layout.unit)) as usize;
        let inner = ticks(self.low, self.high, most);
        let limit = |value: f64, sign: &str, beyond: bool| {
            let near = inner
                .iter()
                .find(|tick| (tick.value - value).abs() < 1e-6 * (self.high - self.low));
            let label = near.map_or_else(|| number(rounded(value)), |tick| tick.label.clone());
            let label = if beyond { format!("{sign}\u{a0}{label}") } else { label };
            (Tick { value, label }, place(value))
        };
        let (low, high) = (limit(self.low, "≤", self.below), limit(self.high, "≥", self.above));
        let clear = |y: f64| {
            [low.1, high.1]
                .iter()
                .all(|end| (y - end).abs() > 1.4 * layout.tick_size())
        };
        let inner = inner
            .iter()
            .map(|tick| (tick.clone(), place(tick.value)))
            .filter(|(_, y)| clear(*y));
        let mut scale: Vec<(Tick, f64)> = inner.collect();
        scale.extend([low, high]);
        scale
    }
}
