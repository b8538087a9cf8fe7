//! What is measured of a point, and when that is known.
//!
//! Owns runs over batches of instances, early decisions, classes, errors, and the table of quantities. Backends integrate the
//! instances; results are stored and drawn elsewhere. From the bottom to the top:
//!
//! - [`class`], [`measurement`], [`quantity`]: what is measured;
//! - `evaluation`: from sums over periods to a measurement;
//! - `cycle`: multipliers of cycles;
//! - `whole_run`, `early`, `undriven`: runs at full length, runs that are decided early, and motion without a drive;
//! - `one_scheme`: a measurement by one scheme;
//! - [`fallback`]: points that the scheme gave up, measured by other schemes;
//! - `scheme_error`: the share of the scheme in the errors;
//! - [`batch`]: all of these, for a batch of any instances.

pub mod batch;
pub mod class;
mod cycle;
mod early;
mod evaluation;
pub mod fallback;
pub mod measurement;
mod one_scheme;
pub mod quantity;
mod scheme_error;
mod undriven;
mod whole_run;

pub use self::batch::measure_batch;
pub use self::class::{CHAOTIC_GROWTH, CONSTANT_GROWTH, Class, Cycle, QUASI_PERIODIC_BOUND, QUASI_PERIODIC_ERROR};
pub use self::measurement::{DEFECT_BOUND, DEFECT_FLOOR, Measurement, Status, is_scheme_to_blame};
pub use self::quantity::{QUANTITIES, Quantity, QuantityInfo, Values};
