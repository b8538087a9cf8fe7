//! Frictional heat, wear and contact loss: the Radau scheme against MODEL's figures and against references that share
//! nothing with it.

use std::ops::ControlFlow;

use tribochaos::backend::Instance;
use tribochaos::backend::cpu::CpuBackend;
use tribochaos::dynamics::adaptive::{Control, Orbit, Peaks, System, Tangent};
use tribochaos::dynamics::history::{Sample, history};
use tribochaos::dynamics::radau::ModeStep;
use tribochaos::experiment::{Integration, Precision, Preset, Sampling, Scheme, Settings};
use tribochaos::lanes::Real;
use tribochaos::measure::{Class, Measurement, Status, measure_batch};
use tribochaos::model::rubbing::HeatModes;
use tribochaos::model::thermal_modes::ThermalModes;
use tribochaos::parameters::{Parameter, ParameterSet};

use crate::dual::Dual;
use crate::thermal_oracle::{Case, finite_volume, preset, volterra};

/// Section 5 of the paper, as reconstructed.
fn paper(zeta_k: f64) -> ParameterSet {
    Preset::Paper.parameters().with(Parameter::ZetaK, zeta_k)
}

fn measure(precision: Precision, settings: &Settings, points: &[ParameterSet]) -> Vec<Measurement> {
    let (mut backend, instances) = (CpuBackend::new(precision), Instance::starts(points));
    measure_batch(&mut backend, settings, &instances, &mut |_| ControlFlow::Continue(()))
        .unwrap()
        .unwrap()
}

fn close(found: f64, expected: f64, relative: f64, what: &str) {
    assert!(
        (found / expected - 1.0).abs() < relative,
        "{what}: {found}, not {expected}"
    );
}

/// A run of 30 periods, in which contact is lost.
fn contact_settings() -> Settings {
    Settings {
        sampling: Sampling {
            periods: 30,
            ..Sampling::default()
        },
        ..Settings::from(Scheme::Radau)
    }
}

/// Q = F(v) v p has no epsilon: a bush that friction cannot move heats all the same. At rest, without a force on it, it stays there.
#[test]
fn friction_that_does_not_move_the_bush_heats_it() {
    let set = |epsilon| {
        let gently = paper(3.5)
            .with(Parameter::KW, 0.0)
            .with(Parameter::Gamma, 0.001)
            .with(Parameter::X0, 1.0);
        gently.with(Parameter::Epsilon, epsilon)
    };
    for precision in [Precision::F64, Precision::F32] {
        let settings = Settings {
            sampling: Sampling {
                transient_periods: 20,
                align_periods: 10,
                periods: 64,
                ..Sampling::default()
            },
            ..Settings::from(Scheme::Radau)
        };
        let [none, little] = measure(precision, &settings, &[set(0.0), set(1e-7)])[..] else {
            panic!("two points were asked for")
        };
        assert!(little.contact.peak_temperature > 1e-4, "{little:?}");
        let what = format!("temperature in {precision:?}");
        close(
            none.contact.peak_temperature,
            little.contact.peak_temperature,
            1e-3,
            &what,
        );
    }
}

/// Without a drive, a run with wear is as long as the given omega_0 says; its wear grows with its length.
#[test]
fn wear_without_a_drive_goes_on_for_the_periods_of_omega_0() {
    let slow = |omega_0| paper(0.0).with(Parameter::Omega0, omega_0);
    let measured = measure(Precision::F64, &contact_settings(), &[slow(2.0), slow(0.5)]);
    for (m, omega_0) in measured.iter().zip([2.0, 0.5]) {
        assert_eq!(m.status, Status::Ok);
        let run = 30.0 * std::f64::consts::TAU / omega_0;
        let end = m.contact.lost.map_or(run, |lost| lost.min(run));
        close(m.lyapunov_interval, end, 1e-9, &format!("run at omega_0 = {omega_0}"));
    }
    assert!(measured[1].contact.final_wear > 1.5 * measured[0].contact.final_wear);
}

