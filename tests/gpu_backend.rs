//! The GPU backend as a backend: its limits, its errors, and that no cutting into batches and dispatches shows.

#![cfg(feature = "gpu")]

mod gpu_context;
mod points;

use std::f64::consts::{LN_2, PI};
use std::ops::ControlFlow;
use std::thread;
use std::time::{Duration, Instant};

use tribochaos::backend::cpu::CpuBackend;
use tribochaos::backend::gpu::shader_source::Lanes;
use tribochaos::backend::gpu::{GpuBackend, GpuContext};
use tribochaos::backend::{Backend, BackendError, BackendKind, Instance, Slice, Stage};
use tribochaos::experiment::{Integration, Precision, Request, Sampling, Scheme, Settings};
use tribochaos::measure::{Measurement, Status, measure_batch};
use tribochaos::parameters::{Parameter, ParameterSet};

use points::line;

fn measure(backend: &mut dyn Backend, settings: &Settings, points: &[ParameterSet]) -> Vec<Measurement> {
    measure_batch(backend, settings, &Instance::starts(points), &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap()
    .expect("nothing breaks the run off")
}

/// A backend whose threads have so many lanes.
fn with_lanes(lanes: Lanes) -> Option<GpuBackend> {
    let context = gpu_context::open()?;
    Some(GpuBackend::new(context.with_lanes(lanes)))
}

fn cheap() -> Settings {
    Settings {
        integration: Integration {
            steps_per_period: 100,
            ..Integration::default()
        },
        sampling: Sampling {
            transient_periods: 20,
            align_periods: 10,
            periods: 40,
            ..Sampling::default()
        },
    }
}

/// All of a measurement; floats in full.
fn text(measurements: &[Measurement]) -> Vec<String> {
    measurements
        .iter()
        .map(|measurement| format!("{measurement:?}"))
        .collect()
}

#[test]
fn a_batch_of_more_workgroups_than_a_dispatch_may_have_is_carried_on_whole() {
    let Some(context) = gpu_context::or_skip(GpuContext::open_with_workgroups(None, true, 3)) else {
        return;
    };
    let settings = Settings {
        integration: Integration {
            steps_per_period: 8,
            ..Integration::default()
        },
        ..Settings::default()
    };
    // 15 workgroups and a part of one
    let instances = Instance::starts(&line(1000));
    let mut gpu = GpuBackend::new(context.with_lanes(Lanes::One));
    let mut cpu = CpuBackend::new(Precision::F32);
    let mut ends = Vec::new();
    for backend in [&mut gpu as &mut dyn Backend, &mut cpu] {
        backend.load(&settings, &instances).unwrap();
        let slice = Slice {
            stage: Stage::Transient,
            first: 0,
            periods: 1,
            elapsed: 0,
        };
        backend.advance(&slice).unwrap();
        ends.push(backend.end_states().unwrap());
    }
    for (i, (a, b)) in ends[0].iter().zip(&ends[1]).enumerate() {
        assert!((a.x - b.x).abs() < 1e-4 && (a.y - b.y).abs() < 1e-4, "{i}: {a:?} {b:?}");
    }
}

fn assert_same(found: &[String], expected: &[String]) {
    assert_eq!(found.len(), expected.len());
    for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert_eq!(found, expected, "{i}");
    }
}

#[test]
fn neither_the_batch_nor_what_ran_before_shows_in_the_results() {
    let Some(context) = gpu_context::open() else { return };
    let (settings, instances) = (cheap(), line(300));
    let mut backend = GpuBackend::new(context);
    let all = text(&measure(&mut backend, &settings, &instances));
    // smaller batches in the same buffers
    let mut parts = text(&measure(&mut backend, &settings, &instances[..100]));
    parts.extend(text(&measure(&mut backend, &settings, &instances[100..])));
    assert_same(&parts, &all);
    // a longer measurement in between needs new buffers
    let longer = Settings {
        sampling: Sampling {
            periods: 60,
            ..settings.sampling
        },
        ..settings
    };
    measure(&mut backend, &longer, &instances[..7]);
    assert_same(&text(&measure(&mut backend, &settings, &instances)), &all);
    assert!(measure(&mut backend, &settings, &[]).is_empty());
}

