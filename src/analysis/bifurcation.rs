//! Bifurcation diagrams: stroboscopic states over one parameter.
//!
//! Owns from which states each column starts; the states come from [`super::orbits`].

use std::ops::ControlFlow;

use super::Progress;
use super::orbits::{is_bounded, stroboscopic_states};
use crate::backend::{Backend, BackendError, Instance};
use crate::design::{Axis, Design, Fixed};
use crate::experiment::{Experiment, Settings};

/// Where the orbits of a column begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Columns {
    /// Every column begins at the same initial states.
    Fresh,
    /// Each column begins where the column at the next lower value ended.
    FollowUp,
    /// Each column begins where the column at the next higher value ended. Where the diagram differs from that of
    /// [`Columns::FollowUp`], attractors coexist.
    FollowDown,
}

/// Measured periods of a diagram where a user asks for no number.
pub const PERIODS: u32 = 200;

/// Most states: more do not fit into memory and a usable table.
const MOST_STATES: u64 = 50_000_000;

/// Why there is no diagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages tell what each is")]
pub enum DiagramError {
    #[error("{states} states are too many (at most {MOST_STATES}): use fewer values, initial states or --periods")]
    TooMany { states: u64 },
    #[error(
        "--follow carries the angle and the speed of the bush from column to column, not the heat of the shaft: leave --follow \
         out, or set gamma = 0"
    )]
    HeatIsLost,
}

/// Checks, before any work, a diagram over the one axis of an experiment, from so many initial states.
///
/// # Errors
/// [`DiagramError::TooMany`]; [`DiagramError::HeatIsLost`] if the columns follow each other, and the shaft heats.
pub fn check(experiment: &Experiment, columns: Columns, starts: usize) -> Result<(), DiagramError> {
    let periods = u64::from(experiment.settings.sampling.periods);
    let states = (experiment.design.len() * starts) as u64 * periods;
    if states > MOST_STATES {
        return Err(DiagramError::TooMany { states });
    }
    if columns != Columns::Fresh && experiment.has_heat_or_wear() {
        return Err(DiagramError::HeatIsLost);
    }
    Ok(())
}

/// Stroboscopic states at drive phase 0, column by column.
#[derive(Clone, Debug)]
pub struct Diagram {
    /// The axis; there is one column for each of its values.
    pub axis: Axis,
    /// The values of everything that is not on the axis.
    pub fixed: Fixed,
    /// [x, y] of every measured period of every orbit, for each value of the axis.
    pub columns: Vec<Vec<[f64; 2]>>,
    /// Orbits that ran away, or that the scheme gave up as under-resolved.
    pub runaways: usize,
}

impl Diagram {
    /// Number of states in all columns.
    pub fn len(&self) -> usize {
        self.columns.iter().map(Vec::len).sum()
    }

