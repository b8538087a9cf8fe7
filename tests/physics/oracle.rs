//! The bush's motion written a second time, as the paper prints it: friction by cases, textbook Runge-Kutta, time as a
//! sum. It shares no line with the library, so that a mistake in one does not hide in the other.

use std::f64::consts::PI;

use nalgebra::{Complex, Matrix2};
use tribochaos::parameters::{Parameter, ParameterSet};

/// F(v) of equation (3.2) with the regularised sign (3.1).
pub fn friction(p: &ParameterSet, v: f64) -> f64 {
    let epsilon_0 = p[Parameter::Epsilon0];
    let sign = if v.abs() >= epsilon_0 {
        v.signum()
    } else {
        (2.0 - v.abs() / epsilon_0) * v / epsilon_0
    };
    p[Parameter::F0] * sign - p[Parameter::Alpha] * v + p[Parameter::Beta] * v.powi(3)
}

/// The right-hand side of equation (3.2).
fn slope(p: &ParameterSet, tau: f64, [x, y]: [f64; 2]) -> [f64; 2] {
    let v = p[Parameter::OmegaK] + p[Parameter::ZetaK] * (p[Parameter::Omega0] * tau).sin() - y;
    let acceleration = x - p[Parameter::B] * x.powi(3) + p[Parameter::Epsilon] * friction(p, v)
        - p[Parameter::Epsilon] * p[Parameter::H1] * y;
    [y, acceleration]
}

pub fn period_time(p: &ParameterSet) -> f64 {
    2.0 * PI / p[Parameter::Omega0]
}

/// Carries a state from `tau` on by one step of `h`.
pub fn step(p: &ParameterSet, tau: f64, h: f64, [x, y]: [f64; 2]) -> [f64; 2] {
    let k1 = slope(p, tau, [x, y]);
    let k2 = slope(p, tau + h / 2.0, [x + h / 2.0 * k1[0], y + h / 2.0 * k1[1]]);
    let k3 = slope(p, tau + h / 2.0, [x + h / 2.0 * k2[0], y + h / 2.0 * k2[1]]);
    let k4 = slope(p, tau + h, [x + h * k3[0], y + h * k3[1]]);
    let sum = |i: usize| h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
    [x + sum(0), y + sum(1)]
}

/// The state `periods` forcing periods after one at drive phase 0.
pub fn after_periods(p: &ParameterSet, state: [f64; 2], periods: u32, steps_per_period: u32) -> [f64; 2] {
    let h = period_time(p) / f64::from(steps_per_period);
    (0..periods * steps_per_period).fold(state, |state, n| step(p, f64::from(n) * h, h, state))
}

/// Real parts of the eigenvalues of the Jacobian at a fixed point with angle `x`, the larger first, for friction that
/// is linear (f_0 = beta = 0) or met at a sliding speed beyond the layer.
pub fn fixed_point_exponents(p: &ParameterSet, x: f64) -> [f64; 2] {
    let v = p[Parameter::OmegaK];
    let friction_slope = -p[Parameter::Alpha] + 3.0 * p[Parameter::Beta] * v * v;
    #[rustfmt::skip]
    let jacobian = Matrix2::new(
        0.0, 1.0,
        1.0 - 3.0 * p[Parameter::B] * x * x, -p[Parameter::Epsilon] * (friction_slope + p[Parameter::H1]),
    );
    let eigenvalues: [Complex<f64>; 2] = jacobian.complex_eigenvalues().into();
    let [a, b] = eigenvalues.map(|eigenvalue| eigenvalue.re);
    [a.max(b), a.min(b)]
}

/// The greatest x with x - b x^3 + eps F(omega_k) = 0, where the bush rests on a shaft of constant speed.
pub fn greatest_fixed_point(p: &ParameterSet) -> f64 {
    let force = p[Parameter::Epsilon] * friction(p, p[Parameter::OmegaK]);
    let b = p[Parameter::B];
    // Newton from above the greatest root of a cubic falls monotonically to it
    (0..100).fold(1.0 + (1.0 + force.abs()) / b, |x, _| {
        x - (x - b * x.powi(3) + force) / (1.0 - 3.0 * b * x * x)
    })
}
