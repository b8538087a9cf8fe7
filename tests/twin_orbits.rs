//! Twins give the same orbits: short trajectories to rounding, long ones in what is measured of them.

#![cfg(feature = "gpu")]

mod gpu_context;
mod points;

use std::ops::ControlFlow;

use tribochaos::backend::cpu::CpuBackend;
use tribochaos::backend::gpu::GpuBackend;
use tribochaos::backend::gpu::shader_source::Lanes;
use tribochaos::backend::{Backend, Instance, Slice, Stage};
use tribochaos::experiment::{Precision, Sampling, Scheme, Settings};
use tribochaos::measure::{Class, Measurement, measure_batch};

use points::line;

/// A backend whose threads have so many lanes.
fn with_lanes(lanes: Lanes) -> Option<GpuBackend> {
    let context = gpu_context::open()?;
    Some(GpuBackend::new(context.with_lanes(lanes)))
}

#[test]
fn short_trajectories_part_no_faster_than_roundings_add_up() {
    for lanes in Lanes::ALL {
        let Some(mut gpu) = with_lanes(lanes) else { return };
        // a step of taylor rounds some ten times as often as one of rk4, and where it ends depends on rounded speeds
        for (scheme, of_a_step) in [(Scheme::Taylor, 1.5e-6), (Scheme::Rk4, 1.5e-7)] {
            assert_short_trajectories(&mut gpu, scheme, of_a_step);
        }
    }
}

fn assert_short_trajectories(gpu: &mut GpuBackend, scheme: Scheme, of_a_step: f64) {
    // an odd number, so that lanes are to spare
    let instances = Instance::starts(&line(255));
    let settings = Settings {
        integration: scheme.into(),
        ..Settings::default()
    };
    for precision in [Precision::F32, Precision::F64] {
        let mut cpu = CpuBackend::new(precision);
        gpu.load(&settings, &instances).unwrap();
        cpu.load(&settings, &instances).unwrap();
        for first in 0..10 {
            let slice = Slice {
                stage: Stage::Measure,
                first,
                periods: 1,
                elapsed: first,
            };
            gpu.advance(&slice).unwrap();
            cpu.advance(&slice).unwrap();
            let ends = gpu.end_states().unwrap().into_iter().zip(cpu.end_states().unwrap());
            let worst = ends
                .map(|(a, b)| {
                    let distance = (a.x - b.x).abs() + (a.y - b.y).abs();
                    distance.max((a.x_min - b.x_min).abs()).max((a.x_max - b.x_max).abs())
                })
                .fold(0.0, f64::max);
            let sums = gpu.collect().unwrap().into_iter().zip(cpu.collect().unwrap());
            let worst_sum = sums
                .map(|(a, b)| {
                    (0..2)
                        .map(|i| (a.growth[i] - b.growth[i]).abs())
                        .fold((a.divergence - b.divergence).abs(), f64::max)
                })
                .fold(0.0, f64::max);
            let bound = of_a_step * f64::from(settings.integration.steps_per_period * (first + 1));
            assert!(worst < bound, "{scheme:?} {precision:?}, period {first}: {worst}");
            // the tangent vectors feel where in a step the layer's boundary is crossed
            assert!(
                worst_sum < 10.0 * bound,
                "{scheme:?} {precision:?}, period {first}: {worst_sum}"
            );
        }
    }
}

#[test]
fn long_orbits_agree_closely_where_regular_and_within_their_errors_where_chaotic() {
    let settings = Settings {
        sampling: Sampling {
            transient_periods: 150,
            align_periods: 30,
            periods: 600,
            ..Sampling::default()
        },
        ..Settings::default()
    };
    let instances = Instance::starts(&line(192));
    let measure = |backend: &mut dyn Backend| {
        measure_batch(backend, &settings, &instances, &mut |_| ControlFlow::Continue(()))
            .unwrap()
            .expect("nothing breaks the run off")
    };
    let cpu = measure(&mut CpuBackend::new(Precision::F64));
    for lanes in Lanes::ALL {
        let Some(mut gpu) = with_lanes(lanes) else { return };
        assert_long_orbits(&measure(&mut gpu), &cpu);
    }
}

fn assert_long_orbits(gpu: &[Measurement], cpu: &[Measurement]) {
    let (mut regular, mut grazing, mut chaotic, mut different) = (0, 0, 0, 0);
    for (i, (a, b)) in gpu.iter().zip(cpu).enumerate() {
        let difference = (a.lyapunov - b.lyapunov).abs();
        assert!(a.divergence_defect().abs() < 1e-4, "{i}: {a:?}");
        // not while a chaotic transient was measured
        let has_settled = a.lyapunov_error.max(b.lyapunov_error) < 3e-3;
        if b.class == Some(Class::Regular) && b.period.is_some() && b.lyapunov < -0.03 && has_settled {
            assert_eq!((a.class, a.period), (b.class, b.period), "{i}");
            let extremes = (a.x_min - b.x_min).abs().max((a.x_max - b.x_max).abs());
            // of a complex pair the vectors turn, and a finite window's exponent with them
            let tolerance = if b.lyapunov - b.lyapunov_second < 2e-3 {
                2e-3
            } else {
                1e-4
            };
            assert!(extremes < 1e-4, "{i}: {a:?} {b:?}");
            // of a cycle that grazes the friction layer a change of 1e-6 in its states changes the multipliers by percents
            assert!(difference < 0.05 * b.lyapunov.abs() + tolerance, "{i}: {a:?} {b:?}");
            grazing += u32::from(difference >= tolerance);
            regular += 1;
        } else if b.lyapunov > 8.0 * b.lyapunov_error {
            let error = a.lyapunov_error.hypot(b.lyapunov_error);
            let is_same = a.class == Some(Class::Chaotic) && difference < 5.0 * error;
            // where chaos is a long transient it ends by chance, and where it dwells near weaker chaos, it does so by chance: in
            // f64 a change of 1e-7 in x0 moves the exponent of one of these points from 0.09 to 0.01
            different += u32::from(!is_same);
            chaotic += 1;
        }
    }
    assert!(regular > 100 && chaotic > 15, "{regular} regular, {chaotic} chaotic");
    assert!(50 * grazing <= regular, "{grazing} of {regular} regular orbits");
    assert!(
        8 * different <= chaotic,
        "{different} of {chaotic} chaotic orbits differ"
    );
}
