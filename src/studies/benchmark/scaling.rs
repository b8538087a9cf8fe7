//! How the cost of an instance-period changes with threads and with the number of points.
//!
//! Owns what is timed; the scheme is the default one, in f64 on the CPU.

use std::ops::ControlFlow;
use std::time::Instant;

use serde::Serialize;

use super::{every, median, plane};
use crate::backend::cpu::CpuBackend;
use crate::backend::{Backend, BackendError, Instance};
use crate::experiment::{Precision, Sampling, Settings};
use crate::measure::measure_batch;
use crate::parameters::ParameterSet;

/// Rounds, of which the median is taken; the threads of one round are timed in turn.
const ROUNDS: usize = 7;

/// Numbers of points that are timed, in rising order.
const POINTS: [usize; 4] = [1_000, 10_000, 100_000, 1_000_000];

/// The speed of a number of threads.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Threads {
    pub threads: usize,
    /// Wall-clock nanoseconds for an instance-period.
    pub ns_per_instance_period: f64,
    /// Speed-up over one thread: the median of the rounds' ratios.
    pub speed_up: f64,
}

/// What an instance-period costs in maps of so many points, on all threads.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Points {
    pub points: usize,
    /// Wall-clock nanoseconds for an instance-period.
    pub ns_per_instance_period: f64,
}

/// Times one thread against two, four, and so on to all.
///
/// # Errors
/// If the CPU backend fails.
pub fn threads() -> Result<Vec<Threads>, BackendError> {
    let all = rayon::current_num_threads();
    let mut counts: Vec<usize> = std::iter::successors(Some(1), |n| Some(2 * n))
        .take_while(|n| *n < all)
        .collect();
    counts.push(all);
    let pools: Vec<_> = counts
        .iter()
        .map(|&threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build().expect("threads can be started")
        })
        .collect();
    let points = points(all * 4096);
    let mut rounds = Vec::new();
    for _ in 0..ROUNDS {
        let times: Result<Vec<f64>, BackendError> =
            pools.iter().map(|pool| pool.install(|| time(&points, 128))).collect();
        rounds.push(times?);
    }
    Ok(counts
        .iter()
        .enumerate()
        .map(|(i, &threads)| Threads {
            threads,
            ns_per_instance_period: median(rounds.iter().map(|times| times[i])),
            speed_up: median(rounds.iter().map(|times| times[0] / times[i])),
        })
        .collect())
}

/// Times maps of a thousand to a million points.
///
/// # Errors
/// If the CPU backend fails.
pub fn sizes() -> Result<Vec<Points>, BackendError> {
    POINTS
        .into_iter()
        .map(|count| {
            let points = points(count);
            // the largest map once, smaller ones as often as it takes for a median
            let rounds = if count < 1_000_000 { ROUNDS } else { 1 };
            let times: Result<Vec<f64>, BackendError> = (0..rounds).map(|_| time(&points, 32)).collect();
            Ok(Points {
                points: count,
                ns_per_instance_period: median(times?),
            })
        })
        .collect()
}

/// So many points, or a few less, over the benchmark's plane.
fn points(count: usize) -> Vec<ParameterSet> {
    let side = count.isqrt();
    let design = plane(side, count / side).expect("the table of parameters admits the benchmark's ranges");
    every(&design, 1)
}

/// Nanoseconds for an instance-period. The points are run in batches of the backend's size, over `periods` periods of the motion
/// alone and as many with tangent vectors.
fn time(points: &[ParameterSet], periods: u32) -> Result<f64, BackendError> {
    let settings = Settings {
        sampling: Sampling {
            transient_periods: periods,
            align_periods: 0,
            periods,
            decide_early: false,
            ..Sampling::default()
        },
        ..Settings::default()
    };
    let mut backend = CpuBackend::new(Precision::F64);
    let batch = backend.batch_size(&settings);
    let started = Instant::now();
    for points in points.chunks(batch) {
        let instances = Instance::starts(points);
        measure_batch(&mut backend, &settings, &instances, &mut |_| ControlFlow::Continue(()))?;
    }
    Ok(started.elapsed().as_nanos() as f64 / (2.0 * f64::from(periods) * points.len() as f64))
}
