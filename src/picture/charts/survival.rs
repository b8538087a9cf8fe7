//! The panel of a decay: over time, the part of the states that have not settled.
//!
//! Owns what is drawn of it; estimates nothing.

use super::shared::{BAND, FAINT, colour_of};
use crate::analysis::lifetime::{Decay, Survival};
use crate::picture::axis_scale::AxisScale;
use crate::picture::layer::{Layer, Stroke};
use crate::picture::panel::Panel;

/// Least extent of the axis of states, in decades.
const LEAST_DECADES: f64 = 0.5;

/// Number of steps in the fit's curve and band.
const SAMPLES: u32 = 200;

/// The fraction of the states that is left, on a logarithmic scale, with the exponential fit and its band.
pub fn survival(survival: &Survival, decay: &Decay) -> Panel {
    let states = survival.states() as f64;
    let least = survival
        .steps()
        .iter()
        .map(|&(_, left)| left)
        .filter(|&left| left > 0)
        .min();
    // down to the least number that is left, and far enough for ticks
    let decades = (states / least.unwrap_or(1) as f64).log10().max(LEAST_DECADES);
    let low = -1.05 * decades;
    // a curve that falls to zero leaves the frame
    let log = |left: f64| (left / states).log10().max(low - 1.0);
    // there is nothing to see after the last state has settled
    let end = f64::from(match survival.lasting {
        0 => survival.settled_by(1.0).unwrap_or(survival.longest).max(1),
        _ => survival.longest,
    });
    let mut curve = vec![[0.0, 0.0]];
    for (time, left) in survival.steps() {
        let [_, before] = curve[curve.len() - 1];
        curve.push([f64::from(time), before]);
        curve.push([f64::from(time), log(left as f64)]);
    }
    let mut layers = vec![Layer::Curve {
        name: "states that have not settled".to_owned(),
        points: curve,
        stroke: Stroke::solid(colour_of(0), 2.0),
    }];
    if let Decay::Exponential(fit) = decay {
        let (from, digits) = (f64::from(fit.start), fit.decimals());
        let times = (0..=SAMPLES).map(|k| from + (end - from) * f64::from(k) / f64::from(SAMPLES));
        let fitted = |time: f64, errors: f64| log(fit.left_after(time, errors));
        let band = times
            .clone()
            .map(|time| [time, fitted(time, -BAND), fitted(time, BAND)]);
        layers.insert(
            0,
            Layer::Band {
                name: "± 2 standard errors of the lifetime".to_owned(),
                points: band.collect(),
                colour: colour_of(4),
            },
        );
        layers.push(Layer::Curve {
            name: format!(
                "exponential fit, mean lifetime {:.digits$} ± {:.digits$}",
                fit.lifetime, fit.error
            ),
            points: times.map(|time| [time, fitted(time, 0.0)]).collect(),
            stroke: Stroke::dashed(colour_of(4), 1.6),
        });
    }
    let flag = match decay {
        Decay::Exponential(fit) => Some((fit.start, "fitted from here on")),
        Decay::Lasting { start, .. } => Some((*start, "from here on no state settles")),
        Decay::Other => None,
    };
    if let Some((start, words)) = flag {
        layers.push(Layer::Flag {
            x: start.into(),
            words: words.to_owned(),
            stroke: Stroke::solid(FAINT, 1.0),
        });
    }
    Panel {
        title: String::new(),
        x: AxisScale::new("time in forcing periods", 0.0, end),
        y: AxisScale::logarithmic("fraction of the initial states", low, 0.05 * decades),
        layers,
        nothing: "no state was followed".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::sheet::Sheet;

    fn svg(of: &Survival) -> String {
        Sheet::single(survival(of, &of.decay()), Vec::new()).draw().unwrap().svg
    }

    #[test]
    fn the_fit_is_drawn_where_there_is_one() {
        let quantile = |k: u32| (-200.0 * (1.0 - (f64::from(k) + 0.5) / 1000.0).ln()).ceil() as u32;
        let decaying = Survival::new((0..1000).map(quantile).collect(), 0, 4000);
        let drawn = svg(&decaying);
        assert!(drawn.contains("exponential fit, mean lifetime ") && drawn.contains(">0.001<"));
        // until the last state has settled
        let panel = survival(&decaying, &decaying.decay());
        assert_eq!(panel.x.high, f64::from(quantile(999)));
        let lasting = svg(&Survival::new(Vec::new(), 500, 4000));
        assert!(!lasting.contains("exponential fit") && lasting.contains("no state settles"));
        // no state has settled: the axis does not go down to a single state
        assert!(lasting.contains(">0.5<") && !lasting.contains(">0.1<"));
    }
}