#[test]
fn the_paper_s_contact_is_lost_when_and_how_the_model_says() {
    // tau_c, wear, peak pressure and its time, peak temperature; converged by finite volumes of ever finer rings
    let expected = [
        (3.9, [72.0555, 30.206, 95.955, 6.733, 543.1]),
        (3.5, [65.840, 27.053, 92.321, 6.722, 296.0]),
    ];
    for precision in [Precision::F64, Precision::F32] {
        let instances = expected.map(|(zeta_k, _)| paper(zeta_k));
        let measured = measure(precision, &contact_settings(), &instances);
        for (m, (zeta_k, [tau_c, wear, peak, time, temperature])) in measured.iter().zip(expected) {
            let what = |name| format!("{name} at {zeta_k} in {precision:?}");
            close(m.contact.lost.unwrap(), tau_c, 1e-4, &what("tau_c"));
            close(m.contact.final_wear, wear, 1e-4, &what("wear"));
            close(m.contact.peak_pressure, peak, 1e-4, &what("peak pressure"));
            close(m.contact.peak_pressure_time, time, 5e-4, &what("time of it"));
            close(m.contact.peak_temperature, temperature, 2e-3, &what("temperature"));
            assert_eq!((m.status, m.class), (Status::Ok, None));
            // the exponent is one of finite time, and says of which
            assert_eq!(m.lyapunov_interval, m.contact.lost.unwrap());
            assert!(m.lyapunov.is_finite() && m.lyapunov_error.is_nan() && m.lyapunov_second.is_nan());
        }
    }
}

#[test]
fn without_wear_the_paper_s_cycles_have_their_periods_and_exponents() {
    let settings = Settings::from(Scheme::Radau);
    let expected = [(3.5, 2, -0.08084), (3.9, 1, -0.44739)];
    for precision in [Precision::F64, Precision::F32] {
        let instances = expected.map(|(zeta_k, ..)| paper(zeta_k).with(Parameter::KW, 0.0));
        for (m, (zeta_k, period, lyapunov)) in measure(precision, &settings, &instances).iter().zip(expected) {
            assert_eq!((m.class, m.period), (Some(Class::Regular), Some(period)), "{zeta_k}");
            assert!((m.lyapunov - lyapunov).abs() < 1e-4, "{zeta_k}: {}", m.lyapunov);
            assert_eq!(m.contact.lost, None);
        }
    }
}

#[test]
fn wear_without_heat_takes_the_pressure_to_zero_slowly() {
    let set = paper(3.9).with(Parameter::Gamma, 0.0);
    let run = history(&set, &Scheme::Radau.into(), 0..40, 100);
    let wear_at = |tau: f64| {
        let after = run.samples.iter().position(|sample| sample.tau >= tau).unwrap();
        let [a, b] = [&run.samples[after - 1], &run.samples[after]];
        a.wear + (b.wear - a.wear) * (tau - a.tau) / (b.tau - a.tau)
    };
    close(wear_at(72.0), 0.8295, 2e-4, "u_w at 72");
    close(wear_at(120.0), 0.9483, 2e-4, "u_w at 120");
    let last = run.samples.last().unwrap();
    assert!((last.pressure - (1.0 - last.wear)).abs() < 1e-12);
}

#[test]
fn contact_holds_where_the_model_says_that_it_does() {
    let held = [paper(1.0), paper(3.9).with(Parameter::Gamma, 0.02)];
    for m in measure(Precision::F64, &Settings::from(Scheme::Radau), &held) {
        assert_eq!(m.contact.lost, None);
        assert!(m.contact.final_wear > 0.5);
    }
    let lost = measure(
        Precision::F64,
        &Settings::from(Scheme::Radau),
        &[paper(3.9).with(Parameter::Gamma, 0.025)],
    );
    close(lost[0].contact.lost.unwrap(), 55.4, 1e-3, "tau_c");
}

