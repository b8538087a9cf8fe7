//! The path of one orbit.
//!
//! Owns the sampling of a scheme's steps; the steps are [`crate::dynamics`]'. A new scheme needs a branch here.

use crate::dynamics::drive::DriveTable;
use crate::dynamics::history::{History, history};
use crate::dynamics::rk4::{self, StageSpeeds, StepSize};
use crate::dynamics::taylor::series::UNITS_PER_PERIOD;
use crate::dynamics::taylor::{self, COEFFICIENTS, Flow};
use crate::experiment::{Scheme, Settings};
use crate::lanes::LONG_PERIOD_TICKS;
use crate::measure::Status;
use crate::model::motion::{Motion, RUNAWAY_BOUND};
use crate::parameters::{Parameter, ParameterSet};

/// A point on the path of an orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// Time since the end of the transient, in units of tau.
    pub tau: f64,
    /// Angle of the bush.
    pub x: f64,
    /// Angular speed of the bush, dx/dtau.
    pub y: f64,
    /// Whether the drive's phase is 0 here: the point belongs to the stroboscopic section.
    pub is_stroboscopic: bool,
}

/// The path of an orbit, and how it ended.
#[derive(Clone, Debug)]
pub struct Path {
    /// In the order of time.
    pub points: Vec<PathPoint>,
    /// How the run ended. If the orbit ran away or the scheme gave it up, the path ends there.
    pub status: Status,
}

/// The path of one orbit in f64 over `sampling.periods` forcing periods after `settings.sampling.transient_periods`, with
/// `points_per_period` points evenly spaced in each period (with rk4, no more than it has steps), and one point at the end. Radau
/// includes frictional heat and wear; with the other schemes the pressure is 1.
pub fn path(parameters: &ParameterSet, settings: &Settings, points_per_period: u32) -> Path {
    let steps = settings.integration.steps_per_period;
    match settings.integration.scheme {
        Scheme::Rk4 => walk(
            FixedSteps::new(parameters, steps),
            parameters,
            settings,
            points_per_period,
        ),
        Scheme::Taylor => {
            let walked = walk(
                TaylorSteps::new(parameters, steps),
                parameters,
                settings,
                points_per_period,
            );
            // as everywhere, radau takes over motion that is too stiff for taylor
            match walked.status {
                Status::UnderResolved => follow(parameters, settings, points_per_period),
                Status::Ok | Status::Runaway { .. } => walked,
            }
        }
        Scheme::Radau => follow(parameters, settings, points_per_period),
    }
}

/// How a run ended.
pub fn ended(history: &History) -> Status {
    match history.runaway {
        Some(time) => Status::Runaway { time },
        _ if history.given_up => Status::UnderResolved,
        _ => Status::Ok,
    }
}

fn has_run_away([x, y]: [f64; 2]) -> bool {
    // false for NaN too
    let is_bounded = x.abs() + y.abs() < RUNAWAY_BOUND;
    !is_bounded
}

/// The path with frictional heat and wear.
fn follow(parameters: &ParameterSet, settings: &Settings, points_per_period: u32) -> Path {
    let shown = settings.sampling.transient_periods..settings.sampling.transient_periods + settings.sampling.periods;
    let step = parameters.forcing_period() / f64::from(points_per_period);
    let begin = f64::from(shown.start) * parameters.forcing_period();
    let history = history(parameters, &settings.integration, shown, points_per_period);
    // an orbit that was given up in the transient has left one sample, from before its end
    let samples = history
        .samples
        .iter()
        .skip_while(|sample| sample.tau < begin - 0.5 * step);
    Path {
        points: samples
            .enumerate()
            .map(|(index, sample)| PathPoint {
                tau: sample.tau - begin,
                x: sample.x,
                y: sample.y,
                is_stroboscopic: index % points_per_period as usize == 0,
            })
            .collect(),
        status: ended(&history),
    }
}

