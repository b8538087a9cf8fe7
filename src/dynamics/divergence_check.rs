//! Comparison of the exponents' sum with the mean divergence, in some of the measured periods.
//!
//! Owns which periods are computed with both tangent vectors, and what they tell about the others; takes no steps. Twin:
//! `shaders/dynamics/divergence_check.wgsl`.
//!
//! The logarithm of the area that two tangent vectors span grows by the integral of the divergence. If this is taken for granted,
//! one vector gives both exponents at half the cost. If both vectors are followed, it is a check of the scheme.

use super::tangent::Growth;
use crate::lanes::Real;

/// One in this many measured periods is computed with both tangent vectors. This checks every point at a small part of its cost.
/// The number is prime, so that on a cycle the checks come to each of its periods in turn.
pub const CHECKED_EVERY: u32 = 17;

/// Whether the measured period `index` is computed with both tangent vectors.
pub fn is_checked(index: u32) -> bool {
    // so that the shortest measurement has a check, too
    index % CHECKED_EVERY == CHECKED_EVERY / 2
}

/// How many periods from `index` on are computed in the same way, with one tangent vector or with both.
pub fn alike(index: u32) -> u32 {
    if is_checked(index) {
        return 1;
    }
    let since = (index + CHECKED_EVERY - CHECKED_EVERY / 2) % CHECKED_EVERY;
    CHECKED_EVERY - since
}

/// Growth over a period with one tangent vector: that of the second is the divergence less that of the first.
#[inline(always)]
pub fn growth_of_first<R: Real>(first: R, divergence: R) -> Growth<R> {
    let second = divergence - first;
    Growth { first, second }
}

/// Growth over a checked period. The amount by which the growth of `both` misses the divergence counts for all periods up to the
/// next check.
#[inline(always)]
pub fn checked_growth<R: Real>(both: Growth<R>, divergence: R) -> Growth<R> {
    let defect = both.first + both.second - divergence;
    Growth {
        first: both.first,
        second: R::splat(f64::from(CHECKED_EVERY)).mul_add(defect, divergence - both.first),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn periods_alike_reach_to_the_next_change() {
        for index in 0..100 {
            let alike = alike(index);
            let same = (index..index + alike).all(|other| is_checked(other) == is_checked(index));
            assert!(
                same && is_checked(index + alike) != is_checked(index),
                "{index}: {alike}"
            );
        }
        assert_eq!((0..1700).filter(|&index| is_checked(index)).count(), 100);
    }

    #[test]
    fn a_defect_counts_for_all_periods_up_to_the_next_check() {
        let both = Growth {
            first: 0.25,
            second: -1.0,
        };
        let growth = checked_growth(both, -0.5);
        let defect = growth.first + growth.second + 0.5;
        assert_eq!(defect, f64::from(CHECKED_EVERY) * (0.25 - 1.0 + 0.5));
        let alone = growth_of_first(0.25, -0.5);
        assert_eq!((alone.first, alone.second), (0.25, -0.75));
    }
}
