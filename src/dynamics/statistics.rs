//! Averages of a growth rate over one orbit, and their errors.
//!
//! Owns batch means, the weighted Birkhoff average, and the order of the exponents; integrates nothing.

use std::ops::Range;

/// Most batches that a measurement is divided into.
const BATCHES: u32 = 32;

/// Divides `periods` into at most 32 batches of (nearly) equal length, of at least two periods each where that is
/// possible.
pub fn batches(periods: u32) -> Vec<Range<u32>> {
    let count = BATCHES.min(periods / 2).max(1);
    let bound = |i: u32| (u64::from(periods) * u64::from(i) / u64::from(count)) as u32;
    (0..count).map(|i| bound(i)..bound(i + 1)).collect()
}

/// Fewest groups of batches whose scatter still gives a useful estimate.
const LEAST_GROUPS: usize = 8;

/// From this number of groups on, no allowance for few groups is made.
const MANY_GROUPS: usize = 12;

/// Standard error of the mean rate `sum(growth)/sum(length)`, given each batch's length and growth.
///
/// The method is batch means: the scatter of the batches gives the error, whatever the correlation inside a batch. If the
/// correlation reaches from one batch into the next, groups of 2, 4, ... batches scatter more than single batches would suggest.
/// Therefore the largest estimate with at least 8 groups is taken; one with fewer than 12 groups is first multiplied by
/// `student`'s factor (H. Flyvbjerg and H. G. Petersen, doi:10.1063/1.457480). Correlation over more than an eighth of the run is
/// not seen. The result is NaN if a growth is NaN.
pub fn standard_error(batches: &[(f64, f64)]) -> f64 {
    std::iter::successors(Some(1), |group| Some(2 * group))
        .take_while(|group| *group == 1 || batches.len() / group >= LEAST_GROUPS)
        .map(|group| {
            let groups: Vec<(f64, f64)> = batches
                .chunks(group)
                .map(|chunk| {
                    chunk
                        .iter()
                        .fold((0.0, 0.0), |sum, batch| (sum.0 + batch.0, sum.1 + batch.1))
                })
                .collect();
            // with more groups, the allowance is less than what taking the largest estimate adds
            let allowance = if groups.len() < MANY_GROUPS {
                student(groups.len())
            } else {
                1.0
            };
            scatter(&groups) * allowance
        })
        // written so that NaN stays
        .fold(0.0, |largest, error| if error <= largest { largest } else { error })
}

/// The factor by which the interval that covers 95 % is wider than that of the normal distribution if the scatter is estimated
/// from this number of `values`. With n degrees of freedom it is 1.96 + 2.37/n + 2.82/n^2, the leading terms of Student's
/// quantile, over 1.96; within 1 % from n = 5.
fn student(values: usize) -> f64 {
    let freedom = values.saturating_sub(1) as f64;
    1.0 + 1.21 / freedom + 1.44 / (freedom * freedom)
}

/// The scatter of the growth of single forcing periods.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spread {
    count: f64,
    sum: f64,
    squares: f64,
}

impl Spread {
    pub fn add(&mut self, growth: f64) {
        self.count += 1.0;
        self.sum += growth;
        self.squares += growth * growth;
    }

    /// Standard error of the mean growth of `periods` periods if each were independent of the others. NaN if only one was added.
    ///
    /// Chaos in bands alternates between large and small growth, which cancel in the mean as long as the orbit visits its bands
    /// in a fixed order. If this order slips now and then, batch means of a run without a slip give a much too small error. The
    /// independent error is about the error that such slips cause.
    pub fn independent_error(&self, periods: u32) -> f64 {
        let mean = self.sum / self.count;
        let squares = self.squares - mean * self.sum;
        // rounding may leave less than nothing; NaN is to stay NaN, which `max` would make 0
        let squares = if squares < 0.0 { 0.0 } else { squares };
        (squares / (self.count - 1.0) / f64::from(periods)).sqrt()
    }
}

