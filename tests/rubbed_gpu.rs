//! The full model on a GPU: the figures of the CPU in f64, its limits, and that no cutting into batches shows.

#![cfg(feature = "gpu")]

mod gpu_context;

use std::ops::ControlFlow;

use tribochaos::backend::cpu::CpuBackend;
use tribochaos::backend::gpu::GpuBackend;
use tribochaos::backend::{Backend, BackendError, EndState, Instance, Slice, Stage};
use tribochaos::experiment::{Integration, Precision, Preset, Sampling, Scheme, Settings};
use tribochaos::measure::{Measurement, Status, measure_batch};
use tribochaos::parameters::{Parameter, ParameterSet};

/// The preset of section 5 at this zeta_k, with or without wear.
fn preset(zeta_k: f64, k_w: f64) -> ParameterSet {
    Preset::Paper
        .parameters()
        .with(Parameter::ZetaK, zeta_k)
        .with(Parameter::KW, k_w)
}

fn settings() -> Settings {
    Settings {
        integration: Integration {
            modes: 8,
            tolerance: 1e-4,
            ..Integration::from(Scheme::Radau)
        },
        sampling: Sampling {
            transient_periods: 60,
            align_periods: 30,
            periods: 60,
            ..Sampling::default()
        },
    }
}

fn measure(backend: &mut dyn Backend, settings: &Settings, points: &[ParameterSet]) -> Vec<Measurement> {
    measure_batch(backend, settings, &Instance::starts(points), &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap()
    .expect("nothing breaks the run off")
}

/// All of a measurement; floats in full.
fn text(measurements: &[Measurement]) -> Vec<String> {
    measurements
        .iter()
        .map(|measurement| format!("{measurement:?}"))
        .collect()
}

fn is_near(a: f64, b: f64, part: f64) -> bool {
    (a - b).abs() <= part * b.abs()
}

#[test]
fn wear_and_heat_are_those_of_f64_over_the_whole_range() {
    let Some(context) = gpu_context::open() else { return };
    let settings = Settings {
        sampling: Sampling {
            periods: 30,
            ..settings().sampling
        },
        ..settings()
    };
    let instances: Vec<_> = (0..=24).map(|i| preset(0.5 * f64::from(i), 0.01)).collect();
    let gpu = measure(&mut GpuBackend::new(context), &settings, &instances);
    let finely = Settings {
        integration: Integration {
            tolerance: 1e-6,
            ..settings.integration
        },
        ..settings
    };
    let cpu = measure(&mut CpuBackend::new(Precision::F64), &finely, &instances);
    for (set, (gpu, cpu)) in instances.iter().zip(gpu.iter().zip(&cpu)) {
        let zeta_k = set[Parameter::ZetaK];
        assert_eq!((gpu.status, cpu.status), (Status::Ok, Status::Ok), "{zeta_k}");
        let (a, b) = (&gpu.contact, &cpu.contact);
        assert_eq!(a.lost.is_some(), b.lost.is_some(), "{zeta_k}");
        // some thirty periods of chaotic transient magnify the errors of rounding and of the steps
        for (what, a, b, part) in [
            ("contact time", a.lost.unwrap_or(1.0), b.lost.unwrap_or(1.0), 1e-4),
            ("wear", a.final_wear, b.final_wear, 1e-4),
            ("peak pressure", a.peak_pressure, b.peak_pressure, 1e-3),
            ("its time", a.peak_pressure_time, b.peak_pressure_time, 1e-2),
            ("peak temperature", a.peak_temperature, b.peak_temperature, 5e-3),
        ] {
            assert!(is_near(a, b, part), "{what} at {zeta_k}: {a} for {b}");
        }
        assert!((gpu.lyapunov - cpu.lyapunov).abs() < 1e-3, "{zeta_k}: {gpu:?} {cpu:?}");
        assert_eq!(gpu.lyapunov_interval.round(), cpu.lyapunov_interval.round());
    }
}

#[test]
fn the_figures_of_section_5_come_out() {
    let Some(context) = gpu_context::open() else { return };
    let mut backend = GpuBackend::new(context);
    let instances = [preset(3.5, 0.01), preset(3.9, 0.01)];
    let expected = [
        [65.840, 27.053, 92.321, 6.722, 296.0],
        [72.0556, 30.206, 95.955, 6.733, 543.0],
    ];
    for (measured, expected) in measure(&mut backend, &settings(), &instances).iter().zip(expected) {
        let contact = &measured.contact;
        let found = [
            contact.lost.unwrap_or(f64::NAN),
            contact.final_wear,
            contact.peak_pressure,
            contact.peak_pressure_time,
            contact.peak_temperature,
        ];
        for (i, part) in [1e-3, 1e-3, 1e-3, 1e-3, 2e-2].into_iter().enumerate() {
            assert!(is_near(found[i], expected[i], part), "{found:?} for {expected:?}");
        }
    }
    let instances = [preset(3.5, 0.0), preset(3.9, 0.0)];
    for (measured, (period, exponent)) in measure(&mut backend, &settings(), &instances)
        .iter()
        .zip([(2, -0.0808), (1, -0.4474)])
    {
        assert_eq!((measured.status, measured.period), (Status::Ok, Some(period)));
        assert!(is_near(measured.lyapunov, exponent, 1e-2), "{measured:?}");
        assert!(measured.contact.lost.is_none() && measured.contact.final_wear.abs() < 1e-6);
    }
}

#[test]
fn short_trajectories_are_those_of_the_cpu() {
    let Some(context) = gpu_context::open() else { return };
    // Rounding changes where steps end. At the usual tolerance, the errors of the steps then differ by too much at a rare point.
    let settings = Settings {
        integration: Integration {
            tolerance: 1e-5,
            ..settings().integration
        },
        ..settings()
    };
    // wear and none, a ramp and none, a thin layer, heat alone, and neither heat nor wear
    let points: Vec<_> = (0..128)
        .map(|i| {
            let set = preset(0.1 * f64::from(i), 0.01 * f64::from(i % 3));
            match i % 8 {
                0 => set.with(Parameter::RampRate, 0.1),
                7 => set.with(Parameter::Y0, -5.0),
                1 => set
                    .with(Parameter::Epsilon0, 1e-3)
                    .with(Parameter::ZetaK, 0.02 * f64::from(i)),
                2 => set.with(Parameter::Gamma, 0.0),
                3 => set.with(Parameter::Gamma, 0.0).with(Parameter::KW, 0.0),
                4 => set.with(Parameter::Biot, 1.0).with(Parameter::OmegaTilde, 1.0),
                _ => set.with(Parameter::X0, 0.7),
            }
        })
        .collect();
    let mut gpu = GpuBackend::new(context);
    let mut cpu = CpuBackend::new(Precision::F64);
    let instances = Instance::starts(&points);
    gpu.load(&settings, &instances).unwrap();
    cpu.load(&settings, &instances).unwrap();
    for first in 0..3 {
        let slice = Slice {
            stage: Stage::Measure,
            first,
            periods: 1,
            elapsed: first,
        };
        gpu.advance(&slice).unwrap();
        cpu.advance(&slice).unwrap();
        let sums = gpu.collect().unwrap().into_iter().zip(cpu.collect().unwrap());
        let ends = gpu.end_states().unwrap().into_iter().zip(cpu.end_states().unwrap());
        for (i, ((a, b), (a_sums, b_sums))) in ends.zip(sums).enumerate() {
            let what = format!("{i} at {first}: {a:?} {a_sums:?} for {b:?} {b_sums:?}");
            assert!(!a.under_resolved && !b.under_resolved, "{what}");
            let distance = (a.x - b.x).abs().max((a.y - b.y).abs());
            let extremes = (a.x_min - b.x_min).abs().max((a.x_max - b.x_max).abs());
            assert!(distance < 1e-3 && extremes < 1e-3, "{what}");
            assert!((a_sums.growth[0] - b_sums.growth[0]).abs() < 1e-2, "{what}");
            let (a, b) = (a.contact, b.contact);
            assert!(is_near(a.peak_pressure, b.peak_pressure, 1e-3), "{what}");
            assert!(is_near(a.peak_temperature, b.peak_temperature, 1e-2), "{what}");
            assert!(
                (a.final_wear - b.final_wear).abs() < 5e-4 * (1.0 + b.final_wear),
                "{what}"
            );
            assert_eq!(a.lost.is_some(), b.lost.is_some(), "{what}");
        }
    }
}

#[test]
fn neither_the_batch_nor_the_slices_nor_what_ran_before_show_in_the_results() {
    let Some(context) = gpu_context::open() else { return };
    let settings = Settings {
        sampling: Sampling {
            transient_periods: 4,
            align_periods: 2,
            periods: 16,
            ..settings().sampling
        },
        ..settings()
    };
    // those with wear and those without are carried on apart
    let points: Vec<_> = (0..150)
        .map(|i| preset(0.05 * f64::from(i), 0.01 * f64::from(i % 2)))
        .collect();
    let mut backend = GpuBackend::new(context);
    let all = text(&measure(&mut backend, &settings, &points));
    let mut parts = text(&measure(&mut backend, &settings, &points[..70]));
    parts.extend(text(&measure(&mut backend, &settings, &points[70..])));
    assert_eq!(parts, all);
    // other kernels in between, of another number of modes and of another scheme
    let other = Settings {
        integration: Integration {
            modes: 3,
            ..settings.integration
        },
        ..settings
    };
    measure(&mut backend, &other, &points[..5]);
    let rk4 = Settings {
        integration: Scheme::Rk4.into(),
        ..settings
    };
    measure(&mut backend, &rk4, &[ParameterSet::default()]);
    assert_eq!(text(&measure(&mut backend, &settings, &points)), all);

    let mut run = |cuts: &[u32]| {
        backend.load(&settings, &Instance::starts(&points)).unwrap();
        let mut first = 0;
        for &periods in cuts {
            let slice = Slice {
                stage: Stage::Measure,
                first,
                periods,
                elapsed: first,
            };
            backend.advance(&slice).unwrap();
            first += periods;
        }
        let sums = backend.collect().unwrap();
        assert!(backend.collect().unwrap().iter().all(|sums| sums.growth[0] == 0.0));
        (format!("{sums:?}"), format!("{:?}", backend.end_states().unwrap()))
    };
    assert_eq!(run(&[16]), run(&[1, 2, 13]));
}

#[test]
fn runaways_are_reported_and_nothing_more_is_asked_of_them() {
    let Some(context) = gpu_context::open() else { return };
    let settings = Settings {
        sampling: Sampling {
            transient_periods: 4,
            align_periods: 2,
            periods: 16,
            ..settings().sampling
        },
        ..settings()
    };
    // where friction does not brake the bush, heat feeds on heat
    let instances = [preset(3.0, 0.0), preset(3.0, 0.0).with(Parameter::Epsilon, 0.0)];
    let gpu = measure(&mut GpuBackend::new(context), &settings, &instances);
    let cpu = measure(&mut CpuBackend::new(Precision::F64), &settings, &instances);
    assert_eq!(gpu[0].status, Status::Ok);
    let [Status::Runaway { time: on_gpu }, Status::Runaway { time: on_cpu }] = [gpu[1].status, cpu[1].status] else {
        panic!("{gpu:?} {cpu:?}");
    };
    assert!((on_gpu - on_cpu).abs() < 1e-5, "{on_gpu} {on_cpu}");
    // steps of all tolerances lead to this time; without interpolation in the last one, it is 1e-3 wrong
    assert!((on_cpu - 0.679455).abs() < 1e-5, "{on_cpu}");
}

#[test]
fn numbers_of_modes_beyond_the_shader_s_are_refused() {
    let Some(context) = gpu_context::open() else { return };
    let mut backend = GpuBackend::new(context);
    for modes in [0, 65] {
        let settings = Settings {
            integration: Integration {
                modes,
                ..settings().integration
            },
            ..settings()
        };
        let error = backend.load(&settings, &[preset(3.0, 0.0).into()]).unwrap_err();
        assert!(matches!(error, BackendError::Unsupported(_)), "{error:?}");
        assert!(
            error.to_string().contains("64") && error.to_string().contains("--modes"),
            "{error}"
        );
    }
    // many modes still work, and give what few do
    let load = Settings {
        integration: Integration {
            modes: 64,
            ..settings().integration
        },
        sampling: Sampling {
            periods: 24,
            ..settings().sampling
        },
    };
    let [many] = measure(&mut backend, &load, &[preset(3.9, 0.01)])[..] else {
        unreachable!()
    };
    assert!(is_near(many.contact.lost.unwrap(), 72.0556, 1e-4), "{many:?}");
    assert!(is_near(many.contact.peak_temperature, 543.0, 1e-2), "{many:?}");
}

/// The legs are the GPU's; cycles are found from its states on the CPU, with the heat that they have.
#[test]
fn heated_points_are_decided_early_as_on_the_cpu() {
    let Some(context) = gpu_context::open() else { return };
    let settings = Settings::from(Scheme::Radau);
    let points: Vec<_> = (0..12)
        .map(|i| {
            let gamma = if i % 2 == 0 { 0.02 } else { 1.87 };
            preset(3.05 + 0.25 * f64::from(i), 0.0).with(Parameter::Gamma, gamma)
        })
        .collect();
    let gpu = measure(&mut GpuBackend::new(context), &settings, &points);
    let cpu = measure(&mut CpuBackend::new(Precision::F64), &settings, &points);
    let full = settings.sampling.transient_periods + settings.sampling.periods;
    assert!(
        gpu.iter().filter(|m| m.integrated_periods < full / 2).count() > 9,
        "{gpu:?}"
    );
    for (gpu, cpu) in gpu.iter().zip(&cpu) {
        assert_eq!((gpu.class, gpu.period), (cpu.class, cpu.period), "{gpu:?}\n{cpu:?}");
        for (a, b) in [(gpu.lyapunov, cpu.lyapunov), (gpu.lyapunov_second, cpu.lyapunov_second)] {
            assert!((a - b).abs() < 1e-3, "{gpu:?}\n{cpu:?}");
        }
        let peaks = [gpu, cpu].map(|m| m.contact.peak_pressure);
        assert!(is_near(peaks[0], peaks[1], 2e-3), "{gpu:?}\n{cpu:?}");
    }
}

#[test]
fn a_heated_run_on_the_gpu_can_be_taken_up_again() {
    let Some(context) = gpu_context::open() else { return };
    let (settings, points) = (settings(), [preset(3.9, 0.0), preset(3.5, 0.0), preset(1.0, 0.0)]);
    let mut backend = GpuBackend::new(context);
    let mut advance = |instances: Option<Vec<Instance>>, stage| {
        if let Some(instances) = instances {
            backend.load(&settings, &instances).unwrap();
        }
        let slice = Slice {
            stage,
            first: 0,
            periods: 10,
            elapsed: 0,
        };
        backend.advance(&slice).unwrap();
        (backend.end_states().unwrap(), backend.collect().unwrap())
    };
    let starts = Instance::starts(&points);
    let (middle, _) = advance(Some(starts.clone()), Stage::Align);
    let (expected, expected_sums) = advance(None, Stage::Measure);
    let again = starts.iter().zip(&middle).map(|(start, end)| start.at(end)).collect();
    let (found, sums) = advance(Some(again), Stage::Measure);
    for i in 0..points.len() {
        let heat = |end: &EndState| {
            end.heated
                .as_ref()
                .map(|heated| (heated.periods, heated.pressures.clone()))
        };
        let [(periods, a), (_, b)] = [&found[i], &expected[i]].map(|end| heat(end).expect("heat stays"));
        assert_eq!(periods, 20.0);
        for (a, b) in a.iter().zip(&b) {
            assert!((a - b).abs() < 1e-3 * (1.0 + b.abs()), "{i}: {a}, not {b}");
        }
        assert!((found[i].x - expected[i].x).abs() < 1e-3, "{i}");
        assert!((sums[i].growth[0] - expected_sums[i].growth[0]).abs() < 2e-2, "{i}");
    }
}