    /// Whether there is no state: every orbit ran away or was given up.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The bifurcation diagram over `axis`; `at` gives everything else. The orbits begin at the initial states `starts` (x, y), or
/// follow the attractors that are reached from there. In each column, every orbit gives `sampling.periods` states after
/// `settings.sampling.transient_periods`. An orbit that runs away while it is followed begins again at its initial state. None if
/// `progress` broke the work off.
///
/// # Errors
/// If the backend fails.
pub fn diagram(
    backend: &mut dyn Backend,
    settings: &Settings,
    at: &Fixed,
    axis: &Axis,
    starts: &[[f64; 2]],
    columns: Columns,
    progress: &mut Progress<'_>,
) -> Result<Option<Diagram>, BackendError> {
    let mut diagram = Diagram {
        axis: axis.clone(),
        fixed: *at,
        columns: vec![Vec::new(); axis.count()],
        runaways: 0,
    };
    let design = Design::product(vec![axis.clone()], *at);
    let from = |column: usize, state: [f64; 2]| Instance::new(design.point(column), state);
    if columns == Columns::Fresh {
        let instances: Vec<Instance> = (0..axis.count())
            .flat_map(|column| starts.iter().map(move |&start| (column, start)))
            .map(|(column, start)| from(column, start))
            .collect();
        let states = &mut diagram.columns;
        let mut visit = |instance: usize, state| states[instance / starts.len()].push(state);
        let Some(ends) = stroboscopic_states(backend, settings, &instances, &mut visit, progress)? else {
            return Ok(None);
        };
        diagram.runaways = ends.iter().filter(|end| !is_bounded(end)).count();
        return Ok(Some(diagram));
    }
    let mut order = axis.rising();
    if columns == Columns::FollowDown {
        order.reverse();
    }
    let mut current = starts.to_vec();
    for column in order {
        let instances: Vec<Instance> = current.iter().map(|&state| from(column, state)).collect();
        let states = &mut diagram.columns[column];
        let mut visit = |_: usize, state| states.push(state);
        let Some(ends) = stroboscopic_states(backend, settings, &instances, &mut visit, progress)? else {
            return Ok(None);
        };
        for ((state, end), start) in current.iter_mut().zip(&ends).zip(starts) {
            *state = if is_bounded(end) { [end.x, end.y] } else { *start };
            diagram.runaways += usize::from(!is_bounded(end));
        }
    }
    Ok(Some(diagram))
}

/// A progress callback that never breaks the work off.
pub fn carry_on(_: u64) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::cpu::CpuBackend;
    use crate::experiment::Precision;
    use crate::experiment::Sampling;
    use crate::parameters::ParameterSet;

    fn compute(axis: &str, starts: &[[f64; 2]], columns: Columns) -> Diagram {
        let settings = Settings {
            sampling: Sampling {
                transient_periods: 200,
                periods: 32,
                ..Sampling::default()
            },
            ..Settings::default()
        };
        let axis = Axis::parse(axis).unwrap();
        let at = ParameterSet::default().into();
        let mut backend = CpuBackend::new(Precision::F64);
        diagram(&mut backend, &settings, &at, &axis, starts, columns, &mut carry_on)
            .unwrap()
            .unwrap()
    }

    /// The states that a column settles on, to three digits.
    fn settled(column: &[[f64; 2]]) -> std::collections::BTreeSet<i64> {
        column.iter().map(|[x, _]| (x * 1e3).round() as i64).collect()
    }

    #[test]
    fn columns_hold_the_states_of_every_start() {
        let diagram = compute("zeta_k=3.3:3.5:5", &[[0.1, 0.0], [-1.0, 0.0]], Columns::Fresh);
        assert!(diagram.columns.iter().all(|column| column.len() == 64));
        assert_eq!((diagram.len(), diagram.runaways), (5 * 64, 0));
        // the two states lead to cycles of short periods
        assert!(diagram.columns.iter().all(|column| settled(column).len() <= 8));
    }

    /// At h1 = 0.5 two attractors coexist around zeta_k = 3.85: the one reached from (1, 0) is chaotic from 3.8025, the one from
    /// (0.1, 0) from 3.8875. A diagram therefore depends on where it was followed from, but not on the direction in which its
    /// axis is written.
    #[test]
    fn followed_attractors_show_coexistence_and_do_not_depend_on_the_axis_direction() {
        let up = compute("zeta_k=3.5:3.6:6", &[[0.1, 0.0]], Columns::FollowUp);
        let same = compute("zeta_k=3.6:3.5:6", &[[0.1, 0.0]], Columns::FollowUp);
        for (column, mirrored) in up.columns.iter().zip(same.columns.iter().rev()) {
            assert_eq!(settled(column), settled(mirrored));
        }
        let fresh = compute("zeta_k=3.5:3.6:6", &[[0.1, 0.0]], Columns::Fresh);
        assert_eq!(settled(&up.columns[0]), settled(&fresh.columns[0]));
    }

    #[test]
    fn runaways_are_counted_and_begin_anew() {
        let diagram = compute("b=-1:1:3", &[[0.1, 0.0]], Columns::FollowUp);
        assert_eq!(diagram.runaways, 2);
        assert_eq!(diagram.columns.iter().map(Vec::len).collect::<Vec<_>>(), [0, 0, 32]);
    }
}
