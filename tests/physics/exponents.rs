//! Exponents that are known from elsewhere: eigenvalues, published figures, MODEL's table, and the mean divergence.

use tribochaos::dynamics::spectrum::lyapunov_spectrum;
use tribochaos::dynamics::statistics;
use tribochaos::experiment::{Integration, Precision, Sampling, Settings};
use tribochaos::measure::{Class, Measurement, Status};
use tribochaos::parameters::{Parameter, ParameterSet};

use crate::common::{PRECISIONS, Random, from_state, measure, pinned_settings, point};
use crate::oracle::{after_periods, fixed_point_exponents, greatest_fixed_point};

fn linear_friction(values: &[(Parameter, f64)]) -> ParameterSet {
    let linear = [
        (Parameter::F0, 0.0),
        (Parameter::Beta, 0.0),
        (Parameter::Alpha, -1.0),
        (Parameter::ZetaK, 0.0),
    ];
    point(&[&linear[..], values].concat())
}

/// Asserts that the exponents are `expected`. A complex pair turns the tangent vector, which makes the exponent of a
/// finite window oscillate by (log of the ratio of the turning ellipse's axes)/window: below 2e-3 for 300 periods of
/// length pi and axes that differ by less than a factor of six. The scheme itself errs by lambda^5 h^4/120, up to 3e-8
/// here.
fn assert_exponents(measured: &Measurement, expected: [f64; 2], label: &str) {
    let [first, second] = expected;
    let tolerance = if first == second { 2e-3 } else { 1e-7 };
    let m = measured;
    assert!(
        (m.lyapunov - first).abs() < tolerance,
        "{label}: {m:?}, expected {first}"
    );
    assert!(
        (m.lyapunov_second - second).abs() < tolerance,
        "{label}: {m:?}, expected {second}"
    );
    let sum = m.lyapunov + m.lyapunov_second;
    assert!(
        (sum - first - second).abs() < 1e-7,
        "{label}: the sum is not the trace, {m:?}"
    );
}

#[test]
fn exponents_of_a_fixed_point_under_linear_friction_are_the_real_parts_of_its_eigenvalues() {
    use Parameter::{B, Epsilon, H1, OmegaK};
    let points = [
        // complex pairs, weakly and strongly damped
        linear_friction(&[(Epsilon, 0.1), (H1, 0.5), (OmegaK, 0.4)]),
        linear_friction(&[(Epsilon, 1.0), (H1, 1.5), (OmegaK, 0.4)]),
        linear_friction(&[(Epsilon, 0.3), (H1, 0.0), (OmegaK, -3.0)]),
        // real pairs
        linear_friction(&[(Epsilon, 1.0), (H1, 2.5), (OmegaK, 0.4)]),
        linear_friction(&[(Epsilon, 2.0), (H1, 2.0), (OmegaK, 0.1), (B, 0.5)]),
    ];
    let started: Vec<ParameterSet> = points
        .iter()
        .map(|p| from_state(*p, [greatest_fixed_point(p) + 0.05, 0.02]))
        .collect();
    for (p, m) in points.iter().zip(measure(Precision::F64, &pinned_settings(), &started)) {
        let x = greatest_fixed_point(p);
        assert_eq!((m.class, m.period), (Some(Class::Regular), Some(1)));
        assert!((m.x - x).abs() < 1e-9 && m.y.abs() < 1e-9, "{m:?} is not at {x}");
        assert_exponents(&m, fixed_point_exponents(p, x), &format!("{p:?}"));
    }
}

#[test]
fn the_unstable_fixed_point_between_the_wells_has_one_positive_exponent_and_is_no_attractor() {
    let saddle = linear_friction(&[(Parameter::OmegaK, 0.0), (Parameter::X0, 0.0)]);
    let m = measure(Precision::F64, &pinned_settings(), &[saddle])[0];
    let expected = fixed_point_exponents(&saddle, 0.0);
    assert!(expected[0] > 0.9 && expected[1] < -0.9);
    assert_exponents(&m, expected, "saddle");
    assert_eq!(m.class, Some(Class::Unstable), "growth without bends is no chaos");
}

