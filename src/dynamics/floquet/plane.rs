//! The monodromy matrix of a cycle at constant contact pressure: the tangent map of one turn in (x, y).
//!
//! Owns its eigenvalues; integrates nothing.

use nalgebra::{Matrix2, Vector2};

use super::{Linearisation, Multipliers};

/// A tangent vector after one turn.
#[derive(Clone, Copy, Debug)]
pub struct Image {
    /// Its direction, of length 1.
    pub direction: [f64; 2],
    /// Logarithm of its growth.
    pub growth: f64,
}

/// The monodromy matrix M of a turn, from the images of two perpendicular vectors of length 1.
#[derive(Clone, Copy, Debug)]
pub struct Monodromy {
    /// The first vector; the second is perpendicular to it, a quarter turn to the left.
    pub first: [f64; 2],
    /// M applied to the first vector, and to the second.
    pub images: [Image; 2],
    /// Logarithm of the determinant, which is positive for a flow: the integral of the divergence. The images alone would give it
    /// with few digits where both have almost the same direction.
    pub log_determinant: f64,
}

/// The vector that is perpendicular to `vector`, a quarter turn to the left.
pub fn across([x, y]: [f64; 2]) -> [f64; 2] {
    [-y, x]
}

impl Monodromy {
    /// The matrix in (x, y). Its entries are infinite or 0 if they are too large or too small for a number.
    pub fn matrix(&self) -> Matrix2<f64> {
        let columns = self
            .images
            .map(|image| Vector2::from(image.direction) * image.growth.exp());
        let basis = Matrix2::from_columns(&[self.first.into(), across(self.first).into()]);
        Matrix2::from_columns(&columns) * basis.transpose()
    }

    /// By how much the logarithm of the area that both images span differs from that of the determinant: an error of the scheme.
    /// None if the images have so nearly the same direction that `rounding` blurs the area.
    pub fn area_defect(&self, rounding: f64) -> Option<f64> {
        let [first, second] = self.images;
        let sine = dot(across(first.direction), second.direction);
        (rounding < BLURRED * sine).then(|| first.growth + second.growth + sine.ln() - self.log_determinant)
    }

    /// The eigenvalues of M.
    pub fn multipliers(&self) -> Multipliers {
        let half = 0.5 * self.log_determinant;
        // the greatest factor is kept as a logarithm, because it overflows over long turns
        let logs = self.images.map(|image| image.growth - half);
        let log_scale = logs[0].max(logs[1]);
        let basis = [self.first, across(self.first)];
        let trace: f64 = (0..2)
            .map(|i| (logs[i] - log_scale).exp() * dot(self.images[i].direction, basis[i]))
            .sum();
        // half of the trace over the square root of the determinant is this times the exponential of log_scale: the cosine of an
        // angle if it is below 1, and else a hyperbolic cosine; NaN stays NaN
        let half_trace = 0.5 * trace;
        let log = half_trace.abs().ln() + log_scale;
        let spread = if log > LARGE {
            log + std::f64::consts::LN_2
        } else if log < 0.0 {
            0.0
        } else {
            log.exp().acosh()
        };
        Multipliers {
            log_moduli: [half + spread, half - spread],
            cosine: (half_trace * log_scale.min(LARGE).exp()).clamp(-1.0, 1.0),
        }
    }
}

/// Largest relative rounding error of an area from which the error of a scheme is seen.
const BLURRED: f64 = 1e-6;

/// If the logarithm of cosh is above this, cosh is half of exp, to rounding.
const LARGE: f64 = 20.0;

impl Linearisation for Monodromy {
    fn newton_step(&self, moved: &[f64]) -> Option<Vec<f64>> {
        let inverse = (Matrix2::identity() - self.matrix()).try_inverse()?;
        let step = inverse * Vector2::from_column_slice(moved);
        Some(vec![step.x, step.y])
    }

    fn attracts(&self, from: &[f64], to: &[f64]) -> bool {
        let [from, to] = [from, to].map(Vector2::from_column_slice);
        super::attracts(&self.matrix(), &from, &to)
    }
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

#[cfg(test)]
mod tests {
    use nalgebra::{Complex, Matrix2, Vector2};

    use super::*;

    /// The monodromy matrix as a run gives it that begins with the vector `first`.
    fn monodromy(matrix: Matrix2<f64>, first: [f64; 2]) -> Monodromy {
        let first: [f64; 2] = Vector2::from(first).normalize().into();
        Monodromy {
            first,
            images: [first, across(first)].map(|vector| {
                let image = matrix * Vector2::from(vector);
                Image {
                    direction: image.normalize().into(),
                    growth: image.norm().ln(),
                }
            }),
            log_determinant: matrix.determinant().ln(),
        }
    }

