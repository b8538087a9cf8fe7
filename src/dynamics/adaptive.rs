//! Steps of the rubbed bush: their length, where they end, and what is taken from them.
//!
//! Owns error control, the ends of steps at the friction layer's boundaries and at loss and return of contact, and the
//! clock; the equations of a step are [`super::radau`]'s. Twin: `shaders/dynamics/adaptive.wgsl`.
//!
//! Every lane has its own clock and its own step: a pass tries one step in each, and keeps it where it is good.

#![allow(
    clippy::needless_range_loop,
    reason = "arrays are walked side by side: indices say so best"
)]

use std::f64::consts::TAU;

use super::decay::single;
use super::dense::Cubic;
use super::matrix::at_nodes;
use super::radau::{self, Drive, ERROR_WEIGHT, Heat, Memory, ModeStep, NODES, Perturbation, Start, Trial};
use crate::experiment::Settings;
use crate::lanes::{Mask, Real, Ticks};
use crate::model::rubbing::{HeatModes, Rubbing};
use crate::parameters::Parameter;

/// Ticks of the clock in a forcing period.
pub const TICKS: u32 = 1 << 28;

/// Shortest step, in ticks.
pub const SHORTEST_STEP: u32 = 2;

/// The first step of a run.
pub const FIRST_STEP: u32 = TICKS / 4096;

/// A contact whose thermal pressure reaches this has run away: expansion feeds the friction that heats.
pub const PRESSURE_BOUND: f64 = 1e9;

/// Passes that a period may take: beyond, it is under-resolved.
pub const PASS_BUDGET: u32 = 20_000;

/// Near a boundary of the friction layer, in half-widths of the layer: how far beyond it a step is cut, how far beyond
/// the cut aims, and from how far before it a lane that is on its way out is taken to have reached the next piece. Between
/// these a lane may turn without chatter, and the tangent misses no more of the layer than that.
pub const CUT: f64 = 2e-3;
pub const AIM: f64 = 5e-4;
pub const REACHED: f64 = 5e-4;

/// Bounds of a sliding velocity that meets no boundary.
const FAR: f64 = 1e30;

/// The error of the pressure is relative down to this pressure, and absolute below: what grows from near 0 by its own heat,
/// as with a ramp, keeps its relative errors.
pub const PRESSURE_FLOOR: f64 = 1e-2;

/// A trial with an error above this many tolerances is tried again.
pub const REJECTED: f64 = 1.5;

/// What all instances of a batch share.
#[derive(Clone, Copy, Debug)]
pub struct Control<R> {
    /// Error of a step: of v in units of 1 outside the friction layer and of its half-width inside, of p relative.
    pub tolerance: R,
    /// Longest step, in ticks: a sixteenth of a period at most, which f32 holds exactly.
    pub longest: R,
}

impl<R: Real> Control<R> {
    pub fn new(settings: &Settings) -> Self {
        Self {
            tolerance: R::splat(settings.tolerance),
            longest: R::splat((f64::from(TICKS) / f64::from(settings.steps_per_period())).floor()),
        }
    }
}

/// What one instance is, apart from its state.
#[derive(Clone, Debug)]
pub struct System<R> {
    pub rubbing: Rubbing<R>,
    /// Forcing period in units of tau, and ticks to tau.
    period: R,
    tick: R,
    rates: Vec<R>,
    inverse_rates: Vec<R>,
    weights: Vec<R>,
    surface_temperature: R,
    /// Whether any lane's fit is a ramp.
    ramps: bool,
    /// 0 in lanes that wear, else 1: there the tangent vector lives until contact is lost, and no longer.
    lasts: R,
}

