//! The scheme's share in an error: exponents are measured again, from where the run ended, by a finer scheme.
//!
//! Owns what is compared, and what a difference means. At constant contact pressure the finer scheme is taylor in f64, whose own
//! error is a millionth, and which costs a fraction of the others.

use std::ops::ControlFlow;

use super::evaluation::checked;
use super::{Class, Measurement, QUASI_PERIODIC_ERROR, Status, fallback};
use crate::backend::cpu::CpuBackend;
use crate::backend::{BackendError, Instance};
use crate::experiment::{Integration, Precision, Sampling, Scheme, Settings};

/// Two exponents may differ by chance by up to this many times their combined error.
const CHANCE: f64 = 2.0;

/// Adds the scheme's share to the errors of instances of constant contact pressure, which were `measured` by the scheme of
/// `settings`. None if `progress` broke it off. A class that no longer holds with the larger error becomes undecided. A motion
/// that the finer scheme cannot follow, or that runs away with it, becomes under-resolved.
///
/// # Errors
/// If the CPU backend fails.
pub(super) fn add(
    settings: &Settings,
    instances: &[Instance],
    measured: &mut [Measurement],
    progress: &mut dyn FnMut(u64) -> ControlFlow<()>,
) -> Result<Option<()>, BackendError> {
    if settings.integration.scheme == Scheme::Taylor {
        return Ok(Some(()));
    }
    let (indices, begun): (Vec<usize>, Vec<Instance>) = measured
        .iter()
        .enumerate()
        .filter(|(_, m)| m.status == Status::Ok)
        .map(|(index, m)| (index, Instance::new(instances[index].parameters, [m.x, m.y])))
        .unzip();
    if indices.is_empty() {
        return Ok(Some(()));
    }
    let finer = Settings {
        integration: Integration {
            precision: Some(Precision::F64),
            ..Integration::from(Scheme::Taylor)
        },
        sampling: Sampling {
            period_tolerance: settings.sampling.period_tolerance,
            max_period: settings.sampling.max_period,
            ..Sampling::default()
        },
    };
    // the scheme's own run was already reported as the whole work
    let mut silent = |_| progress(0);
    let mut backend = CpuBackend::new(Precision::F64);
    let Some(again) = fallback::measure(&mut backend, &finer, &begun, &mut silent)? else {
        return Ok(None);
    };
    for (index, finer) in indices.into_iter().zip(again) {
        measured[index] = compared(&measured[index], &finer);
    }
    Ok(Some(()))
}

/// A measurement with the scheme's share added to its errors, given the finer scheme's measurement of the same motion.
fn compared(measured: &Measurement, finer: &Measurement) -> Measurement {
    let integrated_periods = measured.integrated_periods + finer.integrated_periods;
    if finer.status != Status::Ok {
        return Measurement {
            initial_state: measured.initial_state,
            integrated_periods,
            ..Measurement::unmeasured(Status::UnderResolved, measured.backend)
        };
    }
    let chance = |m: &Measurement, error: f64| error - m.scheme_error;
    let share = finer.scheme_error
        + beyond_chance(
            [measured.lyapunov, chance(measured, measured.lyapunov_error)],
            [finer.lyapunov, chance(finer, finer.lyapunov_error)],
        );
    let second = finer.scheme_error
        + beyond_chance(
            [
                measured.lyapunov_second,
                chance(measured, measured.lyapunov_second_error),
            ],
            [finer.lyapunov_second, chance(finer, finer.lyapunov_second_error)],
        );
    let measured = Measurement {
        lyapunov_error: measured.lyapunov_error + share,
        lyapunov_second_error: measured.lyapunov_second_error + second,
        scheme_error: measured.scheme_error + share,
        // a different period belongs to a different motion
        period: measured
            .period
            .filter(|period| finer.period.is_none_or(|finer| finer == *period)),
        integrated_periods,
        ..*measured
    };
    let stands = match measured.class {
        Some(Class::QuasiPeriodic) => measured.lyapunov_error < QUASI_PERIODIC_ERROR,
        _ => measured.lyapunov.abs() > 3.0 * measured.lyapunov_error,
    };
    if share == 0.0 || finer.class == measured.class || stands {
        // an error that is no number is none
        return checked(measured, true);
    }
    Measurement {
        class: Some(Class::Undecided),
        period: None,
        chaotic_fraction: 0.0,
        ..measured
    }
}

