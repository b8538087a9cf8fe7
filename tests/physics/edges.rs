//! The edges of the parameters: exponents that are known exactly, layers thinner and thinner, slow drives, strong damping, and
//! escapes. Every case holds on every scheme that claims it, in both number types.

use tribochaos::experiment::{Integration, Precision, Preset, Sampling, Scheme, Settings};
use tribochaos::measure::{Class, Measurement, Status};
use tribochaos::parameters::{Parameter, ParameterSet};

use crate::common::{PRECISIONS, measure, point};

fn settings(scheme: Scheme) -> Settings {
    Settings {
        integration: Integration {
            tolerance: if scheme == Scheme::Radau { 1e-8 } else { 2e-4 },
            ..Integration::from(scheme)
        },
        ..Settings::default()
    }
}

/// A damped well without friction and drive, b = 1: near its bottom s^2 + (epsilon h1) s + 2 = 0.
fn linear_well(omega_0: f64, damping: f64) -> ParameterSet {
    use Parameter::{Alpha, Beta, Epsilon, F0, H1, Omega0, OmegaK, X0, ZetaK};
    point(&[
        (F0, 0.0),
        // hardly any friction, by which the drive still counts as one, however slow
        (Alpha, 1e-9),
        (Beta, 0.0),
        (OmegaK, 0.0),
        (ZetaK, 1.0),
        (Epsilon, 1.0),
        (H1, damping),
        (Omega0, omega_0),
        (X0, 0.5),
    ])
}

/// Real parts of the roots, the larger first.
fn roots(damping: f64) -> [f64; 2] {
    let root = (damping * damping / 4.0 - 2.0).max(0.0).sqrt();
    // 2 over the other one, without a difference of near numbers
    let smaller = -damping / 2.0 - root;
    [if root > 0.0 { 2.0 / smaller } else { smaller }, smaller]
}

#[test]
fn no_exponent_has_a_floor() {
    let cases: Vec<(f64, f64)> = [0.02, 0.05, 0.1, 0.15, 0.5, 2.0, 10.0]
        .into_iter()
        .flat_map(|omega_0| [0.05, 0.5, 2.1, 5.0, 20.0].map(|damping| (omega_0, damping)))
        .collect();
    let points: Vec<_> = cases
        .iter()
        .map(|&(omega_0, damping)| linear_well(omega_0, damping))
        .collect();
    for (precision, tolerance) in [(Precision::F64, 1e-6), (Precision::F32, 1e-4)] {
        for scheme in [Scheme::Taylor, Scheme::Radau] {
            // a weak damping takes many periods of a fast drive to bring the orbit to rest
            let settings = Settings {
                sampling: Sampling {
                    transient_periods: 1200,
                    ..settings(scheme).sampling
                },
                ..settings(scheme)
            };
            let measured = measure(precision, &settings, &points);
            for (&(omega_0, damping), m) in cases.iter().zip(&measured) {
                let what = format!("{scheme:?} {precision:?} omega_0 = {omega_0}, epsilon h1 = {damping}: {m:?}");
                let [first, second] = roots(damping);
                assert!(m.status == Status::Ok && m.class == Some(Class::Regular), "{what}");
                assert!((m.lyapunov - first).abs() < tolerance * (1.0 + first.abs()), "{what}");
                // the fast one of two is as good as the slow one, relatively
                assert!(
                    (m.lyapunov_second - second).abs() < 100.0 * tolerance * second.abs(),
                    "{what}"
                );
                // a sum of thousands of steps
                assert!(
                    (m.divergence + damping).abs() < 3.0 * tolerance * (1.0 + damping),
                    "{what}"
                );
            }
        }
    }
}

fn close(m: &Measurement, exponent: f64, tolerance: f64) -> bool {
    m.status == Status::Ok && (m.lyapunov - exponent).abs() < tolerance + 3.0 * m.lyapunov_error
}

