//! The period of the motion from stroboscopic states.
//!
//! Owns which states are kept, and their comparison. The comparison is done once, at the end of a run; in each period only a
//! state is kept. Twin: `shaders/dynamics/stroboscope.wgsl`.

use crate::lanes::{Mask, Real};

/// The motion must repeat over at least this many of the last forcing periods.
pub const LEAST_WINDOW: u32 = 64;

/// Most states that are kept if periods up to `max_period` are searched for.
pub const fn most_states(max_period: u32) -> u32 {
    if 2 * max_period > LEAST_WINDOW {
        2 * max_period
    } else {
        LEAST_WINDOW
    }
}

/// Number of states that are kept from a run of `periods` periods: those at the ends of the last ones.
pub fn window(periods: u32, max_period: u32) -> u32 {
    periods.min(most_states(max_period))
}

/// Number of last states, at most `window`, over which a motion must repeat for `period` to be its period.
pub fn span_of(period: u32, window: u32) -> u32 {
    window.min(most_states(period))
}

/// The least period, up to `max_period`, after which the states of a window repeat. `agree` tells whether two of them are the
/// same. Only periods that fit at least twice into the window are trusted.
pub fn period_of(window: u32, max_period: u32, agree: impl Fn(u32, u32) -> bool) -> Option<u32> {
    (1..=max_period.min(window / 2)).find(|&k| repeats(k, window, &agree))
}

/// Whether all states `k` periods apart agree, from the last ones back.
fn repeats(k: u32, window: u32, agree: impl Fn(u32, u32) -> bool) -> bool {
    let first = window - span_of(k, window);
    (first + k..window).rev().all(|n| agree(n, n - k))
}

/// The last stroboscopic states of the instances in a vector's lanes.
#[derive(Clone, Debug)]
pub struct Stroboscope<R> {
    states: Vec<[R; 2]>,
}

impl<R> Default for Stroboscope<R> {
    fn default() -> Self {
        Self { states: Vec::new() }
    }
}

impl<R: Real> Stroboscope<R> {
    /// Keeps the next state at drive phase 0.
    #[inline(always)]
    pub fn record(&mut self, x: R, y: R) {
        self.states.push([x, y]);
    }

    /// [`period_of`] in every lane. Two states agree if their x and their y differ by less than `tolerance`. The states of all lanes
    /// are compared together, because it takes long to read single lanes of a vector.
    #[inline(always)]
    pub fn periods(&self, max_period: u32, tolerance: R) -> Vec<Option<u32>> {
        let window = self.states.len();
        let mut periods = vec![None; R::LANES];
        for k in 1..=(max_period as usize).min(window / 2) {
            let first = window - span_of(k as u32, window as u32) as usize;
            let mut same = R::splat(0.0).less(R::splat(1.0));
            for n in (first + k..window).rev() {
                let [x, y] = [0, 1].map(|i| (self.states[n][i] - self.states[n - k][i]).abs().less(tolerance));
                same = same.and(x).and(y);
                if !(0..R::LANES).any(|lane| periods[lane].is_none() && same.lane(lane)) {
                    break;
                }
            }
            for (lane, period) in periods.iter_mut().enumerate() {
                *period = period.or_else(|| same.lane(lane).then_some(k as u32));
            }
            if periods.iter().all(Option::is_some) {
                break;
            }
        }
        periods
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Pair;

    fn found(max_period: u32, states: impl Fn(u32) -> (f64, f64)) -> Option<u32> {
        let mut stroboscope = Stroboscope::default();
        for n in 0..window(u32::MAX, max_period) {
            let (x, y) = states(n);
            stroboscope.record(x, y);
        }
        stroboscope.periods(max_period, 1e-4)[0]
    }

    #[test]
    fn the_least_period_is_found_up_to_the_longest() {
        for max_period in [1, 7, 64, 1024] {
            for k in (1..=64.min(max_period)).chain([max_period]) {
                assert_eq!(found(max_period, |n| (f64::from(n % k), 0.5)), Some(k));
                assert_eq!(found(max_period, |n| (0.5, f64::from(n % k))), Some(k));
            }
            assert_eq!(found(max_period, |n| (f64::from(n % (max_period + 1)), 0.0)), None);
        }
    }

    #[test]
    fn every_lane_has_its_own_period() {
        let mut stroboscope = Stroboscope::<Pair<Pair<f64>>>::default();
        for n in 0..window(u32::MAX, 64) {
            let lengths = [3, 6, u32::MAX, 1];
            stroboscope.record(Real::from_lanes(|lane| f64::from(n % lengths[lane])), Real::splat(0.0));
        }
        let periods = stroboscope.periods(64, Real::splat(1e-4));
        assert_eq!(periods, [Some(3), Some(6), None, Some(1)]);
    }

    #[test]
    fn drift_and_late_disturbance_are_no_period() {
        assert_eq!(found(64, |n| (1.1e-4 * f64::from(n), 0.0)), None);
        assert_eq!(found(64, |n| (0.0, if n == 127 { 2e-4 } else { 0.0 })), None);
        assert_eq!(found(64, |_| (f64::NAN, 0.0)), None);
    }

    #[test]
    fn a_short_period_must_show_over_the_last_states_only() {
        let late = |from: u32| move |n: u32| (if n < from { f64::from(n) } else { f64::from(n % 4) }, 0.0);
        assert_eq!(found(64, late(64)), Some(4));
        assert_eq!(found(64, late(70)), None);
    }

    #[test]
    fn a_short_window_trusts_short_periods_only() {
        let repeats = |n: u32, before: u32| (n - before).is_multiple_of(4);
        assert_eq!(period_of(8, 64, repeats), Some(4));
        assert_eq!(period_of(7, 64, repeats), None);
        assert_eq!(period_of(64, 3, repeats), None);
        assert_eq!(period_of(64, 64, |_, _| false), None);
    }
}
