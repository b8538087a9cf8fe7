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

    /// Which lanes have period 1, computed for all lanes at once: this period is the most frequent one, and comparing its states
    /// takes longest.
    #[inline(always)]
    pub fn repeats_after_one(&self, tolerance: R) -> R::Mask {
        let window = self.states.len();
        let first = window - span_of(1, window as u32) as usize;
        let mut same = R::splat(0.0).less(R::splat(f64::from(u8::from(window > 1))));
        for pair in self.states[first..].windows(2) {
            let [x, y] = [0, 1].map(|i| (pair[1][i] - pair[0][i]).abs().less(tolerance));
            same = same.and(x).and(y);
        }
        same
    }

    /// [`period_of`] in one lane: two states agree if their x and their y differ by less than `tolerance`.
    pub fn period_of(&self, lane: usize, max_period: u32, tolerance: f64) -> Option<u32> {
        let state = |n: u32| self.states[n as usize].map(|value| value.lane(lane));
        period_of(self.states.len() as u32, max_period, |n, before| {
            let ([x, y], [x_before, y_before]) = (state(n), state(before));
            (x - x_before).abs() < tolerance && (y - y_before).abs() < tolerance
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(max_period: u32, states: impl Fn(u32) -> (f64, f64)) -> Option<u32> {
        let mut stroboscope = Stroboscope::default();
        for n in 0..window(u32::MAX, max_period) {
            let (x, y) = states(n);
            stroboscope.record(x, y);
        }
        stroboscope.period_of(0, max_period, 1e-4)
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
