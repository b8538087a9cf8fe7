//! The period of the motion from stroboscopic states.
//!
//! Owns the comparison of states a whole number of forcing periods apart, done as they come, so that no history is
//! kept beyond the last 32. Twin: `shaders/dynamics/stroboscope.wgsl`.

/// The longest period that is looked for, in forcing periods.
pub const MAX_PERIOD: usize = 32;

/// The motion must repeat over this many last forcing periods.
pub const WINDOW: u32 = 64;

/// Number of last states compared in a run of `periods`: those at the ends of its last [`WINDOW`] periods.
pub fn window(periods: u32) -> u32 {
    periods.min(WINDOW)
}

/// The period that a bit set of candidates means: bit k-1 stands for k, and the least counts. Only periods that
/// fit at least twice into the window are trusted.
pub fn period(candidates: u32, window: u32) -> Option<u32> {
    let period = candidates.trailing_zeros() + 1;
    (2 * period <= window && period <= MAX_PERIOD as u32).then_some(period)
}

/// Compares each stroboscopic state with those up to [`MAX_PERIOD`] periods before it.
#[derive(Clone, Debug)]
pub struct Stroboscope {
    /// x and y of the last states, state n at n modulo [`MAX_PERIOD`].
    x: [f64; MAX_PERIOD],
    y: [f64; MAX_PERIOD],
    recorded: u32,
    /// Bit k-1 is set while all states k periods apart agree.
    candidates: u32,
}

impl Default for Stroboscope {
    fn default() -> Self {
        Self {
            x: [0.0; MAX_PERIOD],
            y: [0.0; MAX_PERIOD],
            recorded: 0,
            candidates: u32::MAX,
        }
    }
}

impl Stroboscope {
    /// Takes the next state at drive phase 0; states agree whose x and y differ by less than `tolerance`.
    #[inline(always)]
    pub fn record(&mut self, x: f64, y: f64, tolerance: f64) {
        // all places at once, without a branch: this is done for every instance in every period
        let mut agree = 0;
        for place in 0..MAX_PERIOD {
            let agrees = ((x - self.x[place]).abs() < tolerance) & ((y - self.y[place]).abs() < tolerance);
            agree |= u32::from(agrees) << place;
        }
        // state n - k stands k places before that of state n, and periods k are counted from bit 0
        let by_period = agree.reverse_bits().rotate_left(self.recorded % MAX_PERIOD as u32);
        let not_yet_recorded = u32::MAX.checked_shl(self.recorded).unwrap_or(0);
        self.candidates &= by_period | not_yet_recorded;
        let place = self.recorded as usize % MAX_PERIOD;
        (self.x[place], self.y[place]) = (x, y);
        self.recorded += 1;
    }

    /// See [`period`].
    pub fn candidates(&self) -> u32 {
        self.candidates
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn period_of(states: impl Fn(u32) -> (f64, f64)) -> Option<u32> {
        let mut stroboscope = Stroboscope::default();
        for n in 0..WINDOW {
            let (x, y) = states(n);
            stroboscope.record(x, y, 1e-4);
        }
        period(stroboscope.candidates(), WINDOW)
    }

    #[test]
    fn the_least_period_is_found_up_to_the_longest() {
        for k in 1..=MAX_PERIOD as u32 {
            assert_eq!(period_of(|n| (f64::from(n % k), 0.5)), Some(k));
            assert_eq!(period_of(|n| (0.5, f64::from(n % k))), Some(k));
        }
        assert_eq!(period_of(|n| (f64::from(n % 33), 0.0)), None);
    }

    #[test]
    fn drift_and_late_disturbance_are_no_period() {
        assert_eq!(period_of(|n| (1.1e-4 * f64::from(n), 0.0)), None);
        assert_eq!(period_of(|n| (0.0, if n == WINDOW - 1 { 2e-4 } else { 0.0 })), None);
        assert_eq!(period_of(|_| (f64::NAN, 0.0)), None);
    }

    #[test]
    fn a_short_window_trusts_short_periods_only() {
        assert_eq!(period(0b1000, 8), Some(4));
        assert_eq!(period(0b1000, 7), None);
        assert_eq!(period(0, 64), None);
    }
}
