//! The run of a batch at full length: transient, alignment, measurement.
//!
//! Owns their order, and slices short enough for progress to show; decides nothing early.

use std::ops::ControlFlow;

use rayon::prelude::*;

use super::cycle::{self, Candidate};
use super::evaluation::{Ended, GrowthSums, sums_all};
use super::{Measurement, Status};
use crate::backend::{Backend, BackendError, EndState, Instance, Slice, Stage, Sums};
use crate::dynamics::statistics;
use crate::experiment::Settings;

/// Longest slice, so that progress shows and a run can be cancelled.
const LONGEST_SLICE: u32 = 16;

/// Batches of the measurement that begin before this period are summed up period by period, to get the scatter of single periods.
const SAMPLED: u32 = 64;

/// Runs a batch of instances at the full length of the settings, after a run of `elapsed` periods. Either all of the instances
/// wear, or none does.
pub(super) fn measure(
    backend: &mut dyn Backend,
    settings: &Settings,
    instances: &[Instance],
    elapsed: u32,
    progress: &mut dyn FnMut(u64) -> ControlFlow<()>,
) -> Result<Option<Vec<Measurement>>, BackendError> {
    backend.load(settings, instances)?;
    let mut elapsed = elapsed;
    let mut advance = |backend: &mut dyn Backend, stage, range: std::ops::Range<u32>| {
        let mut first = range.start;
        while first < range.end {
            let periods = LONGEST_SLICE.min(range.end - first);
            backend.advance(&Slice {
                stage,
                first,
                periods,
                elapsed,
            })?;
            first += periods;
            elapsed += periods;
            if progress(u64::from(periods) * instances.len() as u64).is_break() {
                return Ok(ControlFlow::Break(()));
            }
        }
        Ok(ControlFlow::Continue(()))
    };
    for (stage, periods) in [
        (
            Stage::Transient,
            settings.sampling.transient_periods - settings.sampling.align_periods,
        ),
        (Stage::Align, settings.sampling.align_periods),
    ] {
        if advance(backend, stage, 0..periods)?.is_break() {
            return Ok(None);
        }
    }
    let mut growth: Vec<GrowthSums> = vec![GrowthSums::default(); instances.len()];
    for batch in statistics::batches(settings.sampling.periods) {
        let mut sums = vec![Sums::default(); instances.len()];
        let stride = if batch.start < SAMPLED { 1 } else { batch.len() };
        for first in batch.clone().step_by(stride) {
            if advance(backend, Stage::Measure, first..first + stride as u32)?.is_break() {
                return Ok(None);
            }
            let part = backend.collect()?;
            growth
                .par_iter_mut()
                .zip(&mut sums)
                .zip(&part)
                .for_each(|((growth, sums), part)| {
                    sums.add(part);
                    if stride == 1 {
                        growth.sample(part);
                    }
                });
        }
        growth
            .par_iter_mut()
            .zip(&sums)
            .for_each(|(growth, sums)| growth.add(batch.len() as f64, sums));
    }
    let ends = backend.end_states()?;
    let kind = backend.kind();
    let mut measured: Vec<Measurement> = instances
        .par_iter()
        .zip(growth.par_iter().zip(&ends))
        .map(|(instance, (growth, state))| {
            growth.measurement(&Ended {
                parameters: &instance.parameters,
                settings,
                elapsed,
                state,
                backend: kind,
            })
        })
        .collect();
    let parameters = &instances[0].parameters;
    let finds_cycles = parameters.is_heated() || (!parameters.wears() && sums_all(backend.kind(), settings));
    if finds_cycles {
        measure_cycles(backend, settings, instances, &ends, &mut measured)?;
    }
    Ok(Some(measured))
}

/// Measures the instances again that have ended on a cycle. The multipliers of the cycle give their exponents, whatever the
/// motion was before.
fn measure_cycles(
    backend: &mut dyn Backend,
    settings: &Settings,
    instances: &[Instance],
    ends: &[EndState],
    measured: &mut [Measurement],
) -> Result<(), BackendError> {
    let (indices, candidates): (Vec<usize>, Vec<Candidate>) = (0..instances.len())
        .filter(|&index| measured[index].status == Status::Ok)
        .filter_map(|index| {
            let candidate = Candidate {
                period: ends[index].period?,
                instance: instances[index].at(&ends[index]),
            };
            Some((index, candidate))
        })
        .unzip();
    for (index, found) in indices.into_iter().zip(cycle::find(backend, settings, &candidates)?) {
        let before = measured[index];
        let integrated_periods = before.integrated_periods + found.periods;
        measured[index] = Measurement {
            integrated_periods,
            ..found.measurement.unwrap_or(before)
        };
    }
    Ok(())
}
