//! Newton's method on the stroboscopic map, near one orbit.
//!
//! Owns when a cycle is found, and whether the orbit goes there; integrates nothing.

use crate::dynamics::floquet::Linearisation;
use crate::measure::Class;

/// Most turns of a search.
pub const ROUNDS: u32 = 6;

/// Newton's method mostly ends where its next step is shorter than this...
pub const CONVERGED: f64 = 1e-7;

/// ...or where rounding prevents shorter steps: the cycle must be known to this distance. The multipliers then have about the
/// same accuracy.
pub const NEAR: f64 = 1e-5;

/// An orbit that is nearer than this to the cycle is on it, if the cycle is known as well as that.
const ON_CYCLE: f64 = 1e-3;

/// A search fails if a step is longer than this, relative to the one before.
const SLOWEST: f64 = 0.5;

/// A step of Newton's method that is longer than this leads to no cycle near the orbit.
const LONGEST_STEP: f64 = 0.5;

/// Two states of a turn are the same if their distance is at most this many times what is left of the distance from the cycle.
/// Deviations grow along a cycle before they shrink: 37-fold along one of period 14.
const APART: f64 = 256.0;

/// A turn from a state.
pub struct Turn<L> {
    pub state: Vec<f64>,
    pub end: Vec<f64>,
    pub linear: L,
    /// Newton's step from the state towards the cycle.
    step: Vec<f64>,
}

/// What follows from a turn.
pub enum Next {
    /// The next turn begins in this state.
    From(Vec<f64>),
    /// The turn followed the cycle; this state is on it.
    Found(Vec<f64>),
    /// There is no cycle nearby.
    Lost,
}

/// The search for a cycle near an orbit.
pub struct Newton<L> {
    /// The search ends where its next step is shorter than this...
    converged: f64,
    /// ...or where steps no longer become shorter, if the cycle is known to this distance.
    near: f64,
    /// The first and the last state of the orbit's own turn.
    from: Option<[Vec<f64>; 2]>,
    /// The last turn and the one before.
    last: Option<Turn<L>>,
    before: Option<Turn<L>>,
}

impl<L: Linearisation> Newton<L> {
    /// A search that ends with a step shorter than `converged`, or one shorter than `near` if steps no longer become shorter.
    pub fn new(converged: f64, near: f64) -> Self {
        Self {
            converged,
            near,
            from: None,
            last: None,
            before: None,
        }
    }

    /// Whether a turn has ended.
    pub fn has_begun(&self) -> bool {
        self.last.is_some()
    }

    /// Ends a turn, given its first and its last state and its linearisation.
    pub fn end_turn(&mut self, state: Vec<f64>, end: Vec<f64>, linear: L) -> Next {
        let moved: Vec<f64> = end.iter().zip(&state).map(|(end, state)| end - state).collect();
        let Some(step) = linear.newton_step(&moved) else {
            return Next::Lost;
        };
        let next = moved_by(&state, &step);
        let turn = Turn {
            state,
            end,
            linear,
            step,
        };
        let length = length(&turn.step);
        self.from.get_or_insert_with(|| [turn.state.clone(), turn.end.clone()]);
        self.before = self.last.replace(turn);
        let is_slower = self
            .before
            .as_ref()
            .is_some_and(|before| length > SLOWEST * self::length(&before.step));
        let is_found = length < self.converged || (is_slower && length < self.near);
        if is_found && self.before.is_some() {
            Next::Found(next)
        } else if length < LONGEST_STEP && !is_slower {
            // written so that NaN ends the search
            Next::From(next)
        } else {
            Next::Lost
        }
    }

    /// The last turn and the one before; None before there were two.
    pub fn last_two(&self) -> Option<[&Turn<L>; 2]> {
        Some([self.before.as_ref()?, self.last.as_ref()?])
    }

    /// By how much the last step was shorter than the one before. Results change in proportion to the distance from the cycle.
    pub fn closer(&self) -> f64 {
        let Some([before, last]) = self.last_two() else {
            return 1.0;
        };
        let closer = (length(&last.step) / length(&before.step)).min(1.0);
        if closer.is_nan() { 0.0 } else { closer }
    }

    /// How far the orbit itself moves in a turn.
    pub fn moved(&self) -> f64 {
        self.from.as_ref().map_or(f64::NAN, |[state, end]| distance(state, end))
    }

