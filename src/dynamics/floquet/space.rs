//! The monodromy matrix of a cycle in a state of any dimension, from the tangent maps of its periods.
//!
//! Owns its two greatest eigenvalues; integrates nothing.

use nalgebra::{DMatrix, DVector, Schur};

use super::{Linearisation, Multipliers};
use crate::dynamics::statistics;

/// The tangent map of one turn: the product of those of its periods.
#[derive(Clone, Debug)]
pub struct Monodromy {
    /// The tangent map of each period, the first one first. All are square and of the same size.
    periods: Vec<DMatrix<f64>>,
    /// Their product.
    matrix: DMatrix<f64>,
}

/// Most iterations in which the eigenvalues of a matrix are to be found.
const ITERATIONS: usize = 10_000;

/// Most turns in which the plane of the two leading directions is to be found.
const TURNS: usize = 64;

/// That plane is found if the growth of an area in it no longer changes by more than this, in logarithms.
const SETTLED: f64 = 1e-9;

impl Monodromy {
    /// The map of a turn of at least one period.
    pub fn new(periods: Vec<DMatrix<f64>>) -> Self {
        let size = periods[0].nrows();
        let matrix = periods
            .iter()
            .fold(DMatrix::identity(size, size), |product, period| period * product);
        Self { periods, matrix }
    }

    /// The two eigenvalues. None if the matrix is not finite.
    ///
    /// The eigenvalues of the matrix give mu_1. The matrix has too few digits for mu_2, which may be many orders of magnitude
    /// smaller: ln |mu_1 mu_2| is the growth of an area, which is followed period by period. If no area settles, as where the second
    /// and the third eigenvalue are a complex pair, it is the weighted Birkhoff average over many turns, through which the area
    /// rotates.
    pub fn multipliers(&self) -> Option<Multipliers> {
        let is_finite = self.matrix.iter().all(|entry| entry.is_finite());
        let schur = is_finite.then(|| Schur::try_new(self.matrix.clone(), f64::EPSILON, ITERATIONS))??;
        let eigenvalues = schur.complex_eigenvalues();
        let leading = eigenvalues.iter().max_by(|a, b| a.norm().total_cmp(&b.norm()))?;
        let first = leading.norm().ln();
        let second = self.log_area() - first;
        // rounding may put it above the first; written so that NaN stays
        let second = if second > first { first } else { second };
        Some(Multipliers {
            log_moduli: [first, second],
            cosine: if leading.im == 0.0 {
                leading.re.signum()
            } else {
                // below 1 also after rounding
                (leading.re / leading.norm()).clamp(-1.0 + f64::EPSILON, 1.0 - f64::EPSILON)
            },
        })
    }

    /// ln |mu_1 mu_2|.
    fn log_area(&self) -> f64 {
        let size = self.matrix.nrows();
        // all entries differ, so that no direction is left out
        let [mut first, mut second] = [0.7, 1.3].map(|shift| DVector::from_fn(size, |n, _| (n as f64 + shift).cos()));
        let mut image = DVector::zeros(size);
        let mut growths: Vec<f64> = Vec::new();
        for turn in 0..TURNS {
            let mut growth = 0.0;
            for period in &self.periods {
                image.gemv(1.0, period, &first, 0.0);
                std::mem::swap(&mut image, &mut first);
                image.gemv(1.0, period, &second, 0.0);
                std::mem::swap(&mut image, &mut second);
                growth += first.norm().ln();
                first.normalize_mut();
                // twice, since the second vector may have been almost parallel to the first one
                for _ in 0..2 {
                    second.axpy(-first.dot(&second), &first, 1.0);
                }
                growth += second.norm().ln();
                second.normalize_mut();
            }
            if turn > 1 && growths.last().is_some_and(|before| (growth - before).abs() < SETTLED) {
                return growth;
            }
            growths.push(growth);
        }
        let weights = statistics::birkhoff_weights(TURNS as u32);
        growths
            .iter()
            .zip(weights)
            .map(|(growth, weight)| growth * weight)
            .sum()
    }
}

impl Linearisation for Monodromy {
    fn newton_step(&self, moved: &[f64]) -> Option<Vec<f64>> {
        let size = self.matrix.nrows();
        let system = DMatrix::identity(size, size) - &self.matrix;
        let step = system.lu().solve(&DVector::from_column_slice(moved))?;
        Some(step.as_slice().to_vec())
    }