#[test]
fn stiff_and_slow_points_have_the_exponents_of_long_independent_runs() {
    use Parameter::{Alpha, B, Beta, Epsilon, Epsilon0, F0, H1, Omega0, OmegaK, X0, Y0, ZetaK};
    // a million steps of a plain Runge-Kutta scheme a period, and 60,000
    let slow = point(&[(ZetaK, 2.0), (Omega0, 0.03)]);
    let stiff = point(&[
        (ZetaK, 8.98),
        (H1, 1.793),
        (Omega0, 1.066),
        (OmegaK, 0.3685),
        (B, 3.298),
        (Epsilon, 0.3294),
        (F0, 0.7489),
        (Alpha, 0.5981),
        (Beta, 0.5635),
        (Epsilon0, 0.04231),
        (X0, 0.5542),
        (Y0, -0.21),
    ]);
    // strong damping without any friction: the slow root of s^2 + 20 s + 2
    let damped = linear_well(2.0, 20.0);
    for precision in PRECISIONS {
        for scheme in [Scheme::Taylor, Scheme::Radau] {
            let measured = measure(precision, &settings(scheme), &[slow, stiff, damped]);
            for (m, exponent) in measured.iter().zip([-0.109_219, -1.973_68, roots(20.0)[0]]) {
                assert!(
                    close(m, exponent, 2e-4),
                    "{scheme:?} {precision:?}: {m:?}, not {exponent}"
                );
            }
        }
    }
}

/// At points with crossings and with sticking, the exponent for thinner and thinner layers.
#[test]
fn exponents_tend_to_a_limit_as_the_layer_becomes_thin() {
    use Parameter::{Alpha, Beta, Epsilon0, H1, ZetaK};
    let crossing = point(&[(ZetaK, 3.5)]);
    let sticking = point(&[(ZetaK, 1.0), (Parameter::F0, 3.0)]);
    let fast = point(&[(ZetaK, 500.0), (Alpha, 0.0), (Beta, 0.0), (H1, 2.0)]);
    for (set, known) in [(crossing, None), (sticking, None), (fast, Some(-0.10002))] {
        let layers = [1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9];
        let points = layers.map(|layer| set.with(Epsilon0, layer));
        let measured = measure(Precision::F64, &settings(Scheme::Taylor), &points);
        let limit = known.unwrap_or(measured[5].lyapunov);
        for (m, layer) in measured.iter().zip(layers) {
            assert!(
                close(m, limit, 1e-4 + 20.0 * layer),
                "epsilon_0 = {layer}: {m:?}, not {limit}"
            );
        }
    }
}

/// A limit cycle without a drive, on which the bush dips into a thin layer in every turn and turns there. The exponents are those of
/// taylor and of 100,000 fixed steps a period (-0.6639), and of the standing proof's reference.
#[test]
fn grazes_of_a_thin_layer_are_met_by_every_scheme() {
    use Parameter::{Alpha, B, Beta, Epsilon, Epsilon0, F0, H1, Omega0, OmegaK, X0, Y0, ZetaK};
    let grazing = |epsilon_0: f64| {
        point(&[
            (ZetaK, 0.0),
            (Omega0, 0.08269),
            (H1, 0.596),
            (Epsilon, 0.1768),
            (F0, 1.511),
            (Alpha, 0.6786),
            (Beta, 0.4817),
            (OmegaK, -0.2138),
            (B, 2.589),
            (Epsilon0, epsilon_0),
            (X0, -0.4718),
            (Y0, 0.1569),
        ])
    };
    for (epsilon_0, exponent, tolerance) in [(1e-4, -0.6638, 1e-3), (5.825e-6, -7.585, 0.1)] {
        for scheme in [Scheme::Taylor, Scheme::Radau] {
            let measured = measure(Precision::F64, &settings(scheme), &[grazing(epsilon_0)]);
            let m = &measured[0];
            assert_eq!(m.class, Some(Class::Regular), "{scheme:?} at {epsilon_0}: {m:?}");
            assert!(
                close(m, exponent, tolerance),
                "{scheme:?} at {epsilon_0}: {} +- {}",
                m.lyapunov,
                m.lyapunov_error
            );
        }
    }
}