    const VECTORS: [[f64; 2]; 3] = [[1.0, 0.0], [0.6, 0.8], [-0.2, 1.0]];

    #[test]
    fn multipliers_are_the_eigenvalues_whatever_the_vector() {
        for matrix in [
            Matrix2::new(0.3, 0.1, -0.2, 0.5),
            Matrix2::new(-0.7, 2.0, 0.1, -0.4),
            Matrix2::new(0.6, -0.8, 0.7, 0.5),
            Matrix2::new(-0.1, -0.9, 0.5, -0.3),
            Matrix2::new(1.4, 0.0, 3.0, 1e-9),
        ] {
            let mut expected: Vec<_> = matrix.complex_eigenvalues().iter().copied().collect();
            expected.sort_by(|a: &Complex<f64>, b| b.norm().total_cmp(&a.norm()));
            for first in VECTORS {
                let monodromy = monodromy(matrix, first);
                assert!((monodromy.matrix() - matrix).norm() < 1e-14);
                let multipliers = monodromy.multipliers();
                for (found, expected) in multipliers.log_moduli.iter().zip(&expected) {
                    assert!((found - expected.norm().ln()).abs() < 1e-6, "{matrix}{first:?}");
                }
                let distance = (expected[0] - 1.0).norm();
                assert!(
                    (multipliers.distance_from_one() - distance).abs() < 1e-9,
                    "{matrix}{first:?}"
                );
            }
        }
    }

    #[test]
    fn newtons_step_leads_to_the_fixed_point_of_a_linear_map() {
        let matrix = Matrix2::new(0.3, 0.9, -0.2, 0.5);
        let (state, fixed) = (Vector2::new(0.4, -1.0), Vector2::new(0.1, 0.2));
        let moved = fixed + matrix * (state - fixed) - state;
        for first in VECTORS {
            let step = monodromy(matrix, first).newton_step(moved.as_slice()).unwrap();
            assert!((state + Vector2::from_vec(step) - fixed).norm() < 1e-14);
        }
        let neutral = Matrix2::new(1.0, 1.0, 0.0, 0.5);
        assert!(monodromy(neutral, [1.0, 0.0]).newton_step(moved.as_slice()).is_none());
    }

    /// The area is blurred where both images have nearly one direction.
    #[test]
    fn the_area_shows_what_a_scheme_missed() {
        let matrix = Matrix2::new(0.3, 0.9, -0.2, 0.5);
        for first in VECTORS {
            let exact = monodromy(matrix, first);
            assert!(exact.area_defect(1e-12).unwrap().abs() < 1e-14);
            let missed = Monodromy {
                log_determinant: exact.log_determinant - 0.01,
                ..exact
            };
            assert!((missed.area_defect(1e-12).unwrap() - 0.01).abs() < 1e-14);
            assert!(exact.area_defect(1e-3).is_none());
        }
        let flat = Matrix2::new(0.5, 1.0, 0.0, 1e-9);
        assert!(monodromy(flat, [0.6, 0.8]).area_defect(1e-12).is_none());
    }

    /// Shear lengthens a deviation for some turns before it shrinks.
    #[test]
    fn an_orbit_goes_to_a_cycle_if_its_turn_is_nearly_linear() {
        let sheared = Matrix2::new(0.9, 20.0, 0.0, 0.8);
        let from = Vector2::new(0.0, 1e-3);
        for first in VECTORS {
            let monodromy = monodromy(sheared, first);
            assert!(monodromy.attracts(from.as_slice(), (sheared * from).as_slice()));
            assert!(!monodromy.attracts(from.as_slice(), (2.0 * sheared * from).as_slice()));
            assert!(!monodromy.attracts(from.as_slice(), (-sheared * from).as_slice()));
        }
        let saddle = Matrix2::new(1.1, 0.0, 0.0, 0.2);
        assert!(!monodromy(saddle, [1.0, 0.0]).attracts(from.as_slice(), (saddle * from).as_slice()));
    }

    #[test]
    fn many_stiff_periods_neither_overflow_nor_vanish() {
        let image = |growth| Image {
            direction: [0.6, 0.8],
            growth,
        };
        let stiff = Monodromy {
            first: [0.6, 0.8],
            images: [image(-5.0), image(-700.0)],
            log_determinant: -605.0,
        };
        let [largest, smallest] = stiff.multipliers().log_moduli;
        assert!((largest + 5.0).abs() < 1e-9 && (smallest + 600.0).abs() < 1e-9);
        assert!(stiff.newton_step(&[1e-3, 0.0]).is_some());
    }
}
