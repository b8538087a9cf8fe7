//! Turns of orbits with heat and without wear, and the cycles near them.
//!
//! Owns the space in which such a cycle is looked for, and the scheme's share in the error of what is found. The state is (x, y)
//! and the pressures that the heat modes cause. Newton's method solves for all of them together. It finds the steady heat of a
//! cycle some time before the shaft has warmed up. The cycle counts only if the whole deviation of the orbit, with the missing heat,
//! leads there.
//!
//! Every search is by radau in f64 on the CPU, which carries a tangent vector in every direction for a fraction of a step's
//! price.

use nalgebra::{DMatrix, DVector};

use super::newton::{CONVERGED, NEAR, Newton, Next, ROUNDS, distance, least_period};
use super::{Candidate, Found, REST, Search};
use crate::backend::cpu::CpuBackend;
use crate::backend::{Backend, BackendError, BackendKind, Contact, EndState, HeatedState, Instance, Slice, Stage};
use crate::dynamics::floquet::Multipliers;
use crate::dynamics::floquet::space::Monodromy;
use crate::experiment::{Integration, Precision, Sampling, Settings};
use crate::measure::evaluation::checked;
use crate::measure::{Class, Measurement, Status};
use crate::model::rubbing::has_ramp_ended;

/// A cycle that was found with the tolerance of the run is found again with a finer one, smaller by this factor. The difference
/// between the exponents is the scheme's share in the error.
const FINER: f64 = 0.125;

/// Most orbits that are searched together, and most numbers that the tangent maps of all their periods may have, of which a search
/// keeps four turns.
const TOGETHER: usize = 256;
const NUMBERS: usize = 2_000_000;

/// Looks for the cycles near candidates.
///
/// # Errors
/// If the backend fails.
pub(super) fn find(settings: &Settings, candidates: &[Candidate]) -> Result<Vec<Found>, BackendError> {
    let mut backend = CpuBackend::new(Precision::F64);
    let by = |tolerance: f64| Settings {
        integration: Integration {
            tolerance: tolerance * settings.integration.tolerance,
            precision: Some(Precision::F64),
            ..settings.integration
        },
        sampling: Sampling {
            transient_periods: 0,
            align_periods: 0,
            periods: 1,
            ..settings.sampling
        },
    };
    let (rough, fine) = (by(1.0), by(FINER));
    let mut found = Vec::with_capacity(candidates.len());
    let largest = candidates.iter().map(numbers).max().unwrap_or(1);
    for together in candidates.chunks((NUMBERS / largest).clamp(1, TOGETHER)) {
        found.extend(super::find_with(
            together,
            settings.sampling.max_period,
            |instance, period| Orbit::new(instance, period, &rough, &fine),
            |searches| {
                for (phase, settings) in [(Phase::Rough, &rough), (Phase::Fine, &fine)] {
                    for _ in 0..ROUNDS {
                        let open = searches.iter_mut().filter(|search| search.phase == phase);
                        turn(&mut backend, settings, open)?;
                    }
                }
                Ok(())
            },
        )?);
    }
    Ok(found)
}

/// How many numbers the tangent maps of one turn have.
fn numbers(candidate: &Candidate) -> usize {
    let size = 2 + heated(&candidate.instance).pressures.len();
    size * size * candidate.period as usize
}

/// Carries searches through one turn each.
fn turn<'a>(
    backend: &mut CpuBackend,
    settings: &Settings,
    searches: impl Iterator<Item = &'a mut Orbit>,
) -> Result<(), BackendError> {
    let mut on_the_way: Vec<Way> = searches.map(Way::new).collect();
    while !on_the_way.is_empty() {
        let instances: Vec<Instance> = on_the_way.iter().map(|way| way.instance.clone()).collect();
        backend.load(settings, &instances)?;
        backend.advance(&Slice {
            stage: Stage::Linearise,
            first: 0,
            periods: 1,
            elapsed: 0,
        })?;
        for (way, end) in on_the_way.iter_mut().zip(backend.end_states()?) {
            way.add(&end);
        }
        let (arrived, others): (Vec<Way>, Vec<Way>) = on_the_way
            .into_iter()
            .partition(|way| way.is_lost || way.periods.len() == way.search.period as usize);
        arrived.into_iter().for_each(Way::end);
        on_the_way = others;
    }
    Ok(())
}

