//! When an orbit runs away, by the Taylor scheme in f64.
//!
//! Owns the search within a step; the caller knows whether an orbit runs away.

use super::{COEFFICIENTS, Flow, Step, most_passes, step, unit_of_time};
use crate::lanes::LONG_PERIOD_TICKS;
use crate::model::motion::RUNAWAY_BOUND;
use crate::parameters::{Parameter, ParameterSet};

/// Steps are shorter than those for exponents by this factor: an orbit may swing a thousand times before it runs away, and the
/// errors of its energy in all swings add up.
const SHORTER: f64 = 0.4;

/// A fast swing reaches the bound at its greatest speed, and at the end of a step it may be slower again. So a step is checked at
/// this number of points.
const LOOKS: u32 = 8;

/// The time in tau from a state (x, y) until |x| + |y| first reaches [`RUNAWAY_BOUND`]. None if it does not within `periods`
/// forcing periods, or if the scheme gives the orbit up before.
pub fn escape_time(parameters: &ParameterSet, [x, y]: [f64; 2], steps_per_period: u32, periods: u32) -> Option<f64> {
    let unit = unit_of_time(parameters[Parameter::Omega0]);
    let mut flow = Flow::<f64>::of(parameters, steps_per_period);
    flow.free_step *= SHORTER;
    let size = |x: f64, w: f64| x.abs() + (w / unit).abs();
    let (mut x, mut w) = (x, y * unit);
    for period in 0..periods {
        let mut state = flow.start(x, w, LONG_PERIOD_TICKS);
        for _ in 0..most_passes(parameters.forcing_period()) {
            if state.left == 0.0 {
                break;
            }
            let begun = 1.0 - state.left / LONG_PERIOD_TICKS;
            let (taken, end) = step::<f64, COEFFICIENTS, true>(&flow, &state);
            if let Some(outside) = first_outside(&taken, &size) {
                let within = outside * unit / parameters.forcing_period();
                return Some((f64::from(period) + begun + within) * parameters.forcing_period());
            }
            state = end;
        }
        if state.left > 0.0 {
            return None;
        }
        (x, w) = (state.x, state.w);
    }
    None
}

/// Where within the step |x| + |y| first reaches the bound, if it does.
fn first_outside(step: &Step<f64, COEFFICIENTS>, size: &impl Fn(f64, f64) -> f64) -> Option<f64> {
    // written so that NaN has run away
    let is_inside = |s: f64| size(step.series.x_at(s), step.series.w_at(s)) < RUNAWAY_BOUND;
    let look = |n: u32| step.s * f64::from(n) / f64::from(LOOKS);
    let first = (1..=LOOKS).find(|&n| !is_inside(look(n)))?;
    let (mut inside, mut outside) = (look(first - 1), look(first));
    for _ in 0..50 {
        let middle = 0.5 * (inside + outside);
        *(if is_inside(middle) { &mut inside } else { &mut outside }) = middle;
    }
    Some(outside)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_orbit_runs_away_when_its_exponential_says() {
        // x'' = x from x = y = 0.1: both are 0.1 exp(tau), their sum is 0.2 exp(tau)
        let set = ParameterSet::default()
            .with(Parameter::B, 0.0)
            .with(Parameter::Epsilon, 0.0);
        let time = escape_time(&set, [0.1, 0.1], 28, 5).unwrap();
        assert!((time - 5e4_f64.ln()).abs() < 1e-9, "{time}");
        assert_eq!(escape_time(&set, [0.1, 0.1], 28, 3), None);
    }

    #[test]
    fn energy_that_grows_over_a_thousand_swings_is_followed() {
        // x'' = x - x^3 + 0.05 x' from (0.1, 0), by an integrator of order 8 at a tolerance of 1e-13, in steps of 5e-4
        let set = [(Parameter::F0, 0.0), (Parameter::Alpha, 0.0), (Parameter::Beta, 0.0)]
            .into_iter()
            .fold(ParameterSet::default(), |set, (parameter, value)| {
                set.with(parameter, value)
            })
            .with(Parameter::H1, -0.5);
        let time = escape_time(&set, [0.1, 0.0], 28, 100).unwrap();
        assert!((time - 286.072_805).abs() < 1e-3, "{time}");
    }
}