impl<R: Real> System<R> {
    /// The system with the parameters that `value` gives, and each lane's heat modes, all of the same number.
    pub fn new<'a>(value: impl Fn(Parameter) -> R, modes: impl Fn(usize) -> &'a HeatModes) -> Self {
        let rubbing = Rubbing::new(&value);
        let period = R::splat(TAU) / value(Parameter::Omega0);
        let count = modes(0).rates.len();
        let each = |of: &dyn Fn(&HeatModes) -> f64| R::from_lanes(|lane| of(modes(lane)));
        Self {
            ramps: (0..R::LANES).any(|lane| rubbing.ramp_rate.lane(lane).is_finite()),
            lasts: R::select(R::splat(0.0).less(rubbing.k_w), R::splat(0.0), R::splat(1.0)),
            rubbing,
            period,
            tick: period * R::splat(1.0 / f64::from(TICKS)),
            rates: (0..count).map(|m| each(&|modes| modes.rates[m])).collect(),
            inverse_rates: (0..count).map(|m| each(&|modes| 1.0 / modes.rates[m])).collect(),
            weights: (0..count).map(|m| each(&|modes| modes.weights[m])).collect(),
            surface_temperature: each(&|modes| modes.surface_temperature),
        }
    }

    /// h_U at a time: 1 - exp(-delta tau^2), to rounding also where it is small.
    #[inline(always)]
    fn fit(&self, time: R) -> R {
        if !self.ramps {
            return R::splat(1.0);
        }
        // ramps are rare: lane by lane is fast enough
        R::from_lanes(|lane| {
            let (rate, time) = (self.rubbing.ramp_rate.lane(lane), time.lane(lane));
            if rate.is_finite() {
                -(-rate * time * time).exp_m1()
            } else {
                1.0
            }
        })
    }
}

/// State of an instance.
#[derive(Clone, Debug)]
pub struct Orbit<R: Real> {
    pub x: R,
    /// Sliding velocity (shaft speed) - y.
    pub v: R,
    /// h_U - u_w.
    pub fit: R,
    pub modes: Vec<R>,
    heat: Heat<R>,
    /// 1 in contact, 0 in the gap.
    pub contact: R,
    /// Drive phase: its sine and cosine, and the ticks left to where the lanes meet.
    sin: R,
    cos: R,
    left: R::Ticks,
    /// The tick of the period that the lanes are on their way to, or at.
    to: u32,
    /// Completed periods.
    pub periods: R,
    /// Length of the next step, in ticks.
    pub step: R,
    /// Piece of the friction law: 0 below the layer, 1 and 2 its halves, 3 above.
    pub piece: R,
    /// Acceleration as a quadratic in time around the last trial's start, and the time since then: guesses the next.
    pub guess: [R; 3],
    pub since: R,
    /// Least and greatest x since they were last set.
    pub extremes: [R; 2],
    /// 1 in lanes that have been given up: because they needed too many or too short steps, or because the pressure ran
    /// away.
    pub under_resolved: R,
    pub runaway: R,
}

/// What an instance's run has shown of its contact.
#[derive(Clone, Copy, Debug)]
pub struct Peaks<R> {
    pub pressure: R,
    /// When: completed periods, and tau since.
    pub pressure_time: [R; 2],
    pub temperature: R,
    /// When contact was first lost; periods are negative while it has not been.
    pub lost: [R; 2],
}

/// A tangent vector of the full state.
#[derive(Clone, Debug)]
pub struct Tangent<R> {
    pub at: Perturbation<R>,
    pub modes: Vec<R>,
}

impl<R: Real> Tangent<R> {
    /// (X, Y, rest) = (1, 0, 0).
    pub fn start(modes: usize) -> Self {
        let zero = R::splat(0.0);
        let heat = Heat {
            pressure: zero,
            falloff: zero,
        };
        Self {
            at: Perturbation {
                x: R::splat(1.0),
                v: zero,
                fit: zero,
                heat,
                flux: zero,
            },
            modes: vec![zero; modes],
        }
    }