#[test]
fn the_bush_on_a_shaft_of_constant_speed_comes_to_rest_with_negative_exponents() {
    let mut random = Random::new(1);
    let points: Vec<ParameterSet> = (0..40)
        .map(|_| {
            point(&[
                (Parameter::ZetaK, 0.0),
                (Parameter::H1, random.uniform(1.0, 3.0)),
                (Parameter::OmegaK, random.uniform(0.3, 1.5)),
                (Parameter::Alpha, random.uniform(0.0, 0.5)),
                (Parameter::X0, random.uniform(-1.5, 1.5)),
            ])
        })
        .collect();
    for precision in PRECISIONS {
        for (p, m) in points.iter().zip(measure(precision, &pinned_settings(), &points)) {
            assert_eq!((m.class, m.period), (Some(Class::Regular), Some(1)), "{p:?} {m:?}");
            let [first, second] = fixed_point_exponents(p, m.x);
            assert!(m.lyapunov < -0.02 && m.lyapunov_second < -0.02, "{p:?} {m:?}");
            assert!((m.lyapunov - first).abs() < 2e-3, "{p:?} {m:?}, expected {first}");
            assert!(
                (m.lyapunov_second - second).abs() < 2e-3,
                "{p:?} {m:?}, expected {second}"
            );
        }
    }
}

#[test]
fn strongly_damped_forced_motion_has_negative_exponents_and_the_forcing_s_period() {
    let mut random = Random::new(2);
    let points: Vec<ParameterSet> = (0..40)
        .map(|_| {
            point(&[
                (Parameter::ZetaK, random.uniform(0.0, 3.0)),
                (Parameter::H1, random.uniform(15.0, 25.0)),
            ])
        })
        .collect();
    for precision in PRECISIONS {
        for m in measure(precision, &pinned_settings(), &points) {
            assert_eq!((m.class, m.period), (Some(Class::Regular), Some(1)), "{m:?}");
            assert!(m.lyapunov < -0.1 && m.lyapunov_second < -0.1, "{m:?}");
        }
    }
}

/// 48 orbits of 1000 periods each: the mean's standard error, from their scatter, is below 1e-3. Halving the step
/// changes it by less than that.
#[test]
fn the_two_well_duffing_oscillator_has_its_published_exponents() {
    let duffing = point(&[
        (Parameter::F0, 0.0),
        (Parameter::Beta, 0.0),
        (Parameter::Alpha, -1.0),
        (Parameter::Epsilon, 1.0),
        (Parameter::H1, -0.8),
        (Parameter::OmegaK, 0.0),
        (Parameter::ZetaK, 0.3),
        (Parameter::Omega0, 1.0),
    ]);
    let settings = Settings {
        integration: Integration {
            steps_per_period: 256,
            renormalise_every: 64,
            ..pinned_settings().integration
        },
        sampling: Sampling {
            periods: 1000,
            ..pinned_settings().sampling
        },
    };
    let mut random = Random::new(3);
    let orbits: Vec<ParameterSet> = (0..48)
        .map(|_| from_state(duffing, [random.uniform(-1.2, 1.2), random.uniform(-0.5, 0.5)]))
        .collect();
    let measured = measure(Precision::F64, &settings, &orbits);
    assert!(measured.iter().all(|m| m.class == Some(Class::Chaotic)));
    let mean = |of: fn(&Measurement) -> f64| measured.iter().map(of).sum::<f64>() / measured.len() as f64;
    let (first, second) = (mean(|m| m.lyapunov), mean(|m| m.lyapunov_second));
    assert!((first - 0.157).abs() < 0.003, "{first}");
    assert!((second + 0.357).abs() < 0.003, "{second}");
    assert!((first + second + 0.2).abs() < 1e-6, "the divergence is -0.2 everywhere");
}

/// Parameters from all over the ranges in which motion stays bounded.
fn random_parameters(random: &mut Random) -> ParameterSet {
    point(&[
        (Parameter::ZetaK, random.uniform(0.0, 8.0)),
        (Parameter::H1, random.uniform(0.0, 2.0)),
        (Parameter::Omega0, random.uniform(0.7, 3.0)),
        (Parameter::OmegaK, random.uniform(-1.0, 1.0)),
        (Parameter::B, random.uniform(0.5, 2.0)),
        (Parameter::Epsilon, random.uniform(0.02, 0.2)),
        (Parameter::F0, random.uniform(0.0, 0.6)),
        (Parameter::Alpha, random.uniform(0.0, 0.5)),
        (Parameter::Beta, random.uniform(0.1, 0.5)),
        (Parameter::Epsilon0, random.uniform(0.02, 0.2)),
        (Parameter::X0, random.uniform(-1.0, 1.0)),
        (Parameter::Y0, random.uniform(-1.0, 1.0)),
    ])
}

