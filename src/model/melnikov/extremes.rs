//! The extremes of M over a drive period.
//!
//! Owns their search; M itself is the parent's.

use std::f64::consts::TAU;

use super::Melnikov;

/// Samples of M over a period. M has kinks where w touches zero. So its extremes are found by sampling and then by golden
/// sections, which need no derivative.
const SAMPLES: usize = 128;
/// Samples for a first check, and the least distance of M from zero, relative to its range, at which this check is enough.
const COARSE_SAMPLES: usize = 48;
const MARGIN: f64 = 0.05;
/// Sampled extremes that are refined; M has few within a period.
const REFINED: usize = 3;
/// Golden sections: 0.618^40 of two sample distances is below 1e-9 of a period.
const SECTIONS: u32 = 40;

/// Least and greatest M over a drive period, and where: tau0 in 0..2 pi/omega_0.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Extremes {
    /// Least M.
    pub minimum: f64,
    /// tau0 of the least M.
    pub minimum_at: f64,
    /// Greatest M.
    pub maximum: f64,
    /// tau0 of the greatest M.
    pub maximum_at: f64,
}

impl Extremes {
    /// Whether M changes sign: by Mel'nikov's criterion chaos may then occur.
    pub fn change_sign(&self) -> bool {
        self.minimum < 0.0 && self.maximum > 0.0
    }
}

impl Melnikov {
    /// The extremes of M over a drive period, to about 1e-9 of its size.
    pub fn extremes(&self) -> Extremes {
        let samples = self.samples();
        let (maximum_at, maximum) = self.greatest(&samples, 1.0);
        let (minimum_at, minimum) = self.greatest(&samples, -1.0);
        Extremes {
            minimum: -minimum,
            minimum_at,
            maximum,
            maximum_at,
        }
    }

    /// Whether M changes sign: as [`Extremes::change_sign`], with less work.
    pub fn changes_sign(&self) -> bool {
        let first = self.closed_form(0.0);
        let (mut least, mut greatest) = (first, first);
        for k in 1..COARSE_SAMPLES {
            let m = self.closed_form(k as f64 / COARSE_SAMPLES as f64 * self.period());
            (least, greatest) = (least.min(m), greatest.max(m));
            // one sample on the other side decides
            if m * first < 0.0 {
                return true;
            }
        }
        // far from zero, finer samples would find nothing else
        let is_far = least.abs().min(greatest.abs()) > MARGIN * (greatest - least);
        !is_far && self.extremes().change_sign()
    }

    /// The maximum of `sign * M` near `at`: its place and its value.
    pub(super) fn peak_near(&self, at: f64, sign: f64) -> (f64, f64) {
        let step = 2.0 * self.period() / SAMPLES as f64;
        golden(&|t| sign * self.closed_form(t), at - step, at + step)
    }

    fn samples(&self) -> Vec<f64> {
        (0..SAMPLES).map(|k| self.closed_form(self.sample_time(k))).collect()
    }

    fn sample_time(&self, k: usize) -> f64 {
        k as f64 / SAMPLES as f64 * self.period()
    }

    /// Where `sign * M` is greatest, and its value there.
    fn greatest(&self, samples: &[f64], sign: f64) -> (f64, f64) {
        let value = |k: usize| sign * samples[k % SAMPLES];
        let mut peaks: Vec<usize> = (0..SAMPLES)
            .filter(|&k| value(k) >= value(k + SAMPLES - 1) && value(k) >= value(k + 1))
            .collect();
        peaks.sort_by(|&a, &b| value(b).total_cmp(&value(a)));
        let step = self.period() / SAMPLES as f64;
        let (at, greatest) = peaks
            .iter()
            .take(REFINED)
            .map(|&k| {
                let middle = self.sample_time(k);
                let (t, refined) = golden(&|t| sign * self.closed_form(t), middle - step, middle + step);
                if refined > value(k) {
                    (t, refined)
                } else {
                    (middle, value(k))
                }
            })
            .max_by(|a, b| a.1.total_cmp(&b.1))
            // only NaN has no peak
            .unwrap_or((f64::NAN, f64::NAN));
        (at.rem_euclid(TAU / self.omega_0), greatest)
    }
}

/// The maximum of a function with one peak between `low` and `high`.
fn golden(f: &impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> (f64, f64) {
    const RATIO: f64 = 0.618_033_988_749_894_8;
    let mut a = high - RATIO * (high - low);
    let mut b = low + RATIO * (high - low);
    let (mut at_a, mut at_b) = (f(a), f(b));
    for _ in 0..SECTIONS {
        if at_a < at_b {
            (low, a, at_a) = (a, b, at_b);
            b = low + RATIO * (high - low);
            at_b = f(b);
        } else {
            (high, b, at_b) = (b, a, at_a);
            a = high - RATIO * (high - low);
            at_a = f(a);
        }
    }
    if at_a > at_b { (a, at_a) } else { (b, at_b) }
}