    /// Divides the vector by its norm and returns the norm. It is that of (X, Y) where there is wear, and else that of
    /// (X, Y) and the heat modes, these in units of the pressure that they make (none where they feed nothing back).
    #[inline(always)]
    pub fn normalise(&mut self, system: &System<R>) -> R {
        let mut square = self.at.x.mul_add(self.at.x, self.at.v * self.at.v);
        for (mode, weight) in self.modes.iter().zip(&system.weights) {
            let pressure = system.lasts * *mode * *weight;
            square = pressure.mul_add(pressure, square);
        }
        let smallest = R::splat(super::tangent::SMALLEST_SQUARE);
        let norm = R::select(square.less(smallest), smallest, square).sqrt();
        let inverse = R::splat(1.0) / norm;
        let at = &mut self.at;
        for value in [
            &mut at.x,
            &mut at.v,
            &mut at.fit,
            &mut at.heat.pressure,
            &mut at.heat.falloff,
            &mut at.flux,
        ]
        .into_iter()
        .chain(&mut self.modes)
        {
            *value = *value * inverse;
        }
        norm
    }
}

/// Room for what a pass knows of each mode.
pub type Scratch<R> = Vec<ModeStep<R>>;

impl<R: Real> Orbit<R> {
    /// The state at the start of a run, from (x, y).
    pub fn start(system: &System<R>, x: R, y: R) -> Self {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let mut orbit = Self {
            x,
            v: system.rubbing.omega_k - y,
            fit: system.fit(zero),
            modes: vec![zero; system.rates.len()],
            heat: Heat {
                pressure: zero,
                falloff: zero,
            },
            contact: one,
            sin: zero,
            cos: one,
            left: R::Ticks::splat(0),
            to: 0,
            periods: zero,
            step: R::splat(f64::from(FIRST_STEP)),
            piece: zero,
            guess: [zero; 3],
            since: zero,
            extremes: [x; 2],
            under_resolved: zero,
            runaway: zero,
        };
        orbit.piece = orbit.piece_of(&system.rubbing);
        orbit.guess[0] = orbit.begin(system).acceleration;
        orbit
    }

    #[inline(always)]
    fn piece_of(&self, rubbing: &Rubbing<R>) -> R {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        R::select((-rubbing.epsilon_0).less(self.v), one, zero)
            + R::select(zero.less(self.v), one, zero)
            + R::select(rubbing.epsilon_0.less(self.v), one, zero)
    }

    #[inline(always)]
    fn begin(&self, system: &System<R>) -> Start<R> {
        let speed = system.rubbing.zeta_k.mul_add(self.sin, system.rubbing.omega_k);
        Start::new(
            &system.rubbing,
            self.x,
            self.v,
            speed,
            self.fit,
            self.heat,
            self.contact,
        )
    }

    /// Time since the start of the run.
    pub fn time(&self, system: &System<R>) -> R {
        self.periods
            .mul_add(system.period, R::splat(f64::from(self.to)) * system.tick)
    }

    /// u_w.
    pub fn wear(&self, system: &System<R>) -> R {
        system.fit(self.time(system)) - self.fit
    }

    /// p, 0 in the gap.
    pub fn pressure(&self) -> R {
        self.contact * (self.fit + self.heat.pressure)
    }

    /// theta(1), the temperature of the shaft's surface.
    pub fn surface_temperature(&self, system: &System<R>) -> R {
        self.heat.falloff * system.surface_temperature
    }

    /// Angular speed of the bush.
    #[inline(always)]
    pub fn y(&self, system: &System<R>) -> R {
        system.rubbing.zeta_k.mul_add(self.sin, system.rubbing.omega_k) - self.v
    }

    /// One forcing period; a tangent vector is carried along if there is one.
    #[inline(always)]
    pub fn period(
        &mut self,
        system: &System<R>,
        control: &Control<R>,
        peaks: &mut Peaks<R>,
        tangent: Option<&mut Tangent<R>>,
        scratch: &mut Scratch<R>,
    ) {
        self.part_of_period(system, control, peaks, tangent, scratch, 0, 1);
    }