#[test]
fn the_whole_range_is_resolved_in_both_precisions() {
    let instances: Vec<_> = (0..=48).map(|i| paper(0.25 * f64::from(i))).collect();
    let double = measure(Precision::F64, &contact_settings(), &instances);
    let single = measure(Precision::F32, &contact_settings(), &instances);
    let fine = Settings {
        integration: Integration {
            tolerance: 1e-6,
            ..contact_settings().integration
        },
        ..contact_settings()
    };
    let reference = measure(Precision::F64, &fine, &instances);
    for (i, set) in instances.iter().enumerate() {
        let zeta_k = set[Parameter::ZetaK];
        assert_eq!(reference[i].status, Status::Ok, "{zeta_k}");
        for found in [&double[i], &single[i]] {
            assert_eq!(found.status, Status::Ok, "{zeta_k}");
            assert_eq!(
                found.contact.lost.is_some(),
                reference[i].contact.lost.is_some(),
                "{zeta_k}"
            );
            let pairs = [
                (
                    found.contact.peak_pressure,
                    reference[i].contact.peak_pressure,
                    "peak pressure",
                ),
                (found.contact.final_wear, reference[i].contact.final_wear, "wear"),
                (
                    found.contact.peak_temperature,
                    reference[i].contact.peak_temperature,
                    "temperature",
                ),
            ];
            for (found, expected, what) in pairs {
                close(found, expected, 5e-3, &format!("{what} at {zeta_k}"));
            }
        }
    }
    for (zeta_k, peak) in [(5, 247.96), (8, 2163.2), (12, 10477.0)] {
        close(reference[4 * zeta_k].contact.peak_pressure, peak, 2e-4, "peak pressure");
    }
}

#[test]
fn rough_tolerances_resolve_the_whole_range_too() {
    // a short step before the end of a period once left a guess that overflowed in f32
    let points: Vec<_> = (0..=192).map(|i| paper(0.0625 * f64::from(i))).collect();
    for tolerance in [1e-2, 1e-3] {
        let rough = Settings {
            integration: Integration {
                tolerance,
                ..contact_settings().integration
            },
            ..contact_settings()
        };
        for precision in [Precision::F64, Precision::F32] {
            let ok = |m: &Measurement| m.status == Status::Ok;
            assert!(
                measure(precision, &rough, &points).iter().all(ok),
                "{precision:?}, {tolerance}"
            );
        }
    }
}

#[test]
fn the_modes_agree_with_finite_volumes_and_with_the_volterra_integral() {
    let set = paper(3.9);
    let case: Case = preset(3.9);
    let settings = Settings {
        integration: Integration {
            modes: 24,
            tolerance: 1e-6,
            ..Scheme::Radau.into()
        },
        ..Settings::from(Scheme::Radau)
    };
    let ours = history(&set, &settings.integration, 0..2, 16);
    let volumes = finite_volume(&case, 6.3, 1e-4, 200);
    let integral = volterra(&case, 6.3, 5e-4);
    for sample in &ours.samples[1..] {
        for (reference, tolerance, name) in [(&volumes, 2e-4, "finite volumes"), (&integral, 2e-4, "Volterra")] {
            let at = reference.at(sample.tau);
            let what = format!("{name} at {}", sample.tau);
            close(sample.pressure, at.pressure, tolerance, &what);
            close(sample.wear, at.wear, tolerance, &what);
            // the flux swings through zero
            assert!((sample.temperature - at.temperature).abs() < 2e-3 * 300.0, "{what}");
            assert!(
                (sample.x - at.x).abs() < 1e-4 && (sample.y - at.y).abs() < 5e-4,
                "{what}"
            );
        }
    }
}

#[test]
fn modes_and_tolerance_converge() {
    // several points, since the error of a single one may be small by chance
    let worn = [3.5, 3.7, 3.9, 4.1, 4.3].map(paper);
    let instances: Vec<_> = worn.into_iter().chain([paper(3.5).with(Parameter::KW, 0.0)]).collect();
    let with = |modes, tolerance| {
        let settings = Settings {
            integration: Integration {
                modes,
                tolerance,
                ..Scheme::Radau.into()
            },
            sampling: Sampling {
                transient_periods: 40,
                align_periods: 10,
                periods: 30,
                ..Sampling::default()
            },
        };
        let measured = measure(Precision::F64, &settings, &instances);
        let wear = measured[..5].iter().map(|worn| worn.contact.final_wear).collect();
        (wear, measured[5].lyapunov)
    };
    let exact: (Vec<f64>, f64) = with(32, 1e-8);
    let errors = |found: (Vec<f64>, f64)| {
        let wear = found.0.iter().zip(&exact.0).map(|(wear, exact)| (wear - exact).abs());
        (wear.sum::<f64>() / 5.0, (found.1 - exact.1).abs())
    };
    // the rest beyond M modes falls with a high power of M: from 4 to 8 by more than four, from 8 to 16 by more than nine
    let [four, eight, sixteen] = [4, 8, 16].map(|modes| errors(with(modes, 1e-8)).0);
    assert!(
        eight < four / 4.0 && sixteen < eight / 9.0,
        "{four:e} {eight:e} {sixteen:e}"
    );
    // the tolerance bounds an estimate of order 3, the steps are of order 5
    let [coarse, fine] = [1e-2, 1e-4].map(|tolerance| errors(with(32, tolerance)));
    assert!(fine.0 < coarse.0 / 3.0 && fine.0 < 1e-4, "{coarse:?} {fine:?}");
    // a cycle is measured with a finer tolerance than that of the run
    assert!(fine.1 < coarse.1 / 5.0 && fine.1 < 1e-5, "{coarse:?} {fine:?}");
}

