//! States of orbits, as the analyses need them: stroboscopic states of many instances, and the path of one.
//!
//! Owns the passage from a stepping scheme to states; every other analysis gets its states here, so that a scheme is
//! exchanged in one place. Knows nothing of what states are for.

use std::f64::consts::TAU;

use super::Progress;
use crate::backend::{Backend, BackendError, EndState, Slice, Stage};
use crate::dynamics::drive::DriveTable;
use crate::dynamics::rk4::{self, StageSpeeds, State, StepSize};
use crate::experiment::Settings;
use crate::measurement::RUNAWAY_BOUND;
use crate::model::motion::Motion;
use crate::parameters::{Parameter, ParameterSet};

/// Longest slice, so that progress shows and the work can be broken off.
const LONGEST_SLICE: u32 = 16;

/// Carries instances from their initial states over `settings.transient_periods` and then `settings.periods` forcing
/// periods; `visit(instance, [x, y])` is called at the end of each of the latter, at drive phase 0, for every instance that
/// has not run away. Returns the states at the end, in the order of the instances; None if `progress` broke the work off.
///
/// # Errors
/// If the backend fails.
pub fn stroboscopic_states(
    backend: &mut dyn Backend,
    settings: &Settings,
    instances: &[ParameterSet],
    visit: &mut dyn FnMut(usize, [f64; 2]),
    progress: &mut Progress<'_>,
) -> Result<Option<Vec<EndState>>, BackendError> {
    let mut all_ends = Vec::with_capacity(instances.len());
    let batch_size = backend.batch_size();
    for batch in instances.chunks(batch_size) {
        backend.load(settings, batch)?;
        let first_instance = all_ends.len();
        let mut ends = Vec::new();
        let total = settings.transient_periods + settings.periods;
        let mut elapsed = 0;
        while elapsed < total {
            let visited = elapsed >= settings.transient_periods;
            let periods = if visited {
                1
            } else {
                LONGEST_SLICE.min(settings.transient_periods - elapsed)
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

/// Whether an instance has not run away.
pub fn is_bounded(end: &EndState) -> bool {
    end.runaway_period.is_none()
}

/// A point on the path of an orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// Time since the end of the transient, in units of tau.
    pub tau: f64,
    pub x: f64,
    pub y: f64,
    /// Whether the drive's phase is 0 here: the point belongs to the stroboscopic section.
    pub is_stroboscopic: bool,
}

/// The path of one orbit in f64 over `settings.periods` forcing periods after `settings.transient_periods`, about
/// `points_per_period` points a period, both ends included; where the orbit runs away, the path ends.
pub fn path(parameters: &ParameterSet, settings: &Settings, points_per_period: u32) -> Vec<PathPoint> {
    let steps = settings.steps_per_period;
    let every = (steps / points_per_period).max(1);
    let h = TAU / (parameters[Parameter::Omega0] * f64::from(steps));
    let motion: Motion<f64> = Motion::new(|parameter| parameters[parameter]);
    let step_size = StepSize::new(|_| h);
    let drive = DriveTable::new::<f64>(steps);
    let mut state = State {
        x: parameters[Parameter::X0],
        y: parameters[Parameter::Y0],
    };
    let mut points = Vec::new();
    let mut record = |period: u32, step: u32, state: State<f64>| {
        let since = period - settings.transient_periods;
        points.push(PathPoint {
            tau: h * (f64::from(since) * f64::from(steps) + f64::from(step)),
            x: state.x,
            y: state.y,
            is_stroboscopic: step == 0,
        });
    };
    for period in 0..settings.transient_periods + settings.periods {
        let is_shown = period >= settings.transient_periods;
        let mut start = motion.shaft_speed(0.0);
        for (step, &[middle, end]) in (0..steps).zip(drive.steps()) {
            if is_shown && step % every == 0 {
                record(period, step, state);
            }
            let speed = StageSpeeds {
                start,
                middle: motion.shaft_speed(middle),
                end: motion.shaft_speed(end),
            };
            state = rk4::step(&motion, &step_size, speed, state);
            start = speed.end;
        }
        // false for NaN too
        let is_bounded = state.x.abs() + state.y.abs() < RUNAWAY_BOUND;
        if !is_bounded {
            return points;
        }
    }
    record(settings.transient_periods + settings.periods, 0, state);
    points
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use crate::backend::cpu::CpuBackend;
    use crate::experiment::Precision;

    fn settings(transient_periods: u32, periods: u32) -> Settings {
        Settings {
            transient_periods,
            periods,
            ..Settings::default()
        }
    }

    #[test]
    fn stroboscopic_states_are_those_of_the_path() {
        let settings = settings(5, 16);
        let instances: Vec<ParameterSet> = (0..70)
            .map(|k| ParameterSet::default().with(Parameter::ZetaK, 0.05 * f64::from(k)))
            .collect();
        let mut states = vec![Vec::new(); instances.len()];
        let ends = stroboscopic_states(
            &mut CpuBackend::new(Precision::F64),
            &settings,
            &instances,
            &mut |instance, state| states[instance].push(state),
            &mut |_| ControlFlow::Continue(()),
        )
        .unwrap()
        .unwrap();
        assert_eq!(ends.len(), instances.len());
        for (instance, states) in instances.iter().zip(&states) {
            let path = path(instance, &settings, 100);
            let strobes: Vec<&PathPoint> = path.iter().filter(|point| point.is_stroboscopic).collect();
            assert_eq!((strobes.len(), states.len()), (17, 16));
            for (strobe, [x, y]) in strobes[1..].iter().zip(states) {
                assert!((strobe.x - x).abs() < 1e-6 && (strobe.y - y).abs() < 1e-6);
            }
            let period = TAU / instance[Parameter::Omega0];
            assert!((path.last().unwrap().tau - 16.0 * period).abs() < 1e-9);
            assert!(path.len() > 16 * 100);
        }
    }

    #[test]
    fn orbits_that_run_away_are_left_out_from_then_on() {
        // without the cubic spring the saddle repels for ever
        let runaway = ParameterSet::default().with(Parameter::B, -1.0);
        let instances = [runaway, ParameterSet::default()];
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
        assert!(path(&runaway, &settings(0, 20), 10).len() < 20 * 10);
    }

    #[test]
    fn work_can_be_broken_off() {
        let broken = stroboscopic_states(
            &mut CpuBackend::new(Precision::F64),
            &settings(100, 100),
            &[ParameterSet::default()],
            &mut |_, _| panic!("broken off before"),
            &mut |_| ControlFlow::Break(()),
        );
        assert!(broken.unwrap().is_none());
    }
}