    /// The class of the orbit, given the maximal exponent of the cycle that was found, and its error. None if it is not certain
    /// that the cycle attracts and that the orbit goes there.
    pub fn class(&self, exponent: f64, error: f64) -> Option<Class> {
        if exponent + 3.0 * error < 0.0 && self.is_reached() {
            Some(Class::Regular)
        } else if exponent - 3.0 * error > 0.0 && self.moved() == 0.0 {
            // an orbit that returns to exactly the same numbers never leaves
            Some(Class::Unstable)
        } else {
            None
        }
    }

    /// Whether the orbit goes to the cycle that was found.
    fn is_reached(&self) -> bool {
        let (Some([state, end]), Some(last)) = (&self.from, &self.last) else {
            return false;
        };
        let cycle = moved_by(&last.state, &last.step);
        let off =
            |state: &[f64]| -> Vec<f64> { state.iter().zip(&cycle).map(|(state, cycle)| state - cycle).collect() };
        let (off, then) = (off(state), off(end));
        length(&off) < self.near.min(ON_CYCLE) || last.linear.attracts(&off, &then)
    }
}

/// The least divisor of the number of periods in a turn after which its states repeat, given the first state of each period and the
/// last state. The distance between the first and the last is `moved`, and the leading multiplier has the given distance from 1.
/// States that are nearer than `same` are the same in any case.
pub fn least_period(states: &[impl AsRef<[f64]>], moved: f64, distance_from_one: f64, same: f64) -> u32 {
    let reach = APART * moved / distance_from_one + same;
    let turn = states.len() - 1;
    let is_same = |n: usize, m: usize| distance(states[n].as_ref(), states[m].as_ref()) <= reach;
    let repeats = |d: usize| (d..=turn).all(|n| is_same(n, n - d));
    let least = (1..turn).find(|&d| turn.is_multiple_of(d) && repeats(d));
    least.unwrap_or(turn) as u32
}

/// The distance between two states.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |sum: f64, (a, b)| sum.hypot(a - b))
}

fn length(vector: &[f64]) -> f64 {
    vector.iter().fold(0.0, |sum: f64, value| sum.hypot(*value))
}

fn moved_by(state: &[f64], step: &[f64]) -> Vec<f64> {
    state.iter().zip(step).map(|(state, step)| state + step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The derivative of a map of the line.
    struct Slope(f64);

    impl Linearisation for Slope {
        fn newton_step(&self, moved: &[f64]) -> Option<Vec<f64>> {
            Some(vec![moved[0] / (1.0 - self.0)])
        }

        fn attracts(&self, from: &[f64], to: &[f64]) -> bool {
            self.0.abs() < 1.0 && to[0].abs() < from[0].abs()
        }
    }

    /// The search that begins in `state`, for a map with this derivative that has the fixed point 0.
    fn search(state: f64, map: fn(f64) -> f64, slope: fn(f64) -> f64) -> Newton<Slope> {
        let mut newton = Newton::new(CONVERGED, NEAR);
        let mut state = vec![state];
        for _ in 0..ROUNDS {
            let end = vec![map(state[0])];
            let linear = Slope(slope(state[0]));
            match newton.end_turn(state, end, linear) {
                Next::From(next) => state = next,
                Next::Found(found) => {
                    assert!(found[0].abs() < NEAR, "{found:?}");
                    return newton;
                }
                Next::Lost => panic!("the search is lost"),
            }
        }
        panic!("the search does not end")
    }

    #[test]
    fn a_cycle_counts_only_if_it_attracts_for_certain_and_the_orbit_goes_there() {
        let near = search(0.3, |x| 0.5 * x, |_| 0.5);
        assert_eq!(near.class(-0.7, 0.1), Some(Class::Regular));
        assert_eq!(near.class(-0.7, 0.3), None);
        // Newton's method comes from 0.3 to the attracting 0, but the orbit goes from 0.3 to 0.45
        let map = |x: f64| x * (0.5 + x * (20.0 - x * 100.0 / 3.0) / 3.0);
        let leaving = search(0.3, map, |x| 0.5 + x * (40.0 - 100.0 * x) / 3.0);
        assert!((leaving.moved() - 0.15).abs() < 1e-12);
        assert_eq!(leaving.class(-0.7, 0.01), None);
    }

    #[test]
    fn an_orbit_is_unstable_only_if_it_returns_to_exactly_the_same_numbers() {
        let from = |state| search(state, |x| 2.0 * x, |_| 2.0);
        assert_eq!(from(0.0).class(0.7, 0.1), Some(Class::Unstable));
        assert_eq!(from(0.0).class(0.7, 0.3), None);
        assert_eq!(from(0.3).class(0.7, 0.1), None);
    }
}