fn scatter(batches: &[(f64, f64)]) -> f64 {
    let length: f64 = batches.iter().map(|batch| batch.0).sum();
    let mean = batches.iter().map(|batch| batch.1).sum::<f64>() / length;
    let squares: f64 = batches
        .iter()
        .map(|(length, growth)| (growth - mean * length).powi(2))
        .sum();
    let count = batches.len() as f64;
    (squares * count / (count - 1.0)).sqrt() / length
}

/// Weights exp(-1/(t(1-t))) at the middle of each period, with sum 1: the weighted Birkhoff average of Das, Sander
/// and Yorke (doi:10.1088/1361-6544/aa84c2), which converges on quasi-periodic orbits faster than any power.
pub fn birkhoff_weights(periods: u32) -> Vec<f64> {
    let weight = |n: u32| {
        let t = (f64::from(n) + 0.5) / f64::from(periods);
        (-1.0 / (t * (1.0 - t))).exp()
    };
    let sum: f64 = (0..periods).map(weight).sum();
    (0..periods).map(|n| weight(n) / sum).collect()
}

/// The two exponents, the larger first, from the mean growth rates of the two tangent vectors. If the second grows faster, the
/// vectors rotate. Then the exponents are equal, and only their sum does not depend on the rotation.
pub fn exponents([first, second]: [f64; 2]) -> [f64; 2] {
    if first < second {
        [0.5 * (first + second); 2]
    } else {
        [first, second]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_cover_every_period_once() {
        for periods in [16, 17, 63, 64, 100, 400, 1001] {
            let batches = batches(periods);
            assert_eq!(batches.first().unwrap().start, 0);
            assert_eq!(batches.last().unwrap().end, periods);
            assert!(batches.windows(2).all(|pair| pair[0].end == pair[1].start));
            assert!(batches.len() >= 8 && batches.iter().all(|batch| batch.len() >= 2));
        }
    }

    /// A pseudo-random number of a linear congruential generator, uniform in -0.5..0.5.
    fn noise(seed: &mut u64) -> f64 {
        *seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }

    #[test]
    fn the_standard_error_covers_the_scatter_of_correlated_means() {
        // autoregressive growth g' = 0.9 g + noise over 400 periods: variance of the mean is 1/(12 * 0.1^2 * 400)
        let truth = (1.0_f64 / (12.0 * 0.01 * 400.0)).sqrt();
        let mut seed = 1;
        let runs = 300;
        let mut sum_square = 0.0;
        for _ in 0..runs {
            let mut growth = 0.0;
            for _ in 0..100 {
                growth = 0.9 * growth + noise(&mut seed);
            }
            let sums: Vec<(f64, f64)> = batches(400)
                .into_iter()
                .map(|batch| {
                    let sum = batch.clone().map(|_| {
                        growth = 0.9 * growth + noise(&mut seed);
                        growth
                    });
                    (batch.len() as f64, sum.sum())
                })
                .collect();
            sum_square += standard_error(&sums).powi(2) / f64::from(runs);
        }
        let ratio = sum_square.sqrt() / truth;
        assert!((0.9..1.4).contains(&ratio), "{ratio}");
    }

    #[test]
    fn few_groups_are_allowed_for_by_student_s_quantile() {
        for (values, quantile) in [(6, 2.571), (8, 2.365), (16, 2.131), (32, 2.040)] {
            let factor = quantile / 1.960;
            assert!(
                (student(values) / factor - 1.0).abs() < 0.01,
                "{values}: {}",
                student(values)
            );
        }
    }

    #[test]
    fn growth_that_alternates_keeps_the_scatter_of_its_periods() {
        let mut spread = Spread::default();
        (0..32).for_each(|n| spread.add(if n % 2 == 0 { 1.0 } else { -0.5 }));
        let expected = (0.75_f64.powi(2) * 32.0 / 31.0 / 192.0).sqrt();
        assert!((spread.independent_error(192) / expected - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_weighted_average_of_a_quasi_periodic_signal_is_its_mean() {
        let weights = birkhoff_weights(400);
        let signal = |n: usize| 0.3 + (1.2345 * n as f64).cos() + (0.777 * n as f64 + 1.0).sin();
        let weighted: f64 = weights.iter().enumerate().map(|(n, weight)| weight * signal(n)).sum();
        assert!((weighted - 0.3).abs() < 1e-6, "{weighted}");
    }
}