/// Bounded orbits, orbits that run away and orbits that are given up, side by side, on lanes that the last thread has to
/// spare.
#[test]
fn lanes_do_not_feel_their_neighbours() {
    let instances: Vec<ParameterSet> = line(203)
        .into_iter()
        .enumerate()
        .map(|(i, set)| match i % 7 {
            2 | 3 => set.with(Parameter::B, -0.003 * i as f64).with(Parameter::Beta, 0.0),
            // the bush sticks in a layer of which 8192 steps do not reach the period's end
            5 => set
                .with(Parameter::Epsilon0, 1.01e-4)
                .with(Parameter::F0, 20.0)
                .with(Parameter::ZetaK, 0.01),
            _ => set,
        })
        .collect();
    for scheme in [Scheme::Taylor, Scheme::Rk4] {
        let settings = Settings {
            integration: Integration {
                steps_per_period: 100,
                ..scheme.into()
            },
            sampling: Sampling {
                decide_early: false,
                ..cheap().sampling
            },
        };
        let mut alone = None;
        for lanes in Lanes::ALL {
            let Some(mut backend) = with_lanes(lanes) else { return };
            let measured = measure(&mut backend, &settings, &instances);
            let count = |is: fn(&Status) -> bool| measured.iter().filter(|point| is(&point.status)).count();
            assert!(count(|status| matches!(status, Status::Runaway { .. })) > 20);
            // those that were given up are left to the CPU
            let completed = measured.iter().filter(|point| point.backend == BackendKind::CpuF64);
            assert!(scheme == Scheme::Rk4 || completed.count() > 20);
            let measured = text(&measured);
            // a driver of hardware may order operations as it likes in each
            if backend.context().description().is_software {
                assert_eq!(
                    &measured,
                    alone.get_or_insert_with(|| measured.clone()),
                    "{scheme:?} {lanes:?}"
                );
            }
        }
    }
}

#[test]
fn a_run_that_is_taken_up_again_goes_on_as_if_it_had_not_been_interrupted() {
    let points = line(33);
    for lanes in Lanes::ALL {
        let Some(mut backend) = with_lanes(lanes) else { return };
        for scheme in [Scheme::Taylor, Scheme::Rk4] {
            let settings = Settings {
                integration: scheme.into(),
                ..cheap()
            };
            // by the same kernel in all periods, which a driver may translate otherwise than the next one
            let mut advance = |instances: Option<&[Instance]>| -> Vec<Instance> {
                if let Some(instances) = instances {
                    backend.load(&settings, instances).unwrap();
                }
                let slice = Slice {
                    stage: Stage::Align,
                    first: 0,
                    periods: 10,
                    elapsed: 0,
                };
                backend.advance(&slice).unwrap();
                let ends = backend.end_states().unwrap();
                let taken_up = points.iter().zip(&ends);
                taken_up.map(|(&point, end)| Instance::from(point).at(end)).collect()
            };
            let middle = advance(Some(&Instance::starts(&points)));
            let expected = advance(None);
            assert_ne!(middle, expected, "{scheme:?} {lanes:?}");
            assert_eq!(advance(Some(&middle)), expected, "{scheme:?} {lanes:?}");
        }
    }
}

#[test]
fn slices_add_up_and_sums_are_collected_once() {
    let Some(context) = gpu_context::open() else { return };
    let (settings, instances) = (cheap(), Instance::starts(&line(50)));
    let mut backend = GpuBackend::new(context);
    let mut run = |cuts: &[u32]| {
        backend.load(&settings, &instances).unwrap();
        let mut first = 0;
        for &periods in cuts {
            backend
                .advance(&Slice {
                    stage: Stage::Measure,
                    first,
                    periods,
                    elapsed: first,
                })
                .unwrap();
            first += periods;
        }
        let sums = backend.collect().unwrap();
        assert!(
            backend
                .collect()
                .unwrap()
                .iter()
                .all(|sums| sums.growth == [0.0; 2] && sums.divergence == 0.0)
        );
        (sums, backend.end_states().unwrap())
    };
    let (whole, whole_ends) = run(&[40]);
    let (cut, cut_ends) = run(&[1, 2, 17, 20]);
    assert_eq!(format!("{whole_ends:?}"), format!("{cut_ends:?}"));
    for (a, b) in whole.iter().zip(&cut) {
        assert_eq!(a.growth, b.growth);
        assert_eq!(a.divergence, b.divergence);
        assert_eq!(a.birkhoff, b.birkhoff);
    }
}