/// Settings by which exponents are means over the measured periods, since no states agree, and not the multipliers of cycles.
fn means() -> Settings {
    Settings {
        sampling: Sampling {
            period_tolerance: 0.0,
            ..pinned_settings().sampling
        },
        ..pinned_settings()
    }
}

/// Liouville: the area that the two vectors span grows by the divergence. Growth and divergence are summed up
/// separately, so that they differ by the scheme's error (which falls as the step does) and, in f32, by the rounding of
/// a period's sum.
#[test]
fn the_sum_of_the_exponents_is_the_mean_divergence_at_random_parameters() {
    let mut random = Random::new(4);
    let points: Vec<ParameterSet> = (0..96).map(|_| random_parameters(&mut random)).collect();
    for (precision, steps_per_period, tolerance) in [
        (Precision::F64, 628, 3e-5),
        (Precision::F32, 628, 3e-5),
        (Precision::F64, 2512, 3e-7),
        (Precision::F32, 2512, 1e-5),
    ] {
        let settings = Settings {
            integration: Integration {
                steps_per_period,
                ..means().integration
            },
            ..means()
        };
        for (p, m) in points.iter().zip(measure(precision, &settings, &points)) {
            assert_eq!(m.status, Status::Ok, "{p:?}");
            let defect = m.divergence_defect().abs();
            assert!(
                defect < tolerance,
                "{precision:?}, {steps_per_period} steps: {defect:e}, {p:?}"
            );
        }
    }
}

fn at(zeta_k: f64, h1: f64, state: [f64; 2]) -> ParameterSet {
    from_state(point(&[(Parameter::ZetaK, zeta_k), (Parameter::H1, h1)]), state)
}

/// The textbook reference with three vectors steps and renormalises at the same instants: on a regular orbit nothing
/// but rounding separates the two.
#[test]
fn the_full_spectrum_is_the_two_exponents_of_the_lanes_and_zero() {
    let regular = [
        at(3.5, 0.5, [0.1, 0.0]),
        at(3.5, 0.5, [-1.0, 0.0]),
        at(4.7, 0.175, [0.1, 0.0]),
        at(2.0, 1.0, [0.1, 0.0]),
    ];
    let settings = means();
    for (p, m) in regular.iter().zip(measure(Precision::F64, &settings, &regular)) {
        let spectrum = lyapunov_spectrum(p, &settings).expect("bounded").exponents;
        let [first, second] = statistics::exponents([spectrum[0], spectrum[1]]);
        assert_eq!(spectrum[2], 0.0);
        // what the fixed step adds to the sum of the exponents, which a complex pair halves, is taken from every 17th period
        let tolerance = if first > second { 1e-10 } else { 1e-6 };
        for (of_lanes, reference, tolerance) in [(m.lyapunov, first, tolerance), (m.lyapunov_second, second, 1e-6)] {
            assert!((of_lanes - reference).abs() < tolerance, "{p:?}: {m:?}, {spectrum:?}");
        }
    }
    let chaotic = [at(3.9, 0.5, [0.7, 0.1]), at(4.25, 0.3, [0.1, 0.0])];
    for (p, m) in chaotic.iter().zip(measure(Precision::F64, &settings, &chaotic)) {
        assert_eq!(m.class, Some(Class::Chaotic), "{m:?}");
        let spectrum = lyapunov_spectrum(p, &settings).expect("bounded");
        let [first, second, along_the_flow] = spectrum.exponents;
        // both ran over as many periods of the same motion, from other rounding errors
        assert!(
            (0.3..3.0).contains(&(spectrum.errors[0] / m.lyapunov_error)),
            "{m:?}, {spectrum:?}"
        );
        let error = 3.0 * std::f64::consts::SQRT_2 * m.lyapunov_error;
        assert!((m.lyapunov - first).abs() < error, "{m:?}, {first}");
        assert!((m.lyapunov_second - second).abs() < error, "{m:?}, {second}");
        assert!(along_the_flow.abs() < 1e-9);
    }
}