    fn attracts(&self, from: &[f64], to: &[f64]) -> bool {
        let [from, to] = [from, to].map(DVector::from_column_slice);
        super::attracts(&self.matrix, &from, &to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix with these eigenvalues, each pair of which may be complex: the blocks on the diagonal, seen from other axes.
    fn with_blocks(blocks: &DMatrix<f64>) -> DMatrix<f64> {
        let size = blocks.nrows();
        let axes = DMatrix::from_fn(
            size,
            size,
            |i, j| if i == j { 1.0 } else { 0.3 * ((3 * i + j) as f64).sin() },
        );
        &axes * blocks * axes.clone().try_inverse().expect("the axes are independent")
    }

    #[test]
    fn multipliers_are_the_two_greatest_eigenvalues() {
        let diagonal = |values: &[f64]| DMatrix::from_diagonal(&DVector::from_column_slice(values));
        let mut pair = diagonal(&[0.6, 0.6, 0.3, 0.01]);
        (pair[(0, 1)], pair[(1, 0)]) = (0.5, -0.5);
        let mut later_pair = diagonal(&[0.9, 0.3, 0.3, 0.01]);
        (later_pair[(1, 2)], later_pair[(2, 1)]) = (0.2, -0.2);
        for (blocks, first, second, cosine) in [
            (diagonal(&[-0.9, 0.5, 0.1, 1e-9]), 0.9, 0.5, -1.0),
            (diagonal(&[0.2, 0.1, 1.5, 1e-3]), 1.5, 0.2, 1.0),
            (later_pair, 0.9, 0.13_f64.sqrt(), 1.0),
            (pair, 0.61_f64.sqrt(), 0.61_f64.sqrt(), 0.6 / 0.61_f64.sqrt()),
        ] {
            let one = with_blocks(&blocks);
            for turn in [vec![one.clone()], vec![one.clone(), DMatrix::identity(4, 4)]] {
                let found = Monodromy::new(turn).multipliers().unwrap();
                let [a, b] = found.log_moduli;
                assert!(
                    (a - f64::ln(first)).abs() < 1e-8 && (b - f64::ln(second)).abs() < 1e-3,
                    "{found:?}"
                );
                assert!((found.cosine - cosine).abs() < 1e-8, "{found:?}");
            }
        }
    }

    /// Over 30 periods the second multiplier is far smaller than the rounding of the matrix.
    #[test]
    fn a_small_second_multiplier_keeps_its_digits() {
        let one = with_blocks(&DMatrix::from_diagonal(&DVector::from_column_slice(&[
            0.95, 0.05, 0.01,
        ])));
        let [first, second] = Monodromy::new(vec![one; 30]).multipliers().unwrap().log_moduli;
        assert!((first - 30.0 * 0.95_f64.ln()).abs() < 1e-9, "{first}");
        assert!((second - 30.0 * 0.05_f64.ln()).abs() < 1e-6, "{second}");
    }

    #[test]
    fn newtons_step_leads_to_the_fixed_point_and_an_orbit_goes_there_if_its_turn_is_nearly_linear() {
        let matrix = with_blocks(&DMatrix::from_diagonal(&DVector::from_column_slice(&[0.9, -0.5, 1e-5])));
        let map = Monodromy::new(vec![matrix.clone()]);
        let fixed = DVector::from_column_slice(&[1.0, -2.0, 0.5]);
        let from = DVector::from_column_slice(&[0.3, 0.1, -0.2]);
        let moved = &matrix * &from - &from;
        let step = DVector::from_vec(map.newton_step(moved.as_slice()).unwrap());
        assert!((&fixed + &from + step - &fixed).norm() < 1e-12);
        let to = &matrix * &from;
        assert!(map.attracts(from.as_slice(), to.as_slice()));
        assert!(!map.attracts(from.as_slice(), (to * 2.0).as_slice()));
    }

    #[test]
    fn a_matrix_that_is_not_finite_has_no_multipliers() {
        assert!(
            Monodromy::new(vec![DMatrix::from_element(3, 3, f64::NAN)])
                .multipliers()
                .is_none()
        );
    }
}
