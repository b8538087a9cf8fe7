//! Turns of orbits at constant contact pressure, and the cycles near them.
//!
//! Owns which vectors they carry, and the error of what they show.

use super::newton::{CONVERGED, NEAR, Newton, Next, ROUNDS, distance, least_period};
use super::{Candidate, Found, REST, Search};
use crate::backend::{Backend, BackendError, BackendKind, Contact, EndState, Instance, Slice, Stage, Sums};
use crate::dynamics::divergence_check::CHECKED_EVERY;
use crate::dynamics::floquet::plane::{Image, Monodromy, across};
use crate::experiment::{Sampling, Settings};
use crate::measure::evaluation::{checked, is_resolved, missed_by_scheme};
use crate::measure::{Class, Measurement, Status};

/// Rounding error of one forcing period, in units of the number type's last place. Over several periods it grows like a random
/// walk.
const ROUNDING: f64 = 100.0;

/// Looks for the cycles near candidates.
///
/// # Errors
/// If the backend fails.
pub(super) fn find(
    backend: &mut dyn Backend,
    settings: &Settings,
    candidates: &[Candidate],
) -> Result<Vec<Found>, BackendError> {
    super::find_with(candidates, settings.sampling.max_period, Orbit::new, |searches| {
        for _ in 0..ROUNDS {
            let open = searches.iter_mut().filter(|search| search.phase == Phase::Searching);
            turn(backend, settings, Stage::Measure, open)?;
        }
        let unchecked = searches.iter_mut().filter(|search| search.phase == Phase::Unchecked);
        turn(backend, settings, Stage::Check, unchecked)
    })
}

/// Carries searches through one turn each.
fn turn<'a>(
    backend: &mut dyn Backend,
    settings: &Settings,
    stage: Stage,
    searches: impl Iterator<Item = &'a mut Orbit>,
) -> Result<(), BackendError> {
    let mut on_the_way: Vec<Way> = searches.map(Way::new).collect();
    on_the_way.sort_by_key(|way| way.search.period);
    let mut done = 0;
    // the shortest turns end first; the others go on together, so that the batch is as large as possible
    while let Some(next) = on_the_way.first().map(|way| way.search.period) {
        let settings = Settings {
            sampling: Sampling {
                transient_periods: 0,
                align_periods: 0,
                periods: next,
                ..settings.sampling
            },
            ..*settings
        };
        let instances: Vec<Instance> = on_the_way.iter().flat_map(|way| way.pair.clone()).collect();
        backend.load(&settings, &instances)?;
        // period by period, so that the rounding of sums does not depend on where the shorter turns end
        for first in done..next {
            backend.advance(&Slice {
                stage,
                first,
                periods: 1,
                elapsed: first,
            })?;
            let (ends, sums) = (backend.end_states()?, backend.collect()?);
            for (way, (ends, sums)) in on_the_way.iter_mut().zip(ends.chunks(2).zip(sums.chunks(2))) {
                way.add(stage, ends, sums);
            }
        }
        done = next;
        let kind = backend.kind();
        let arrived = on_the_way.partition_point(|way| way.search.period == done);
        for way in on_the_way.drain(..arrived) {
            way.end(stage, kind);
        }
    }
    Ok(())
}

/// A search on its way through a turn.
struct Way<'a> {
    search: &'a mut Orbit,
    /// One state with each of two vectors that were perpendicular when the turn began.
    pair: [Instance; 2],
    sums: [Sums; 2],
    /// Least and greatest x.
    extremes: [f64; 2],
    /// Whether the orbit ran away or was given up.
    is_lost: bool,
}

impl<'a> Way<'a> {
    fn new(search: &'a mut Orbit) -> Self {
        Self {
            pair: search.pair(),
            search,
            sums: [Sums::default(); 2],
            extremes: [f64::INFINITY, f64::NEG_INFINITY],
            is_lost: false,
        }
    }

    /// Adds a period of the turn.
    fn add(&mut self, stage: Stage, ends: &[EndState], sums: &[Sums]) {
        if stage == Stage::Measure {
            self.search.states.push([ends[0].x, ends[0].y]);
        }
        for (i, (end, sums)) in ends.iter().zip(sums).enumerate() {
            self.sums[i].add(sums);
            self.pair[i].state = [end.x, end.y];
            self.pair[i].tangent = end.tangent;
            self.is_lost |= end.runaway_periods.is_some() || end.under_resolved;
        }
        self.extremes = [self.extremes[0].min(ends[0].x_min), self.extremes[1].max(ends[0].x_max)];
    }

