//! How accurate a kernel's exponents are, compared with the reference integrator.
//!
//! Owns which points count and how errors are summed up; times nothing.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::{median, points_of_model, quantile};
use crate::backend::cpu::CpuBackend;
use crate::backend::{Backend, BackendError, Instance, Slice, Stage};
use crate::dynamics::reference::ReferenceOrbit;
use crate::experiment::{Integration, MAX_MODES, Precision, Sampling, Scheme, Settings};
use crate::parameters::{Parameter, ParameterSet};

/// Forcing periods over which exponents are compared, from the initial state on.
pub const PERIODS: u32 = 20;

/// Shift of the initial angle. A point counts if the shift changes its exponent by less than the same number.
const SENSITIVITY: f64 = 1e-6;

/// The bound on the change of the exponent for the full model: its reference is not more accurate than this.
const RUBBED_SENSITIVITY: f64 = 1e-5;

/// One of so many points is compared.
const STRIDE: usize = 9;

/// Points, each with its reference exponent over [`PERIODS`].
#[derive(Clone, Debug)]
pub struct References {
    points: Vec<(ParameterSet, f64)>,
}

impl References {
    /// Keeps the insensitive points: those whose exponent changes by less than 1e-6 if x0 changes by 1e-6. The others are
    /// chaotic, or meet the friction layer's boundary tangentially, and tell nothing of a scheme.
    pub fn compute(points: &[ParameterSet]) -> Self {
        let exponent = |point: &ParameterSet| {
            let mut orbit = ReferenceOrbit::new(point);
            (0..PERIODS).for_each(|_| orbit.period());
            orbit.state().growth / length(point)
        };
        let points = points
            .par_iter()
            .filter_map(|point| {
                let moved = point.with(Parameter::X0, point[Parameter::X0] + SENSITIVITY);
                let (reference, moved) = (exponent(point), exponent(&moved));
                ((reference - moved).abs() < SENSITIVITY).then_some((*point, reference))
            })
            .collect();
        Self { points }
    }

    /// References for every ninth point of the benchmark, of the full model or of the reduced one.
    pub fn of_model(rubbed: bool) -> Self {
        let points = points_of_model(rubbed, STRIDE);
        if rubbed {
            Self::compute_rubbed(&points)
        } else {
            Self::compute(&points)
        }
    }

    /// As [`References::compute`], for points of the full model. The reference is radau itself, at a tolerance of 1e-8 and with
    /// [`MAX_MODES`] heat modes: no other kind of integrator is fast enough.
    pub fn compute_rubbed(points: &[ParameterSet]) -> Self {
        let settings = Settings {
            integration: Integration {
                tolerance: 1e-8,
                modes: MAX_MODES,
                ..Integration::from(Scheme::Radau)
            },
            ..Settings::default()
        };
        let exponents = |points: &[ParameterSet]| {
            exponents(&mut CpuBackend::new(Precision::F64), &settings, points).expect("the CPU backend does not fail")
        };
        let moved: Vec<_> = points
            .iter()
            .map(|point| point.with(Parameter::X0, point[Parameter::X0] + SENSITIVITY))
            .collect();
        let points = points
            .iter()
            .zip(exponents(points).into_iter().zip(exponents(&moved)))
            .filter(|(_, (reference, moved))| (reference - moved).abs() < RUBBED_SENSITIVITY)
            .map(|(point, (reference, _))| (*point, reference))
            .collect();
        Self { points }
    }

    pub fn len(&self) -> usize {
        self.points.len()
    }

    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Errors of a backend's exponents with the settings' scheme.
    ///
    /// # Errors
    /// If the backend fails.
    pub fn errors(&self, backend: &mut dyn Backend, settings: &Settings) -> Result<Errors, BackendError> {
        let points: Vec<ParameterSet> = self.points.iter().map(|(point, _)| *point).collect();
        let found = exponents(backend, settings, &points)?;
        let pairs = found.iter().zip(&self.points);
        Ok(Errors(
            pairs.map(|(found, (_, reference))| (found - reference).abs()).collect(),
        ))
    }
}

/// Exponents over [`PERIODS`] from the start.
fn exponents(
    backend: &mut dyn Backend,
    settings: &Settings,
    points: &[ParameterSet],
) -> Result<Vec<f64>, BackendError> {
    let settings = Settings {
        sampling: Sampling {
            periods: PERIODS,
            ..settings.sampling
        },
        ..*settings
    };
    backend.load(&settings, &Instance::starts(points))?;
    backend.advance(&Slice {
        stage: Stage::Measure,
        first: 0,
        periods: PERIODS,
        elapsed: 0,
    })?;
    let sums = backend.collect()?;
    Ok(sums
        .iter()
        .zip(points)
        .map(|(sums, point)| sums.growth[0] / length(point))
        .collect())
}

/// Length of [`PERIODS`] in units of tau.
fn length(point: &ParameterSet) -> f64 {
    f64::from(PERIODS) * TAU / point[Parameter::Omega0]
}

/// Absolute errors of exponents.
#[derive(Clone, Debug)]
pub struct Errors(Vec<f64>);

impl Errors {
    /// The error that the given part of the points does not exceed.
    pub fn quantile(&self, part: f64) -> f64 {
        quantile(self.0.iter().copied(), part)
    }

    pub fn median(&self) -> f64 {
        median(self.0.iter().copied())
    }
}
