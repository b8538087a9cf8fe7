//! Several initial states for one point, because attractors coexist in this system.
//!
//! Owns which states are tried and how their measurements become that of the point; integrates nothing.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::backend::Instance;
use crate::design::uniform;
use crate::experiment::{Sampling, Settings};
use crate::measure::{Class, Measurement, Status};
use crate::parameters::ParameterSet;

/// The initial states besides (x0, y0): uniform in the box, the same for every point, reproducible from the seed.
pub fn offsets(sampling: &Sampling) -> Vec<[f64; 2]> {
    let mut generator = ChaCha8Rng::seed_from_u64(sampling.seed.into());
    let mut within = |[low, high]: [f64; 2]| low + (high - low) * uniform(&mut generator);
    (1..sampling.initial_states)
        .map(|_| [within(sampling.initial_box.x), within(sampling.initial_box.y)])
        .collect()
}

/// A point with each of its initial states; its own state (x0, y0) comes first.
pub fn points(point: ParameterSet, others: &[[f64; 2]]) -> impl Iterator<Item = ParameterSet> + '_ {
    let others = others.iter().map(move |&state| point.with_initial_state(state));
    std::iter::once(point).chain(others)
}

/// A run that has not settled is carried on to this multiple of its length, and then measured again.
const LONGER: u32 = 4;

/// The runs to carry on: their indices, and instances that start from their last states. These are the runs of points with
/// several initial states whose motion is bounded but has not surely settled. Runs with heat or wear cannot be carried on, since
/// their measurements have (x, y) alone, which is not their whole state.
pub fn unsettled(settings: &Settings, instances: &[Instance], measured: &[Measurement]) -> Vec<(usize, Instance)> {
    // an orbit that is classified as quasi-periodic may be a slow approach to a cycle
    let goes_on = |m: &Measurement| match m.class {
        Some(Class::Regular | Class::Undecided) => !m.has_settled(),
        Some(Class::QuasiPeriodic) => true,
        Some(Class::Chaotic | Class::Unstable) | None => false,
    };
    (0..instances.len())
        .filter(|&index| {
            settings.sampling.initial_states > 1
                && !instances[index].parameters.has_heat_or_wear()
                && goes_on(&measured[index])
        })
        .map(|index| {
            let Measurement { x, y, .. } = measured[index];
            (index, Instance::new(instances[index].parameters, [x, y]))
        })
        .collect()
}

/// The settings for the runs that are carried on: they have a longer transient.
pub fn carried_on(settings: &Settings) -> Settings {
    let length = settings
        .sampling
        .transient_periods
        .saturating_add(settings.sampling.periods);
    Settings {
        sampling: Sampling {
            transient_periods: length.saturating_mul(LONGER - 1).max(settings.sampling.align_periods),
            ..settings.sampling
        },
        ..*settings
    }
}

/// The measurement of a point: that of the initial state with the largest exponent. To it are added the fraction of the initial
/// states whose motion is chaotic, the number of distinct attractors on which states have settled, and the fraction of the states
/// whose motion is bounded but has not settled.
///
/// # Panics
/// If there is no measurement.
pub fn combine(measurements: &[Measurement], period_tolerance: f64) -> Measurement {
    let integrated_periods = measurements.iter().map(|m| m.integrated_periods).sum();
    let bounded: Vec<&Measurement> = measurements.iter().filter(|m| m.status == Status::Ok).collect();
    let Some(largest) = bounded.iter().max_by(|a, b| a.lyapunov.total_cmp(&b.lyapunov)) else {
        return Measurement {
            integrated_periods,
            ..measurements[0]
        };
    };
    let chaotic = bounded.iter().filter(|m| m.class == Some(Class::Chaotic)).count();
    let mut attractors: Vec<&Measurement> = Vec::new();
    for m in bounded.iter().filter(|m| m.has_settled()) {
        if !attractors
            .iter()
            .any(|known| same_attractor(known, m, period_tolerance))
        {
            attractors.push(m);
        }
    }
    Measurement {
        chaotic_fraction: chaotic as f64 / measurements.len() as f64,
        attractors: attractors.len() as u32,
        unsettled_fraction: bounded.iter().filter(|m| !m.has_settled()).count() as f64 / measurements.len() as f64,
        integrated_periods,
        ..**largest
    }
}

