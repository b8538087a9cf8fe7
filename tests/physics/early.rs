//! Deciding early against runs at full length, and what is claimed of exponents against independent ones.

use nalgebra::Matrix2;
use tribochaos::backend::cpu::CpuBackend;
use tribochaos::backend::{Backend, Instance, Slice, Stage};
use tribochaos::dynamics::reference::ReferenceOrbit;
use tribochaos::experiment::{Precision, Request, Sampling, Scheme, Settings};
use tribochaos::measure::{Class, Measurement, Status};
use tribochaos::parameters::{Parameter, ParameterSet};

use crate::common::{PRECISIONS, from_state, measure};

/// Every `stride`-th point of the default map.
fn map_points(stride: usize) -> Vec<ParameterSet> {
    let grid = Request::default().resolve().unwrap().design;
    (0..grid.len()).step_by(stride).map(|index| grid.point(index)).collect()
}

fn full_length() -> Settings {
    Settings {
        sampling: Sampling {
            decide_early: false,
            ..Sampling::default()
        },
        ..Settings::default()
    }
}

fn is_decided_early(m: &Measurement) -> bool {
    let settings = Settings::default();
    m.integrated_periods < settings.sampling.transient_periods + settings.sampling.periods
}

#[test]
fn classes_are_those_of_runs_at_full_length_for_an_eighth_of_their_work() {
    let points = map_points(1);
    for precision in PRECISIONS {
        let full = measure(precision, &full_length(), &points);
        let early = measure(precision, &Settings::default(), &points);
        let share = |count: usize, of: usize| count as f64 / of as f64;
        let pairs = || early.iter().zip(&full);
        let decided = pairs().filter(|(m, _)| is_decided_early(m)).count();
        let same = pairs()
            .filter(|(m, f)| is_decided_early(m) && m.class == f.class)
            .count();
        assert!(share(same, decided) >= 0.999, "{precision:?}: {same} of {decided}");
        let chaotic = pairs().filter(|(_, f)| f.class == Some(Class::Chaotic)).count();
        let both = pairs()
            .filter(|(m, f)| f.class == Some(Class::Chaotic) && m.class == f.class)
            .count();
        assert!(share(both, chaotic) >= 0.99, "{precision:?}: {both} of {chaotic}");
        println!("{precision:?}: {same} of {decided} decided, {both} of {chaotic} chaotic");
        let periods = |measured: &[Measurement]| measured.iter().map(|m| m.integrated_periods as usize).sum::<usize>();
        println!("{:.4} of the work", share(periods(&early), periods(&full)));
        assert!(
            8 * periods(&early) < periods(&full),
            "{precision:?}: {}",
            periods(&early)
        );
        // one that is reached slowly may show as a multiple of itself in either
        let periods = || pairs().filter_map(|(m, f)| Some((m.period?, f.period?)));
        assert!(
            periods().all(|(m, f)| m.is_multiple_of(f) || f.is_multiple_of(m)),
            "{precision:?}"
        );
        let different = periods().filter(|(m, f)| m != f).count();
        assert!(10_000 * different < points.len(), "{precision:?}: {different}");
    }
}

/// A transient that is shorter than the first leg leaves no time to decide in: such a run is the one at full length.
#[test]
fn what_is_too_short_to_be_decided_early_runs_as_it_was_asked_to() {
    let points = [3.5, 3.9].map(|zeta_k| ParameterSet::default().with(Parameter::ZetaK, zeta_k));
    for transient_periods in [0, 1, 3] {
        let measured = |decide_early| {
            let settings = Settings {
                sampling: Sampling {
                    transient_periods,
                    align_periods: transient_periods.min(2),
                    periods: 64,
                    decide_early,
                    ..Sampling::default()
                },
                ..Settings::default()
            };
            // NaN is written alike, and equals nothing
            format!("{:#?}", measure(Precision::F64, &settings, &points))
        };
        assert_eq!(measured(true), measured(false), "{transient_periods}");
    }
}

/// Both leave an unstable cycle so slowly that vectors grow steadily for some two hundred periods; both end on a cycle of period 4.
#[test]
fn a_slow_departure_from_an_unstable_cycle_is_not_taken_for_chaos() {
    let points = [(4.04, 0.9), (4.52, 1.46)].map(|(zeta_k, h1)| {
        let point = ParameterSet::default().with(Parameter::ZetaK, zeta_k);
        point.with(Parameter::H1, h1)
    });
    let long = Settings {
        sampling: Sampling {
            transient_periods: 1000,
            periods: 1000,
            ..full_length().sampling
        },
        ..full_length()
    };
    for precision in PRECISIONS {
        for (m, f) in measure(precision, &Settings::default(), &points)
            .iter()
            .zip(measure(precision, &long, &points))
        {
            assert_eq!(
                (f.class, f.period),
                (Some(Class::Regular), Some(4)),
                "{precision:?} {f:?}"
            );
            assert_ne!(m.class, Some(Class::Chaotic), "{precision:?} {m:?}");
        }
    }
}