/// By how much two numbers, each with its error, differ by more than chance explains; NaN if either is NaN.
fn beyond_chance([a, a_error]: [f64; 2], [b, b_error]: [f64; 2]) -> f64 {
    let beyond = (a - b).abs() - CHANCE * a_error.hypot(b_error);
    // unlike max, keeps NaN
    if beyond < 0.0 { 0.0 } else { beyond }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::BackendKind;

    fn orbit(class: Class, lyapunov: f64, error: f64, period: Option<u32>) -> Measurement {
        Measurement {
            class: Some(class),
            lyapunov,
            lyapunov_birkhoff: lyapunov,
            lyapunov_error: error,
            scheme_error: 0.0,
            period,
            ..Measurement::unmeasured(Status::Ok, BackendKind::CpuF64)
        }
    }

    #[test]
    fn what_a_finer_scheme_says_otherwise_is_error_and_may_take_the_class() {
        let cycle = orbit(Class::Regular, -0.3, 1e-6, Some(2));
        let near = compared(&cycle, &orbit(Class::Regular, -0.31, 0.0, Some(2)));
        assert!((near.lyapunov_error - 0.01).abs() < 2e-6, "{}", near.lyapunov_error);
        assert_eq!((near.class, near.period), (Some(Class::Regular), Some(2)));
        assert_eq!(near.lyapunov, -0.3);
        let doubled = compared(&cycle, &orbit(Class::Regular, -0.01, 0.0, Some(4)));
        assert_eq!((doubled.class, doubled.period), (Some(Class::Regular), None));
        let chaos = orbit(Class::Chaotic, 0.1, 0.01, None);
        assert_eq!(compared(&cycle, &chaos).class, Some(Class::Undecided));
        let other = compared(&chaos, &orbit(Class::Chaotic, 0.12, 0.01, None));
        assert_eq!((other.lyapunov_error, other.class), (0.01, Some(Class::Chaotic)));
        let runaway = Measurement::runaway(3.0, BackendKind::CpuF64);
        assert_eq!(compared(&cycle, &runaway).status, Status::UnderResolved);
        let unknown = Measurement {
            scheme_error: f64::NAN,
            ..cycle
        };
        assert_eq!(compared(&unknown, &cycle).status, Status::UnderResolved);
    }

    /// If the finer scheme finds another class, the class stands only if the exponent exceeds three errors, or for a torus, if
    /// its error is one that a torus may have.
    #[test]
    fn a_class_stands_where_it_stands_above_its_error() {
        let exact = |class, lyapunov| orbit(class, lyapunov, 0.0, None);
        for (class, lyapunov, off, stands) in [
            (Class::Regular, -0.3, 0.095, true),
            (Class::Regular, -0.3, 0.105, false),
            (Class::Chaotic, 0.3, 0.095, true),
            (Class::Chaotic, 0.3, 0.105, false),
            (Class::QuasiPeriodic, 0.0, 0.0045, true),
            (Class::QuasiPeriodic, 0.0, 0.0055, false),
        ] {
            let found = compared(&exact(class, lyapunov), &exact(Class::Undecided, lyapunov + off));
            assert!((found.lyapunov_error - off).abs() < 1e-12, "{class:?} {off}: {found:?}");
            let expected = if stands { class } else { Class::Undecided };
            assert_eq!(found.class, Some(expected), "{class:?} {off}");
        }
    }
}
