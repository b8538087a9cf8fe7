//! Stroboscopic sections of one attractor, with many points.
//!
//! Owns how many orbits share the work and where they begin; the states come from [`super::orbits`].

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::Progress;
use super::orbits::{is_bounded, stroboscopic_states};
use crate::backend::{Backend, BackendError, Instance};
use crate::experiment::{Sampling, Settings};
use crate::parameters::ParameterSet;

/// Orbits that share the work: enough to fill the lanes of all cores, few enough for the transients not to take most of it.
const ORBITS: u32 = 2048;

/// Half the side of the square of initial states around (x0, y0). It is so small that nearly all orbits reach the same attractor,
/// and so large that the orbits on a chaotic attractor part within some tens of periods.
pub const SPREAD: f64 = 1e-3;

/// Forcing periods before a section where a user asks for no number: its states are to be those of the attractor alone.
pub const TRANSIENT_PERIODS: u32 = 500;

/// How a section of so many states is divided.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// Orbits that share the work; fewer for a small section.
    pub orbits: u32,
    /// Forcing periods for each of the orbits.
    periods: u32,
}

impl Plan {
    /// The plan for at least `points` states.
    pub fn new(points: u64) -> Self {
        let orbits = u32::try_from(points.div_ceil(64)).unwrap_or(ORBITS).clamp(1, ORBITS);
        Self {
            orbits,
            periods: points.div_ceil(orbits.into()).try_into().unwrap_or(u32::MAX),
        }
    }

    /// The periods that an experiment for it must have: a measurement needs more than a small section.
    pub fn measured_periods(self) -> u32 {
        self.periods.max(Sampling::LEAST_PERIODS)
    }
}

/// States of an attractor at drive phase 0.
#[derive(Clone, Debug)]
pub struct Section {
    /// (x, y): for each period in turn, one state of every orbit.
    pub points: Vec<[f64; 2]>,
    /// Orbits that ran away, or that the scheme gave up as under-resolved.
    pub runaways: usize,
}

/// The stroboscopic section: `sampling.periods` states from each of `orbits` orbits that begin within [`SPREAD`] of
/// (x0, y0), after `settings.sampling.transient_periods`. None if `progress` broke the work off.
///
/// # Errors
/// If the backend fails.
pub fn section(
    backend: &mut dyn Backend,
    settings: &Settings,
    at: &ParameterSet,
    orbits: u32,
    progress: &mut Progress<'_>,
) -> Result<Option<Section>, BackendError> {
    let mut generator = ChaCha8Rng::seed_from_u64(settings.sampling.seed.into());
    let mut deviation = || ((generator.next_u64() >> 11) as f64 / (1u64 << 52) as f64 - 1.0) * SPREAD;
    let [x, y] = at.initial_state();
    let instances: Vec<Instance> = (0..orbits)
        .map(|orbit| {
            // the first orbit begins at (x0, y0) itself
            let [dx, dy] = if orbit == 0 {
                [0.0; 2]
            } else {
                [deviation(), deviation()]
            };
            Instance::new(*at, [x + dx, y + dy])
        })
        .collect();
    let mut points = Vec::with_capacity(orbits as usize * settings.sampling.periods as usize);
    let ends = stroboscopic_states(
        backend,
        settings,
        &instances,
        &mut |_, state| points.push(state),
        progress,
    )?;
    Ok(ends.map(|ends| Section {
        points,
        runaways: ends.iter().filter(|end| !is_bounded(end)).count(),
    }))
}

#[cfg(test)]
mod tests {
    use super::super::bifurcation::carry_on;
    use super::*;
    use crate::backend::cpu::CpuBackend;
    use crate::experiment::Precision;
    use crate::experiment::Sampling;

    #[test]
    fn orbits_of_a_section_have_parted_and_fill_the_attractor() {
        let settings = Settings {
            sampling: Sampling {
                transient_periods: 200,
                periods: 40,
                ..Sampling::default()
            },
            ..Settings::default()
        };
        let mut backend = CpuBackend::new(Precision::F64);
        let Section { points, runaways } =
            section(&mut backend, &settings, &ParameterSet::default(), 100, &mut carry_on)
                .unwrap()
                .unwrap();
        assert_eq!((points.len(), runaways), (4000, 0));
        // after the transient, the states of all orbits at one time are spread over a whole band of the attractor
        let extent = |points: &[[f64; 2]]| {
            let x = points.iter().map(|point| point[0]);
            x.clone().fold(f64::MIN, f64::max) - x.fold(f64::MAX, f64::min)
        };
        assert!(extent(&points[..100]) > 100.0 * SPREAD && extent(&points) < 4.0);
    }
}
