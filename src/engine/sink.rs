//! What takes the results of a run.

use crate::measure::Measurement;

/// Why a sink failed.
pub type SinkError = Box<dyn std::error::Error + Send + Sync>;

/// Takes the results of an experiment unit by unit: a store on disk, or a table in memory.
pub trait Sink {
    /// Number of units.
    fn units(&self) -> usize;

    /// The points of a unit, as indices into the design.
    fn points(&self, unit: usize) -> Vec<usize>;

    /// Whether a unit is there whole.
    ///
    /// # Errors
    /// If that cannot be found out.
    fn is_finished(&self, unit: usize) -> Result<bool, SinkError>;

    /// Takes the measurements of a unit, in the order of its points, and the device on which they were made. When it returns, the unit
    /// is finished.
    ///
    /// # Errors
    /// If the unit cannot be kept; it is then not finished.
    fn write(&mut self, unit: usize, measurements: &[Measurement], device: &str) -> Result<(), SinkError>;
}