#[test]
fn the_spectrum_of_a_runaway_is_none() {
    let runaway = point(&[(Parameter::B, -1.0), (Parameter::X0, 2.0)]);
    assert_eq!(lyapunov_spectrum(&runaway, &pinned_settings()), None);
}

/// The friction layer resolved; see the next test for what the paper's step makes of it.
fn resolved_settings() -> Settings {
    Settings {
        integration: Integration {
            steps_per_period: 4000,
            renormalise_every: 1000,
            ..pinned_settings().integration
        },
        ..pinned_settings()
    }
}

#[test]
fn coexisting_cycles_at_zeta_k_3_5_have_their_exponents_once_the_layer_is_resolved() {
    let points = [
        at(3.5, 0.5, [0.1, 0.0]),
        at(3.5, 0.5, [1.0, 0.0]),
        at(3.5, 0.5, [-1.0, 0.0]),
    ];
    let measured = measure(Precision::F64, &resolved_settings(), &points);
    for m in &measured[..2] {
        assert_eq!((m.class, m.period), (Some(Class::Regular), Some(1)));
        assert!((m.lyapunov + 0.2317).abs() < 2e-4, "{m:?}");
    }
    // the multipliers are a complex pair: the exact exponent is half the divergence, the window's oscillates about it
    let m = &measured[2];
    assert_eq!((m.class, m.period), (Some(Class::Regular), Some(2)));
    assert!((m.divergence / 2.0 + 0.2809).abs() < 2e-4, "{m:?}");
    assert!((m.lyapunov - m.divergence / 2.0).abs() < 1e-3, "{m:?}");
}

/// The multipliers of the period map by finite differences of the independent integrator: no tangent equations at all.
#[test]
fn the_exponent_of_a_cycle_is_that_of_its_period_map() {
    let p = at(3.5, 0.5, [0.1, 0.0]);
    let m = measure(Precision::F64, &resolved_settings(), &[p])[0];
    let map = |dx: f64, dy: f64| after_periods(&p, [m.x + dx, m.y + dy], 1, 4000);
    // small against the layer's width, large against rounding
    let delta = 1e-6;
    let column = |[ax, ay]: [f64; 2], [bx, by]: [f64; 2]| [(ax - bx) / (2.0 * delta), (ay - by) / (2.0 * delta)];
    let [xx, yx] = column(map(delta, 0.0), map(-delta, 0.0));
    let [xy, yy] = column(map(0.0, delta), map(0.0, -delta));
    let multipliers: [nalgebra::Complex<f64>; 2] = nalgebra::Matrix2::new(xx, xy, yx, yy).complex_eigenvalues().into();
    let largest = multipliers[0].norm().max(multipliers[1].norm());
    let exponent = largest.ln() / crate::oracle::period_time(&p);
    assert!((m.lyapunov - exponent).abs() < 1e-5, "{m:?}, period map: {exponent}");
}

/// The layer is crossed in about one step, and on a cycle every crossing meets the same phase of the step: nothing
/// averages the error out. Steps of nearly the same size give -0.2326 (620) and -0.2308 (640).
#[test]
fn the_paper_s_step_misses_the_exponent_of_a_cycle_by_a_hundredth() {
    let m = measure(Precision::F64, &pinned_settings(), &[at(3.5, 0.5, [0.1, 0.0])])[0];
    assert!((m.lyapunov + 0.2425).abs() < 2e-4, "{m:?}");
}

#[test]
fn motion_at_zeta_k_3_9_is_chaotic_with_the_known_exponent() {
    let points: Vec<ParameterSet> = [[0.1, 0.0], [1.0, 0.0], [-1.0, 0.0]]
        .map(|state| at(3.9, 0.5, state))
        .to_vec();
    for settings in [pinned_settings(), resolved_settings()] {
        for m in measure(Precision::F64, &settings, &points) {
            assert_eq!(m.class, Some(Class::Chaotic), "{m:?}");
            let (low, high) = (0.07 - 3.0 * m.lyapunov_error, 0.09 + 3.0 * m.lyapunov_error);
            assert!((low..high).contains(&m.lyapunov), "{m:?}");
        }
    }
}
