//! Compares two backends over a short run.
//!
//! Owns the comparison that distinguishes a faulty driver from rounding; the audit compares long runs.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::{Backend, BackendError, Instance, Slice, Stage};
use crate::experiment::Settings;
use crate::parameters::{Parameter, ParameterSet};

/// Differences between two backends after one plain and one measured forcing period.
#[derive(Clone, Copy, Debug)]
pub struct Twins {
    pub instances: usize,
    /// Median and largest difference of x and y.
    pub state: [f64; 2],
    /// Median and largest difference of the tangent vectors' logarithmic growth and of the integrated divergence.
    pub growth: [f64; 2],
}

/// Two f32 backends agree if no difference is above this. Rounding differs, and is magnified where the sliding velocity
/// grazes the friction layer.
pub const TOLERANCE: f64 = 1e-2;

/// Half of the differences must be below this.
pub const MEDIAN_TOLERANCE: f64 = 1e-5;

impl Twins {
    pub fn agree(&self) -> bool {
        [self.state, self.growth]
            .iter()
            .all(|[median, largest]| *median < MEDIAN_TOLERANCE && *largest < TOLERANCE)
    }
}

/// Runs both backends over the same random instances.
///
/// # Errors
/// If one of them fails.
pub fn compare(a: &mut dyn Backend, b: &mut dyn Backend) -> Result<Twins, BackendError> {
    let instances = random_instances(256);
    let [a, b] = [run(a, &instances)?, run(b, &instances)?];
    let differences = |index: fn(&[f64; 5]) -> &[f64]| {
        let mut all: Vec<f64> = a
            .iter()
            .zip(&b)
            .flat_map(|(a, b)| index(a).iter().zip(index(b)).map(|(a, b)| (a - b).abs()))
            // a value that is missing on a side (NaN) must not pass for agreement
            .map(|difference| if difference.is_nan() { f64::INFINITY } else { difference })
            .collect();
        all.sort_by(f64::total_cmp);
        [all[all.len() / 2], all[all.len() - 1]]
    };
    Ok(Twins {
        instances: instances.len(),
        state: differences(|v| &v[..2]),
        growth: differences(|v| &v[2..]),
    })
}

/// x, y, both growths and the divergence of each instance.
fn run(backend: &mut dyn Backend, instances: &[Instance]) -> Result<Vec<[f64; 5]>, BackendError> {
    backend.load(&Settings::default(), instances)?;
    backend.advance(&Slice {
        stage: Stage::Transient,
        first: 0,
        periods: 1,
        elapsed: 0,
    })?;
    backend.advance(&Slice {
        stage: Stage::Measure,
        first: 0,
        periods: 1,
        elapsed: 1,
    })?;
    let sums = backend.collect()?;
    let ends = backend.end_states()?;
    Ok(ends
        .iter()
        .zip(&sums)
        .map(|(end, sums)| [end.x, end.y, sums.growth[0], sums.growth[1], sums.divergence])
        .collect())
}

/// Random instances: every parameter is drawn from a range around its default. In these ranges motion stays bounded, and the
/// two tangent vectors do not become parallel, to f32, between two renormalisations.
fn random_instances(count: usize) -> Vec<Instance> {
    use Parameter::{Alpha, B, Beta, Epsilon, Epsilon0, F0, H1, Omega0, OmegaK, X0, Y0, ZetaK};
    let mut generator = ChaCha8Rng::seed_from_u64(1);
    let mut uniform = |low: f64, high: f64| low + (high - low) * f64::from(generator.next_u32()) / 4_294_967_296.0;
    (0..count)
        .map(|_| {
            [
                (ZetaK, 0.0, 12.0),
                (H1, 0.0, 2.0),
                (Omega0, 1.5, 3.0),
                (OmegaK, -1.0, 1.0),
                (B, 0.5, 2.0),
                (Epsilon, 0.0, 0.2),
                (F0, 0.0, 0.3),
                (Alpha, 0.0, 0.5),
                (Beta, 0.1, 0.5),
                (Epsilon0, 0.02, 0.1),
                (X0, -1.0, 1.0),
                (Y0, -1.0, 1.0),
            ]
            .into_iter()
            .fold(ParameterSet::default(), |set, (parameter, low, high)| {
                set.with(parameter, uniform(low, high))
            })
            .into()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::cpu::{CpuBackend, InstructionSet};
    use crate::experiment::Precision;

    #[test]
    fn every_instruction_set_is_the_twin_of_the_portable_one() {
        for set in InstructionSet::available() {
            for (precision, median) in [(Precision::F32, MEDIAN_TOLERANCE), (Precision::F64, 1e-13)] {
                let mut portable = CpuBackend::with_instructions(precision, InstructionSet::Portable);
                let mut other = CpuBackend::with_instructions(precision, set);
                let twins = compare(&mut portable, &mut other).unwrap();
                assert!(
                    twins.agree() && twins.state[0] < median,
                    "{set:?} {precision:?}: {twins:?}"
                );
            }
        }
    }

    #[test]
    fn different_arithmetic_is_told_apart() {
        struct Broken(CpuBackend);
        impl Backend for Broken {
            fn kind(&self) -> crate::backend::BackendKind {
                self.0.kind()
            }
            fn device(&self) -> String {
                self.0.device()
            }
            fn batch_size(&self, settings: &Settings) -> usize {
                self.0.batch_size(settings)
            }
            fn load(&mut self, settings: &Settings, instances: &[Instance]) -> Result<(), BackendError> {
                let mut bent = instances.to_vec();
                for instance in &mut bent {
                    instance.parameters[Parameter::Alpha] += 1e-3;
                }
                self.0.load(settings, &bent)
            }
            fn advance(&mut self, slice: &Slice) -> Result<(), BackendError> {
                self.0.advance(slice)
            }
            fn collect(&mut self) -> Result<Vec<crate::backend::Sums>, BackendError> {
                self.0.collect()
            }
            fn end_states(&mut self) -> Result<Vec<crate::backend::EndState>, BackendError> {
                self.0.end_states()
            }
        }
        let mut right = CpuBackend::new(Precision::F32);
        let mut broken = Broken(CpuBackend::new(Precision::F32));
        assert!(!compare(&mut right, &mut broken).unwrap().agree());
    }
}
