//! A block of instances with frictional heat and wear that one thread carries on by the Radau scheme.
//!
//! Owns the loop over forcing periods and what is recorded of each; [`adaptive`](crate::dynamics::adaptive) takes the steps
//! within. Compiled for each instruction set by its caller.

use nalgebra::DMatrix;

use super::super::{EndState, Instance, Slice, Stage, Sums};
use super::Block;
use super::record::{Measuring, Record};
use crate::backend::rubbed::Begun;
use crate::backend::{Contact, HeatedState};
use crate::dynamics::adaptive::{Control, Orbit, Peaks, Scratch, System, Tangent};
use crate::dynamics::divergence_check::growth_of_first;
use crate::dynamics::radau::ModeStep;
use crate::dynamics::tangent::Growth;
use crate::experiment::Settings;
use crate::lanes::{Mask, Real};
use crate::model::rubbing::{HeatModes, Spectra};
use crate::parameters::ParameterSet;

/// As many instances as the lane type holds.
pub(super) struct RadauBlock<R: Real> {
    system: System<R>,
    orbit: Orbit<R>,
    /// The tangent vectors that are carried.
    tangents: Vec<Tangent<R>>,
    peaks: Peaks<R>,
    scratch: Scratch<R>,
    record: Record<R>,
    /// Of each lane, in f64: a lane's own type may round them to 0.
    parameters: Vec<ParameterSet>,
}

/// Data that all instances of a batch share.
pub(super) struct Run<R> {
    measuring: Measuring,
    control: Control<R>,
    /// None where there is neither heat nor wear.
    spectra: Option<Spectra>,
    /// Number of tangent vectors.
    vectors: usize,
}

impl<R: Real + Send + Sync> Block for RadauBlock<R> {
    type Run = Run<R>;
    const INSTANCES: usize = R::LANES;

    fn run(settings: &Settings, instances: &[Instance]) -> Run<R> {
        let points = instances.iter().map(|instance| &instance.parameters);
        Run {
            measuring: Measuring::new(settings),
            control: Control::new(&settings.integration),
            // if no instance has heat or wear, heat modes would be computed and carried in vain
            spectra: points
                .clone()
                .any(ParameterSet::has_heat_or_wear)
                .then(|| Spectra::new(points, settings.integration.modes as usize)),
            vectors: instances.iter().map(Instance::vectors).max().unwrap_or(1),
        }
    }

    fn new(run: &Run<R>, _: &Settings, instances: &[Instance]) -> Self {
        let instance = |lane: usize| &instances[lane.min(instances.len() - 1)];
        let lanes = |parameter| R::from_lanes(|lane| instance(lane).parameters[parameter]);
        let modes: Vec<_> = instances
            .iter()
            .map(|instance| match &run.spectra {
                Some(spectra) => spectra.heat_modes(&instance.parameters),
                None => HeatModes::none(),
            })
            .collect();
        let system = System::new(lanes, |lane| &modes[lane.min(modes.len() - 1)]);
        let Begun { orbit, peaks, tangents } = Begun::new(&system, run.vectors, instance);
        Self {
            tangents,
            peaks,
            scratch: vec![ModeStep::empty(); system.mode_count()],
            record: Record::new(),
            parameters: (0..R::LANES).map(|lane| instance(lane).parameters).collect(),
            system,
            orbit,
        }
    }

    #[inline(always)]
    fn advance(&mut self, run: &Run<R>, slice: &Slice) {
        let measured = slice.stage.is_measured();
        if measured && slice.first == 0 {
            self.orbit.extremes = [self.orbit.x; 2];
        }
        for n in 0..slice.periods {
            // one call serves all stages: the scheme is long, and every call of it is compiled for every lane type
            let tangents = if slice.stage.is_plain() {
                &mut []
            } else {
                self.tangents.as_mut_slice()
            };
            self.orbit
                .period(&self.system, &run.control, &mut self.peaks, tangents, &mut self.scratch);
            match slice.stage {
                Stage::Transient => {}
                Stage::Linearise => [self.record.x_min, self.record.x_max] = self.orbit.extremes,
                Stage::Watch => {
                    let (x, y) = (self.orbit.x, self.orbit.y(&self.system));
                    self.record.watch(&run.measuring, slice.first + n, x, y);
                }
                Stage::Align | Stage::Measure | Stage::Check => {
                    let growth = Tangent::orthonormalise(&mut self.tangents, &self.system);
                    let divergence = self.tangents[0].take_divergence();
                    if measured {
                        self.add(run, slice.first + n, growth, divergence);
                    }
                }
            }
            self.note_given_up(slice.elapsed + n + 1);
        }
    }

