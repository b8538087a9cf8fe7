//! Motion without a drive: states of rest and limit cycles. A forcing period has no meaning for either.
//!
//! Owns the omega_0 by which such motion is integrated, and the measurement of limit cycles.

use std::ops::Range;

use super::{Class, Measurement, Status};
use crate::backend::{Backend, BackendError, Instance, Slice, Stage};
use crate::dynamics::statistics::{batches, birkhoff_weights, standard_error};
use crate::experiment::{Sampling, Settings};
use crate::parameters::Parameter;

/// Replaces the given omega_0, so that nothing depends on the frequency of a drive that does not exist. A "forcing period" is
/// then pi units of tau.
const OMEGA_0: f64 = 2.0;

/// Forcing periods of the measurement of a limit cycle: first those in which the vectors turn to their directions, then those of
/// the averages.
const ALIGN: u32 = 64;
const LOOK: u32 = 512;

/// Number of shifts of a window of half the periods. The averages over these windows give the error of the average over all
/// periods. Where the bush sticks in every turn, the divergence has spikes, and averages converge slowly.
const HALVES: u32 = 8;

/// Largest difference of those averages, relative to the exponent, if the divergence is a smooth function along the cycle. If it
/// is not smooth, the averages may agree by chance, and batch means are more reliable.
const SMOOTH: f64 = 1e-4;

/// On a limit cycle, the first vector grows by less than this share of the divergence; on the way to a state of rest, by half of
/// it or more.
const ALONG_THE_FLOW: f64 = 0.1;

/// If the divergence is smaller than this, the motion has no damping.
const DAMPED: f64 = 1e-6;

/// The instance with the omega_0 by which it is integrated. With wear that is the given one: it determines how long the run is.
pub(super) fn instance(mut instance: Instance) -> Instance {
    if !instance.parameters.is_driven() && !instance.parameters.wears() {
        instance.parameters[Parameter::Omega0] = OMEGA_0;
    }
    instance
}

/// The bush is at rest if its angle stays within a range of this width.
const AT_REST: f64 = 1e-6;

/// Fewest passages through the middle of the range of angles by which an oscillation is distinguished from creep.
const LEAST_CROSSINGS: usize = 3;

/// Measures the instances again that are on a limit cycle. One exponent is the trivial zero along the flow, and is left out. The
/// other one is the mean divergence over whole turns; a weighted Birkhoff average gives it without the length of a turn.
///
/// # Errors
/// If the backend fails.
pub(super) fn measure_limit_cycles(
    backend: &mut dyn Backend,
    settings: &Settings,
    instances: &[Instance],
    measured: &mut [Measurement],
) -> Result<(), BackendError> {
    let moves = |m: &Measurement| m.status == Status::Ok && m.x_max - m.x_min > settings.sampling.period_tolerance;
    let indices: Vec<usize> = (0..instances.len())
        .filter(|&index| !instances[index].parameters.is_driven() && moves(&measured[index]))
        .collect();
    if indices.is_empty() {
        return Ok(());
    }
    let begun: Vec<Instance> = indices
        .iter()
        .map(|&index| {
            let Measurement { x, y, .. } = measured[index];
            Instance::new(instances[index].parameters, [x, y])
        })
        .collect();
    let settings = Settings {
        sampling: Sampling {
            transient_periods: ALIGN,
            align_periods: ALIGN,
            periods: LOOK,
            ..settings.sampling
        },
        ..*settings
    };
    backend.load(&settings, &begun)?;
    backend.advance(&Slice {
        stage: Stage::Align,
        first: 0,
        periods: ALIGN,
        elapsed: 0,
    })?;
    // for every period: growth of the first vector and divergence, and x at the end
    let mut rates = vec![[Vec::new(), Vec::new()]; indices.len()];
    let mut states = vec![Vec::new(); indices.len()];
    let mut ends = Vec::new();
    for first in 0..LOOK {
        backend.advance(&Slice {
            stage: Stage::Measure,
            first,
            periods: 1,
            elapsed: ALIGN + first,
        })?;
        for (rates, sums) in rates.iter_mut().zip(backend.collect()?) {
            rates[0].push(sums.growth[0]);
            rates[1].push(sums.divergence);
        }
        ends = backend.end_states()?;
        for (states, end) in states.iter_mut().zip(&ends) {
            states.push(end.x);
        }
    }
    for (((index, [growth, divergence]), states), end) in indices.into_iter().zip(rates).zip(states).zip(ends) {
        let period_time = instances[index].parameters.forcing_period();
        let average = |values: &[f64], range: Range<u32>| {
            let weights = birkhoff_weights(range.end - range.start);
            let values = &values[range.start as usize..range.end as usize];
            let sum: f64 = weights.iter().zip(values).map(|(weight, value)| weight * value).sum();
            sum / period_time
        };
        let along = average(&growth, 0..LOOK);
        let exponent = average(&divergence, 0..LOOK);
        // an average over half the periods has a larger error; two halves alone may agree by chance
        let halves = (0..=HALVES).map(|n| {
            let first = n * LOOK / 2 / HALVES;
            average(&divergence, first..first + LOOK / 2)
        });
        let of_halves = halves.map(|half| (half - exponent).abs()).fold(0.0, f64::max);
        let error = if of_halves < SMOOTH * exponent.abs() {
            of_halves
        } else {
            of_halves.max(standard_error(&batches_of(&divergence)) / period_time)
        };
        let attracts = exponent + 3.0 * error < 0.0 && exponent < -DAMPED;
        let is_cycle = attracts && along.abs() <= ALONG_THE_FLOW * -exponent && swings(&states[states.len() / 2..]);
        if end.runaway_periods.is_some() || end.under_resolved || !is_cycle {
            continue;
        }
        let before = measured[index];
        measured[index] = Measurement {
            class: Some(Class::Regular),
            lyapunov: exponent,
            lyapunov_error: error,
            lyapunov_second: f64::NAN,
            lyapunov_second_error: f64::NAN,
            divergence: exponent,
            lyapunov_birkhoff: exponent,
            lyapunov_interval: f64::from(LOOK) * period_time,
            period: None,
            x: end.x,
            y: end.y,
            x_min: end.x_min,
            x_max: end.x_max,
            chaotic_fraction: 0.0,
            attractors: 1,
            integrated_periods: before.integrated_periods + ALIGN + LOOK,
            ..before
        };
    }
    Ok(())
}

/// Length and sum of each batch, given the values of single periods.
fn batches_of(values: &[f64]) -> Vec<(f64, f64)> {
    let batches = batches(values.len() as u32).into_iter();
    batches
        .map(|batch| {
            let part = &values[batch.start as usize..batch.end as usize];
            (part.len() as f64, part.iter().sum())
        })
        .collect()
}

/// Whether an angle oscillates. A bush that creeps in the friction layer moves in one direction, or is at rest except for
/// rounding.
fn swings(angles: &[f64]) -> bool {
    let least = angles.iter().copied().fold(f64::INFINITY, f64::min);
    let greatest = angles.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let middle = 0.5 * (least + greatest);
    let crossings = angles
        .windows(2)
        .filter(|pair| (pair[0] < middle) != (pair[1] < middle));
    greatest - least > AT_REST && crossings.count() >= LEAST_CROSSINGS
}