/// How far a search is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// With the tolerance of the run.
    Rough,
    /// With the finer tolerance, from the cycle that was found.
    Fine,
    Over,
}

/// The search for a cycle near an orbit. States are (x, y) and the pressures of the heat modes in units of `unit`, a pressure of the
/// orbit.
struct Orbit {
    instance: Instance,
    unit: f64,
    period: u32,
    /// Distance below which two states of a turn are the same, whatever the search has missed.
    same: f64,
    phase: Phase,
    /// Forcing periods that were integrated.
    integrated: u32,
    rough: Newton<Monodromy>,
    fine: Newton<Monodromy>,
    /// The state in which the next turn begins.
    state: Vec<f64>,
    has_doubled: bool,
    measurement: Option<Measurement>,
}

/// What a turn has shown besides its linearisation.
struct Along {
    /// Its states, from the first one on.
    states: Vec<Vec<f64>>,
    /// Least and greatest x.
    extremes: [f64; 2],
    contact: Contact,
}

impl Search for Orbit {
    fn found(&self) -> Found {
        Found {
            moved: self.rough.moved(),
            periods: self.integrated,
            measurement: self.measurement,
        }
    }

    fn has_doubled(&self) -> bool {
        self.has_doubled
    }
}

impl Orbit {
    fn new(instance: &Instance, period: u32, rough: &Settings, fine: &Settings) -> Self {
        let heated = heated(instance);
        let time = heated.periods * instance.parameters.forcing_period();
        let is_steady = has_ramp_ended(&instance.parameters, time);
        let unit = 1.0 + heated.pressures.iter().sum::<f64>().abs();
        let state = instance.state.into_iter();
        let state = state.chain(heated.pressures.iter().map(|pressure| pressure / unit));
        Self {
            unit,
            period,
            // while the fit still changes, there is no cycle
            phase: if is_steady { Phase::Rough } else { Phase::Over },
            integrated: 0,
            // a tolerance does not tell apart states that are nearer than it; the finer search goes on from what the first has found
            rough: Newton::new(
                CONVERGED.max(rough.integration.tolerance),
                NEAR.max(rough.integration.tolerance),
            ),
            fine: Newton::new(CONVERGED, NEAR.max(fine.integration.tolerance)),
            same: rough.sampling.period_tolerance,
            state: state.collect(),
            has_doubled: false,
            measurement: None,
            instance: instance.clone(),
        }
    }

    /// The instance in a state, after some more periods, with a vector along each axis of the state.
    fn at(&self, state: &[f64], periods: usize, step: f64, contact: Contact) -> Instance {
        let before = heated(&self.instance);
        let scales = DVector::from_fn(state.len(), |n, _| self.scale(n));
        Instance {
            state: [state[0], state[1]],
            heated: Some(Box::new(HeatedState {
                pressures: state[2..].iter().map(|pressure| pressure * self.unit).collect(),
                vectors: DMatrix::from_diagonal(&scales),
                periods: before.periods + periods as f64,
                is_in_contact: before.is_in_contact,
                contact,
                step,
            })),
            ..self.instance.clone()
        }
    }

    /// The unit of component `n` of a state.
    fn scale(&self, n: usize) -> f64 {
        if n < 2 { 1.0 } else { self.unit }
    }

    /// Ends a turn of a search.
    fn end_turn(&mut self, monodromy: Monodromy, along: &Along) -> Phase {
        let [first, .., last] = along.states.as_slice() else {
            unreachable!("a turn has a first and a last state");
        };
        let newton = match self.phase {
            Phase::Rough => &mut self.rough,
            _ => &mut self.fine,
        };
        let next = newton.end_turn(first.clone(), last.clone(), monodromy);
        match (next, self.phase) {
            (Next::From(state), phase) => {
                self.state = state;
                phase
            }
            (Next::Found(state), Phase::Rough) => {
                self.state = state;
                Phase::Fine
            }
            (Next::Found(_), _) => {
                self.measurement = self.measured(along);
                Phase::Over
            }
            (Next::Lost, _) => Phase::Over,
        }
    }