/// The path at constant contact pressure.
fn walk(mut walker: impl Walker, parameters: &ParameterSet, settings: &Settings, points_per_period: u32) -> Path {
    let forcing_period = parameters.forcing_period();
    let mut points = Vec::new();
    for period in 0..settings.sampling.transient_periods + settings.sampling.periods {
        let shown = period.checked_sub(settings.sampling.transient_periods);
        let is_whole = walker.period(points_per_period, &mut |phase, [x, y]| {
            if let Some(shown) = shown {
                points.push(PathPoint {
                    tau: (f64::from(shown) + phase) * forcing_period,
                    x,
                    y,
                    is_stroboscopic: phase == 0.0,
                });
            }
        });
        let status = if has_run_away(walker.state()) {
            let time = f64::from(period + 1) * forcing_period;
            Status::Runaway { time }
        } else if is_whole {
            continue;
        } else {
            Status::UnderResolved
        };
        return Path { points, status };
    }
    let [x, y] = walker.state();
    points.push(PathPoint {
        tau: f64::from(settings.sampling.periods) * forcing_period,
        x,
        y,
        is_stroboscopic: true,
    });
    let status = Status::Ok;
    Path { points, status }
}

/// Integrates one orbit, and shows states on the way.
trait Walker {
    /// One forcing period; `sample(phase, [x, y])` is called with phases from 0, inclusive, to 1, exclusive. False if the
    /// scheme gave the orbit up.
    fn period(&mut self, points: u32, sample: &mut dyn FnMut(f64, [f64; 2])) -> bool;
    /// The state (x, y) at the end of the last period.
    fn state(&self) -> [f64; 2];
}

struct FixedSteps {
    motion: Motion<f64>,
    step_size: StepSize<f64>,
    drive: DriveTable<f64>,
    steps: u32,
    state: rk4::State<f64>,
}

impl FixedSteps {
    fn new(parameters: &ParameterSet, steps: u32) -> Self {
        let h = parameters.forcing_period() / f64::from(steps);
        let [x, y] = parameters.initial_state();
        Self {
            motion: Motion::new(|parameter| parameters[parameter]),
            step_size: StepSize::new(|_| h),
            drive: DriveTable::new::<f64>(steps),
            steps,
            state: rk4::State { x, y },
        }
    }
}

impl Walker for FixedSteps {
    fn period(&mut self, points: u32, sample: &mut dyn FnMut(f64, [f64; 2])) -> bool {
        let every = (self.steps / points).max(1);
        let mut start = self.motion.shaft_speed(0.0);
        for (step, &[middle, end]) in (0..self.steps).zip(self.drive.steps()) {
            if step % every == 0 {
                sample(f64::from(step) / f64::from(self.steps), self.state());
            }
            let speed = StageSpeeds {
                start,
                middle: self.motion.shaft_speed(middle),
                end: self.motion.shaft_speed(end),
            };
            self.state = rk4::step(&self.motion, &self.step_size, speed, self.state);
            start = speed.end;
        }
        true
    }

    fn state(&self) -> [f64; 2] {
        [self.state.x, self.state.y]
    }
}

struct TaylorSteps {
    flow: Flow<f64>,
    unit: f64,
    most_passes: u32,
    x: f64,
    y: f64,
}

impl TaylorSteps {
    fn new(parameters: &ParameterSet, steps_per_period: u32) -> Self {
        let [x, y] = parameters.initial_state();
        Self {
            flow: Flow::of(parameters, steps_per_period),
            unit: taylor::unit_of_time(parameters[Parameter::Omega0]),
            most_passes: taylor::most_passes(parameters.forcing_period()),
            x,
            y,
        }
    }
}

impl Walker for TaylorSteps {
    fn period(&mut self, points: u32, sample: &mut dyn FnMut(f64, [f64; 2])) -> bool {
        let whole = f64::from(UNITS_PER_PERIOD);
        let time = |point: u32| whole * f64::from(point) / f64::from(points);
        let mut state = self.flow.start(self.x, self.y * self.unit, LONG_PERIOD_TICKS);
        let mut next = 0;
        for _ in 0..self.most_passes {
            if state.left == 0.0 {
                break;
            }
            let begun = whole * (1.0 - state.left / LONG_PERIOD_TICKS);
            let (step, end) = taylor::step::<f64, COEFFICIENTS, true>(&self.flow, &state);
            while next < points && time(next) < begun + step.s {
                let s = (time(next) - begun).max(0.0);
                let [x, w] = [step.series.x_at(s), step.series.w_at(s)];
                sample(f64::from(next) / f64::from(points), [x, w / self.unit]);
                next += 1;
            }
            state = end;
        }
        (self.x, self.y) = (state.x, state.w / self.unit);
        state.left == 0.0
    }

    fn state(&self) -> [f64; 2] {
        [self.x, self.y]
    }
}
