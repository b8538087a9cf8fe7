//! Classes of motion, periods and runaways at points where they are certain.

use tribochaos::experiment::{Sampling, Settings};
use tribochaos::measure::{Class, Measurement, Status};
use tribochaos::model::motion::RUNAWAY_BOUND;
use tribochaos::parameters::{Parameter, ParameterSet};

use crate::common::{PRECISIONS, from_state, measure, pinned_settings, point};
use crate::oracle;

fn at(zeta_k: f64, h1: f64, state: [f64; 2]) -> ParameterSet {
    from_state(point(&[(Parameter::ZetaK, zeta_k), (Parameter::H1, h1)]), state)
}

fn distance([ax, ay]: [f64; 2], [bx, by]: [f64; 2]) -> f64 {
    (ax - bx).abs().max((ay - by).abs())
}

struct KnownCycle {
    zeta_k: f64,
    h1: f64,
    start: [f64; 2],
    period: u32,
    /// One of its stroboscopic states, computed at 20,000 steps a period.
    state: [f64; 2],
}

/// Two coexisting cycles, a period 3 and a period 4.
const CYCLES: [KnownCycle; 4] = [
    KnownCycle {
        zeta_k: 3.5,
        h1: 0.5,
        start: [0.1, 0.0],
        period: 1,
        state: [0.8548127, -0.7337065],
    },
    KnownCycle {
        zeta_k: 3.5,
        h1: 0.5,
        start: [-1.0, 0.0],
        period: 2,
        state: [-0.9955084, -0.6303017],
    },
    KnownCycle {
        zeta_k: 4.7,
        h1: 0.175,
        start: [0.1, 0.0],
        period: 3,
        state: [-0.2891012, -0.6687445],
    },
    KnownCycle {
        zeta_k: 5.3,
        h1: 0.3,
        start: [0.1, 0.0],
        period: 4,
        state: [0.4487500, -0.6234821],
    },
];

#[test]
fn known_cycles_are_found_with_their_period_and_place() {
    for precision in PRECISIONS {
        let points = CYCLES.map(|cycle| at(cycle.zeta_k, cycle.h1, cycle.start));
        let measured = measure(precision, &pinned_settings(), &points);
        for (
            (p, m),
            KnownCycle {
                period,
                state: on_cycle,
                ..
            },
        ) in points.iter().zip(&measured).zip(CYCLES)
        {
            assert_eq!(
                (m.class, m.period),
                (Some(Class::Regular), Some(period)),
                "{precision:?} {p:?}"
            );
            assert!(m.lyapunov < -0.1, "{m:?}");

            // the independent integrator stays on the cycle, comes back after the period and not before
            let orbit: Vec<[f64; 2]> = (0..=period)
                .map(|n| oracle::after_periods(p, [m.x, m.y], n, 2000))
                .collect();
            assert!(orbit.iter().any(|&state| distance(state, on_cycle) < 1e-3), "{orbit:?}");
            for (n, state) in orbit.iter().enumerate().skip(1) {
                let back = distance(*state, orbit[0]) < 1e-3;
                assert_eq!(
                    back,
                    n == period as usize,
                    "{precision:?} {p:?}: after {n} periods {state:?}"
                );
            }
        }
    }
}

/// Weak damping and a slow shaft: the bush's own oscillation keeps its frequency beside the drive's. The weighted
/// Birkhoff average shows the zero two orders more sharply than the plain one.
#[test]
fn quasi_periodic_motion_is_recognised() {
    let settings = Settings {
        sampling: Sampling {
            transient_periods: 1000,
            periods: 3000,
            ..pinned_settings().sampling
        },
        ..pinned_settings()
    };
    let points = [
        at(0.2, 0.0, [0.1, 0.0]),
        at(0.3, 0.05, [0.1, 0.0]),
        at(0.3, 0.075, [0.1, 0.0]),
    ];
    for precision in PRECISIONS {
        for m in measure(precision, &settings, &points) {
            assert_eq!(
                (m.class, m.period),
                (Some(Class::QuasiPeriodic), None),
                "{precision:?} {m:?}"
            );
            assert!(m.lyapunov_birkhoff.abs() < 1e-5, "{precision:?} {m:?}");
            assert!(m.lyapunov.abs() < 3.0 * m.lyapunov_error, "{precision:?} {m:?}");
            assert!(m.lyapunov_second < -0.01, "{precision:?} {m:?}");
        }
    }
}

/// The forcing period, counted from 1, at whose end the independent integrator finds the state beyond the bound.
fn runaway_period(p: &ParameterSet) -> u32 {
    let steps = 100_000;
    let h = oracle::period_time(p) / f64::from(steps);
    let mut state = [p[Parameter::X0], p[Parameter::Y0]];
    for n in 0.. {
        let size = state[0].abs() + state[1].abs();
        if size.is_nan() || size >= RUNAWAY_BOUND {
            return n / steps + 1;
        }
        state = oracle::step(p, f64::from(n) * h, h, state);
    }
    unreachable!("the point does not run away")
}

#[test]
fn a_runaway_is_reported_with_its_time_and_does_not_disturb_its_neighbours() {
    // softening springs, without the cubic drag, which is too stiff for fixed steps at the speed of a runaway
    let soft = |b: f64, x0: f64| at(3.5, 0.5, [x0, 0.0]).with(Parameter::B, b).with(Parameter::Beta, 0.0);
    // by the settings below they run away in the transient, in the alignment, or in the measurement
    let runaways = [soft(-1.0, 0.5), soft(-1.0, 1e-2), soft(0.0, 0.5), soft(-1e-3, -0.1)];
    let neighbours: Vec<ParameterSet> = (0..40).map(|i| at(0.15 * f64::from(i), 0.5, [0.1, 0.0])).collect();
    let mut mixed = neighbours.clone();
    let places = [3, 4, 17, 43];
    for (place, runaway) in places.into_iter().zip(runaways) {
        mixed.insert(place, runaway);
    }
    for (transient_periods, align_periods) in [(300, 50), (20, 20), (0, 0)] {
        let settings = Settings {
            sampling: Sampling {
                transient_periods,
                align_periods,
                periods: 64,
                ..pinned_settings().sampling
            },
            ..pinned_settings()
        };
        for precision in PRECISIONS {
            let mut measured = measure(precision, &settings, &mixed);
            for (place, p) in places.into_iter().zip(&runaways).rev() {
                let m = measured.remove(place);
                let end = f64::from(runaway_period(p)) * oracle::period_time(p);
                assert_eq!((m.class, m.period), (None, None), "{m:?}");
                assert!(m.lyapunov.is_nan() && m.x.is_nan(), "{m:?}");
                let Status::Runaway { time: reported } = m.status else {
                    panic!("{precision:?} {p:?}: {m:?}");
                };
                assert!(
                    end - oracle::period_time(p) < reported && reported <= end,
                    "{precision:?} {p:?}: {reported}, should be in the period that ends at {end}"
                );
            }
            let alone = measure(precision, &settings, &neighbours);
            for (m, expected) in measured.iter().zip(&alone) {
                assert_eq!(m.status, Status::Ok);
                let state = |m: &Measurement| [m.lyapunov, m.x, m.y].map(f64::to_bits);
                assert_eq!(state(m), state(expected), "{m:?}");
            }
        }
    }
}

#[test]
fn a_chaotic_orbit_has_no_period() {
    for precision in PRECISIONS {
        let m = measure(precision, &pinned_settings(), &[at(3.9, 0.5, [0.1, 0.0])])[0];
        assert_eq!((m.class, m.period), (Some(Class::Chaotic), None), "{m:?}");
    }
}