#[test]
fn a_layer_that_a_number_type_does_not_resolve_is_left_to_one_that_does() {
    use Parameter::{Epsilon0, ZetaK};
    let thin = point(&[(ZetaK, 3.5), (Epsilon0, 1e-6)]);
    let [single] = measure(Precision::F32, &settings(Scheme::Taylor), &[thin])[..] else {
        unreachable!()
    };
    let [double] = measure(Precision::F64, &settings(Scheme::Taylor), &[thin])[..] else {
        unreachable!()
    };
    assert_eq!(single.backend.precision(), "f64");
    assert!(
        (single.lyapunov - double.lyapunov).abs() < 1e-4,
        "{single:?} {double:?}"
    );
    // rk4 is asked for as it is
    let settings = settings(Scheme::Rk4);
    let [fixed] = measure(Precision::F32, &settings, &[thin])[..] else {
        unreachable!()
    };
    assert!(
        fixed.status == Status::UnderResolved || fixed.lyapunov_error > 1e-3,
        "{fixed:?}"
    );
}

#[test]
fn what_truly_diverges_has_run_away_at_its_time() {
    use Parameter::{Alpha, B, Beta, F0, H1};
    let softening = [-1.0, -0.1].map(|b| point(&[(B, b)]));
    for precision in PRECISIONS {
        for scheme in Scheme::ALL {
            let measured = measure(precision, &settings(scheme), &softening);
            for (m, expected) in measured.iter().zip([4.3755, 7.5821]) {
                let Status::Runaway { time } = m.status else {
                    panic!("{scheme:?} {precision:?}: {m:?}")
                };
                assert!(
                    (time - expected).abs() < 1e-3,
                    "{scheme:?} {precision:?}: {time}, not {expected}"
                );
            }
        }
    }
    // negative damping: energy grows without bound, and the speed reaches the bound in some swing
    let driven_up = point(&[(F0, 0.0), (Alpha, 0.0), (Beta, 0.0), (H1, -0.5)]);
    for scheme in Scheme::ALL {
        let settings = Settings {
            integration: Integration {
                tolerance: 1e-5,
                ..settings(scheme).integration
            },
            ..settings(scheme)
        };
        let [m] = measure(Precision::F64, &settings, &[driven_up])[..] else {
            unreachable!()
        };
        assert!(
            matches!(m.status, Status::Runaway { time } if (time - 286.0728).abs() < 1e-3),
            "{scheme:?}: {m:?}"
        );
    }
}

/// In a long run a batch is longer than the window in which a period shows.
#[test]
fn a_cycle_is_told_however_long_the_run() {
    let cycles = [4.0, 5.3].map(|zeta_k| point(&[(Parameter::ZetaK, zeta_k)]));
    for periods in [550, 1600, 2100, 4999, 10_000] {
        let settings = Settings {
            sampling: Sampling {
                decide_early: false,
                periods,
                ..settings(Scheme::Taylor).sampling
            },
            ..settings(Scheme::Taylor)
        };
        for m in measure(Precision::F64, &settings, &cycles) {
            assert!(
                m.status == Status::Ok && m.class == Some(Class::Regular),
                "{periods}: {m:?}"
            );
        }
    }
}

