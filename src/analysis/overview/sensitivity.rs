//! Which coordinates matter: variance-based sensitivity indices (Sobol' 1993, Homma and Saltelli 1996).
//!
//! Owns the estimators; what the values are, its caller knows.
//!
//! The first-order index of a coordinate is the part of the variance that is gone, in the mean, once its value is known:
//! S = Var(E(Y | x)) / Var(Y). The total index is the part that is left, in the mean, if all but its value are known:
//! T = E(Var(Y | all others)) / Var(Y). T - S is what it does together with others.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::coordinate::Places;
use crate::design::uniform;

/// The indices of one coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Indices {
    /// The first-order index.
    pub first: f64,
    /// Its standard error; 0 over a product of axes, which has no chance in it.
    pub first_error: f64,
    /// The total index; None for a list of points, which does not hold all values of one coordinate at given others, and for a product of
    /// which some points have no value.
    pub total: Option<f64>,
}

/// Resamples from which the error comes, and about how many points they may have together.
const RESAMPLES: usize = 200;
const MOST_DRAWN: usize = 20_000_000;

/// The indices of each coordinate for values at the points of a design; NaN stands for no value. None where the values do not vary.
///
/// Over a product of axes the indices are those of the points that have a value. For a list, the first-order index comes from the bins of
/// its values, corrected for the chance differences of their means (Kelley's epsilon squared); its error from bootstrap resamples.
pub fn indices(places: &Places<'_>, values: &[f64], is_product: bool) -> Option<Vec<Indices>> {
    let known = || values.iter().copied().filter(|value| value.is_finite());
    let count = known().count();
    let mean = known().sum::<f64>() / count as f64;
    let whole: f64 = known().map(|value| (value - mean).powi(2)).sum();
    // what is left of rounding where all values are equal
    if count < 2 || whole <= 1e-24 * count as f64 * mean * mean || whole == 0.0 {
        return None;
    }
    let all = if is_product {
        let axes = places.strides().map(|(stride, axis)| Indices {
            first: explained(values, axis, |index| index / stride % axis) / whole,
            first_error: 0.0,
            total: (count == values.len()).then(|| left_along(values, stride, axis) / whole),
        });
        axes.collect()
    } else {
        let points: Vec<usize> = (0..values.len()).filter(|&index| values[index].is_finite()).collect();
        let resamples = (MOST_DRAWN / count).clamp(20, RESAMPLES);
        (0..places.extents.len())
            .map(|coordinate| {
                let bins = places.extents[coordinate].bins.len();
                let bin = |index: usize| places.bin(coordinate, index);
                let first = corrected(values, &points, bins, &bin);
                let mut generator = ChaCha8Rng::seed_from_u64(coordinate as u64);
                let again: Vec<f64> = (0..resamples)
                    .map(|_| {
                        let drawn = (0..count).map(|_| points[(uniform(&mut generator) * count as f64) as usize]);
                        corrected(values, &drawn.collect::<Vec<_>>(), bins, &bin)
                    })
                    .collect();
                let mean = again.iter().sum::<f64>() / resamples as f64;
                let squares: f64 = again.iter().map(|value| (value - mean).powi(2)).sum();
                Indices {
                    first,
                    first_error: (squares / (resamples - 1) as f64).sqrt(),
                    total: None,
                }
            })
            .collect()
    };
    Some(all)
}

/// The sum of squares between groups: that of the means of the groups, each as often as the group has values.
fn explained(values: &[f64], groups: usize, group: impl Fn(usize) -> usize) -> f64 {
    let mut sums = vec![(0.0, 0usize); groups];
    for (index, value) in values.iter().enumerate().filter(|(_, value)| value.is_finite()) {
        let (sum, count) = &mut sums[group(index)];
        *sum += value;
        *count += 1;
    }
    let (whole, count) = sums
        .iter()
        .fold((0.0, 0), |(sum, count), group| (sum + group.0, count + group.1));
    let mean = whole / count as f64;
    let filled = sums.into_iter().filter(|(_, count)| *count > 0);
    filled
        .map(|(sum, count)| count as f64 * (sum / count as f64 - mean).powi(2))
        .sum()
}

/// The sum of squares about the mean of each line along an axis.
fn left_along(values: &[f64], stride: usize, count: usize) -> f64 {
    let starts = (0..values.len()).filter(|index| (index / stride).is_multiple_of(count));
    starts
        .map(|start| {
            let line = || {
                (0..count)
                    .map(|step| values[start + step * stride])
                    .filter(|value| value.is_finite())
            };
            let mean = line().sum::<f64>() / line().count().max(1) as f64;
            line().map(|value| (value - mean).powi(2)).sum::<f64>()
        })
        .sum()
}

/// Epsilon squared of the bins of some points: 1 - (variance within bins) / (variance), both unbiased; not below 0.
fn corrected(values: &[f64], points: &[usize], bins: usize, bin: &impl Fn(usize) -> usize) -> f64 {
    let mut sums = vec![(0.0, 0.0, 0usize); bins];
    for &index in points {
        let value = values[index];
        let (sum, squares, count) = &mut sums[bin(index)];
        *sum += value;
        *squares += value * value;
        *count += 1;
    }
    let [mut sum, mut squares, mut within, mut filled] = [0.0; 4];
    for (of_bin, squares_of_bin, count) in sums {
        sum += of_bin;
        squares += squares_of_bin;
        if count > 0 {
            within += squares_of_bin - of_bin * of_bin / count as f64;
            filled += 1.0;
        }
    }
    let count = points.len() as f64;
    let whole = squares - sum * sum / count;
    if whole <= 0.0 || count <= filled {
        return 0.0;
    }
    (1.0 - within / (count - filled) / (whole / (count - 1.0))).max(0.0)
}