    /// Ends the turn.
    fn end(self, stage: Stage, backend: BackendKind) {
        let search = self.search;
        search.periods += 2 * search.period;
        let is_at_rest = self.extremes[1] - self.extremes[0] < REST;
        let may_be_cycle = search.instance.parameters.is_driven() || is_at_rest || !search.newton.has_begun();
        search.phase = if self.is_lost || !may_be_cycle {
            Phase::Over
        } else if stage == Stage::Check {
            let sums = &self.sums[0];
            let defect = (sums.growth[0] + sums.growth[1] - sums.divergence) / f64::from(CHECKED_EVERY);
            search.measurement = search.measured(defect, backend);
            Phase::Over
        } else {
            search.extremes = self.extremes;
            let monodromy = Monodromy {
                first: search.instance.tangent,
                images: [0, 1].map(|i| Image {
                    direction: self.pair[i].tangent,
                    growth: self.sums[i].growth[0],
                }),
                log_determinant: self.sums[0].divergence,
            };
            search.end_turn(self.pair[0].state, monodromy, backend)
        };
    }
}

/// How far a search is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Phase {
    Searching,
    /// The cycle was found, but the area that the two vectors span does not show how well the scheme has followed it.
    Unchecked,
    Over,
}

/// The search for a cycle near an orbit.
struct Orbit {
    instance: Instance,
    period: u32,
    phase: Phase,
    /// Forcing periods that were integrated.
    periods: u32,
    newton: Newton<Monodromy>,
    /// States of the last turn, from its first state on.
    states: Vec<[f64; 2]>,
    /// Least and greatest x of the last turn.
    extremes: [f64; 2],
    /// Whether the cycle that was found has shed a cycle of twice its period.
    has_doubled: bool,
    measurement: Option<Measurement>,
}

impl Search for Orbit {
    fn found(&self) -> Found {
        Found {
            moved: self.newton.moved(),
            periods: self.periods,
            measurement: self.measurement,
        }
    }

    fn has_doubled(&self) -> bool {
        self.has_doubled
    }
}

impl Orbit {
    fn new(instance: &Instance, period: u32) -> Self {
        Self {
            instance: instance.clone(),
            period,
            phase: Phase::Searching,
            periods: 0,
            newton: Newton::new(CONVERGED, NEAR),
            states: vec![instance.state],
            extremes: [f64::NAN; 2],
            has_doubled: false,
            measurement: None,
        }
    }

    /// The state in which the present turn begins, with each of two perpendicular vectors.
    fn pair(&self) -> [Instance; 2] {
        let tangent = self.instance.tangent;
        [tangent, across(tangent)].map(|tangent| Instance {
            state: self.states[0],
            tangent,
            ..self.instance.clone()
        })
    }

    /// Ends a turn, given the state at its end and its monodromy matrix.
    fn end_turn(&mut self, end: [f64; 2], monodromy: Monodromy, backend: BackendKind) -> Phase {
        match self.newton.end_turn(self.states[0].to_vec(), end.to_vec(), monodromy) {
            Next::From(state) => {
                self.states = vec![[state[0], state[1]]];
                Phase::Searching
            }
            Next::Found(_) => match monodromy.area_defect(self.rounding(backend)) {
                Some(defect) => {
                    self.measurement = self.measured(defect, backend);
                    Phase::Over
                }
                None => Phase::Unchecked,
            },
            Next::Lost => Phase::Over,
        }
    }

    /// Rounding error of a turn.
    fn rounding(&self, backend: BackendKind) -> f64 {
        ROUNDING * f64::from(self.period).sqrt() * backend.epsilon()
    }