    fn sums(&self, index: usize) -> Sums {
        self.record.sums(index)
    }

    fn clear_sums(&mut self) {
        self.record.clear_sums();
    }

    fn end_state(&self, index: usize) -> EndState {
        let parameters = &self.parameters[index];
        let tau = |at: [R; 2]| at[0].lane(index) * parameters.forcing_period() + at[1].lane(index);
        let lost = self.peaks.lost;
        let y = self.orbit.y(&self.system).lane(index);
        let contact = Contact {
            lost: (lost[0].lane(index) >= 0.0).then(|| tau(lost)),
            peak_pressure: self.peaks.pressure.lane(index),
            peak_pressure_time: tau(self.peaks.pressure_time),
            final_wear: self.orbit.wear(&self.system).lane(index),
            peak_temperature: self.peaks.temperature.lane(index),
        };
        let tangent = if parameters.has_heat_or_wear() {
            [f64::NAN; 2]
        } else {
            self.tangents[0].in_plane(index)
        };
        let heated = parameters.is_heated().then(|| {
            Box::new(HeatedState {
                pressures: self.orbit.mode_pressures(&self.system, index),
                vectors: self.vectors(index),
                periods: self.orbit.periods.lane(index),
                is_in_contact: self.orbit.contact.lane(index) > 0.0,
                contact,
                step: self.orbit.step.lane(index) / R::PERIOD_TICKS,
            })
        });
        EndState {
            heated,
            contact,
            ..self.record.end_state(index, [self.orbit.x.lane(index), y], tangent)
        }
    }
}

impl<R: Real> RadauBlock<R> {
    #[inline(always)]
    fn add(&mut self, run: &Run<R>, index: u32, growth: Growth<R>, divergence: R) {
        let (x, y) = (self.orbit.x, self.orbit.y(&self.system));
        // at constant pressure the tangent space has two dimensions: the divergence tells how the second vector grows
        let has_heat_or_wear = R::splat(0.5).less(self.system.has_heat_or_wear);
        let constant = growth_of_first(growth.first, divergence);
        let growth = Growth {
            first: growth.first,
            second: R::select(has_heat_or_wear, growth.second, constant.second),
        };
        let divergence = R::select(has_heat_or_wear, R::splat(f64::NAN), divergence);
        self.record.add(&run.measuring, index, growth, divergence, x, y);
        [self.record.x_min, self.record.x_max] = self.orbit.extremes;
    }

    /// The tangent vectors of a lane.
    fn vectors(&self, lane: usize) -> DMatrix<f64> {
        let (size, count) = (2 + self.system.mode_count(), self.tangents.len());
        let components = self
            .tangents
            .iter()
            .flat_map(|tangent| tangent.components(&self.system, lane));
        DMatrix::from_iterator(size, count, components)
    }

    /// Notes lanes that the scheme gave up in `period`, counted from 1.
    #[inline(always)]
    fn note_given_up(&mut self, period: u32) {
        let (under_resolved, runaway) = (self.orbit.under_resolved, self.orbit.runaway);
        if (under_resolved + runaway).less(R::splat(0.5)).all() {
            return;
        }
        self.record.note_under_resolved(|lane| under_resolved.lane(lane) > 0.0);
        let phase = self.orbit.runaway_phase;
        self.record
            .note_runaway_lanes(|lane| (runaway.lane(lane) > 0.0).then(|| f64::from(period - 1) + phase.lane(lane)));
    }
}
