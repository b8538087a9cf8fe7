//! Stroboscopic states of many instances.
//!
//! Owns the passage from a backend to states; every analysis of stroboscopic states gets them here, whatever the scheme.
//! Knows nothing of what states are for.

use super::Progress;
use crate::backend::{Backend, BackendError, EndState, Instance, Slice, Stage, check_model};
use crate::experiment::Settings;

/// Longest slice, so that progress shows and the work can be broken off.
const LONGEST_SLICE: u32 = 16;

/// Integrates instances from their states over `settings.sampling.transient_periods` and then `sampling.periods` forcing periods.
/// At the end of each of the `sampling.periods`, at drive phase 0, `visit(instance, [x, y])` is called for every instance that
/// has neither run away nor been given up. Returns the states at the end, in the order of the instances; None if `progress` broke
/// the work off.
///
/// # Errors
/// If the backend fails, or the scheme that was asked for does not carry the heat and wear of an instance.
pub fn stroboscopic_states(
    backend: &mut dyn Backend,
    settings: &Settings,
    instances: &[Instance],
    visit: &mut dyn FnMut(usize, [f64; 2]),
    progress: &mut Progress<'_>,
) -> Result<Option<Vec<EndState>>, BackendError> {
    check_model(&settings.integration, instances)?;
    let mut all_ends = Vec::with_capacity(instances.len());
    let batch_size = backend.batch_size(settings);
    for batch in instances.chunks(batch_size) {
        backend.load(settings, batch)?;
        let first_instance = all_ends.len();
        let mut ends = Vec::new();
        let total = settings.sampling.transient_periods + settings.sampling.periods;
        let mut elapsed = 0;
        while elapsed < total {
            let visited = elapsed >= settings.sampling.transient_periods;
            let periods = if visited {
                1
            } else {
                LONGEST_SLICE.min(settings.sampling.transient_periods - elapsed)
            };
            backend.advance(&Slice {
                stage: Stage::Transient,
                first: elapsed,
                periods,
                elapsed,
            })?;
            elapsed += periods;
            if visited {
                ends = backend.end_states()?;
                for (index, end) in ends.iter().enumerate().filter(|(_, end)| is_bounded(end)) {
                    visit(first_instance + index, [end.x, end.y]);
                }
            }
            if progress(u64::from(periods) * batch.len() as u64).is_break() {
                return Ok(None);
            }
        }
        all_ends.append(&mut ends);
    }
    Ok(Some(all_ends))
}

/// Whether an instance has neither run away nor been given up.
pub fn is_bounded(end: &EndState) -> bool {
    end.runaway_periods.is_none() && !end.under_resolved
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use crate::analysis::path::{PathPoint, path};
    use crate::backend::cpu::CpuBackend;
    use crate::experiment::{Precision, Sampling, Scheme};
    use crate::parameters::{Parameter, ParameterSet};

    fn settings(transient_periods: u32, periods: u32) -> Settings {
        Settings {
            sampling: Sampling {
                transient_periods,
                periods,
                ..Sampling::default()
            },
            ..Settings::default()
        }
    }

    #[test]
    fn stroboscopic_states_are_those_of_the_path() {
        // the steps of radau end at the points of a path, so that their errors differ from those of steps without these points
        for (scheme, bound) in [(Scheme::Taylor, 1e-6), (Scheme::Rk4, 1e-6), (Scheme::Radau, 1e-3)] {
            let settings = Settings {
                integration: scheme.into(),
                ..settings(5, 16)
            };
            assert_agreement(&settings, bound);
        }
    }

    fn assert_agreement(settings: &Settings, bound: f64) {
        let points: Vec<ParameterSet> = (0..70)
            .map(|k| ParameterSet::default().with(Parameter::ZetaK, 0.05 * f64::from(k)))
            .collect();
        let mut states = vec![Vec::new(); points.len()];
        let ends = stroboscopic_states(
            &mut CpuBackend::new(Precision::F64),
            settings,
            &Instance::starts(&points),
            &mut |instance, state| states[instance].push(state),
            &mut |_| ControlFlow::Continue(()),
        )
        .unwrap()
        .unwrap();
        assert_eq!(ends.len(), points.len());
        for (point, states) in points.iter().zip(&states) {
            let path = path(point, settings, 100).points;
            let strobes: Vec<&PathPoint> = path.iter().filter(|point| point.is_stroboscopic).collect();
            assert_eq!((strobes.len(), states.len()), (17, 16));
            for (strobe, [x, y]) in strobes[1..].iter().zip(states) {
                assert!((strobe.x - x).abs() < bound && (strobe.y - y).abs() < bound);
            }
            let period = point.forcing_period();
            assert!((path.last().unwrap().tau - 16.0 * period).abs() < 1e-9);
            assert!(path.windows(2).all(|pair| pair[0].tau < pair[1].tau) && path.len() >= 16 * 100);
        }
    }

    #[test]
    fn orbits_that_run_away_are_left_out_from_then_on() {
        // without the cubic spring the saddle repels for ever
        let runaway = ParameterSet::default().with(Parameter::B, -1.0);
        let instances = [runaway, ParameterSet::default()].map(Instance::from);
        let mut counts = [0; 2];
        let ends = stroboscopic_states(
            &mut CpuBackend::new(Precision::F64),
            &settings(10, 20),
            &instances,
            &mut |instance, _| counts[instance] += 1,
            &mut |_| ControlFlow::Continue(()),
        )
        .unwrap()
        .unwrap();
        assert_eq!(counts, [0, 20]);
        assert!(!is_bounded(&ends[0]) && is_bounded(&ends[1]));
        assert!(path(&runaway, &settings(0, 20), 10).points.len() < 20 * 10);
    }

    #[test]
    fn work_can_be_broken_off() {
        let broken = stroboscopic_states(
            &mut CpuBackend::new(Precision::F64),
            &settings(100, 100),
            &[ParameterSet::default().into()],
            &mut |_, _| panic!("broken off before"),
            &mut |_| ControlFlow::Break(()),
        );
        assert!(broken.unwrap().is_none());
    }
}
