//! The audit of results: some of their points are computed again on the CPU in f64.
//!
//! Owns the choice of points and what agreement means; does not change the results.

use serde::{Deserialize, Serialize};

use super::{Backends, Observer};
use crate::backend::BackendError;
use crate::backend::cpu::CpuBackend;
use crate::experiment::Precision;
use crate::measure::{Class, Quantity};
use crate::results::Results;

/// Agreement of audited points with the f64 reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Audit {
    /// One row for each class that occurs in the results.
    pub classes: Vec<ClassAudit>,
}

/// Agreement of the audited points that the results put into one class.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClassAudit {
    /// None for the transient motion of contacts that wear.
    pub class: Option<Class>,
    /// Points of the class that were computed again.
    pub points: usize,
    /// Points that the reference puts into the same class, and whose contact is lost in both computations or held in both.
    pub same_class: usize,
    /// Points whose exponents differ by at most three combined standard errors, or by at most [`EXPONENT_FLOOR`].
    pub same_exponent: usize,
    /// Largest difference between the exponents.
    pub largest_difference: f64,
}

/// Exponents agree in any case if they differ by no more than this, which is the rounding of f32. Regular orbits need this
/// bound, since their standard error vanishes.
pub const EXPONENT_FLOOR: f64 = 1e-3;

impl Audit {
    /// Points that were computed again, of all classes.
    pub fn points(&self) -> usize {
        self.classes.iter().map(|row| row.points).sum()
    }

    /// Whether at least 98 % of the points of each class but `undecided` agree in class (one point may always differ), and at
    /// least 95 % of all these points agree in their exponents, within the errors.
    pub fn passes(&self) -> bool {
        let decided = self.classes.iter().filter(|row| row.class != Some(Class::Undecided));
        let points: usize = decided.clone().map(|row| row.points).sum();
        let different: usize = decided.clone().map(|row| row.points - row.same_exponent).sum();
        decided
            .clone()
            .all(|row| (row.points - row.same_class) as f64 <= (0.02 * row.points as f64).max(1.0))
            && different as f64 <= 0.05 * points as f64
    }

    /// Points of all classes that agree in the sense of [`ClassAudit::same_class`].
    pub fn same_class(&self) -> usize {
        self.classes.iter().map(|row| row.same_class).sum()
    }

    /// Points of all classes that agree in the sense of [`ClassAudit::same_exponent`].
    pub fn same_exponent(&self) -> usize {
        self.classes.iter().map(|row| row.same_exponent).sum()
    }
}

/// Points to audit, by class. Each class that occurs gets the same number of points, or all its points if it has fewer; a
/// remainder goes to chaos first. Within each class the points are spread evenly over the design.
pub fn choose(results: &Results, points: usize) -> Vec<(Option<Class>, Vec<usize>)> {
    let mut strata: Vec<(Option<Class>, Vec<usize>)> = Class::ALL
        .into_iter()
        .map(Some)
        .chain([None])
        .map(|class| {
            let indices = (0..results.experiment.design.len())
                .filter(|&index| results.is_ok(index) && results.class(index) == class);
            (class, indices.collect())
        })
        .filter(|(_, indices): &(_, Vec<usize>)| !indices.is_empty())
        .collect();
    let mut shares = vec![0; strata.len()];
    let mut left = points;
    while left > 0 && (0..strata.len()).any(|i| shares[i] < strata[i].1.len()) {
        for (share, (_, indices)) in shares.iter_mut().zip(&strata) {
            if left > 0 && *share < indices.len() {
                *share += 1;
                left -= 1;
            }
        }
    }
    for ((_, indices), share) in strata.iter_mut().zip(shares) {
        *indices = (0..share)
            .map(|i| indices[(2 * i + 1) * indices.len() / (2 * share)])
            .collect();
    }
    strata.retain(|(_, indices)| !indices.is_empty());
    strata
}