    /// Part `part` of `parts` equal parts of a forcing period, which follow one another from 0 on.
    #[allow(clippy::too_many_arguments, reason = "what a step needs, and where it ends")]
    #[inline(always)]
    pub fn part_of_period(
        &mut self,
        system: &System<R>,
        control: &Control<R>,
        peaks: &mut Peaks<R>,
        mut tangent: Option<&mut Tangent<R>>,
        scratch: &mut Scratch<R>,
        part: u32,
        parts: u32,
    ) {
        let (zero, half, one) = (R::splat(0.0), R::splat(0.5), R::splat(1.0));
        if part == 0 {
            // the drive's phase is 0 exactly: rounding does not grow from period to period
            self.sin = zero;
            self.cos = one;
        }
        let ticks = |parts_done: u32| (u64::from(TICKS) * u64::from(parts_done) / u64::from(parts)) as u32;
        let (from, to) = (ticks(part), ticks(part + 1));
        let alive = self.under_resolved.less(half).and(self.runaway.less(half));
        self.left = R::select(alive, R::splat(f64::from(to - from)), zero).to_ticks();
        self.to = to;
        let mut passes = 0;
        while !self.left.all_zero() {
            self.pass(system, control, peaks, tangent.as_deref_mut(), scratch);
            passes += 1;
            if passes == PASS_BUDGET {
                let unfinished = R::splat(0.5).less(R::from_ticks(self.left));
                self.under_resolved = R::select(unfinished, R::splat(1.0), self.under_resolved);
                self.left = R::Ticks::splat(0);
            }
        }
        if part + 1 == parts {
            self.periods = self.periods + one;
            self.to = 0;
        }
    }

    /// Tries one step in every lane.
    #[inline(always)]
    fn pass(
        &mut self,
        system: &System<R>,
        control: &Control<R>,
        peaks: &mut Peaks<R>,
        tangent: Option<&mut Tangent<R>>,
        scratch: &mut Scratch<R>,
    ) {
        let rubbing = &system.rubbing;
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let left = R::from_ticks(self.left);
        let running = R::splat(0.5).less(left);
        // lanes that wait for others try something harmless
        let ticks = R::from_ticks(self.step.to_ticks().least(self.left));
        let ticks = R::select(running, ticks, R::splat(f64::from(FIRST_STEP)));
        let h = ticks * system.tick;

        let elapsed = (R::splat(f64::from(self.to)) - left) * system.tick;
        let start = self.begin(system);
        let drive = self.drive(system, ticks, h, elapsed);
        let memory = Memory::new(
            h,
            &system.rates,
            &system.inverse_rates,
            &system.weights,
            &self.modes,
            scratch,
        );
        let guess = at_nodes!(i => {
            let time = R::splat(NODES[i]).mul_add(h, self.since);
            self.guess[2].mul_add(time, self.guess[1]).mul_add(time, self.guess[0])
        });
        let trial = radau::solve(rubbing, &start, &drive, &memory, guess);

        // what the trial calls for: a part of itself, if it is to be tried again
        let (error, growth) = self.error(rubbing, control, &start, &trial, h);
        let (shorter, kept) = self.cut(rubbing, &start, &trial);
        let kept = kept.and(trial.converged).and(error.less(R::splat(REJECTED)));
        let kept = kept.and(running);
        let again = R::select(
            trial.converged,
            // a cut is exact enough only where the trial is
            R::select(shorter.less(one), shorter, growth.min(R::splat(0.9))),
            R::splat(0.25),
        );
        // whatever has converged guesses the next; what has not is forgotten
        let parabola = radau::parabola(trial.acceleration);
        let inverse_h = one / h;
        self.guess = [
            R::select(trial.converged, parabola[0], start.acceleration),
            R::select(trial.converged, parabola[1] * inverse_h, zero),
            R::select(trial.converged, parabola[2] * inverse_h * inverse_h, zero),
        ];
        self.since = R::select(kept, h, zero);

        if let Some(tangent) = tangent {
            let alive = peaks.lost[0].less(zero).or(zero.less(system.lasts));
            self.carry(system, &start, &trial, &memory, tangent, scratch, h, kept.and(alive));
        }
        self.keep(
            system, peaks, &start, &drive, &trial, &memory, scratch, h, elapsed, kept,
        );
        self.left = self.left.minus(R::select(kept, ticks, zero).to_ticks());

        let moved = self.switch(rubbing, &start, &trial);
        // a step cut short by the end of the period says nothing of the next one
        let free = R::select(ticks.less(self.step), self.step, ticks * growth);
        let next = R::select(kept, R::select(zero.less(moved), ticks * moved, free), ticks * again);
        let next = R::from_ticks(next.min(control.longest).max(zero).to_ticks());
        self.step = R::select(running, next, self.step);
        self.give_up(running);
    }

