//! Periods of settled ends, long ones among them, and cycles that do not attract.

use std::ops::ControlFlow;

use tribochaos::backend::cpu::CpuBackend;
use tribochaos::design::Axis;
use tribochaos::engine::{Backends, initial_states};
use tribochaos::experiment::{Experiment, Precision, Request, Sampling, Settings};
use tribochaos::measure::Class;
use tribochaos::parameters::{Parameter, ParameterSet};

use crate::common::{PRECISIONS, from_state, measure, point};

fn at(zeta_k: f64, h1: f64) -> ParameterSet {
    point(&[(Parameter::ZetaK, zeta_k), (Parameter::H1, h1)])
}

/// Four times as long as the default, which leaves an orbit near the end of doubling time to settle.
fn long() -> Settings {
    Settings {
        sampling: Sampling {
            transient_periods: 1750,
            periods: 450,
            decide_early: false,
            period_tolerance: 1e-5,
            ..Sampling::default()
        },
        ..Settings::default()
    }
}

#[test]
fn an_orbit_that_came_nearer_while_it_was_watched_has_the_period_of_its_end() {
    let points = [
        (at(4.664_429_530_201_342, 0.060_402_684_563_758_385), 6),
        (at(5.0, 1.041_666_666_666_666_5), 10),
    ];
    for precision in PRECISIONS {
        for (point, period) in points {
            for settings in [Settings::default(), long()] {
                let m = measure(precision, &settings, &[point])[0];
                assert_eq!(m.class, Some(Class::Regular), "{precision:?} {m:?}");
                assert_eq!(m.period, Some(period), "{precision:?} {m:?}");
            }
        }
    }
}

/// Zones of doubling: what is decided early, and what runs to its full length, has the period of a run four times as long.
#[test]
fn periods_in_zones_of_doubling_are_those_of_long_runs() {
    let zone = |zeta_k: [f64; 2], h1: [f64; 2]| {
        let across = move |[low, high]: [f64; 2], i: u32| low + (high - low) * f64::from(i) / 39.0;
        (0..1600).map(move |i| at(across(zeta_k, i % 40), across(h1, i / 40)))
    };
    let points: Vec<_> = zone([4.6, 5.0], [0.0, 0.2])
        .chain(zone([4.9, 5.3], [0.95, 1.15]))
        .collect();
    let settled = measure(Precision::F64, &long(), &points);
    for precision in PRECISIONS {
        let short = measure(precision, &Settings::default(), &points);
        let pairs: Vec<_> = (short.iter().zip(&settled))
            .filter_map(|(s, l)| Some((s, l, s.period?, l.period?)))
            // an orbit may end on another of several cycles; the same one shows by its exponent
            .filter(|(s, l, ..)| (s.lyapunov - l.lyapunov).abs() < 1e-4 * (1.0 + l.lyapunov.abs()))
            .collect();
        assert!(pairs.len() > 1000, "{precision:?}: {}", pairs.len());
        let different: Vec<_> = pairs.iter().filter(|(.., short, long)| short != long).collect();
        let told = different.iter().map(|(s, l, short, long)| {
            format!(
                "{short} for {long}: {:.6} {:.6} {}",
                s.lyapunov, l.lyapunov, s.integrated_periods
            )
        });
        assert!(
            different.is_empty(),
            "{precision:?} of {} {:#?}",
            pairs.len(),
            told.collect::<Vec<_>>()
        );
    }
}

/// x'' + 0.3 x' - x + x^3 = 0.1 zeta_k sin 1.2 tau.
fn duffing(zeta_k: f64) -> ParameterSet {
    use Parameter::{Alpha, Beta, F0, H1, Omega0, OmegaK, ZetaK};
    point(&[
        (F0, 0.0),
        (Alpha, -1.0),
        (Beta, 0.0),
        (OmegaK, 0.0),
        (H1, 2.0),
        (Omega0, 1.2),
        (ZetaK, zeta_k),
    ])
}

