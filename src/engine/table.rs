//! A table in memory as a sink.

use super::{Sink, SinkError};
use crate::experiment::Experiment;
use crate::measure::Measurement;
use crate::results::Results;

/// Takes results into memory.
#[derive(Clone, Debug)]
pub struct Table {
    results: Results,
    /// Points in a unit.
    unit: usize,
}

impl Table {
    /// A table of which nothing is computed yet, in units of so many points.
    ///
    /// # Panics
    /// If a unit has no points.
    pub fn new(experiment: Experiment, unit: usize) -> Self {
        assert!(unit > 0, "a unit has points");
        Self {
            results: Results::new(experiment),
            unit,
        }
    }

    /// What was taken; points of unfinished units are not computed.
    pub fn into_results(self) -> Results {
        self.results
    }
}

impl Sink for Table {
    fn units(&self) -> usize {
        self.results.experiment.design.len().div_ceil(self.unit)
    }

    fn points(&self, unit: usize) -> Vec<usize> {
        let points = self.results.experiment.design.len();
        (unit * self.unit..points.min((unit + 1) * self.unit)).collect()
    }

    fn is_finished(&self, unit: usize) -> Result<bool, SinkError> {
        Ok(self
            .points(unit)
            .into_iter()
            .all(|point| self.results.is_computed(point)))
    }

    fn write(&mut self, unit: usize, measurements: &[Measurement], _device: &str) -> Result<(), SinkError> {
        for (point, measurement) in self.points(unit).into_iter().zip(measurements) {
            self.results.set(point, measurement);
        }
        Ok(())
    }
}