/// Whether two orbits lie on the same attractor, judged by class, period, range of x and exponent. The ranges of cycles must
/// agree within a hundred times the tolerance of the period. A run shows the range of other attractors less exactly: the overlap
/// of the two ranges must be at least half of their union, or nine tenths of it if the exponents differ by more than four
/// combined standard errors.
fn same_attractor(a: &Measurement, b: &Measurement, period_tolerance: f64) -> bool {
    if a.class != b.class || a.period != b.period {
        return false;
    }
    if a.period.is_some() {
        let near = |p: f64, q: f64| (p - q).abs() < 100.0 * period_tolerance;
        return near(a.x_min, b.x_min) && near(a.x_max, b.x_max);
    }
    let common = a.x_max.min(b.x_max) - a.x_min.max(b.x_min);
    let both = a.x_max.max(b.x_max) - a.x_min.min(b.x_min);
    let differ = (a.lyapunov - b.lyapunov).abs() > 4.0 * a.lyapunov_error.hypot(b.lyapunov_error);
    common >= if differ { 0.9 } else { 0.5 } * both
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::BackendKind;
    use crate::parameters::Parameter;

    fn orbit(class: Class, lyapunov: f64, period: Option<u32>, x_min: f64, x_max: f64) -> Measurement {
        let runaway = Measurement::runaway(1.0, BackendKind::CpuF64);
        Measurement {
            status: Status::Ok,
            class: Some(class),
            lyapunov,
            period,
            x_min,
            x_max,
            ..runaway
        }
    }

    #[test]
    fn the_largest_exponent_stands_for_the_point_and_attractors_are_counted() {
        let orbits = [
            orbit(Class::Regular, -0.2, Some(1), 0.5, 1.0),
            orbit(Class::Regular, -0.2, Some(1), 0.501, 1.0),
            orbit(Class::Regular, -0.3, Some(1), -1.0, -0.5),
            orbit(Class::Regular, -0.3, Some(2), 0.5, 1.0),
            orbit(Class::Chaotic, 0.10, None, -1.2, 1.5),
            orbit(Class::Chaotic, 0.12, None, -1.21, 1.48),
            Measurement::runaway(3.0, BackendKind::CpuF64),
            orbit(Class::Regular, -0.2, Some(1), 0.5, 1.0),
            orbit(Class::Regular, -0.01, None, 0.4, 1.1),
            orbit(Class::Undecided, 0.01, None, -1.3, 1.1),
        ];
        let point = combine(&orbits, 1e-4);
        assert_eq!((point.lyapunov, point.class), (0.12, Some(Class::Chaotic)));
        assert_eq!((point.chaotic_fraction, point.attractors), (0.2, 4));
        assert_eq!(point.unsettled_fraction, 0.2);
    }

    /// This holds only for points with several initial states, and without heat.
    #[test]
    fn what_is_bounded_and_has_not_settled_is_carried_on() {
        let runaway = Measurement::runaway(1.0, BackendKind::CpuF64);
        let cases = [
            (orbit(Class::Regular, -0.1, Some(3), 0.0, 1.0), false),
            (orbit(Class::Regular, -0.1, None, 0.0, 1.0), true),
            (orbit(Class::Undecided, 0.0, None, 0.0, 1.0), true),
            (orbit(Class::QuasiPeriodic, 0.0, None, 0.0, 1.0), true),
            (orbit(Class::Chaotic, 0.1, None, 0.0, 1.0), false),
            (orbit(Class::Unstable, 0.1, Some(1), 0.0, 1.0), false),
            (runaway, false),
        ];
        let measured: Vec<Measurement> = cases
            .iter()
            .map(|(m, _)| Measurement { x: 0.25, y: -0.5, ..*m })
            .collect();
        let expected: Vec<usize> = (0..cases.len()).filter(|&index| cases[index].1).collect();
        let carried = |initial_states, set: ParameterSet| {
            let settings = Settings {
                sampling: Sampling {
                    initial_states,
                    ..Sampling::default()
                },
                ..Settings::default()
            };
            unsettled(&settings, &vec![Instance::from(set); cases.len()], &measured)
        };
        let several = carried(2, ParameterSet::default());
        let indices: Vec<usize> = several.iter().map(|(index, _)| *index).collect();
        assert_eq!(indices, expected);
        for (_, instance) in several {
            assert_eq!(instance.state, [0.25, -0.5]);
        }
        assert!(carried(1, ParameterSet::default()).is_empty());
        assert!(carried(2, ParameterSet::default().with(Parameter::Gamma, 1.0)).is_empty());
    }

    /// The first run is one of the four lengths.
    #[test]
    fn it_is_measured_anew_after_four_lengths_of_its_run() {
        let settings = Settings {
            sampling: Sampling {
                transient_periods: 300,
                periods: 250,
                ..Sampling::default()
            },
            ..Settings::default()
        };
        let longer = carried_on(&settings).sampling;
        assert_eq!((550 + longer.transient_periods, longer.periods), (4 * 550, 250));
    }

    #[test]
    fn a_point_all_of_whose_states_run_away_has_run_away() {
        let runaway = Measurement {
            integrated_periods: 7,
            ..Measurement::runaway(3.0, BackendKind::CpuF64)
        };
        let point = combine(&[runaway, runaway], 1e-4);
        assert_eq!(point.status, Status::Runaway { time: 3.0 });
        assert_eq!(point.integrated_periods, 14);
    }

    #[test]
    fn states_are_reproducible_inside_the_box_and_differ_by_seed() {
        let sampling = Sampling {
            initial_states: 50,
            ..Sampling::default()
        };
        let states = offsets(&sampling);
        assert_eq!(states.len(), 49);
        assert_eq!(states, offsets(&sampling));
        assert!(states.iter().flatten().all(|value| (-2.0..2.0).contains(value)));
        assert_ne!(states, offsets(&Sampling { seed: 2, ..sampling }));
    }
}
