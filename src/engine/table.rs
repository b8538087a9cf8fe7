//! A table in memory as a sink.

use std::ops::Range;

use super::{Condition, Origin, Sink, SinkError};
use crate::experiment::Experiment;
use crate::measure::{Measurement, Quantity};
use crate::results::{Results, Tally};

/// Takes results into memory.
#[derive(Clone, Debug)]
pub struct Table {
    results: Results,
    /// Points in a unit.
    unit: usize,
    /// What is finished.
    tallies: Vec<Option<Tally>>,
}

impl Table {
    /// A table of every quantity in which nothing is computed yet, in units of this number of points.
    ///
    /// # Panics
    /// If a unit has no points.
    pub fn new(experiment: Experiment, unit: usize) -> Self {
        Self::of(experiment, &Quantity::all(), unit)
    }

    /// A table of some quantities and of the status.
    ///
    /// # Panics
    /// If a unit has no points.
    pub fn of(experiment: Experiment, quantities: &[Quantity], unit: usize) -> Self {
        assert!(unit > 0, "a unit has points");
        Self {
            tallies: vec![None; experiment.design.len().div_ceil(unit)],
            results: Results::of(experiment, quantities),
            unit,
        }
    }

    /// The results; points of unfinished units are not computed.
    pub fn into_results(self) -> Results {
        self.results
    }
}

impl Sink for Table {
    fn units(&self) -> usize {
        self.tallies.len()
    }

    fn points(&self, unit: usize) -> Range<usize> {
        let points = self.results.experiment.design.len();
        unit * self.unit..points.min((unit + 1) * self.unit)
    }

    fn condition(&self, unit: usize) -> Result<Condition, SinkError> {
        let tally = self.tallies[unit].clone();
        Ok(tally.map_or(Condition::Missing, Condition::Whole))
    }

    fn is_finished(&self, unit: usize) -> Result<bool, SinkError> {
        Ok(self.tallies[unit].is_some())
    }

    fn write(&mut self, unit: usize, measurements: &[Measurement], _origin: &Origin) -> Result<(), SinkError> {
        for (point, measurement) in self.points(unit).zip(measurements) {
            self.results.set(point, measurement);
        }
        self.tallies[unit] = Some(Tally::of(measurements));
        Ok(())
    }
}
