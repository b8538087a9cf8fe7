//! Motion without a drive: rests and limit cycles, in neither of which a forcing period plays a part.
//!
//! Owns the omega_0 by which such motion is integrated, and the measurement of limit cycles.

use std::ops::Range;

use super::{Class, Measurement, Status};
use crate::backend::{Backend, BackendError, Instance, Slice, Stage};
use crate::dynamics::statistics::{batches, birkhoff_weights, standard_error};
use crate::experiment::{Sampling, Settings};
use crate::parameters::Parameter;

/// In place of any other, so that nothing depends on a frequency with which nothing is driven: pi units of tau make what
/// is called a forcing period.
const OMEGA_0: f64 = 2.0;

/// Periods of a look at a limit cycle: until the vectors have turned to their directions, and of the averages.
const ALIGN: u32 = 64;
const LOOK: u32 = 512;

/// Shifts of a window of half the periods, whose averages tell how sure that over all is. Where the bush sticks in every turn the
/// divergence comes in spikes, and averages converge slowly.
const HALVES: u32 = 8;

/// Relative to the exponent, by how much those averages differ at most where the divergence is a smooth function along the cycle. Where
/// it is not, they may agree by chance, and batch means tell more.
const SMOOTH: f64 = 1e-4;

/// Along a limit cycle the first vector grows by less than this share of the divergence, on the way to a rest by half of it
/// or more.
const ALONG_THE_FLOW: f64 = 0.1;

/// A divergence below this is that of motion that nothing damps.
const DAMPED: f64 = 1e-6;

/// The instance as it is integrated.
pub(super) fn instance(mut instance: Instance) -> Instance {
    if !instance.parameters.is_driven() {
        instance.parameters[Parameter::Omega0] = OMEGA_0;
    }
    instance
}

/// An angle that stays within this is one of rest.
const AT_REST: f64 = 1e-6;

/// Fewest passages through its middle by which a swing is told from a creep.
const LEAST_CROSSINGS: usize = 3;

/// Measures those anew that are on a limit cycle. One exponent is the trivial zero along the flow, and left out; the other
/// one is the mean divergence over whole turns, which a weighted Birkhoff average gives without knowing how long a turn is.
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
    // growth of the first vector and divergence, of every period, and x at its end
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
        // half as many periods are off by more; two halves may agree by chance
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

/// Lengths and sums of the batches of values of single periods.
fn batches_of(values: &[f64]) -> Vec<(f64, f64)> {
    let batches = batches(values.len() as u32).into_iter();
    batches
        .map(|batch| {
            let part = &values[batch.start as usize..batch.end as usize];
            (part.len() as f64, part.iter().sum())
        })
        .collect()
}

/// Whether an angle goes to and fro: a bush that creeps in the friction layer goes one way, or is at rest but for rounding.
fn swings(angles: &[f64]) -> bool {
    let least = angles.iter().copied().fold(f64::INFINITY, f64::min);
    let greatest = angles.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let middle = 0.5 * (least + greatest);
    let crossings = angles
        .windows(2)
        .filter(|pair| (pair[0] < middle) != (pair[1] < middle));
    greatest - least > AT_REST && crossings.count() >= LEAST_CROSSINGS
}