#[test]
fn without_heat_and_wear_the_scheme_gives_the_reduced_model() {
    let regular = ParameterSet::default().with(Parameter::ZetaK, 3.5);
    let chaotic = ParameterSet::default();
    let by = |scheme: Scheme| measure(Precision::F64, &scheme.into(), &[regular, chaotic]);
    let [radau, taylor] = [Scheme::Radau, Scheme::Taylor].map(by);
    // at the default tolerance
    assert!(
        (radau[0].lyapunov - taylor[0].lyapunov).abs() < 3e-4,
        "{} {}",
        radau[0].lyapunov,
        taylor[0].lyapunov
    );
    assert!((radau[0].x - taylor[0].x).abs() < 1e-4);
    assert_eq!((radau[0].class, radau[0].period), (taylor[0].class, taylor[0].period));
    assert_eq!(radau[1].class, Some(Class::Chaotic));
    let error = radau[1].lyapunov_error.hypot(taylor[1].lyapunov_error);
    assert!((radau[1].lyapunov - taylor[1].lyapunov).abs() < 4.0 * error);
}

#[test]
fn a_fast_start_does_not_lose_contact_at_once() {
    let instances = [-5.0, 5.0].map(|y0| paper(3.9).with(Parameter::Y0, y0));
    for m in measure(Precision::F64, &contact_settings(), &instances) {
        assert_eq!(m.status, Status::Ok);
        assert!(m.contact.lost.is_none_or(|time| time > 10.0), "{:?}", m.contact);
    }
}

#[test]
fn with_a_ramp_contact_begins_at_zero_and_can_come_back() {
    let ramped = paper(3.9).with(Parameter::RampRate, 0.05).with(Parameter::KW, 0.05);
    let run = history(&ramped, &Scheme::Radau.into(), 0..8, 64);
    assert_eq!(run.samples[0].pressure, 0.0);
    assert!(!run.given_up);
    for sample in &run.samples {
        assert!(sample.pressure >= 0.0, "{sample:?}");
    }
    // slow motion: the shaft cools while it rests, loses contact, and the fit that still grows closes the gap again
    let slow = paper(1.0).with(Parameter::Omega0, 0.2).with(Parameter::RampRate, 1e-5);
    let run = history(&slow, &Scheme::Radau.into(), 0..5, 256);
    let case = Case {
        set: slow,
        ramp_rate: Some(1e-5),
        ..preset(1.0)
    };
    let volumes = finite_volume(&case, 156.0, 4e-4, 60);
    close(run.contact_lost.unwrap(), volumes.tau_c.unwrap(), 1e-3, "tau_c");
    let closed = |of: &dyn Fn(f64) -> f64| -> Vec<bool> { (1..150).map(|tau| of(f64::from(tau)) > 0.0).collect() };
    let ours = closed(&|tau| {
        let after = run.samples.iter().position(|sample| sample.tau >= tau).unwrap();
        run.samples[after].pressure
    });
    let theirs = closed(&|tau| volumes.at(tau).pressure);
    let lost = ours.iter().position(|closed| !closed).unwrap();
    assert!(ours[lost..].iter().any(|closed| *closed), "contact came back");
    let differ = ours.iter().zip(&theirs).filter(|(a, b)| a != b).count();
    assert!(differ <= 2, "{differ} of {} times", ours.len());
    let last = run.samples.iter().find(|sample| sample.tau >= 150.0).unwrap();
    close(last.wear, volumes.at(last.tau).wear, 2e-3, "wear");
}