    /// The measurement of the cycle that was found, given its last turn. None if it is not certain that the cycle attracts and that
    /// the orbit goes there.
    fn measured(&mut self, along: &Along) -> Option<Measurement> {
        let [before, last] = self.fine.last_two()?;
        let [_, rough] = self.rough.last_two()?;
        let parameters = &self.instance.parameters;
        let turn_time = f64::from(self.period) * parameters.forcing_period();
        let multipliers = last.linear.multipliers()?;
        let [before, rough] = [before.linear.multipliers()?, rough.linear.multipliers()?];
        let exponents = multipliers.log_moduli.map(|log| log / turn_time);
        let closer = self.fine.closer();
        let off = |other: &Multipliers, i: usize| (multipliers.log_moduli[i] - other.log_moduli[i]).abs() / turn_time;
        let shares = [0, 1].map(|i| off(&rough, i));
        let errors = [0, 1].map(|i| off(&before, i) * closer + shares[i]);
        let moved = distance(&last.state, &last.end);
        self.has_doubled = multipliers.leading() < -1.0;
        let class = self.rough.class(exponents[0], errors[0])?;
        let Along {
            states,
            extremes,
            contact,
        } = along;
        let measurement = Measurement {
            class: Some(class),
            lyapunov: exponents[0],
            lyapunov_error: errors[0],
            scheme_error: shares[0],
            lyapunov_second: exponents[1],
            lyapunov_second_error: errors[1],
            // the tangent space has more dimensions than two
            divergence: f64::NAN,
            lyapunov_birkhoff: exponents[0],
            lyapunov_interval: turn_time,
            period: Some(least_period(states, moved, multipliers.distance_from_one(), self.same)),
            x: last.end[0],
            y: last.end[1],
            x_min: extremes[0],
            x_max: extremes[1],
            contact: *contact,
            attractors: u32::from(class == Class::Regular),
            initial_state: parameters.initial_state(),
            ..Measurement::unmeasured(Status::Ok, BackendKind::CpuF64)
        };
        Some(checked(measurement, true))
    }
}

/// What a heated instance has besides (x, y).
fn heated(instance: &Instance) -> &HeatedState {
    instance.heated.as_deref().expect("the candidates are heated")
}

/// A search on its way through a turn.
struct Way<'a> {
    search: &'a mut Orbit,
    /// Where it is, with a vector along each axis.
    instance: Instance,
    /// The tangent map of each period so far.
    periods: Vec<DMatrix<f64>>,
    along: Along,
    /// Whether the orbit ran away or was given up, or the contact has changed.
    is_lost: bool,
}

impl<'a> Way<'a> {
    fn new(search: &'a mut Orbit) -> Self {
        let start = heated(&search.instance);
        Self {
            instance: search.at(&search.state, 0, start.step, start.contact),
            periods: Vec::new(),
            along: Along {
                states: vec![search.state.clone()],
                extremes: [f64::INFINITY, f64::NEG_INFINITY],
                contact: start.contact,
            },
            is_lost: false,
            search,
        }
    }

    /// Adds a period of the turn.
    fn add(&mut self, end: &EndState) {
        let search = &self.search;
        let after = end.heated.as_deref().expect("heat stays");
        let pressures = after.pressures.iter().map(|pressure| pressure / search.unit);
        let state: Vec<f64> = [end.x, end.y].into_iter().chain(pressures).collect();
        let mut map = after.vectors.clone();
        for (n, mut row) in map.row_iter_mut().enumerate() {
            row /= search.scale(n);
        }
        self.periods.push(map);
        self.instance = search.at(&state, self.periods.len(), after.step, after.contact);
        self.is_lost |= end.runaway_periods.is_some()
            || end.under_resolved
            || after.is_in_contact != heated(&search.instance).is_in_contact;
        let [x_min, x_max] = self.along.extremes;
        self.along.extremes = [x_min.min(end.x_min), x_max.max(end.x_max)];
        self.along.contact = after.contact;
        self.along.states.push(state);
    }

    /// Ends the turn.
    fn end(self) {
        let search = self.search;
        search.integrated += self.periods.len() as u32;
        let is_at_rest = self.along.extremes[1] - self.along.extremes[0] < REST;
        let may_be_cycle = search.instance.parameters.is_driven() || is_at_rest || !search.rough.has_begun();
        search.phase = if self.is_lost || !may_be_cycle {
            Phase::Over
        } else {
            search.end_turn(Monodromy::new(self.periods), &self.along)
        };
    }
}
