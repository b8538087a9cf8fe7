//! Floquet multipliers of a cycle, from two turns of one tangent vector.
//!
//! Owns the eigenvalues of the monodromy matrix M, the tangent map of one turn, from growths and directions over two turns;
//! integrates nothing.
//!
//! The matrix itself is not needed. In the plane, M obeys M^2 = (trace) M - (determinant) (Cayley and Hamilton). For every vector
//! v0, v1 = M v0 and v2 = M v1 therefore obey v2 = (trace) v1 - (determinant) v0. The determinant is the product of the growth of
//! both tangent vectors.

/// The change of the tangent vectors in one turn of a cycle.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    /// Direction of the first vector before and after, of length 1.
    pub from: [f64; 2],
    pub to: [f64; 2],
    /// Logarithms of the growth of the first vector, and of the second, perpendicular to it.
    pub growth: [f64; 2],
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

/// If the logarithm of cosh is above this, cosh is half of exp, to rounding.
const LARGE: f64 = 20.0;

impl Multipliers {
    /// From two turns of a cycle; the second begins where the first ends.
    pub fn new(first: &Turn, second: &Turn) -> Self {
        let half = 0.25 * (first.growth.iter().sum::<f64>() + second.growth.iter().sum::<f64>());
        let [v0, v1, v2] = [first.from, first.to, second.to];
        // the component of v2 = (trace) v1 - (determinant) v0 along v1, divided by the length of v1, gives the trace; its
        // greatest factor is kept as a logarithm, because it overflows over long turns
        let logs = [second.growth[0] - half, half - first.growth[0]];
        let greatest = logs[0].max(logs[1]);
        let trace = (logs[0] - greatest).exp() * dot(v2, v1) + (logs[1] - greatest).exp() * dot(v0, v1);
        Self {
            half_log_determinant: half,
            half_trace: 0.5 * trace,
            log_scale: greatest,
        }
    }

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

    /// Two turns of a vector by a matrix, as a run gives them.
    fn turns(matrix: Matrix2<f64>, start: Vector2<f64>) -> [Turn; 2] {
        let mut vector = start.normalize();
        [(); 2].map(|()| {
            let next = matrix * vector;
            let turn = Turn {
                from: vector.into(),
                to: next.normalize().into(),
                growth: [next.norm().ln(), (matrix.determinant() / next.norm()).ln()],
            };
            vector = next.normalize();
            turn
        })
    }

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
            for start in [Vector2::new(1.0, 0.0), Vector2::new(0.6, 0.8), Vector2::new(-0.2, 1.0)] {
                let [first, second] = turns(matrix, start);
                let multipliers = Multipliers::new(&first, &second);
                for (found, expected) in multipliers.log_moduli().iter().zip(&expected) {
                    assert!((found - expected.norm().ln()).abs() < 1e-6, "{matrix}{start}");
                }
                let distance = (expected[0] - 1.0).norm();
                assert!(
                    (multipliers.distance_from_one() - distance).abs() < 1e-9,
                    "{matrix}{start}"
                );
            }
        }
    }

    #[test]
    fn a_vector_along_an_eigenvector_tells_both_multipliers() {
        let [first, second] = turns(Matrix2::new(0.5, 1.0, 0.0, 0.2), Vector2::new(1.0, 0.0));
        let [largest, smallest] = Multipliers::new(&first, &second).log_moduli();
        assert!((largest - 0.5_f64.ln()).abs() < 1e-14 && (smallest - 0.2_f64.ln()).abs() < 1e-14);
    }

    #[test]
    fn many_stiff_periods_neither_overflow_nor_vanish() {
        let turn = Turn {
            from: [0.6, 0.8],
            to: [0.6, 0.8],
            growth: [-5.0, -600.0],
        };
        let [largest, smallest] = Multipliers::new(&turn, &turn).log_moduli();
        assert!((largest + 5.0).abs() < 1e-9 && (smallest + 600.0).abs() < 1e-9);
    }
}
