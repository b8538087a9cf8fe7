//! What the tests of physics share: settings that pin every number, points, and measuring them on a backend.

#![allow(dead_code, reason = "every test file uses some of the helpers, none uses all")]

use std::ops::ControlFlow;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use tribochaos::backend::cpu::CpuBackend;
use tribochaos::backend::{Backend, Instance};
use tribochaos::experiment::{Integration, Precision, Sampling, Scheme, Settings};
use tribochaos::measure::{Measurement, measure_batch};
use tribochaos::parameters::{Parameter, ParameterSet};

/// Settings with every number that enters a result written out, so that a changed default moves no reference value.
pub fn pinned_settings() -> Settings {
    Settings {
        integration: Integration {
            steps_per_period: 628,
            renormalise_every: 157,
            ..Integration::from(Scheme::Rk4)
        },
        sampling: Sampling {
            transient_periods: 300,
            align_periods: 50,
            periods: 300,
            decide_early: false,
            period_tolerance: 1e-4,
            ..Sampling::default()
        },
    }
}

/// The default parameters with some replaced.
pub fn point(values: &[(Parameter, f64)]) -> ParameterSet {
    values.iter().fold(ParameterSet::default(), |set, &(parameter, value)| {
        set.with(parameter, value)
    })
}

/// The point, started from (x, y).
pub fn from_state(point: ParameterSet, [x, y]: [f64; 2]) -> ParameterSet {
    point.with(Parameter::X0, x).with(Parameter::Y0, y)
}

pub fn measure_on(backend: &mut dyn Backend, settings: &Settings, points: &[ParameterSet]) -> Vec<Measurement> {
    let instances = Instance::starts(points);
    measure_batch(backend, settings, &instances, &mut |_| ControlFlow::Continue(()))
        .expect("the backend does not fail")
        .expect("nobody breaks the run off")
}

pub fn measure(precision: Precision, settings: &Settings, points: &[ParameterSet]) -> Vec<Measurement> {
    measure_on(&mut CpuBackend::new(precision), settings, points)
}

pub const PRECISIONS: [Precision; 2] = [Precision::F64, Precision::F32];

/// Numbers that look random and are the same in every run.
pub struct Random(ChaCha8Rng);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Uniform in `low..high`.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64)
    }
}