    /// Shaft speed and fit over a step of `h`: growth since its start, at the nodes. Growth, not values, so that f32
    /// keeps the digits of v.
    #[inline(always)]
    fn drive(&self, system: &System<R>, ticks: R, h: R, elapsed: R) -> Drive<R> {
        let mut drive = Drive {
            h,
            speed: [R::splat(0.0); 3],
            fit: [R::splat(0.0); 3],
        };
        let angle = ticks * R::splat(TAU / f64::from(TICKS));
        for i in 0..3 {
            let (sine, versine) = rotation(angle * R::splat(NODES[i]));
            drive.speed[i] = system.rubbing.zeta_k * (self.cos * sine - self.sin * versine);
        }
        if system.ramps {
            let now = self.periods.mul_add(system.period, elapsed);
            let fit = system.fit(now);
            for i in 0..3 {
                drive.fit[i] = system.fit(R::splat(NODES[i]).mul_add(h, now)) - fit;
            }
        }
        drive
    }

    /// Error of a trial in tolerances, and the factor by which the next step is longer.
    #[inline(always)]
    fn error(&self, rubbing: &Rubbing<R>, control: &Control<R>, start: &Start<R>, trial: &Trial<R>, h: R) -> (R, R) {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        // the quadratics extrapolated to the start miss the values there; a stiff motion forgets the error
        let weight = h * R::splat(ERROR_WEIGHT);
        let rate = (rubbing.epsilon * start.pressure).mul_add(rubbing.friction_slope(self.v), rubbing.damping);
        let weight = weight / weight.mul_add(rate.max(zero), one);
        let inside = (self.piece - R::splat(1.5)).abs().less(one);
        let scale = R::select(inside, rubbing.epsilon_0.min(one), one);
        let motion = (start.acceleration - radau::parabola(trial.acceleration)[0]).abs() * weight / scale;
        let heat = (start.flux - radau::parabola(trial.flux)[0]).abs() * weight * rubbing.two_gamma
            / (start.pressure.abs() + R::splat(PRESSURE_FLOOR));
        let error = motion.max(heat) / control.tolerance;
        // the estimate is of order 3: its error grows with the fourth power of the step
        let growth = R::splat(0.9) / error.max(R::splat(1e-12)).sqrt().sqrt();
        (error, growth.max(R::splat(0.2)).min(R::splat(3.0)))
    }

