//! Lanes change speed, not results: every instruction set and both precisions agree with the scalar reference, and an
//! instance's result does not depend on its neighbours.

use tribochaos::backend::cpu::{CpuBackend, InstructionSet};
use tribochaos::dynamics::spectrum::lyapunov_spectrum;
use tribochaos::dynamics::statistics;
use tribochaos::experiment::{Precision, Sampling, Settings};
use tribochaos::measure::{Class, Measurement, QUANTITIES};
use tribochaos::parameters::{Parameter, ParameterSet};

use crate::common::{PRECISIONS, measure, measure_on, pinned_settings, point};

/// One more than a whole number of blocks of 4, 8, 16 and 32, and no multiple of 24, 48 or 96 lanes.
const INSTANCES: usize = 97;

/// Long enough for the damped orbits below to settle to rounding.
fn short_settings() -> Settings {
    Settings {
        sampling: Sampling {
            transient_periods: 150,
            periods: 100,
            ..pinned_settings().sampling
        },
        ..pinned_settings()
    }
}

/// A row of points from rest to strong forcing, all regular at this damping.
fn regular_points() -> Vec<ParameterSet> {
    (0..INSTANCES)
        .map(|i| point(&[(Parameter::ZetaK, 0.5 + 0.025 * i as f64), (Parameter::H1, 2.0)]))
        .collect()
}

/// Points of every kind of motion.
fn mixed_points() -> Vec<ParameterSet> {
    (0..INSTANCES)
        .map(|i| point(&[(Parameter::ZetaK, 0.06 * i as f64), (Parameter::H1, 0.1)]))
        .collect()
}

/// The bits of everything that is measured.
fn bits(measured: &Measurement) -> Vec<u64> {
    QUANTITIES
        .iter()
        .map(|info| info.quantity.of(measured).to_bits())
        .collect()
}

#[test]
fn every_instruction_set_and_precision_agrees_with_the_scalar_reference_on_regular_orbits() {
    // means over the measured periods, as the reference's, and not the multipliers of cycles
    let settings = Settings {
        sampling: Sampling {
            period_tolerance: 0.0,
            ..short_settings().sampling
        },
        ..short_settings()
    };
    let points = regular_points();
    let references: Vec<[f64; 2]> = points
        .iter()
        .map(|p| {
            let [first, second, _] = lyapunov_spectrum(p, &settings).expect("bounded").exponents;
            statistics::exponents([first, second])
        })
        .collect();
    for instructions in InstructionSet::available() {
        for precision in PRECISIONS {
            // f64: rounding over 250 periods; f32: the rounded orbit meets the layer at other points of its steps
            let tolerance: f64 = match precision {
                Precision::F64 => 1e-9,
                Precision::F32 => 1e-3,
            };
            let mut backend = CpuBackend::with_instructions(precision, instructions);
            let measured = measure_on(&mut backend, &settings, &points);
            assert_eq!(measured.len(), INSTANCES);
            for ((p, m), [first, second]) in points.iter().zip(&measured).zip(&references) {
                let label = format!(
                    "{} {precision:?}, zeta_k = {}",
                    instructions.name(),
                    p[Parameter::ZetaK]
                );
                assert_eq!(m.class, Some(Class::Regular), "{label}");
                let differences = [m.lyapunov - first, m.lyapunov_second - second];
                // what the fixed step adds to the sum of the exponents, which a complex pair halves, is taken from every 17th
                // period
                let coarse = tolerance.max(1e-6);
                let tolerances = [if first > second { tolerance } else { coarse }, coarse];
                assert!(
                    differences
                        .iter()
                        .zip(tolerances)
                        .all(|(d, tolerance)| d.abs() < tolerance),
                    "{label}: {differences:?}, {m:?}"
                );
            }
        }
    }
}

#[test]
fn a_result_does_not_depend_on_the_position_in_the_batch_nor_on_its_size() {
    let settings = short_settings();
    let points = mixed_points();
    for instructions in InstructionSet::available() {
        for precision in PRECISIONS {
            let run = |points: &[ParameterSet]| -> Vec<Vec<u64>> {
                let mut backend = CpuBackend::with_instructions(precision, instructions);
                measure_on(&mut backend, &settings, points).iter().map(bits).collect()
            };
            let in_order = run(&points);
            let mut backwards = points.clone();
            backwards.reverse();
            let mut reversed = run(&backwards);
            reversed.reverse();
            assert_eq!(reversed, in_order, "{} {precision:?}: backwards", instructions.name());
            assert_eq!(
                run(&points[60..61]),
                in_order[60..61],
                "{} {precision:?}: alone",
                instructions.name()
            );
        }
    }
}

#[test]
fn the_same_batch_gives_the_same_bits_again() {
    let points = mixed_points();
    for precision in PRECISIONS {
        let run = || -> Vec<Vec<u64>> {
            measure(precision, &short_settings(), &points)
                .iter()
                .map(bits)
                .collect()
        };
        assert_eq!(run(), run());
    }
}