/// On a GPU radau carries one tangent vector and no divergence. Its exponents still have an error, which covers the difference from
/// taylor in f64.
#[test]
fn exponents_by_radau_have_an_error_that_covers_theirs() {
    let Some(context) = gpu_context::open() else { return };
    let thin = |zeta_k, epsilon_0| {
        ParameterSet::default()
            .with(Parameter::ZetaK, zeta_k)
            .with(Parameter::Epsilon0, epsilon_0)
    };
    let points = [thin(2.0, 0.01), thin(2.0, 2e-4), thin(3.9, 0.01), thin(6.0, 1e-3)];
    let settings = Settings {
        integration: Scheme::Radau.into(),
        sampling: Sampling {
            decide_early: false,
            ..Sampling::default()
        },
    };
    let on_gpu = measure(&mut GpuBackend::new(context), &settings, &points);
    let exact = measure(&mut CpuBackend::new(Precision::F64), &Settings::default(), &points);
    // in a thin layer, the rounding of f32 has a share of its own
    assert!(
        on_gpu[1].scheme_error > 1e-3 * on_gpu[1].lyapunov.abs(),
        "{:?}",
        on_gpu[1]
    );
    for (m, exact) in on_gpu.iter().zip(&exact) {
        assert_eq!(m.class, exact.class);
        assert!(m.scheme_error >= 0.0 && m.lyapunov_error >= m.scheme_error, "{m:?}");
        let allowed = 3.0 * m.lyapunov_error.hypot(exact.lyapunov_error);
        assert!((m.lyapunov - exact.lyapunov).abs() <= allowed, "{m:?} {exact:?}");
    }
}

