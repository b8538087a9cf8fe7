//! One instance with frictional heat and wear over time.
//!
//! Owns its samples; the motion between them is [`super::adaptive`]'s.

use std::ops::{ControlFlow, Range};

use super::adaptive::{Control, Orbit, Peaks, System};
use super::radau::ModeStep;
use crate::experiment::Integration;
use crate::model::motion::RUNAWAY_BOUND;
use crate::model::rubbing::HeatModes;
use crate::model::thermal_modes::ThermalModes;
use crate::parameters::{Parameter, ParameterSet};

/// The system at one time; all quantities are dimensionless.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    pub tau: f64,
    /// phi and phi-dot.
    pub x: f64,
    pub y: f64,
    /// Sliding velocity (shaft speed) - y.
    pub v: f64,
    /// p; 0 in the gap.
    pub pressure: f64,
    /// u_w.
    pub wear: f64,
    /// theta(1, tau).
    pub temperature: f64,
}

/// A run, sampled in equal steps.
#[derive(Clone, Debug)]
pub struct History {
    /// The samples of the shown periods, both ends included. They end where the instance was given up. If that was before the
    /// shown periods, only the last sample before it is left.
    pub samples: Vec<Sample>,
    /// tau_c, when contact was first lost.
    pub contact_lost: Option<f64>,
    /// Whether the instance was given up: the motion or the pressure ran away, or too many or too short steps were needed.
    pub given_up: bool,
    /// Whether the pressure ran away.
    pub pressure_ran_away: bool,
    /// When the motion or the pressure ran away, in tau.
    pub runaway: Option<f64>,
    /// Greatest p, also between samples, and its tau.
    pub peak_pressure: f64,
    pub peak_pressure_time: f64,
    /// Greatest theta(1, tau), also between samples.
    pub peak_temperature: f64,
}

/// Follows an instance from its initial state to the end of the forcing periods `shown`, and samples it `samples` times in each
/// of them. The periods before are divided in the same way.
///
/// # Panics
/// If `samples` is 0.
pub fn history(parameters: &ParameterSet, integration: &Integration, shown: Range<u32>, samples: u32) -> History {
    let followed = follow(parameters, integration, shown, samples, &mut || {
        ControlFlow::Continue(())
    });
    followed.expect("nothing breaks it off")
}

/// The same; after every forcing period `go_on` may break it off, and the result is None.
///
/// # Panics
/// If `samples` is 0.
pub fn follow(
    parameters: &ParameterSet,
    integration: &Integration,
    shown: Range<u32>,
    samples: u32,
    go_on: &mut dyn FnMut() -> ControlFlow<()>,
) -> Option<History> {
    assert!(samples > 0, "samples in a period");
    let spectrum = ThermalModes::new(parameters[Parameter::Biot], integration.modes as usize);
    let modes = HeatModes::new(parameters, &spectrum);
    let system = System::<f64>::new(|parameter| parameters[parameter], |_| &modes);
    let control = Control::new(integration);
    let [x, y] = parameters.initial_state();
    let mut orbit = Orbit::start(&system, x, y);
    let mut peaks = Peaks::start(&orbit);
    let mut scratch = vec![ModeStep::empty(); modes.rates.len()];
    let sample = |orbit: &Orbit<f64>| Sample {
        tau: orbit.time(&system),
        x: orbit.x,
        y: orbit.y(&system),
        v: orbit.v,
        pressure: orbit.pressure(),
        wear: orbit.wear(&system),
        temperature: orbit.surface_temperature(&system),
    };
    let mut all = vec![sample(&orbit)];
    let mut given_up = false;
    'run: for period in 0..shown.end {
        if go_on().is_break() {
            return None;
        }
        for part in 0..samples {
            orbit.part_of_period(&system, &control, &mut peaks, &mut [], &mut scratch, part, samples);
            given_up = orbit.under_resolved + orbit.runaway > 0.0;
            if given_up {
                break 'run;
            }
            if period < shown.start {
                all.clear();
            }
            all.push(sample(&orbit));
        }
    }
    let time = |[periods, rest]: [f64; 2]| periods * parameters.forcing_period() + rest;
    Some(History {
        samples: all,
        contact_lost: (peaks.lost[0] >= 0.0).then(|| time(peaks.lost)),
        given_up,
        runaway: (orbit.runaway > 0.0)
            .then(|| time([orbit.periods, orbit.runaway_phase * parameters.forcing_period()])),
        pressure_ran_away: orbit.runaway > 0.0 && orbit.x.abs() + orbit.y(&system).abs() < RUNAWAY_BOUND,
        peak_pressure: peaks.pressure,
        peak_pressure_time: time(peaks.pressure_time),
        peak_temperature: peaks.temperature,
    })
}