/// The state (x, v, h_U - u_w) after some periods, and a tangent vector started at (1, 0), in any number type.
fn followed<R: Real>(set: &ParameterSet, x0: R, periods: u32) -> ([R; 3], [R; 3]) {
    let settings = Settings {
        integration: Integration {
            tolerance: 1e-6,
            ..Scheme::Radau.into()
        },
        ..Settings::from(Scheme::Radau)
    };
    let modes = HeatModes::new(set, &ThermalModes::new(set[Parameter::Biot], 6));
    let system = System::<R>::new(|parameter| R::splat(set[parameter]), |_| &modes);
    let control = Control::new(&settings.integration);
    let mut orbit = Orbit::start(&system, x0, R::splat(set[Parameter::Y0]));
    let mut peaks = Peaks::start(&orbit);
    let mut tangent = [Tangent::at(&orbit, &system, &[R::splat(1.0)])];
    let mut scratch = vec![ModeStep::empty(); modes.rates.len()];
    for _ in 0..periods {
        orbit.period(&system, &control, &mut peaks, &mut tangent, &mut scratch);
    }
    let [tangent] = tangent;
    (
        [orbit.x, orbit.v, orbit.fit],
        [tangent.at.x, tangent.at.v, tangent.at.fit],
    )
}

#[test]
fn the_tangent_of_the_full_state_is_the_derivative_by_dual_numbers() {
    for (zeta_k, k_w, periods) in [
        (3.9, 0.01, 1),
        (3.9, 0.0, 3),
        (3.5, 0.02, 2),
        (7.0, 0.01, 1),
        (1.5, 0.05, 2),
    ] {
        let set = paper(zeta_k).with(Parameter::KW, k_w).with(Parameter::X0, 0.3);
        let x0 = Dual {
            value: 0.3,
            derivatives: [1.0, 0.0],
        };
        let (state, _) = followed(&set, x0, periods);
        let (_, tangent) = followed(&set, 0.3, periods);
        let scale = tangent.iter().map(|component| component.abs()).fold(0.0, f64::max);
        for (dual, ours) in state.iter().zip(tangent) {
            let error = (dual.derivatives[0] - ours).abs() / scale;
            assert!(error < 1e-5, "{zeta_k} {k_w}: {dual:?} {ours}");
        }
    }
}

#[test]
fn the_heat_put_in_is_stored_or_lost_at_the_surface() {
    // (sum c_m q_m)' = Q - omega_tilde Bi theta(1)/gamma, in terms of the pressure: p - (1 - u_w) = 2 gamma sum c_m q_m
    let set = paper(3.9);
    let settings = Settings {
        integration: Integration {
            tolerance: 1e-6,
            ..Scheme::Radau.into()
        },
        ..Settings::from(Scheme::Radau)
    };
    let run = history(&set, &settings.integration, 0..3, 2000);
    let (gamma, cooling) = (set[Parameter::Gamma], set[Parameter::OmegaTilde] * set[Parameter::Biot]);
    let friction = |v: f64| crate::oracle::friction(&set, v);
    // Simpson's rule over pairs of samples
    let integral = |of: &dyn Fn(&Sample) -> f64| {
        run.samples[..run.samples.len() - 1]
            .chunks_exact(2)
            .enumerate()
            .map(|(pair, two)| {
                let last = &run.samples[2 * pair + 2];
                (of(&two[0]) + 4.0 * of(&two[1]) + of(last)) * (last.tau - two[0].tau) / 6.0
            })
            .sum::<f64>()
    };
    let put_in = integral(&|s| friction(s.v) * s.v * s.pressure);
    let lost = integral(&|s| cooling * s.temperature / gamma);
    let last = run.samples.last().unwrap();
    let stored = (last.pressure - (1.0 - last.wear)) / (2.0 * gamma);
    assert!(put_in > 100.0);
    close(stored + lost, put_in, 2e-5, "heat");
}