    /// Whether the trial stays on its piece of the friction law and in its state of contact; else the part of it that
    /// does.
    #[inline(always)]
    fn cut(&self, rubbing: &Rubbing<R>, start: &Start<R>, trial: &Trial<R>) -> (R, R::Mask) {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let mut part = one;
        let mut stays = running_mask::<R>();

        let [low, high] = self.bounds(rubbing);
        let margin = R::splat(CUT) * rubbing.epsilon_0;
        let (lowest, highest) = (low - margin, high + margin);
        let [first, second, last] = at_nodes!(i => lowest.less(trial.v[i]).and(trial.v[i].less(highest)));
        let inside = first.and(second).and(last);
        if !inside.all() {
            let aim = R::splat(AIM) * rubbing.epsilon_0;
            let cubic = Cubic::new(start.v, trial.v);
            // the first node beyond, and the one before it
            let from = R::select(first, R::select(second, R::splat(NODES[1]), R::splat(NODES[0])), zero);
            let to = R::select(first, R::select(second, one, R::splat(NODES[1])), R::splat(NODES[0]));
            let v = R::select(first, R::select(second, trial.v[2], trial.v[1]), trial.v[0]);
            let level = R::select(v.less(low), low - aim, high + aim);
            let crossing = cubic.crossing(level, from, to).max(R::splat(1e-3));
            part = R::select(inside, one, crossing);
            stays = stays.and(inside);
        }

        // p in contact, and minus what it would be in the gap: falls below 0 where contact changes
        let gap = self.contact.less(R::splat(0.5));
        let signals = at_nodes!(i => R::select(gap, -trial.if_closed[i], trial.pressure[i]));
        let allowed = -contact_tolerance(self.fit);
        let [first, second, last] = at_nodes!(i => allowed.less(signals[i]));
        let lasts = first.and(second).and(last);
        if !lasts.all() {
            let before = R::select(gap, -(self.fit + self.heat.pressure), start.pressure);
            let cubic = Cubic::new(before, signals);
            let from = R::select(first, R::select(second, R::splat(NODES[1]), R::splat(NODES[0])), zero);
            let to = R::select(first, R::select(second, one, R::splat(NODES[1])), R::splat(NODES[0]));
            let aim = allowed * R::splat(0.5);
            let crossing = cubic.crossing(aim, from, to).max(R::splat(1e-3));
            part = part.min(R::select(lasts, one, crossing));
            stays = stays.and(lasts);
        }
        (part, stays)
    }

    /// The piece of the friction law that v is on; in the gap there is none.
    #[inline(always)]
    fn bounds(&self, rubbing: &Rubbing<R>) -> [R; 2] {
        let (half, far) = (R::splat(0.5), R::splat(FAR));
        let gap = self.contact.less(half);
        let lowest = gap.or(self.piece.less(half));
        let highest = gap.or(R::splat(2.5).less(self.piece));
        let low = (self.piece - R::splat(2.0)) * rubbing.epsilon_0;
        [
            R::select(lowest, -far, low),
            R::select(highest, far, low + rubbing.epsilon_0),
        ]
    }

    /// Carries a tangent vector over a kept step.
    #[allow(clippy::too_many_arguments, reason = "the parts of one pass")]
    #[inline(always)]
    fn carry(
        &self,
        system: &System<R>,
        start: &Start<R>,
        trial: &Trial<R>,
        memory: &Memory<R>,
        tangent: &mut Tangent<R>,
        steps: &Scratch<R>,
        h: R,
        kept: R::Mask,
    ) {
        let mut free = Heat {
            pressure: R::splat(0.0),
            falloff: R::splat(0.0),
        };
        for (m, step) in steps.iter().enumerate() {
            let left = system.weights[m] * step.factor * tangent.modes[m];
            free.pressure = free.pressure + left;
            free.falloff = system.rates[m].mul_add(left, free.falloff);
        }
        let memory = Memory { free, ..*memory };
        let (end, flux) = trial.perturbed(&system.rubbing, start, h, &memory, &tangent.at);
        let flux = radau::parabola(flux);
        let flux = at_nodes!(k => flux[k] * h);
        for (m, step) in steps.iter().enumerate() {
            let mode = advanced(step, tangent.modes[m], flux);
            tangent.modes[m] = R::select(kept, mode, tangent.modes[m]);
        }
        let old = tangent.at;
        tangent.at = Perturbation {
            x: R::select(kept, end.x, old.x),
            v: R::select(kept, end.v, old.v),
            fit: R::select(kept, end.fit, old.fit),
            heat: Heat {
                pressure: R::select(kept, end.heat.pressure, old.heat.pressure),
                falloff: R::select(kept, end.heat.falloff, old.heat.falloff),
            },
            flux: R::select(kept, end.flux, old.flux),
        };
    }

