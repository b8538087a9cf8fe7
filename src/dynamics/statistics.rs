//! Averages of a growth rate over one orbit, and how sure they are.
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

/// Standard error of the mean rate `sum(growth)/sum(length)`, given each batch's length and growth.
///
/// Batch means: the batches' scatter gives the error whatever the correlation inside a batch. Where it reaches from one
/// batch into the next, pairs and fours of batches scatter more than single ones would make them; the largest of the
/// three estimates is taken; NaN if a growth is.
pub fn standard_error(batches: &[(f64, f64)]) -> f64 {
    [1, 2, 4]
        .into_iter()
        .filter(|group| *group == 1 || batches.len() / group >= 8)
        .map(|group| {
            let groups: Vec<(f64, f64)> = batches
                .chunks(group)
                .map(|chunk| {
                    chunk
                        .iter()
                        .fold((0.0, 0.0), |sum, batch| (sum.0 + batch.0, sum.1 + batch.1))
                })
                .collect();
            scatter(&groups)
        })
        // written so that NaN stays
        .fold(0.0, |largest, error| if error <= largest { largest } else { error })
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

/// The two exponents, the larger first, from the mean growth rates of the two tangent vectors. Where the second
/// grows faster the vectors rotate: the exponents are equal, and only their sum is free of the rotation.
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

    /// A pseudo-random walk through a linear congruence: uniform in -0.5..0.5.
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
    fn the_weighted_average_of_a_quasi_periodic_signal_is_its_mean() {
        let weights = birkhoff_weights(400);
        let signal = |n: usize| 0.3 + (1.2345 * n as f64).cos() + (0.777 * n as f64 + 1.0).sin();
        let weighted: f64 = weights.iter().enumerate().map(|(n, weight)| weight * signal(n)).sum();
        assert!((weighted - 0.3).abs() < 1e-6, "{weighted}");
    }
}