/// Computes `points` points again on the CPU in f64; None if the observer broke the audit off.
///
/// # Errors
/// If the CPU backend fails.
pub fn audit(results: &Results, points: usize, observer: &mut Observer<'_>) -> Result<Option<Audit>, BackendError> {
    let mut reference = Backends::new(Box::new(CpuBackend::new(Precision::F64)), None);
    let strata = choose(results, points);
    let indices: Vec<usize> = strata.iter().flat_map(|(_, indices)| indices.iter().copied()).collect();
    let Some(again) = reference.measure(
        &results.experiment.design,
        &results.experiment.settings,
        &indices,
        observer,
    )?
    else {
        return Ok(None);
    };
    let mut again = indices.iter().zip(&again);
    let classes = strata
        .iter()
        .map(|(class, indices)| {
            let mut row = ClassAudit {
                class: *class,
                points: 0,
                same_class: 0,
                same_exponent: 0,
                largest_difference: 0.0,
            };
            for (&index, reference) in again.by_ref().take(indices.len()) {
                let difference = (results.value(Quantity::Lyapunov, index) - reference.lyapunov).abs();
                let error = results
                    .value(Quantity::LyapunovError, index)
                    .hypot(reference.lyapunov_error);
                let contact = Quantity::ContactStatus;
                let same_contact = results
                    .column(contact)
                    .is_none_or(|column| column.value(index) == contact.of(reference));
                row.points += 1;
                row.same_class += usize::from(reference.class == *class && same_contact);
                // an exponent of finite time has no error: the floor alone applies
                row.same_exponent += usize::from(difference <= (3.0 * error).max(EXPONENT_FLOOR));
                row.largest_difference = row.largest_difference.max(difference);
            }
            row
        })
        .collect();
    Ok(Some(Audit { classes }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::BackendKind;
    use crate::experiment::Request;
    use crate::measure::{Measurement, Status};

    /// A map of 10 x 10 points: three chaotic, one undecided, the rest regular.
    fn results() -> Results {
        let axes = Request::default_map().map(|axis| axis.resampled(10));
        let request = Request::over(axes.into());
        let mut results = Results::new(request.resolve().unwrap());
        for index in 0..100 {
            let class = match index {
                7 | 50 | 93 => Class::Chaotic,
                60 => Class::Undecided,
                _ => Class::Regular,
            };
            let runaway = Measurement::runaway(0.0, BackendKind::GpuF32);
            results.set(
                index,
                &Measurement {
                    status: Status::Ok,
                    class: Some(class),
                    ..runaway
                },
            );
        }
        results
    }

    #[test]
    fn classes_share_the_audit_and_chaos_is_never_left_out() {
        let chosen = |points| {
            choose(&results(), points)
                .into_iter()
                .map(|(class, i)| (class, i.len()))
                .collect::<Vec<_>>()
        };
        assert_eq!(chosen(1), [(Some(Class::Chaotic), 1)]);
        assert_eq!(
            chosen(5),
            [
                (Some(Class::Chaotic), 2),
                (Some(Class::Regular), 2),
                (Some(Class::Undecided), 1)
            ]
        );
        assert_eq!(
            chosen(32),
            [
                (Some(Class::Chaotic), 3),
                (Some(Class::Regular), 28),
                (Some(Class::Undecided), 1)
            ]
        );
        assert_eq!(
            chosen(1000),
            [
                (Some(Class::Chaotic), 3),
                (Some(Class::Regular), 96),
                (Some(Class::Undecided), 1)
            ]
        );
    }

    #[test]
    fn a_forged_map_does_not_pass() {
        // nothing in this map was computed: its exponents are NaN
        let audit = audit(&results(), 6, &mut |_| std::ops::ControlFlow::Continue(()))
            .unwrap()
            .unwrap();
        assert_eq!(audit.points(), 6);
        assert_eq!(audit.same_exponent(), 0);
        assert!(!audit.passes());
    }
}