    /// The measurement of the cycle that was found, given the difference between the growth of the area in a turn and the divergence.
    /// None if it is not certain that the cycle attracts and that the orbit goes there.
    fn measured(&mut self, defect: f64, backend: BackendKind) -> Option<Measurement> {
        let [before, last] = self.newton.last_two()?;
        let parameters = &self.instance.parameters;
        let turn_time = f64::from(self.period) * parameters.forcing_period();
        let [before_moduli, moduli] = [before, last].map(|turn| turn.linear.multipliers().log_moduli);
        let multipliers = last.linear.multipliers();
        let exponents = moduli.map(|log| log / turn_time);
        let closer = self.newton.closer();
        let changes = [0, 1].map(|i| (moduli[i] - before_moduli[i]).abs() * closer / turn_time);
        let defect = defect / turn_time;
        let missed = missed_by_scheme(parameters, backend, exponents[0], defect);
        let errors = changes.map(|change| change + missed);
        let moved = distance(&last.state, &last.end);
        self.has_doubled = multipliers.leading() < -1.0;
        let class = self.newton.class(exponents[0], errors[0])?;
        let rounding = self.rounding(backend) * (1.0 + last.end[0].abs() + last.end[1].abs());
        let period = least_period(
            &self.states,
            moved,
            multipliers.distance_from_one(),
            rounding / multipliers.distance_from_one(),
        );
        let measurement = Measurement {
            class: Some(class),
            lyapunov: exponents[0],
            lyapunov_error: errors[0],
            scheme_error: missed,
            lyapunov_second: exponents[1] + defect,
            lyapunov_second_error: errors[1],
            divergence: last.linear.log_determinant / turn_time,
            lyapunov_birkhoff: exponents[0],
            lyapunov_interval: turn_time,
            period: Some(period),
            x: last.end[0],
            y: last.end[1],
            x_min: self.extremes[0],
            x_max: self.extremes[1],
            contact: Contact::CONSTANT,
            attractors: u32::from(class == Class::Regular),
            initial_state: parameters.initial_state(),
            ..Measurement::unmeasured(Status::Ok, backend)
        };
        let resolved = is_resolved(&measurement);
        Some(checked(measurement, resolved))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::Backend;
    use crate::backend::cpu::CpuBackend;
    use crate::experiment::Precision;
    use crate::parameters::{Parameter, ParameterSet};

    /// What is found for a period near the state of an orbit after some periods.
    fn near(zeta_k: f64, h1: f64, period: u32, after: u32) -> Found {
        let parameters = ParameterSet::default()
            .with(Parameter::ZetaK, zeta_k)
            .with(Parameter::H1, h1);
        let mut backend = CpuBackend::new(Precision::F64);
        let settings = Settings::default();
        backend.load(&settings, &[parameters.into()]).unwrap();
        let slice = Slice {
            stage: Stage::Transient,
            first: 0,
            periods: after,
            elapsed: 0,
        };
        backend.advance(&slice).unwrap();
        let EndState { x, y, .. } = backend.end_states().unwrap()[0];
        let candidate = Candidate {
            instance: Instance::new(parameters, [x, y]),
            period,
        };
        find(&mut backend, &settings, &[candidate]).unwrap().remove(0)
    }

    #[test]
    fn a_cycle_is_found_from_afar_as_from_nearby() {
        let nearby = near(3.2, 0.5, 1, 300).measurement.unwrap();
        assert_eq!((nearby.class, nearby.period), (Some(Class::Regular), Some(1)));
        let afar = near(3.2, 0.5, 1, 16);
        assert!(afar.moved > 1e-6, "{}", afar.moved);
        for found in [afar.measurement.unwrap(), near(3.2, 0.5, 6, 300).measurement.unwrap()] {
            assert_eq!((found.class, found.period), (nearby.class, nearby.period));
            let error = found.lyapunov_error + nearby.lyapunov_error;
            assert!(
                (found.lyapunov - nearby.lyapunov).abs() <= error,
                "{found:?} {nearby:?}"
            );
            assert!((found.x - nearby.x).hypot(found.y - nearby.y) < 1e-5);
        }
    }

    /// Beyond a period doubling, Newton's method for the period before finds a cycle that does not attract.
    #[test]
    fn a_search_that_finds_the_cycle_before_a_doubling_goes_on_with_twice_the_period() {
        for period in [1, 2] {
            let found = near(6.442953, 0.348993, period, 100).measurement.unwrap();
            assert_eq!((found.class, found.period), (Some(Class::Regular), Some(2)));
            assert!((found.lyapunov + 0.0216).abs() < 1e-3, "{found:?}");
        }
    }

    #[test]
    fn chaos_is_on_no_cycle() {
        for period in [1, 2, 5] {
            assert!(near(4.4, 0.5, period, 300).measurement.is_none());
        }
    }
}