/// A point at which radau at its usual tolerance and rk4 by the paper's steps are off by more than their exponents' scatter, against a
/// reference of another order; and cycles with heat by coarse tolerances, against a fine one.
#[test]
fn what_a_scheme_misses_is_part_of_its_error() {
    use Parameter::{Alpha, B, Beta, Epsilon, Epsilon0, F0, H1, KW, Omega0, OmegaK, X0, Y0, ZetaK};
    let set = point(&[
        (Omega0, 0.8752),
        (Alpha, 0.1045),
        (Beta, 0.2019),
        (F0, 0.8844),
        (X0, 0.5394),
        (Y0, 1.048),
        (B, 1.467),
        (OmegaK, -0.1869),
        (Epsilon, 0.1055),
        (Epsilon0, 0.01538),
        (ZetaK, 4.2152),
        (H1, 1.00408),
    ]);
    for scheme in Scheme::ALL {
        for decide_early in [true, false] {
            let settings = Settings {
                integration: scheme.into(),
                sampling: Sampling {
                    decide_early,
                    ..Sampling::default()
                },
            };
            let [m] = measure(Precision::F64, &settings, &[set])[..] else {
                unreachable!()
            };
            let off = (m.lyapunov + 0.263_189).abs();
            assert!(off < 3.0 * m.lyapunov_error + 1e-6, "{scheme:?}: {off:e} {m:?}");
            assert!(m.lyapunov_error < 0.03 && m.scheme_error <= m.lyapunov_error, "{m:?}");
            // the default scheme has hardly any share
            assert!(scheme != Scheme::Taylor || m.scheme_error < 1e-5, "{m:?}");
        }
    }

    let heated = [3.2, 3.5, 3.9].map(|zeta_k| Preset::Paper.parameters().with(ZetaK, zeta_k).with(KW, 0.0));
    let at_tolerance = |tolerance| {
        let settings = Settings {
            integration: Integration {
                tolerance,
                ..Scheme::Radau.into()
            },
            ..Settings::default()
        };
        measure(Precision::F64, &settings, &heated)
    };
    let fine = at_tolerance(1e-7);
    for tolerance in [1e-2, 2e-4] {
        for (m, exact) in at_tolerance(tolerance).iter().zip(&fine) {
            assert!(m.period.is_some() && m.scheme_error >= 0.0, "{m:?}");
            let off = (m.lyapunov - exact.lyapunov).abs();
            assert!(
                off < 3.0 * (m.lyapunov_error + exact.lyapunov_error),
                "{tolerance}: {off:e} {m:?}"
            );
        }
    }
}

/// Over omega_0 = 0.01..10 and h1 = 0..20, `columns` by `rows` points by the default scheme and by radau at its tightest: all are
/// resolved, and those that are regular by both have the same exponents, but for `others` that end on another attractor.
fn slow_drives_and_strong_damping(columns: u32, rows: u32, others: usize) {
    use Parameter::{H1, Omega0};
    let value = |[low, high]: [f64; 2], i: u32, count: u32| low + (high - low) * f64::from(i) / f64::from(count - 1);
    let points: Vec<_> = (0..columns * rows)
        .map(|index| {
            point(&[
                (Omega0, value([0.01, 10.0], index % columns, columns)),
                (H1, value([0.0, 20.0], index / columns, rows)),
            ])
        })
        .collect();
    let by_taylor = measure(Precision::F64, &settings(Scheme::Taylor), &points);
    let tightest = Settings {
        integration: Integration {
            tolerance: 1e-9,
            ..settings(Scheme::Radau).integration
        },
        ..settings(Scheme::Radau)
    };
    let by_radau = measure(Precision::F64, &tightest, &points);
    let mut apart = Vec::new();
    for ((set, a), b) in points.iter().zip(&by_taylor).zip(&by_radau) {
        assert_eq!(a.status, Status::Ok, "{a:?}");
        // chaos is compared elsewhere: its errors are of another kind
        if a.class == Some(Class::Regular) && b.class == Some(Class::Regular) {
            // radau's own error has taylor's in it, and proves nothing here
            let error = 3.0 * a.lyapunov_error + 1e-5;
            if (a.lyapunov - b.lyapunov).abs() >= error {
                let (omega_0, h1) = (set[Omega0], set[H1]);
                println!("omega_0 = {omega_0}, h1 = {h1}: {a:?} {b:?}");
                apart.push((omega_0, h1));
            }
        }
    }
    println!("{} of {} apart", apart.len(), points.len());
    assert!(apart.len() <= others, "{apart:?}");
}

#[test]
fn slow_drives_and_strong_damping_are_resolved_and_schemes_agree() {
    slow_drives_and_strong_damping(8, 5, 0);
}

#[test]
#[ignore = "minutes"]
fn slow_drives_and_strong_damping_agree_all_over_the_map() {
    slow_drives_and_strong_damping(300, 200, 6);
}
