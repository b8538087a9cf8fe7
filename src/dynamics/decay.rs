//! Exponential decay over a step, and the response of a decaying mode to a source that is a polynomial of time.
//!
//! Owns the functions that make the linear heat modes exact; knows no physics. Twin: `shaders/dynamics/decay.wgsl`.

use crate::lanes::{Mask, Real};

/// Below this z the moments come from their series, above it from the recursion. At this z both are accurate to rounding.
const SERIES_BOUND: f64 = 0.5;

/// Beyond this z, e^-z is taken as e^-40, which is 0 to rounding.
const LARGEST: f64 = 40.0;

/// SERIES[n]: coefficient of z^n in I_2, (-1)^n 2!/(n+3)!.
const SERIES: [f64; 11] = {
    let mut coefficients = [1.0 / 3.0; 11];
    let mut n = 1;
    while n < coefficients.len() {
        coefficients[n] = -coefficients[n - 1] / (n + 3) as f64;
        n += 1;
    }
    coefficients
};

/// A mode of rate z over a step of length 1.
#[derive(Clone, Copy, Debug)]
pub struct Decay<R> {
    /// e^-z.
    pub factor: R,
    /// I_k = Int_0^1 e^{-z(1-s)} s^k ds for k = 0, 1, 2.
    pub moments: [R; 3],
}

impl<R: Real> Decay<R> {
    /// An empty value, to be filled.
    pub fn empty() -> Self {
        Self {
            factor: R::splat(0.0),
            moments: [R::splat(0.0); 3],
        }
    }
}

/// Whether the lane type is single precision, which needs fewer terms.
#[inline(always)]
pub(super) fn single<R: Real>() -> bool {
    size_of::<R::Scalar>() == 4
}

/// The decay of a mode over a step. `z` >= 0 is the rate times the length of the step, `inverse_z` is 1/z.
#[inline(always)]
pub fn decay<R: Real>(z: R, inverse_z: R) -> Decay<R> {
    let slow = z.less(R::splat(SERIES_BOUND));
    // for a fast mode, the series only gives e^{-z/64}
    let part = z.min(R::splat(LARGEST)) * R::splat(1.0 / 64.0);
    let series = by_series(R::select(slow, z, part));
    if slow.all() {
        return series;
    }
    let recursion = by_recursion(series.factor, inverse_z);
    Decay {
        factor: R::select(slow, series.factor, recursion.factor),
        moments: [
            R::select(slow, series.moments[0], recursion.moments[0]),
            R::select(slow, series.moments[1], recursion.moments[1]),
            R::select(slow, series.moments[2], recursion.moments[2]),
        ],
    }
}

/// I_2 = sum_n (-z)^n 2!/(n+3)!, then downwards by I_{k-1} = (1 - z I_k)/k, which is stable for small z.
#[inline(always)]
fn by_series<R: Real>(z: R) -> Decay<R> {
    let one = R::splat(1.0);
    let last = if single::<R>() { 6 } else { 10 };
    let mut second = R::splat(SERIES[last]);
    for n in (0..last).rev() {
        second = second.mul_add(z, R::splat(SERIES[n]));
    }
    let first = (one - z * second) * R::splat(0.5);
    let zeroth = one - z * first;
    Decay {
        factor: one - z * zeroth,
        moments: [zeroth, first, second],
    }
}

/// e^-z = (e^{-z/64})^64 and I_0 = (1 - e^-z)/z, then upwards by I_k = (1 - k I_{k-1})/z, which is stable for large z.
#[inline(always)]
fn by_recursion<R: Real>(part: R, inverse_z: R) -> Decay<R> {
    let one = R::splat(1.0);
    let mut factor = part;
    for _ in 0..6 {
        factor = factor * factor;
    }
    let zeroth = (one - factor) * inverse_z;
    let first = (one - zeroth) * inverse_z;
    Decay {
        factor,
        moments: [zeroth, first, (one - first - first) * inverse_z],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Composite Gauss-Legendre quadrature of the definition.
    fn moment(z: f64, k: i32) -> f64 {
        let nodes = [-(0.6f64.sqrt()), 0.0, 0.6f64.sqrt()];
        let weights = [5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0];
        let cells = 4000;
        (0..cells)
            .flat_map(|cell| (0..3).map(move |i| (cell, i)))
            .map(|(cell, i)| {
                let s = (f64::from(cell) + 0.5 + 0.5 * nodes[i]) / f64::from(cells);
                weights[i] / f64::from(cells) * (-z * (1.0 - s)).exp() * s.powi(k)
            })
            .sum()
    }

    #[test]
    fn moments_are_the_integrals_they_stand_for() {
        for z in [
            1e-12_f64, 1e-3, 0.1, 0.3, 0.4999, 0.5, 0.51, 0.7, 1.0, 2.0, 5.0, 20.0, 39.0, 300.0,
        ] {
            let decay = decay(z, 1.0 / z);
            assert!(
                (decay.factor - (-z).exp()).abs() < 3e-14 * (-z).exp() + 1e-16,
                "factor at {z}"
            );
            for k in 0..3 {
                let error = decay.moments[k] / moment(z, k as i32) - 1.0;
                assert!(error.abs() < 3e-13, "moment {k} at {z}: {error:e}");
            }
        }
    }

    #[test]
    fn single_precision_keeps_what_a_pressure_needs() {
        for i in 1..2000 {
            let z = 0.01 * f64::from(i);
            let (double, single) = (decay(z, 1.0 / z), decay(z as f32, 1.0 / z as f32));
            assert!(
                (f64::from(single.factor) - double.factor).abs() < 1e-5 * double.factor + 1e-7,
                "{z}"
            );
            for k in 0..3 {
                assert!(
                    (f64::from(single.moments[k]) / double.moments[k] - 1.0).abs() < 1e-4,
                    "{z} {k}"
                );
            }
        }
    }
}
