//! The monodromy matrix of a cycle: the tangent map of one turn.
//!
//! Owns its Floquet multipliers, and the step of Newton's method towards the cycle; integrates nothing.

use nalgebra::{Matrix2, Vector2};

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

    /// The step of Newton's method from a state to the cycle, given how far one turn has moved the state. None if M has the
    /// eigenvalue 1.
    pub fn newton_step(&self, moved: [f64; 2]) -> Option<[f64; 2]> {
        let inverse = (Matrix2::identity() - self.matrix()).try_inverse()?;
        Some((inverse * Vector2::from(moved)).into())
    }

    /// Whether an orbit goes to the cycle, whose deviation from it is `from`, and `to` one turn later. The turn need not be that of M
    /// exactly: it may differ by half of what M contracts. Deviations are measured by the length of their whole future, the sum of
    /// their squares over all turns, which decreases in every turn if M alone decides.
    pub fn attracts(&self, from: [f64; 2], to: [f64; 2]) -> bool {
        let (from, to) = (Vector2::from(from), Vector2::from(to));
        let matrix = self.matrix();
        let (mut future, mut power) = (Matrix2::identity(), matrix);
        for _ in 0..DOUBLINGS {
            future += power.transpose() * future * power;
            power *= power;
        }
        let measure = |v: Vector2<f64>| v.dot(&(future * v)).sqrt();
        let expected = matrix * from;
        measure(to - expected) < 0.5 * (measure(from) - measure(expected))
    }

    /// The eigenvalues of M.
    pub fn multipliers(&self) -> Multipliers {
        let half = 0.5 * self.log_determinant;
        // the greatest factor is kept as a logarithm, because it overflows over long turns
        let logs = self.images.map(|image| image.growth - half);
        let greatest = logs[0].max(logs[1]);
        let basis = [self.first, across(self.first)];
        let trace: f64 = (0..2)
            .map(|i| (logs[i] - greatest).exp() * dot(self.images[i].direction, basis[i]))
            .sum();
        Multipliers {
            half_log_determinant: half,
            half_trace: 0.5 * trace,
            log_scale: greatest,
        }
    }
}

/// The eigenvalues mu_1, mu_2 of a monodromy matrix, |mu_1| >= |mu_2|, in logarithms, since products of many stiff periods
/// overflow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Multipliers {
    /// ln of the square root of the determinant, which is positive for a flow.
    half_log_determinant: f64,
    /// Half of the trace over the square root of the determinant is this times the exponential of `log_scale`.
    half_trace: f64,
    log_scale: f64,
}

/// Turns, as a power of two, after which nothing is left of a deviation.
const DOUBLINGS: u32 = 16;

/// Largest relative rounding error of an area from which the error of a scheme is seen.
const BLURRED: f64 = 1e-6;

/// If the logarithm of cosh is above this, cosh is half of exp, to rounding.
const LARGE: f64 = 20.0;

impl Multipliers {
    /// ln |mu_1| and ln |mu_2|; divided by the time of a turn, they are the exponents.
    pub fn log_moduli(&self) -> [f64; 2] {
        // the half trace is the cosine of an angle if it is below 1, and else a hyperbolic cosine; NaN stays NaN
        let log = self.half_trace.abs().ln() + self.log_scale;
        let spread = if log > LARGE {
            log + std::f64::consts::LN_2
        } else if log < 0.0 {
            0.0
        } else {
            log.exp().acosh()
        };
        [self.half_log_determinant + spread, self.half_log_determinant - spread]
    }

    /// mu_1 if it is real, else 0: the factor of the distance from an attracting cycle in one turn.
    pub fn leading(&self) -> f64 {
        let scaled_trace = self.half_trace * self.log_scale.min(LARGE).exp();
        if scaled_trace.abs() < 1.0 {
            0.0
        } else {
            self.log_moduli()[0].exp().copysign(scaled_trace)
        }
    }

    /// |1 - mu_1|: the distance that an orbit moves in a turn, over its distance from an attracting cycle.
    pub fn distance_from_one(&self) -> f64 {
        let modulus = self.log_moduli()[0].exp();
        // the cosine of mu_1's angle: 1 or -1 for real multipliers
        let cosine = (self.half_trace * self.log_scale.min(LARGE).exp()).clamp(-1.0, 1.0);
        (1.0 - 2.0 * modulus * cosine + modulus * modulus).max(0.0).sqrt()
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
                for (found, expected) in multipliers.log_moduli().iter().zip(&expected) {
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
            let step = monodromy(matrix, first).newton_step(moved.into()).unwrap();
            assert!((state + Vector2::from(step) - fixed).norm() < 1e-14);
        }
        let neutral = Matrix2::new(1.0, 1.0, 0.0, 0.5);
        assert!(monodromy(neutral, [1.0, 0.0]).newton_step(moved.into()).is_none());
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
            assert!(monodromy.attracts(from.into(), (sheared * from).into()));
            assert!(!monodromy.attracts(from.into(), (2.0 * sheared * from).into()));
            assert!(!monodromy.attracts(from.into(), (-sheared * from).into()));
        }
        let saddle = Matrix2::new(1.1, 0.0, 0.0, 0.2);
        assert!(!monodromy(saddle, [1.0, 0.0]).attracts(from.into(), (saddle * from).into()));
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
        let [largest, smallest] = stiff.multipliers().log_moduli();
        assert!((largest + 5.0).abs() < 1e-9 && (smallest + 600.0).abs() < 1e-9);
        assert!(stiff.newton_step([1e-3, 0.0]).is_some());
    }
}
