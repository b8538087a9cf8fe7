//! The cycle near an orbit, by Newton's method on the stroboscopic map, and its measurement.
//!
//! Owns what makes a cycle certain: that it attracts, and that the orbit goes there. From the bottom to the top:
//!
//! - [`newton`]: Newton's method;
//! - [`constant`], [`heated`]: turns at constant contact pressure, and with heat.
//!
//! The stroboscopic map P takes a state at drive phase 0 over one forcing period; a cycle of period k is a fixed point of P^k. One
//! turn with tangent vectors in all directions gives P^k and its derivative, the monodromy matrix. With it Newton's method finds
//! the cycle in a few turns, where the orbit itself would take as many as the leading multiplier is close to 1.

mod constant;
mod heated;
mod newton;

use super::Measurement;
use crate::backend::{Backend, BackendError, Instance};
use crate::experiment::Settings;

/// Without a drive, the only cycle of forcing periods is a state of rest: x then varies by less than this.
const REST: f64 = 1e-4;

/// An orbit that may be near a cycle.
pub(super) struct Candidate {
    pub instance: Instance,
    /// The period of the cycle or a multiple of it, in forcing periods.
    pub period: u32,
}

/// What was found near a candidate.
#[derive(Clone)]
pub(super) struct Found {
    /// How far the orbit moves in a turn.
    pub moved: f64,
    /// Forcing periods that were integrated.
    pub periods: u32,
    /// The measurement of the cycle on which the orbit is, attracting or not; None if that is not certain.
    pub measurement: Option<Measurement>,
}

impl Found {
    /// Nothing was looked for.
    const NOTHING: Self = Self {
        moved: f64::NAN,
        periods: 0,
        measurement: None,
    };
}

/// The search for a cycle near an orbit, once it is over.
trait Search {
    fn found(&self) -> Found;

    /// Whether the cycle that was found has shed a cycle of twice its period.
    fn has_doubled(&self) -> bool;
}

/// Looks for the cycles near candidates: `begin` begins the search for a period, and `carry_out` carries searches out. Where a cycle
/// has shed one of twice its period, that one is looked for.
fn find_with<S: Search>(
    candidates: &[Candidate],
    max_period: u32,
    begin: impl Fn(&Instance, u32) -> S,
    mut carry_out: impl FnMut(&mut [S]) -> Result<(), BackendError>,
) -> Result<Vec<Found>, BackendError> {
    let mut found = vec![Found::NOTHING; candidates.len()];
    let mut open: Vec<(usize, u32)> = candidates
        .iter()
        .map(|candidate| candidate.period)
        .enumerate()
        .collect();
    while !open.is_empty() {
        let begun = open.iter();
        let mut searches: Vec<S> = begun
            .map(|&(index, period)| begin(&candidates[index].instance, period))
            .collect();
        carry_out(&mut searches)?;
        let mut doubled = Vec::new();
        for (search, (index, period)) in searches.iter().zip(open) {
            let before = found[index].periods;
            found[index] = search.found();
            found[index].periods += before;
            if search.has_doubled() && 2 * period <= max_period {
                doubled.push((index, 2 * period));
            }
        }
        open = doubled;
    }
    Ok(found)
}

/// Looks for the cycles near candidates. Either all of them are heated, or none is.
///
/// # Errors
/// If the backend fails.
pub(super) fn find(
    backend: &mut dyn Backend,
    settings: &Settings,
    candidates: &[Candidate],
) -> Result<Vec<Found>, BackendError> {
    match candidates.first() {
        Some(first) if first.instance.parameters.is_heated() => heated::find(settings, candidates),
        _ => constant::find(backend, settings, candidates),
    }
}