#[test]
fn a_cascade_is_followed_to_period_64() {
    let settings = Settings {
        sampling: Sampling {
            transient_periods: 4000,
            periods: 512,
            period_tolerance: 1e-6,
            ..Sampling::default()
        },
        ..Settings::default()
    };
    let points = [2.9, 2.92, 2.9228].map(duffing);
    let periods = |settings: &Settings| {
        let measured = measure(Precision::F64, settings, &points);
        [0, 1, 2].map(|i: usize| measured[i].period)
    };
    assert_eq!(periods(&settings), [Some(4), Some(8), Some(64)]);
    let longer = Settings {
        sampling: Sampling {
            max_period: 256,
            ..settings.sampling
        },
        ..settings
    };
    assert_eq!(periods(&longer), [Some(4), Some(8), Some(64)]);
    let shorter = Settings {
        sampling: Sampling {
            max_period: 32,
            ..settings.sampling
        },
        ..settings
    };
    assert_eq!(periods(&shorter), [Some(4), Some(8), None]);
}

/// At rest on the saddle the exponents are the roots of s^2 + c s - 1 = 0 with c = epsilon (h1 + F'(0)).
#[test]
fn an_orbit_that_stays_where_disturbances_grow_is_on_no_attractor() {
    let saddle = from_state(at(0.0, 0.5), [0.0, 0.0]).with(Parameter::OmegaK, 0.0);
    let slope = 2.0 * 0.3 / 0.01 - 0.3;
    let c = 0.1 * (0.5 + slope);
    let root = (c * c / 4.0 + 1.0_f64).sqrt();
    for precision in PRECISIONS {
        for decide_early in [true, false] {
            let settings = Settings {
                sampling: Sampling {
                    decide_early,
                    ..Sampling::default()
                },
                ..Settings::default()
            };
            let m = measure(precision, &settings, &[saddle])[0];
            assert_eq!(
                (m.class, m.attractors),
                (Some(Class::Unstable), 0),
                "{precision:?} {m:?}"
            );
            assert!((m.lyapunov - (root - c / 2.0)).abs() < 1e-5, "{precision:?} {m:?}");
            assert!((m.lyapunov_second + root + c / 2.0).abs() < 1e-4, "{precision:?} {m:?}");
        }
    }
}

/// The 64 x 32 points of a plane in which chaos is often transient: those that are regular have no positive exponent, and those on
/// a cycle that of a run that began there.
#[test]
fn a_chaotic_transient_is_no_part_of_a_cycle_s_exponent() {
    let points: Vec<_> = (0..2048)
        .map(|i| at(3.0 + f64::from(i % 64) / 32.0, 1.5 * f64::from(i / 64) / 31.0))
        .collect();
    let settings = Settings {
        sampling: Sampling {
            transient_periods: 50,
            align_periods: 50,
            periods: 500,
            decide_early: false,
            ..Sampling::default()
        },
        ..Settings::default()
    };
    let measured = measure(Precision::F64, &settings, &points);
    let on_cycles: Vec<_> = (points.iter().zip(&measured))
        .filter(|(_, m)| m.class == Some(Class::Regular))
        .inspect(|(_, m)| assert!(m.lyapunov <= 0.0, "{m:?}"))
        .filter(|(_, m)| m.period.is_some())
        .collect();
    assert!(on_cycles.len() > 1000);
    let again: Vec<_> = on_cycles
        .iter()
        .map(|(point, m)| from_state(**point, [m.x, m.y]))
        .collect();
    for ((_, m), again) in on_cycles.iter().zip(measure(Precision::F64, &settings, &again)) {
        assert!((m.lyapunov - again.lyapunov).abs() < 1e-3, "{m:?} {again:?}");
        assert_eq!(m.period, again.period, "{m:?} {again:?}");
    }
}

/// y' = x - x^3 + 0.5 (0.8 y - 0.3 y^3) - 0.5 * 0.3 y: a shaft at rest whose friction falls with speed.
fn self_excited() -> ParameterSet {
    use Parameter::{Alpha, Beta, Epsilon, F0, H1, OmegaK, ZetaK};
    point(&[
        (Epsilon, 0.5),
        (F0, 0.0),
        (Alpha, 0.8),
        (Beta, 0.3),
        (H1, 0.3),
        (OmegaK, 0.0),
        (ZetaK, 0.0),
    ])
}