/// ln |mu_1| of the period map by finite differences of the reference integrator, which knows nothing of tangents, along a
/// cycle of `turn` forcing periods.
fn log_multiplier(point: &ParameterSet, state: [f64; 2], turn: u32) -> f64 {
    let map = |state: [f64; 2]| {
        let mut orbit = ReferenceOrbit::new(&from_state(*point, state));
        (0..turn).for_each(|_| orbit.period());
        [orbit.state().x, orbit.state().y]
    };
    let h = 1e-7;
    let column = |dx: f64, dy: f64| {
        let [a, b] = [1.0, -1.0].map(|sign| map([state[0] + sign * dx, state[1] + sign * dy]));
        [(a[0] - b[0]) / (2.0 * h), (a[1] - b[1]) / (2.0 * h)]
    };
    let ([a, c], [b, d]) = (column(h, 0.0), column(0.0, h));
    let multipliers = Matrix2::new(a, b, c, d).complex_eigenvalues();
    multipliers
        .iter()
        .map(|mu| mu.norm().ln())
        .fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn exponents_of_cycles_are_the_multipliers_of_the_period_map() {
    let points = map_points(601);
    let early = measure(Precision::F64, &Settings::default(), &points);
    let mut compared = 0;
    for (point, m) in points.iter().zip(&early) {
        let Some(period) = m.period.filter(|_| is_decided_early(m)) else {
            continue;
        };
        let time = f64::from(period) * point.forcing_period();
        let expected = log_multiplier(point, [m.x, m.y], period) / time;
        // strongly contracting cycles leave no digits to the differences
        if expected * time > -6.0 {
            assert!((m.lyapunov - expected).abs() < 2e-4, "{expected} {point:?} {m:?}");
            compared += 1;
        }
    }
    assert!(compared > 80, "{compared}");
}

/// In 95 % of the cases, give or take 3, two standard errors of the difference cover it. One sample of the map's chaotic
/// points leaves a percent to chance: three are taken, from initial angles so near that only chaos tells them apart.
#[test]
fn the_error_claimed_for_chaos_covers_a_disjoint_run_ten_times_longer() {
    let longer = Settings {
        sampling: Sampling {
            transient_periods: 300,
            periods: 2000,
            ..full_length().sampling
        },
        ..full_length()
    };
    let (mut covered, mut compared) = (0, 0);
    for moved in [0.0, 1e-6, 2e-6] {
        let points: Vec<_> = map_points(3)
            .iter()
            .map(|point| point.with(Parameter::X0, point[Parameter::X0] + moved))
            .collect();
        let short = measure(Precision::F64, &Settings::default(), &points);
        let (points, short): (Vec<_>, Vec<_>) = points
            .into_iter()
            .zip(short)
            .filter(|(_, m)| m.class == Some(Class::Chaotic) && is_decided_early(m))
            .unzip();
        let long = measure(Precision::F64, &longer, &points);
        // chaos that has ended meanwhile was none to last
        for (s, l) in short.iter().zip(&long).filter(|(_, l)| l.class == Some(Class::Chaotic)) {
            compared += 1;
            covered += u32::from((s.lyapunov - l.lyapunov).abs() < 2.0 * s.lyapunov_error.hypot(l.lyapunov_error));
        }
    }
    let share = f64::from(covered) / f64::from(compared);
    println!("{covered} of {compared}");
    assert!(
        compared > 1800 && (0.92..0.98).contains(&share),
        "{covered} of {compared}"
    );
}

/// Chaos in bands that the orbit leaves and changes after some hundred periods: two standard errors of the difference to a
/// disjoint longer run, and the mean of all that are chaotic, which early decisions would make too large.
#[test]
fn the_error_claimed_for_intermittent_chaos_covers_a_longer_run() {
    let intermittent = [
        (Parameter::Omega0, 1.774),
        (Parameter::Alpha, 0.1028),
        (Parameter::Beta, 0.3583),
        (Parameter::F0, 0.4319),
        (Parameter::ZetaK, 3.5998),
        (Parameter::H1, 1.446),
    ]
    .iter()
    .fold(ParameterSet::default(), |set, &(parameter, value)| {
        set.with(parameter, value)
    });
    let side = |i: u32| -1.5 + 3.0 * f64::from(i) / 39.0;
    let points: Vec<_> = (0..1600)
        .map(|i| from_state(intermittent, [side(i % 40), side(i / 40)]))
        .collect();
    let long = Settings {
        sampling: Sampling {
            transient_periods: 600,
            periods: 4000,
            ..full_length().sampling
        },
        ..full_length()
    };
    let long = measure(Precision::F64, &long, &points);
    for settings in [Settings::default(), full_length()] {
        let short = measure(Precision::F64, &settings, &points);
        // those with a low mean are undecided: of the chaotic ones alone the mean is 5 % too high
        let pairs: Vec<_> = short
            .iter()
            .zip(&long)
            .filter(|(s, l)| {
                s.status == Status::Ok && l.class == Some(Class::Chaotic) && s.class != Some(Class::Regular)
            })
            .collect();
        let mean =
            |of: fn(&(&Measurement, &Measurement)) -> f64| pairs.iter().map(of).sum::<f64>() / pairs.len() as f64;
        let bias = mean(|(s, _)| s.lyapunov) / mean(|(_, l)| l.lyapunov) - 1.0;
        let early = pairs.iter().filter(|(s, _)| is_decided_early(s)).count();
        let chaotic: Vec<_> = pairs.iter().filter(|(s, _)| s.class == Some(Class::Chaotic)).collect();
        let covered = chaotic
            .iter()
            .filter(|(s, l)| (s.lyapunov - l.lyapunov).abs() < 2.0 * s.lyapunov_error.hypot(l.lyapunov_error))
            .count();
        let share = covered as f64 / chaotic.len() as f64;
        println!(
            "{covered} of {} chaotic of {}, {early} early, bias {bias:.4}",
            chaotic.len(),
            pairs.len()
        );
        assert!(
            chaotic.len() > 1000 && (0.92..0.98).contains(&share),
            "{covered} of {}",
            chaotic.len()
        );
        assert!(bias.abs() < 0.03 && 25 * early < pairs.len(), "{bias} {early}");
    }
}

#[test]
fn a_run_that_is_taken_up_again_goes_on_as_if_it_had_not_been_interrupted() {
    let points = map_points(997);
    for scheme in [Scheme::Taylor, Scheme::Rk4] {
        for precision in PRECISIONS {
            let settings = Settings {
                integration: scheme.into(),
                ..Settings::default()
            };
            let mut backend = CpuBackend::new(precision);
            let advance = |backend: &mut CpuBackend, first| {
                let slice = Slice {
                    stage: Stage::Measure,
                    first,
                    periods: 20,
                    elapsed: first,
                };
                backend.advance(&slice).unwrap();
                (backend.collect().unwrap(), backend.end_states().unwrap())
            };
            backend.load(&settings, &Instance::starts(&points)).unwrap();
            let (_, middle) = advance(&mut backend, 0);
            let (expected, ends) = advance(&mut backend, 20);
            let again: Vec<_> = points
                .iter()
                .zip(&middle)
                .map(|(&parameters, end)| Instance::from(parameters).at(end))
                .collect();
            backend.load(&settings, &again).unwrap();
            let (sums, again) = advance(&mut backend, 0);
            for i in 0..points.len() {
                assert_eq!(
                    (again[i].x, again[i].y),
                    (ends[i].x, ends[i].y),
                    "{scheme:?} {precision:?}"
                );
                assert_eq!(again[i].tangent, ends[i].tangent, "{scheme:?} {precision:?}");
                assert_eq!(sums[i].growth[0], expected[i].growth[0], "{scheme:?} {precision:?}");
            }
        }
    }
}

#[test]
fn tangents_are_refused_where_they_have_more_dimensions() {
    let mut backend = CpuBackend::new(Precision::F64);
    let point = ParameterSet::default();
    let heated = point.with(Parameter::Gamma, 1.0);
    let settings = Settings {
        integration: Scheme::Radau.into(),
        ..Settings::default()
    };
    let mut load = |point: ParameterSet, tangent: [f64; 2]| {
        let instance = Instance {
            tangent,
            ..point.into()
        };
        backend.load(&settings, &[point.into(), instance]).is_ok()
    };
    assert!(load(heated, [1.0, 0.0]) && load(point, [0.0, 1.0]));
    assert!(!load(heated, [0.0, 1.0]));
}
