//! How many points there are of each kind.
//!
//! Owns the names of the kinds; knows no points.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::measure::{Class, Measurement, Status};

/// Numbers of points by their kind of motion: one of [`Class::NAMES`]; without a class `transient` in a contact that wears, `runaway`
/// and `under_resolved`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Tally {
    counts: BTreeMap<String, u64>,
}

impl Tally {
    /// Of these points.
    pub fn of(measurements: &[Measurement]) -> Self {
        Self::counted(measurements.iter().map(|measurement| {
            let class = measurement.class.map(|class| class as usize);
            (measurement.status.code().into(), class)
        }))
    }

    /// Of points whose status and class have these codes.
    pub fn counted(points: impl Iterator<Item = (usize, Option<usize>)>) -> Self {
        let mut tally = Self::default();
        for (status, class) in points {
            let name = match class {
                Some(class) => Class::NAMES[class],
                None if status == usize::from(Status::Ok.code()) => "transient",
                None => Status::NAMES[status],
            };
            *tally.counts.entry(name.to_owned()).or_default() += 1;
        }
        tally
    }

    /// Adds the numbers of other points.
    pub fn add(&mut self, other: &Self) {
        for (name, count) in &other.counts {
            *self.counts.entry(name.clone()).or_default() += count;
        }
    }

    /// Number of points of all kinds.
    pub fn points(&self) -> u64 {
        self.counts.values().sum()
    }

    /// Kinds that occur, with the number of their points, the most frequent first.
    pub fn kinds(&self) -> Vec<(&str, u64)> {
        let mut kinds: Vec<_> = self
            .counts
            .iter()
            .map(|(name, &count)| (name.as_str(), count))
            .collect();
        kinds.sort_by_key(|&(_, count)| std::cmp::Reverse(count));
        kinds
    }
}