#[test]
fn runaways_are_found_when_they_happen_as_on_the_cpu() {
    let settings = Settings {
        sampling: Sampling {
            transient_periods: 20,
            align_periods: 5,
            periods: 20,
            ..Sampling::default()
        },
        ..Settings::default()
    };
    // bounded orbits; softening springs, which let go in finite time and end as NaN; and x' = y = x = 5e3, the bound, ln 2 before
    // tau = pi (k + 1/2), the middle of period k + 1 (k below 10: of smaller speeds the sliding speed, which radau carries,
    // keeps few digits)
    let instances: Vec<ParameterSet> = (0..96)
        .map(|i| {
            let set = ParameterSet::default();
            let linear = 1e4 * (-PI * (f64::from(i / 3 % 10) + 0.5)).exp();
            match i % 3 {
                0 => set,
                // without the cubic drag, which is too stiff at the speed of a runaway
                1 => set.with(Parameter::B, -0.02 * f64::from(i)).with(Parameter::Beta, 0.0),
                _ => set
                    .with(Parameter::B, 0.0)
                    .with(Parameter::Epsilon, 0.0)
                    .with(Parameter::X0, linear)
                    .with(Parameter::Y0, linear),
            }
        })
        .collect();
    let escape = |measurement: &Measurement| match measurement.status {
        Status::Runaway { time } => time,
        other => panic!("{other:?}"),
    };
    for lanes in Lanes::ALL {
        let Some(mut gpu) = with_lanes(lanes) else { return };
        let gpu = measure(&mut gpu, &settings, &instances);
        for precision in [Precision::F32, Precision::F64] {
            let cpu = measure(&mut CpuBackend::new(precision), &settings, &instances);
            for (i, (a, b)) in gpu.iter().zip(&cpu).enumerate() {
                match i % 3 {
                    0 => assert!(a.status == Status::Ok && b.status == Status::Ok, "{i}"),
                    1 => assert!(
                        (escape(a) - escape(b)).abs() < 1e-3,
                        "{i}: {:?} {:?}",
                        a.status,
                        b.status
                    ),
                    _ => {
                        let time = ((i / 3 % 10) as f64 + 0.5) * PI - LN_2;
                        assert!(
                            (escape(a) - time).abs() < 1e-3 && (escape(b) - time).abs() < 1e-3,
                            "{i}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn a_device_lost_in_the_middle_of_a_run_is_reported_at_once() {
    let Some(context) = gpu_context::open() else { return };
    let device = context.device().clone();
    let mut backend = GpuBackend::new(context);
    let instances = Instance::starts(&line(64));
    // one load for the whole run
    let settings = Settings {
        sampling: Sampling {
            decide_early: false,
            ..Sampling::default()
        },
        ..Settings::default()
    };
    let mut lost_at = None;
    let mut slices = 0;
    let result = measure_batch(&mut backend, &settings, &instances, &mut |_| {
        slices += 1;
        if slices == 3 {
            device.destroy();
            lost_at = Some(Instant::now());
        }
        assert!(slices <= 3, "no slice is carried out after the loss");
        ControlFlow::Continue(())
    });
    assert!(matches!(result, Err(BackendError::DeviceLost(_))), "{result:?}");
    assert!(lost_at.unwrap().elapsed() < Duration::from_secs(5));
    // and so is every later use
    for _ in 0..2 {
        let error = backend.load(&settings, &instances).unwrap_err();
        assert!(matches!(error, BackendError::DeviceLost(_)), "{error}");
    }
    assert!(matches!(backend.end_states(), Err(BackendError::DeviceLost(_))));
}

#[test]
fn a_device_lost_while_it_computes_is_reported_at_once() {
    let Some(context) = gpu_context::open() else { return };
    let device = context.device().clone();
    let mut backend = GpuBackend::new(context);
    let killer = thread::spawn(move || {
        thread::sleep(Duration::from_millis(300));
        device.destroy();
        Instant::now()
    });
    let endless = Settings {
        sampling: Sampling {
            transient_periods: 10_000_000,
            decide_early: false,
            ..Sampling::default()
        },
        ..Settings::default()
    };
    let result = measure_batch(&mut backend, &endless, &Instance::starts(&line(512)), &mut |_| {
        ControlFlow::Continue(())
    });
    let lost_at = killer.join().unwrap();
    assert!(matches!(result, Err(BackendError::DeviceLost(_))), "{result:?}");
    assert!(lost_at.elapsed() < Duration::from_secs(5));
}

#[test]
fn a_device_lost_before_a_batch_is_loaded_is_reported_as_lost() {
    let Some(context) = gpu_context::open() else { return };
    context.device().destroy();
    let mut backend = GpuBackend::new(context);
    let result = backend.load(&cheap(), &Instance::starts(&line(10)));
    assert!(matches!(result, Err(BackendError::DeviceLost(_))), "{result:?}");
}

#[test]
fn what_the_gpu_cannot_do_is_refused_with_a_remedy() {
    let Some(context) = gpu_context::open() else { return };
    let mut backend = GpuBackend::new(context);
    let instance = [ParameterSet::default().into()];
    let mut refusal = |settings: &Settings, instances: &[Instance]| {
        let error = backend.load(settings, instances).unwrap_err();
        assert!(matches!(error, BackendError::Unsupported(_)), "{error:?}");
        error.to_string()
    };
    let many_steps = |steps_per_period| Settings {
        integration: Integration {
            steps_per_period,
            ..Integration::from(Scheme::Rk4)
        },
        ..Settings::default()
    };
    let message = refusal(&many_steps(8193), &instance);
    assert!(
        message.contains("8193") && message.contains("8192") && message.contains("--backend cpu"),
        "{message}"
    );
    backend.load(&many_steps(8192), &instance).unwrap();
}

#[test]
fn a_batch_larger_than_a_buffer_is_refused_and_a_smaller_one_taken() {
    let Some(context) = gpu_context::open() else { return };
    let limits = context.device().limits();
    let most = (limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) / 1024) as usize;
    if most > 1 << 20 {
        return eprintln!("skipped: this device's buffers are too large to overflow in a test");
    }
    let mut backend = GpuBackend::new(context);
    assert!(backend.batch_size(&cheap()) <= most);
    let instances = vec![Instance::from(ParameterSet::default()); most + 1];
    let error = backend.load(&cheap(), &instances).unwrap_err();
    assert!(error.to_string().contains(&most.to_string()), "{error}");
    backend.load(&cheap(), &instances[..1]).unwrap();
}

#[test]
fn adapters_are_chosen_by_name_and_software_only_where_allowed() {
    let adapters = tribochaos::backend::gpu::adapters();
    let error = GpuContext::open(Some("no such thing"), true).err().unwrap();
    assert!(matches!(error, BackendError::NoDevice(_)), "{error}");
    let Some(first) = adapters.first() else {
        return drop(gpu_context::open());
    };
    let context = gpu_context::or_skip(GpuContext::open(Some(&first.name.to_uppercase()), true)).unwrap();
    assert_eq!(context.description().name, first.name);
    let backend = GpuBackend::new(context);
    assert!(backend.device().contains(&first.name) && backend.device().ends_with("f32"));
    if first.is_software {
        let message = GpuContext::open(None, false).err().unwrap().to_string();
        assert!(
            message.contains(&first.name) && message.contains("--backend cpu"),
            "{message}"
        );
    }
}

/// Legs, turns along cycles and what is left at full length, each a batch of another size.
#[test]
fn points_are_decided_early_as_on_the_cpu() {
    let grid = Request::default().resolve().unwrap().design;
    let instances: Vec<_> = (0..grid.len()).step_by(401).map(|index| grid.point(index)).collect();
    let settings = Settings::default();
    let on_cpu = measure(&mut CpuBackend::new(Precision::F64), &settings, &instances);
    for lanes in Lanes::ALL {
        let Some(mut gpu) = with_lanes(lanes) else { return };
        let on_gpu = measure(&mut gpu, &settings, &instances);
        assert_alike(&on_gpu, &on_cpu, &settings);
    }
}

fn assert_alike(on_gpu: &[Measurement], on_cpu: &[Measurement], settings: &Settings) {
    let pairs = || on_gpu.iter().zip(on_cpu);
    let full_length = settings.sampling.transient_periods + settings.sampling.periods;
    let early = pairs().filter(|(gpu, _)| gpu.integrated_periods < full_length);
    assert!(early.count() * 100 >= 95 * on_cpu.len());
    let same = pairs().filter(|(gpu, cpu)| gpu.class == cpu.class).count();
    assert!(same * 100 >= 98 * on_cpu.len(), "{same} of {}", on_cpu.len());
    for (gpu, cpu) in pairs().filter(|(gpu, cpu)| gpu.period.is_some() && cpu.period.is_some()) {
        assert_eq!(gpu.period, cpu.period, "{gpu:?} {cpu:?}");
        assert!((gpu.lyapunov - cpu.lyapunov).abs() < 1e-3, "{gpu:?} {cpu:?}");
    }
}

/// The cascade of x'' + 0.3 x' - x + x^3 = 0.1 zeta_k sin 1.2 tau, in batches as large as the device holds of long periods.
#[test]
fn long_periods_are_found_as_on_the_cpu() {
    use Parameter::{Alpha, Beta, F0, H1, Omega0, OmegaK};
    let Some(context) = gpu_context::open() else { return };
    let mut backend = GpuBackend::new(context);
    let duffing = [
        (F0, 0.0),
        (Alpha, -1.0),
        (Beta, 0.0),
        (OmegaK, 0.0),
        (H1, 2.0),
        (Omega0, 1.2),
    ]
    .into_iter()
    .fold(ParameterSet::default(), |set, (parameter, value)| {
        set.with(parameter, value)
    });
    let points = [2.9, 2.92, 2.9225].map(|zeta_k| duffing.with(Parameter::ZetaK, zeta_k));
    let most = |backend: &GpuBackend, max_period| {
        backend.batch_size(&Settings {
            sampling: Sampling {
                max_period,
                ..Sampling::default()
            },
            ..Settings::default()
        })
    };
    assert!(most(&backend, 1024) <= most(&backend, 64));
    for (max_period, longest) in [(1024, Some(32)), (64, Some(32)), (16, None)] {
        let settings = Settings {
            sampling: Sampling {
                transient_periods: 2000,
                periods: 2 * max_period.max(64),
                max_period,
                ..Sampling::default()
            },
            ..Settings::default()
        };
        for measured in [
            measure(&mut backend, &settings, &points),
            measure(&mut CpuBackend::new(Precision::F32), &settings, &points),
        ] {
            let periods: Vec<_> = measured.iter().map(|m| m.period).collect();
            assert_eq!(periods, [Some(4), Some(8), longest], "{max_period} {measured:?}");
        }
    }
}