/// Mean divergence over 20 turns of the limit cycle, between upward crossings of x = 0, by a fixed step of own code.
fn divergence_of_the_limit_cycle() -> f64 {
    let rate = |[x, y]: [f64; 2]| [y, x - x * x * x + 0.5 * (0.8 * y - 0.3 * y * y * y) - 0.15 * y];
    let h = 1e-4;
    let step = |s: [f64; 2]| {
        let moved = |k: [f64; 2], h: f64| [s[0] + h * k[0], s[1] + h * k[1]];
        let k1 = rate(s);
        let k2 = rate(moved(k1, h / 2.0));
        let k3 = rate(moved(k2, h / 2.0));
        let k4 = rate(moved(k3, h));
        [0, 1].map(|i| s[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
    };
    let mut state = [0.1, 0.0];
    let (mut turns, mut time, mut integral) = (0, 0.0, 0.0);
    while turns < 120 {
        let next = step(state);
        let crosses = state[0] < 0.0 && next[0] >= 0.0;
        if turns >= 100 {
            time += h;
            let divergence = |[_, y]: [f64; 2]| 0.5 * (0.8 - 0.9 * y * y) - 0.15;
            integral += 0.5 * h * (divergence(state) + divergence(next));
        }
        turns += u32::from(crosses);
        state = next;
    }
    integral / time
}

#[test]
fn a_limit_cycle_has_the_exponent_across_the_flow_whatever_omega_0() {
    let expected = divergence_of_the_limit_cycle();
    let points = [0.3, 1.0, 2.0, 7.0].map(|omega_0| self_excited().with(Parameter::Omega0, omega_0));
    for precision in PRECISIONS {
        let bound = if precision == Precision::F64 { 1e-5 } else { 1e-4 };
        for decide_early in [true, false] {
            let settings = Settings {
                sampling: Sampling {
                    decide_early,
                    ..Sampling::default()
                },
                ..Settings::default()
            };
            for m in measure(precision, &settings, &points) {
                assert_eq!((m.class, m.period), (Some(Class::Regular), None), "{precision:?} {m:?}");
                assert!(m.lyapunov_second.is_nan(), "{m:?}");
                assert!((m.lyapunov - expected).abs() < bound, "{expected} {precision:?} {m:?}");
            }
        }
    }
}

/// At rest in a well both exponents are those of the linear motion there.
#[test]
fn a_rest_without_a_drive_has_period_1_whatever_omega_0() {
    let well = point(&[
        (Parameter::F0, 0.0),
        (Parameter::Alpha, 0.0),
        (Parameter::Beta, 0.0),
        (Parameter::Epsilon, 1.0),
        (Parameter::H1, 0.5),
        (Parameter::X0, 0.5),
    ]);
    // the friction law may be left out, or the drive
    let undriven = [well, well.with(Parameter::ZetaK, 0.0)];
    let points: Vec<_> = (undriven.iter())
        .flat_map(|set| [0.3, 1.0, 2.0, 7.0].map(|omega_0| set.with(Parameter::Omega0, omega_0)))
        .collect();
    for precision in PRECISIONS {
        for m in measure(precision, &Settings::default(), &points) {
            assert_eq!(
                (m.class, m.period),
                (Some(Class::Regular), Some(1)),
                "{precision:?} {m:?}"
            );
            assert!(
                (m.lyapunov + 0.25).abs() < 1e-4 && (m.lyapunov_second + 0.25).abs() < 1e-4,
                "{m:?}"
            );
        }
    }
}

/// In the layer of a shaft at rest a bush creeps towards its rest for a time of 1/epsilon_0, one way: that is no limit cycle.
#[test]
fn a_bush_that_creeps_is_on_no_limit_cycle() {
    use Parameter::{Epsilon0, F0, H1, OmegaK, X0, Y0, ZetaK};
    let creeping = [1e-4, 1e-5, 1e-6].map(|layer| {
        point(&[
            (ZetaK, 0.0),
            (OmegaK, 0.0),
            (F0, 3.0),
            (H1, 5.0),
            (Epsilon0, layer),
            (X0, 1.3),
            (Y0, -0.4),
        ])
    });
    for decide_early in [true, false] {
        let settings = Settings {
            sampling: Sampling {
                decide_early,
                ..Sampling::default()
            },
            ..Settings::default()
        };
        for (m, set) in measure(Precision::F64, &settings, &creeping).iter().zip(&creeping) {
            // the slow rate of a creep, (1 - 3 b x^2)/K, is below 3 epsilon_0
            assert!(
                m.lyapunov.abs() < 10.0 * set[Epsilon0] + 3.0 * m.lyapunov_error,
                "{m:?}"
            );
            assert!(m.lyapunov_error < 1e-3 && !m.is_on_limit_cycle(), "{m:?}");
        }
    }
}

/// As the drive vanishes: of a rest both exponents, and beside a limit cycle, where the driven motion is a torus, the second one.
#[test]
fn exponents_are_continuous_as_the_drive_vanishes() {
    let rest = self_excited().with(Parameter::Alpha, -0.3).with(Parameter::X0, 0.5);
    let driven = [1e-2, 1e-4, 1e-6, 0.0].map(|zeta_k| rest.with(Parameter::ZetaK, zeta_k));
    let measured = measure(Precision::F64, &Settings::default(), &driven);
    for (m, set) in measured.iter().zip(&driven) {
        let off = [
            m.lyapunov - measured[3].lyapunov,
            m.lyapunov_second - measured[3].lyapunov_second,
        ];
        let bound = 1e-6 + 0.1 * set[Parameter::ZetaK];
        assert!(off.iter().all(|off| off.abs() < bound), "{off:?} {set:?}");
        assert_eq!((m.class, m.period), (Some(Class::Regular), Some(1)));
    }

    let expected = divergence_of_the_limit_cycle();
    let torus = [1e-2, 1e-3].map(|zeta_k| self_excited().with(Parameter::ZetaK, zeta_k));
    for m in measure(Precision::F64, &Settings::default(), &torus) {
        assert_eq!(m.class, Some(Class::QuasiPeriodic), "{m:?}");
        assert!((m.lyapunov_second - expected).abs() < 5e-3, "{expected} {m:?}");
    }
}

fn experiment(x: &str, y: &str, states: u32, settings: &Settings) -> Experiment {
    let request = Request {
        axes: Some(vec![Axis::parse(x).unwrap(), Axis::parse(y).unwrap()]),
        integration: settings.integration.into(),
        sampling: Sampling {
            initial_states: states,
            ..settings.sampling
        },
        ..Request::default()
    };
    request.resolve().unwrap()
}

/// Of every point of a map.
fn attractors(experiment: &Experiment) -> Vec<u32> {
    let grid = &experiment.design;
    let indices: Vec<usize> = (0..grid.len()).collect();
    let mut backends = Backends::new(Box::new(CpuBackend::new(Precision::F64)), None);
    let measured = backends.measure(grid, &experiment.settings, &indices, &mut |_| ControlFlow::Continue(()));
    measured.unwrap().unwrap().iter().map(|m| m.attractors).collect()
}

/// What is told of each orbit of a point, where a test fails.
fn orbits_of(experiment: &Experiment, index: usize) -> Vec<String> {
    let states = initial_states::offsets(&experiment.settings.sampling);
    let points: Vec<_> = initial_states::points(experiment.design.point(index), &states).collect();
    let measured = measure(Precision::F64, &experiment.settings, &points);
    let mut told: Vec<String> = (measured.iter())
        .map(|m| {
            let class = m.class.map(Class::name);
            let exponent = format!("{:.5} +- {:.5}", m.lyapunov, m.lyapunov_error);
            format!(
                "{class:?} {:?} {exponent} {:.3} {:.3} {}",
                m.period, m.x_min, m.x_max, m.integrated_periods
            )
        })
        .collect();
    told.sort();
    told.dedup();
    told
}

/// Orbits of the first cell are slow to settle; of the others, more orbits show as many attractors at least once they are four
/// times as long.
#[test]
fn only_what_has_settled_counts_as_an_attractor() {
    let long = Settings {
        sampling: Sampling {
            transient_periods: 1500,
            periods: 500,
            ..Sampling::default()
        },
        ..Settings::default()
    };
    let slow = experiment(
        "zeta_k=3.1052631578947367:3.2:2",
        "h1=0.7894736842105263:0.8:2",
        16,
        &Settings::default(),
    );
    assert_eq!(attractors(&slow)[0], 2, "{:#?}", orbits_of(&slow, 0));
    let default = Settings::default();
    let map = |states, settings| experiment("zeta_k=3:5:20", "h1=0:1.5:20", states, settings);
    let short = map(16, &default);
    let (counted, settled) = (attractors(&short), attractors(&map(64, &long)));
    let too_high: Vec<_> = (0..counted.len())
        .filter(|&i| counted[i] > settled[i])
        .map(|i| (i, counted[i], settled[i], orbits_of(&short, i)))
        .collect();
    assert!(too_high.is_empty(), "{too_high:#?}");
}
