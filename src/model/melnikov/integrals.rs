//! The half-line integrals of (A.1), in closed form.
//!
//! Owns their formulas; does not integrate.

use std::f64::consts::PI;

/// I_jkl = Int_0^inf y0^j sin^k(omega_0 t) cos^l(omega_0 t) dt along the homoclinic orbit of x'' = x - b x^3.
///
/// The formulas of I112, I130 and I310 replace the paper's longer ones, which are misprinted.
#[derive(Clone, Copy, Debug)]
#[allow(missing_docs, reason = "a field's name holds its j, k and l")]
pub struct Integrals {
    pub i200: f64,
    pub i400: f64,
    pub i110: f64,
    pub i111: f64,
    pub i201: f64,
    pub i220: f64,
    pub i202: f64,
    pub i310: f64,
    pub i112: f64,
    pub i130: f64,
}

impl Integrals {
    /// `omega_0` and `b` must be positive. Quotients by hyperbolic functions go to 0 for large omega_0, as they should.
    pub fn new(omega_0: f64, b: f64) -> Self {
        let w = PI * omega_0;
        let square = omega_0 * omega_0;
        let root = (2.0 * b).sqrt();
        let by_sinh = w / w.sinh();
        let [by_cosh_half, by_cosh, by_cosh_three_halves] = [0.5, 1.0, 1.5].map(|part| w / (part * w).cosh());
        Self {
            i200: 2.0 / (3.0 * b),
            i400: 8.0 / (35.0 * b * b),
            i110: -by_cosh_half / root,
            i111: -by_cosh / root,
            i201: (2.0 - square) / (6.0 * b) * (w / (0.5 * w).sinh()),
            i220: (by_sinh * (2.0 * square - 1.0) + 1.0) / (3.0 * b),
            i202: (by_sinh * (1.0 - 2.0 * square) + 1.0) / (3.0 * b),
            i310: -by_cosh_half * (11.0 + 10.0 * square - square * square) / (60.0 * b * root),
            i112: -(3.0 * by_cosh_three_halves + by_cosh_half) / (4.0 * root),
            i130: -3.0 * (by_cosh_half - by_cosh_three_halves) / (4.0 * root),
        }
    }
}
