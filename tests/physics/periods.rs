//! Periods of settled ends, long ones among them, and cycles that do not attract.

use tribochaos::experiment::{Precision, Settings};
use tribochaos::measurement::Class;
use tribochaos::parameters::{Parameter, ParameterSet};

use crate::common::{PRECISIONS, from_state, measure, point};

fn at(zeta_k: f64, h1: f64) -> ParameterSet {
    point(&[(Parameter::ZetaK, zeta_k), (Parameter::H1, h1)])
}

/// Four times as long as the default, which leaves an orbit near the end of doubling time to settle.
fn long() -> Settings {
    Settings {
        transient_periods: 1750,
        periods: 450,
        decide_early: false,
        period_tolerance: 1e-5,
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
    for precision in PRECISIONS {
        let short = measure(precision, &Settings::default(), &points);
        let settled = measure(precision, &long(), &points);
        let pairs: Vec<_> = (short.iter().zip(&settled))
            .filter_map(|(s, l)| Some((s, l, s.period?, l.period?)))
            .collect();
        assert!(pairs.len() > 1000, "{precision:?}: {}", pairs.len());
        for (s, l, short, long) in pairs {
            // an orbit may end on another of several cycles; the same one shows by its exponent
            let same_cycle = (s.lyapunov - l.lyapunov).abs() < 1e-4 * (1.0 + l.lyapunov.abs());
            assert!(
                short == long || !same_cycle,
                "{precision:?} {short} for {long}: {s:?} {l:?}"
            );
        }
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
        transient_periods: 4000,
        periods: 512,
        period_tolerance: 1e-6,
        ..Settings::default()
    };
    let points = [2.9, 2.92, 2.9228].map(duffing);
    let periods = |settings: &Settings| {
        let measured = measure(Precision::F64, settings, &points);
        [0, 1, 2].map(|i: usize| measured[i].period)
    };
    assert_eq!(periods(&settings), [Some(4), Some(8), Some(64)]);
    let longer = Settings {
        max_period: 256,
        ..settings.clone()
    };
    assert_eq!(periods(&longer), [Some(4), Some(8), Some(64)]);
    let shorter = Settings {
        max_period: 32,
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
                decide_early,
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
        transient_periods: 50,
        align_periods: 50,
        periods: 500,
        decide_early: false,
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