    /// Takes the end of a trial as the new state where it is kept.
    #[allow(clippy::too_many_arguments, reason = "the parts of one pass")]
    #[inline(always)]
    fn keep(
        &mut self,
        system: &System<R>,
        peaks: &mut Peaks<R>,
        start: &Start<R>,
        drive: &Drive<R>,
        trial: &Trial<R>,
        memory: &Memory<R>,
        steps: &Scratch<R>,
        h: R,
        elapsed: R,
        kept: R::Mask,
    ) {
        let coefficients = radau::parabola(trial.flux);
        let heat = memory.end(coefficients);
        let flux = at_nodes!(k => coefficients[k] * h);
        for (m, step) in steps.iter().enumerate() {
            self.modes[m] = R::select(kept, advanced(step, self.modes[m], flux), self.modes[m]);
        }

        let (pressure, part) = Cubic::new(start.pressure, trial.pressure).maximum();
        let higher = kept.and(peaks.pressure.less(pressure));
        peaks.pressure = R::select(higher, pressure, peaks.pressure);
        let time = [self.periods, part.mul_add(h, elapsed)];
        peaks.pressure_time = [
            R::select(higher, time[0], peaks.pressure_time[0]),
            R::select(higher, time[1], peaks.pressure_time[1]),
        ];
        let falloff = trial.falloff(&system.rubbing, start, h, heat);
        let (falloff, _) = Cubic::new(start.heat.falloff, falloff).maximum();
        let temperature = falloff * system.surface_temperature;
        peaks.temperature = R::select(kept, temperature.max(peaks.temperature), peaks.temperature);

        let (highest, _) = Cubic::new(start.x, trial.x).maximum();
        let (lowest, _) = Cubic::new(-start.x, at_nodes!(i => -trial.x[i])).maximum();
        let [x_min, x_max] = self.extremes;
        self.extremes = [
            R::select(kept, x_min.min(-lowest), x_min),
            R::select(kept, x_max.max(highest), x_max),
        ];

        self.fit = R::select(kept, self.fit + drive.fit[2] - trial.worn(&system.rubbing, h), self.fit);
        self.x = R::select(kept, trial.x[2], self.x);
        self.v = R::select(kept, trial.v[2], self.v);
        self.heat = Heat {
            pressure: R::select(kept, heat.pressure, self.heat.pressure),
            falloff: R::select(kept, heat.falloff, self.heat.falloff),
        };
        let angle = h / system.period * R::splat(TAU);
        let (sine, versine) = rotation(angle);
        let (sin, cos) = (self.sin, self.cos);
        self.sin = R::select(kept, sin + (cos * sine - sin * versine), sin);
        self.cos = R::select(kept, cos - (sin * sine + cos * versine), cos);

        // contact changes where its signal has come down to zero
        let (zero, one, half) = (R::splat(0.0), R::splat(1.0), R::splat(0.5));
        let gap = self.contact.less(half);
        let signal = R::select(gap, -trial.if_closed[2], trial.pressure[2]);
        let changes = kept.and(signal.less(zero));
        if R::select(changes, one, zero).less(half).all() {
            return;
        }
        let first = changes.and(half.less(self.contact)).and(peaks.lost[0].less(zero));
        let lost = [self.periods, elapsed + h];
        peaks.lost = [
            R::select(first, lost[0], peaks.lost[0]),
            R::select(first, lost[1], peaks.lost[1]),
        ];
        self.contact = R::select(changes, one - self.contact, self.contact);
        self.piece = R::select(changes, self.piece_of(&system.rubbing), self.piece);
    }

