//! All three Lyapunov exponents as the paper computes them, equations (3.3), (3.5) and (3.6).
//!
//! Owns the plain f64 reference: the textbook Runge-Kutta scheme on (x, y, z) and three tangent vectors, kept simple
//! and independent of the fast path, which it checks.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};

use super::statistics;
use crate::experiment::{Scheme, Settings};
use crate::model::motion::Motion;
use crate::parameters::{Parameter, ParameterSet};

/// Exponents in the paper's order: the larger and the smaller of the two non-trivial ones, then the one along the flow, 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spectrum {
    /// Per unit of tau.
    pub exponents: [f64; 3],
    /// Their standard errors, by batch means.
    pub errors: [f64; 3],
}

/// The spectrum over the measured periods of the settings, after their transient. None if the orbit runs away.
pub fn lyapunov_spectrum(parameters: &ParameterSet, settings: &Settings) -> Option<Spectrum> {
    let orbit = Orbit::new(parameters, settings);
    let [x, y] = parameters.initial_state();
    let mut state = Vector3::new(x, y, 0.0);
    let mut basis = Matrix3::identity();
    for _ in 0..settings.sampling.transient_periods - settings.sampling.align_periods {
        orbit.period(&mut state, &mut Matrix3::zeros());
    }
    for _ in 0..settings.sampling.align_periods {
        orbit.period(&mut state, &mut basis);
    }
    // length in periods, and growth of each vector
    let batches: Vec<(f64, Vector3<f64>)> = statistics::batches(settings.sampling.periods)
        .into_iter()
        .map(|batch| {
            let length = batch.len() as f64;
            let growth = batch.map(|_| orbit.period(&mut state, &mut basis)).sum();
            (length, growth)
        })
        .collect();
    let period_time = TAU / parameters[Parameter::Omega0];
    let growth: Vector3<f64> = batches.iter().map(|(_, growth)| growth).sum();
    let exponents = growth / (f64::from(settings.sampling.periods) * period_time);
    let error = |n: usize| {
        let of_vector: Vec<_> = batches.iter().map(|(length, growth)| (*length, growth[n])).collect();
        statistics::standard_error(&of_vector) / period_time
    };
    let is_finite = exponents.iter().all(|exponent| exponent.is_finite());
    is_finite.then(|| Spectrum {
        exponents: exponents.into(),
        errors: std::array::from_fn(error),
    })
}

/// Steps in a forcing period with which this scheme agrees with the others to about 1e-4. It needs so many because its steps do
/// not end at the boundaries of the friction layer.
const FINE_STEPS: u32 = 5024;

struct Orbit {
    motion: Motion<f64>,
    omega_0: f64,
    steps: u32,
    renormalise_every: u32,
}

impl Orbit {
    fn new(parameters: &ParameterSet, settings: &Settings) -> Self {
        Self {
            motion: Motion::new(|parameter| parameters[parameter]),
            omega_0: parameters[Parameter::Omega0],
            steps: match settings.integration.scheme {
                Scheme::Rk4 => settings.integration.steps_per_period,
                Scheme::Taylor | Scheme::Radau => FINE_STEPS,
            },
            renormalise_every: settings.integration.renormalise_every,
        }
    }

    /// Carries the orbit over one forcing period; returns the logarithms of the vectors' growth.
    fn period(&self, state: &mut Vector3<f64>, basis: &mut Matrix3<f64>) -> Vector3<f64> {
        let h = TAU / (self.omega_0 * f64::from(self.steps));
        let mut growth = Vector3::zeros();
        state.z = 0.0;
        for step in 1..=self.steps {
            let (k1, j1) = self.slope(state, basis);
            let (k2, j2) = self.slope(&(*state + k1 * (h / 2.0)), &(*basis + j1 * (h / 2.0)));
            let (k3, j3) = self.slope(&(*state + k2 * (h / 2.0)), &(*basis + j2 * (h / 2.0)));
            let (k4, j4) = self.slope(&(*state + k3 * h), &(*basis + j3 * h));
            *state += (k1 + 2.0 * k2 + 2.0 * k3 + k4) * (h / 6.0);
            *basis += (j1 + 2.0 * j2 + 2.0 * j3 + j4) * (h / 6.0);
            if step % self.renormalise_every == 0 || step == self.steps {
                growth += orthonormalise(basis);
            }
        }
        growth
    }

    /// Right-hand sides of (3.2) and (3.3); the tangent vectors are the columns of `basis`.
    fn slope(&self, state: &Vector3<f64>, basis: &Matrix3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
        let (x, y, z) = (state.x, state.y, state.z);
        let speed = self.motion.shaft_speed(z.sin());
        let v = speed - y;
        let linearised = self.motion.linearised(x, v, speed);
        #[rustfmt::skip]
        let jacobian = Matrix3::new(
            0.0, 1.0, 0.0,
            linearised.by_x, linearised.by_y, self.motion.by_phase(v, z.cos()),
            0.0, 0.0, 0.0,
        );
        (Vector3::new(y, linearised.acceleration, self.omega_0), jacobian * basis)
    }
}

/// Gram-Schmidt orthonormalisation of the columns (3.5); returns the logarithms of the norms.
fn orthonormalise(basis: &mut Matrix3<f64>) -> Vector3<f64> {
    let mut logarithms = Vector3::zeros();
    for n in 0..3 {
        let mut vector = basis.column(n).clone_owned();
        for m in 0..n {
            let before = basis.column(m).clone_owned();
            vector -= before * before.dot(&vector);
        }
        let norm = vector.norm();
        logarithms[n] = norm.ln();
        basis.set_column(n, &(vector / norm));
    }
    logarithms
}
