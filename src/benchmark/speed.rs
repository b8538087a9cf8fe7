//! What a kernel costs.
//!
//! Owns the timing of slices; compares nothing.

use std::time::Instant;

use crate::backend::{Backend, BackendError, Slice, Stage};
use crate::experiment::Settings;
use crate::parameters::ParameterSet;

/// Forcing periods of one timing.
const PERIODS: u32 = 8;

/// A loaded batch whose slices are timed one by one, so that kernels can take turns: machines are shared, and only what
/// ran in the same minute compares.
pub struct Timing<B> {
    backend: B,
    instances: usize,
    done: u32,
    /// Seconds of each slice, of the motion alone and with tangent vectors.
    slices: [Vec<f64>; 2],
}

impl<B: Backend> Timing<B> {
    /// Loads the points and warms the kernel up.
    ///
    /// # Errors
    /// If the backend fails.
    pub fn new(mut backend: B, settings: &Settings, points: &[ParameterSet]) -> Result<Self, BackendError> {
        // every slice is one of a long measurement
        let settings = Settings {
            periods: 1_000_000,
            ..settings.clone()
        };
        backend.load(&settings, points)?;
        let mut timing = Self {
            backend,
            instances: points.len(),
            done: 0,
            slices: Default::default(),
        };
        timing.turn()?;
        timing.slices = Default::default();
        Ok(timing)
    }

    /// Times a slice of each phase.
    ///
    /// # Errors
    /// If the backend fails.
    pub fn turn(&mut self) -> Result<(), BackendError> {
        for (stage, slices) in [Stage::Transient, Stage::Measure].into_iter().zip(&mut self.slices) {
            let started = Instant::now();
            self.backend.advance(&Slice {
                stage,
                first: self.done,
                periods: PERIODS,
                elapsed: self.done,
            })?;
            if stage == Stage::Measure {
                // reading the sums is part of what a measurement costs
                self.backend.collect()?;
            }
            slices.push(started.elapsed().as_secs_f64());
            self.done += PERIODS;
        }
        Ok(())
    }

    /// Median cost of an instance-period in nanoseconds, of the motion alone and with tangent vectors.
    pub fn nanoseconds(&self) -> [f64; 2] {
        self.slices.clone().map(|mut slices| {
            slices.sort_by(f64::total_cmp);
            slices.get(slices.len() / 2).map_or(f64::NAN, |seconds| {
                seconds * 1e9 / (self.instances as f64 * f64::from(PERIODS))
            })
        })
    }
}