    /// Moves a lane to the piece that it has reached; returns the factor for its next step, 0 where it has not moved.
    #[inline(always)]
    fn switch(&mut self, rubbing: &Rubbing<R>, start: &Start<R>, trial: &Trial<R>) -> R {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let [low, high] = self.bounds(rubbing);
        let reached = R::splat(REACHED) * rubbing.epsilon_0;
        let up = (high - reached).less(self.v).and(start.v.less(self.v));
        let down = self.v.less(low + reached).and(self.v.less(start.v));
        let moved = up.or(down);
        if R::select(moved, one, zero).less(R::splat(0.5)).all() {
            return zero;
        }
        self.piece = R::select(up, self.piece + one, R::select(down, self.piece - one, self.piece));
        // entering the layer, the next boundary is a layer's half-width away at most; leaving it, what limited the step
        // is gone
        let inside = (self.piece - R::splat(1.5)).abs().less(one);
        // v' through the last two nodes is good enough for the length of a step
        let slid = (trial.v[2] - trial.v[1]).abs().max(R::splat(1e-20)) * R::splat(1.0 / (1.0 - NODES[1]));
        let entering = (R::splat(1.1) * rubbing.epsilon_0 / slid).min(R::splat(64.0));
        R::select(moved, R::select(inside, entering, R::splat(4.0)), zero)
    }

    /// Gives up lanes whose step has become too short or whose state is no longer a number of this world.
    #[inline(always)]
    fn give_up(&mut self, running: R::Mask) {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        // written so that NaN is given up
        let bounded = self.heat.pressure.abs().less(R::splat(PRESSURE_BOUND));
        let steps = R::splat(f64::from(SHORTEST_STEP)).less(self.step);
        let fine = bounded.and(steps);
        if fine.all() {
            return;
        }
        let left = R::from_ticks(self.left);
        let lost = R::select(running, R::select(fine, zero, one), zero);
        let ran_away = R::select(bounded, zero, lost);
        self.runaway = self.runaway.max(ran_away);
        self.under_resolved = self.under_resolved.max(lost - ran_away);
        self.left = R::select(lost.less(R::splat(0.5)), left, zero).to_ticks();
    }
}

/// All lanes true.
#[inline(always)]
fn running_mask<R: Real>() -> R::Mask {
    R::splat(0.0).less(R::splat(1.0))
}

/// A mode after a step; `flux` are the coefficients of the heat flux times the step's length.
#[inline(always)]
fn advanced<R: Real>(step: &ModeStep<R>, mode: R, flux: [R; 3]) -> R {
    step.factor.mul_add(
        mode,
        step.moments[0].mul_add(flux[0], step.moments[1].mul_add(flux[1], step.moments[2] * flux[2])),
    )
}

/// How far below zero a pressure counts as zero: p is a difference of numbers of the size of the worn depth.
#[inline(always)]
fn contact_tolerance<R: Real>(fit: R) -> R {
    let unit = if single::<R>() { 4e-6 } else { 1e-6 };
    R::splat(unit) * (fit.abs() + R::splat(1.0))
}

/// sin and 1 - cos of an angle of 0 to 2 pi/16, by their series: no digits are lost in either.
#[inline(always)]
fn rotation<R: Real>(angle: R) -> (R, R) {
    let square = angle * angle;
    let one = R::splat(1.0);
    let terms = if single::<R>() { 4 } else { 7 };
    let (mut sine, mut versine) = (one, one);
    for n in (1..terms).rev() {
        let k = f64::from(2 * n);
        sine = (square * R::splat(-1.0 / (k * (k + 1.0)))).mul_add(sine, one);
        versine = (square * R::splat(-1.0 / ((k + 1.0) * (k + 2.0)))).mul_add(versine, one);
    }
    (angle * sine, square * R::splat(0.5) * versine)
}

impl<R: Real> Peaks<R> {
    /// Before anything has happened.
    pub fn start(orbit: &Orbit<R>) -> Self {
        let zero = R::splat(0.0);
        Self {
            pressure: orbit.fit,
            pressure_time: [zero; 2],
            temperature: zero,
            lost: [R::splat(-1.0), zero],
        }
    }
}
