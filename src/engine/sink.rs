//! What takes the results of a run.

use std::any::Any;
use std::ops::Range;
use std::time::Duration;

use crate::measure::Measurement;
use crate::results::Tally;

/// Why a sink failed.
pub type SinkError = Box<dyn std::error::Error + Send + Sync>;

/// What a sink holds of a unit.
#[derive(Clone, Debug, PartialEq)]
pub enum Condition {
    /// Nothing, or a part whose writing was cut short.
    Missing,
    /// All of it.
    Whole(Tally),
    /// Values that were changed or lost after they had been written.
    Damaged {
        /// What is wrong, and where.
        what: String,
    },
}

/// How a unit was computed.
#[derive(Clone, Debug, PartialEq)]
pub struct Origin {
    /// The device, in words.
    pub device: String,
    /// How long it took.
    pub elapsed: Duration,
}

/// The right to compute a unit. It ends when this is dropped, or with the process.
pub struct Claim(#[allow(dead_code, reason = "it is held until it is dropped")] Box<dyn Any + Send>);

impl Claim {
    /// A claim that lasts as long as what is given.
    pub fn new(held: impl Any + Send) -> Self {
        Self(Box::new(held))
    }
}

/// Takes the results of an experiment unit by unit: a store on disk, or a table in memory.
pub trait Sink {
    /// Number of units.
    fn units(&self) -> usize;

    /// The points of a unit, as indices into the design.
    fn points(&self, unit: usize) -> Range<usize>;

    /// What the sink holds of a unit, thoroughly checked.
    ///
    /// # Errors
    /// If that cannot be found out.
    fn condition(&self, unit: usize) -> Result<Condition, SinkError>;

    /// Whether a unit is finished, by what can be found out without reading its values.
    ///
    /// # Errors
    /// If that cannot be found out.
    fn is_finished(&self, unit: usize) -> Result<bool, SinkError>;

    /// The right to compute a unit; None while another process has it.
    ///
    /// # Errors
    /// If processes cannot be kept apart.
    fn claim(&self, unit: usize) -> Result<Option<Claim>, SinkError> {
        let _ = unit;
        Ok(Some(Claim::new(())))
    }

    /// Takes the measurements of a unit, in the order of its points. When it returns without an error, the unit is finished.
    ///
    /// # Errors
    /// If the unit cannot be kept; it is then not finished.
    fn write(&mut self, unit: usize, measurements: &[Measurement], origin: &Origin) -> Result<(), SinkError>;
}
