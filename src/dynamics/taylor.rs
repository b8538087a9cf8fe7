//! The Taylor scheme whose steps end at the boundaries of the friction layer.
//!
//! Owns the length of a step, the search for its end, and the clock; the series are in [`series`], and the loops over periods in
//! the backends. Twin: `shaders/dynamics/taylor.wgsl`, which uses the generated text of the series.
//!
//! Between the boundaries v = -eps0, 0, +eps0 friction is a polynomial. Short recurrences therefore give the series of the
//! motion. v(s) over the step is a polynomial too: a few evaluations find where it leaves the piece. Every lane has its own clock
//! in whole ticks, and every step is a whole number of ticks: no clock drifts, and the last step ends on the period exactly.

pub mod escape;
pub mod growth;
pub mod number;
pub mod series;
pub mod wgsl;

use std::f64::consts::{PI, TAU};

use self::series::{Local, Series, UNITS_PER_PERIOD};
use crate::dynamics::decay::single;
use crate::lanes::{Mask, Real, Ticks};
use crate::model::friction::{Friction, Piece, thinnest_layer};
use crate::parameters::{Parameter, ParameterSet};

/// Order of the scheme.
pub const ORDER: usize = 8;

/// Number of coefficients of a series.
pub const COEFFICIENTS: usize = ORDER + 1;

/// Ticks in a unit of time.
pub const fn ticks_per_unit<R: Real>() -> f64 {
    R::PERIOD_TICKS / UNITS_PER_PERIOD as f64
}

/// Least step, in ticks. A start on the wrong side of a boundary moves on by this step.
pub const LEAST_TICKS: f64 = 16.0;

/// Most steps in a period that is not longer than pi, the period of the paper; a lane that needs more is given up as
/// under-resolved. A longer period may take more in proportion to its length.
pub const MAX_PASSES: u32 = 8192;

/// In the layer, a step covers at most this many times the distance to the boundary ahead, estimated by the slope of v. A
/// polynomial that is followed much farther beyond its piece runs away.
pub const REACH: f64 = 1.1;

/// In the layer, a step is at most this divided by the layer's greatest rate. Without this limit, the motion comes out smooth,
/// plausible and wrong where the bush sticks. If v crosses the layer in about the time in which friction would stop it, the
/// series has a pole at about 1.1 over that rate. A limit of 0.35 would leave an error of 1e-4 of the growth in such a crossing,
/// this one leaves 1e-6.
pub const LAYER_STEP: f64 = 0.2;

/// Outside the layer, a step is at most this divided by the rates at its start...
pub const FREE_STEP: f64 = 2.0;

/// ...or this divided by them if the cubic drag is stiff. Longer steps would then cost digits of the exponents, since such drag
/// acts all the time.
pub const STIFF_FREE_STEP: f64 = 0.8;

/// The cubic drag is stiff if its rate times the longest step exceeds this. The rate is that at the shaft's greatest speed plus
/// [`OWN_SPEED`].
pub const STIFF: f64 = 2.0;

/// Limit of the longest step for a stiff cubic drag: the rate that the drag reaches in a step that begins without sliding, times
/// this step.
pub const DRAG_GROWTH: f64 = 0.1;

/// The rate at which x swings counts this many times as much as a rate of decay, because the series converges more slowly where x
/// swings.
pub const SWING: f64 = 2.5;

/// Speed of the bush that is added to the shaft's greatest speed when the drag is estimated.
pub const OWN_SPEED: f64 = 1.0;

/// With the usual number of steps, a step is at most this divided by the rate of the linear damping. The exponent of the fast
/// decay is then as accurate as that of the slow one.
pub const DAMPING_STEP: f64 = 0.6;

/// Number of steps per period for which the bounds above are stated. With more steps, [`DAMPING_STEP`] falls in proportion.
const USUAL_STEPS: f64 = 28.0;

/// Stands for the half-width of the layer if there is no dry friction, and so no layer. It is negative: -eps0 then lies above all
/// speeds and eps0 below them, so that v is always on an outer piece and meets no boundary.
pub const NO_LAYER: f64 = -1e30;

/// v counts as beyond a boundary if it exceeds it by more than this, in units of eps0. Less may be rounding.
pub const BEYOND: f64 = 2e-4;

/// A layer with a half-width below this is thin. Between the points of a step at which v is evaluated, v may enter such a layer,
/// turn, and leave it. One step of Newton's method may also miss its boundary by more than its width. In thicker layers, neither
/// has much effect on friction.
pub const THIN: f64 = 5e-3;

/// Distance from the boundary of a thin layer, in units of eps0, by which v may miss it. Newton's method goes on until v is
/// within a tenth of this distance...
pub const MISSED: f64 = 1e-2;

/// ...for at most this many further steps.
pub const REFINEMENTS: u32 = 60;

/// A half step that starts beyond the boundary, or meets it within this part of its length, may end where it starts.
pub const ON_BOUNDARY: f64 = 1e-2;

/// If a step starts closer than this to the boundary ahead, in units of eps0, the distance to it is taken as eps0: v has just
/// come from that boundary.
pub const AT_BOUNDARY: f64 = 1e-4;

/// Square of the least slope that is used as a divisor, for v that turns at a boundary.
pub const SMALLEST_SLOPE_SQUARE: f64 = 1e-30;

/// The constants of an orbit, in the units of [`series`].
#[derive(Clone, Copy, Debug)]
pub struct Flow<R> {
    linear: R,
    minus_b: R,
    minus_damping: R,
    omega_k: R,
    zeta_k: R,
    friction: Friction<R>,
    epsilon_0: R,
    longest: R,
    longest_in_layer: R,
    /// Outside the layer, a step is at most this divided by the rates at its start.
    free_step: R,
    /// The angular speed times this counts as the square of a rate. It is sqrt(3 |b|), the squared frequency of a fast swing over
    /// its speed.
    stiffening: R,
    /// 1 in lanes whose layer is [`THIN`], and whether there are any.
    thin: R,
    pub any_thin: bool,
}

/// Unit of time of an instance, in units of tau.
pub fn unit_of_time(omega_0: f64) -> f64 {
    TAU / (omega_0 * f64::from(UNITS_PER_PERIOD))
}

/// Longest step in units of time of the instance, the least of three:
///
/// - the forcing period, or pi (the period of the paper) if that is shorter, divided by the number of steps;
/// - [`DAMPING_STEP`] over the rate of the linear damping;
/// - if the cubic drag is stiff, the step in which its rate grows from 0 to [`DRAG_GROWTH`] divided by this step.
pub fn longest_step_units(parameters: &ParameterSet, steps_per_period: u32) -> f64 {
    use Parameter::{Alpha, Beta, Epsilon, H1, Omega0, OmegaK, ZetaK};
    let damping = parameters[Epsilon] * parameters[H1].abs().max(parameters[Alpha].abs());
    let steps = f64::from(steps_per_period);
    let tau = (parameters.forcing_period().min(PI) / steps).min(DAMPING_STEP * USUAL_STEPS / steps / damping);
    let drag = 3.0 * parameters[Epsilon] * parameters[Beta].abs();
    let speed = parameters[OmegaK].abs() + parameters[ZetaK] + OWN_SPEED;
    let tau = if drag * speed * speed * tau > STIFF {
        // v grows by about (acceleration of the shaft) h, and the rate of the drag grows with the square of v
        let acceleration = parameters[ZetaK] * parameters[Omega0] + OWN_SPEED;
        tau.min((DRAG_GROWTH / (drag * acceleration * acceleration)).cbrt() * USUAL_STEPS / steps)
    } else {
        tau
    };
    tau / unit_of_time(parameters[Omega0])
}

/// Whether the number type resolves the friction layer at the shaft's greatest speed; true if there is no layer.
pub fn is_layer_resolved<R: Real>(parameters: &ParameterSet) -> bool {
    use Parameter::{Epsilon, Epsilon0, F0, OmegaK, ZetaK};
    let spacing = if single::<R>() {
        f32::EPSILON.into()
    } else {
        f64::EPSILON
    };
    let speed = parameters[OmegaK].abs() + parameters[ZetaK];
    parameters[Epsilon] * parameters[F0] == 0.0 || parameters[Epsilon0] > thinnest_layer(spacing, speed)
}

/// Most steps of a lane in a period; a lane that needs more is given up.
pub fn most_passes(forcing_period: f64) -> u32 {
    (f64::from(MAX_PASSES) * (forcing_period / PI).max(1.0)) as u32
}

impl<R: Real> Flow<R> {
    /// The flow of one instance.
    pub fn of(parameters: &ParameterSet, steps_per_period: u32) -> Self {
        Self::new(
            |parameter| R::splat(parameters[parameter]),
            R::splat(unit_of_time(parameters[Parameter::Omega0])),
            R::splat(longest_step_units(parameters, steps_per_period)),
        )
    }

    /// The flow with the parameters that `value` gives, given [`unit_of_time`] and [`longest_step_units`].
    pub fn new(value: impl Fn(Parameter) -> R, unit: R, longest: R) -> Self {
        use Parameter::{Alpha, B, Beta, Epsilon, Epsilon0, F0, H1, OmegaK, ZetaK};
        let linear = unit * unit;
        let epsilon = value(Epsilon);
        let is_dry = R::splat(0.0).less(epsilon * value(F0));
        let epsilon_0 = R::select(is_dry, unit * value(Epsilon0), R::splat(NO_LAYER));
        let thin = R::select(
            is_dry.and(value(Epsilon0).less(R::splat(THIN))),
            R::splat(1.0),
            R::splat(0.0),
        );
        let speed = value(OmegaK).abs() + value(ZetaK) + R::splat(OWN_SPEED);
        let drag = R::splat(3.0) * epsilon * value(Beta).abs() * speed * speed;
        let is_stiff = R::splat(STIFF).less(drag * unit * longest);
        let free_step = R::select(is_stiff, R::splat(STIFF_FREE_STEP), R::splat(FREE_STEP));
        // F(v) as a function of U v
        let friction = Friction::new(
            linear * epsilon,
            value(F0),
            value(Alpha) / unit,
            value(Beta) / (linear * unit),
            epsilon_0,
        );
        Self {
            linear,
            minus_b: -(linear * value(B)),
            minus_damping: -(unit * epsilon * value(H1)),
            omega_k: unit * value(OmegaK),
            zeta_k: unit * value(ZetaK),
            friction,
            epsilon_0,
            thin,
            any_thin: !thin.less(R::splat(0.5)).all(),
            longest,
            free_step,
            stiffening: (R::splat(3.0) * linear * value(B).abs()).sqrt(),
            // an absent layer limits nothing
            longest_in_layer: R::splat(LAYER_STEP) / friction.layer_rate().max(R::splat(1e-9)),
        }
    }

    /// The state at the beginning of a period, with `ticks` of it to go.
    #[inline(always)]
    pub fn start(&self, x: R, w: R, ticks: R::Ticks) -> State<R> {
        State {
            x,
            w,
            drive: R::splat(0.0),
            drive_slope: self.zeta_k,
            piece: self.friction.piece_index(self.omega_k - w),
            left: ticks,
        }
    }
}

/// A state within a period.
#[derive(Clone, Copy, Debug)]
pub struct State<R: Real> {
    pub x: R,
    /// Angular speed times the unit of time.
    pub w: R,
    /// zeta_k sin z and zeta_k cos z, times the unit of time. A rotation advances them in each step, and each period starts with
    /// their exact values.
    drive: R,
    drive_slope: R,
    /// Index of the piece of the friction law that v moves on.
    pub piece: R,
    /// Ticks to the period's end.
    pub left: R::Ticks,
}

/// A step that was taken: its series and its length.
#[derive(Clone, Copy, Debug)]
pub struct Step<R, const L: usize> {
    pub series: Series<R, L>,
    pub s: R,
}

/// Takes a step, to the boundary of the piece or as far as a step may go. A lane whose period is over stays as it is. The
/// parameter `THIN` must be true if some lanes have [`THIN`] layers.
#[inline(always)]
pub fn step<R: Real, const L: usize, const THIN: bool>(flow: &Flow<R>, state: &State<R>) -> (Step<R, L>, State<R>) {
    let v = flow.omega_k + state.drive - state.w;
    let mut state = *state;
    if THIN {
        // v may have crossed a layer in less than the least step: its piece is then found anew
        let piece = flow.friction.piece(state.piece, flow.epsilon_0);
        let margin = R::splat(MISSED) * flow.epsilon_0;
        let is_lost = v.less(piece.lower - margin).or((piece.upper + margin).less(v));
        let is_lost = is_lost.and(R::splat(0.5).less(flow.thin));
        state.piece = R::select(is_lost, flow.friction.piece_index(v), state.piece);
    }
    let piece = flow.friction.piece(state.piece, flow.epsilon_0);
    let series = Series::of(&Local {
        linear: flow.linear,
        minus_b: flow.minus_b,
        minus_damping: flow.minus_damping,
        a_0: piece.a_0,
        a_1: piece.a_1,
        a_2: piece.a_2,
        cubic: flow.friction.cubic(),
        drive: state.drive,
        drive_slope: state.drive_slope,
        x: state.x,
        w: state.w,
        v,
    });
    let trial = trial_step(flow, &piece, &series, state.left);
    let leave = leave::<R, L, THIN>(flow, &piece, &series, trial);
    let at = if THIN { refined(flow, &series, &leave) } else { leave.at };
    end(&state, &series, at, leave.change)
}

/// A step of about `s`, in whole ticks, and the state at its end, where the index of the piece changes by `change`.
#[inline(always)]
fn end<R: Real, const L: usize>(state: &State<R>, series: &Series<R, L>, s: R, change: R) -> (Step<R, L>, State<R>) {
    let ticks = (s * R::splat(ticks_per_unit::<R>()))
        .max(R::splat(LEAST_TICKS))
        .to_ticks();
    let ticks = ticks.least(state.left);
    let s = (R::from_ticks(ticks) * R::splat(1.0 / ticks_per_unit::<R>())).in_step();
    let (drive, drive_slope) = series::rotated(state.drive, state.drive_slope, s);
    let next = State {
        x: series.x_at(s),
        w: series.w_at(s),
        drive,
        drive_slope,
        piece: state.piece + change,
        left: state.left.minus(ticks),
    };
    let series = *series;
    (Step { series, s }, next)
}

/// The longest step over which the series may be followed. A limit that is NaN has no effect.
#[inline(always)]
fn trial_step<R: Real, const L: usize>(flow: &Flow<R>, piece: &Piece<R>, series: &Series<R, L>, left: R::Ticks) -> R {
    let left = R::from_ticks(left) * R::splat(1.0 / ticks_per_unit::<R>());
    let longest = flow.longest.min(left);
    let (v, slope) = (series.v[0], series.v[1]);
    let falls = slope.less(R::splat(0.0));
    let distance = R::select(falls, v - piece.lower, piece.upper - v);
    let has_just_come = distance.less(R::splat(AT_BOUNDARY) * flow.epsilon_0);
    let distance = R::select(has_just_come, flow.epsilon_0, distance);
    let is_in_layer = (piece.upper - piece.lower).less(R::splat(1.5) * flow.epsilon_0);
    // where x passes through 0 fast, its rate is small but soon grows: the speed tells how large it will be
    let swing = series.by_x[0].abs().max(flow.stiffening * series.w[0].abs()).sqrt();
    let rates = (series.by_w[0].abs() + swing).max(R::splat(SWING) * swing);
    let way = R::select(is_in_layer, R::splat(REACH) * distance, flow.free_step);
    let speed = R::select(is_in_layer, slope.abs(), rates);
    let longest = longest.min(R::select(is_in_layer, flow.longest_in_layer, longest));
    (way / speed).min(longest)
}

/// Where a step is to end.
#[derive(Clone, Copy, Debug)]
struct Leave<R: Real> {
    at: R,
    /// The change of the piece's index there; 0 where the step stays on its piece.
    change: R,
    /// The boundary that v meets, and the ends of the part of the step in which v comes from inside of it to outside.
    boundary: R,
    from: R,
    to: R,
}

/// Where v leaves the piece on the way to the trial step's end; the trial step itself if it does not.
///
/// v is evaluated halfway and at the end and, in thin layers, at the point where the parabola through the three values turns
/// beyond a boundary. The crossing is searched for in the half step before the first of these points that lies outside. The
/// parabola and one step of Newton's method give it. It is the point where v leaves the piece, even if v starts on the boundary,
/// enters the piece, and turns.
#[inline(always)]
fn leave<R: Real, const L: usize, const THIN: bool>(
    flow: &Flow<R>,
    piece: &Piece<R>,
    series: &Series<R, L>,
    trial: R,
) -> Leave<R> {
    let zero = R::splat(0.0);
    let margin = R::splat(BEYOND) * flow.epsilon_0;
    let (lower, upper) = (piece.lower - margin, piece.upper + margin);
    let middle = R::splat(0.5) * trial;
    // the search is one long chain of operations that wait for each other: `in_step` lets several vectors go through it side by
    // side
    let (v_middle, v_end) = (series.v_at(middle), series.v_at(trial).in_step());
    let mut left_early = v_middle.less(lower).or(upper.less(v_middle));
    let mut left = left_early.or(v_end.less(lower)).or(upper.less(v_end));

    let v_start = series.v[0];
    let mut from = R::select(left_early, zero, middle);
    let mut to = R::select(left_early, middle, trial);
    let mut v_to = R::select(left_early, v_middle, v_end);

    let second = v_start - R::splat(2.0) * v_middle + v_end;
    if THIN {
        // v_start + rise t + curve t^2, t = 0..1 over the trial step, may turn within it beyond a boundary
        let curve = second + second;
        let rise = v_end - v_start - curve;
        let bulge = R::select(zero.less(curve), lower, upper);
        let goes_on = (curve.abs() + curve.abs()).less(rise.abs()).or(zero.less(rise * curve));
        let room = (R::splat(4.0) * curve).mul_add(v_start - bulge, R::splat(SMALLEST_SLOPE_SQUARE));
        let stays = goes_on.or((rise * rise).less(room)).or(left_early);
        let stays = stays.or(flow.thin.less(R::splat(0.5)));
        if !stays.all() {
            let turn = (-(rise / (curve + curve)) * trial).max(zero).min(trial);
            let v_turn = series.v_at(turn);
            let inside = lower.less(v_turn).and(v_turn.less(upper));
            let touches = R::splat(0.5).less(R::select(stays.or(inside), zero, R::splat(1.0)));
            from = R::select(touches, zero, from);
            to = R::select(touches, turn, to);
            v_to = R::select(touches, v_turn, v_to);
            left_early = left_early.or(touches);
            left = left.or(touches);
        }
    }
    let v_from = R::select(left_early, v_start, v_middle);
    let v_half_on = R::select(left_early, v_middle, v_end);
    let rises = piece.upper.less(v_to);
    let boundary = R::select(rises, piece.upper, piece.lower);
    let change = R::select(rises, R::splat(1.0), R::splat(-1.0));

    // the distance outward from the boundary is beyond + slope part + bend part^2, with `part` a part of the half step; the root
    // is taken at which it rises through 0
    let beyond = change * (v_from - boundary);
    let bend = change * R::splat(0.5) * second;
    let slope = change * (v_half_on - v_from) - bend;
    let square = slope.mul_add(slope, -(R::splat(4.0) * bend * beyond));
    let root = square.max(R::splat(SMALLEST_SLOPE_SQUARE)).sqrt();
    let goes_out = zero.less(slope);
    let part = R::select(goes_out, R::splat(-2.0) * beyond, root - slope)
        / R::select(goes_out, slope + root, R::splat(2.0) * bend);
    let guess = part.mul_add(middle, from).max(from).min(to);
    // the slope of the parabola there is `root`; it is used as the slope of v
    let step_per_v = change * middle / root;
    let newton = (boundary - series.v_at(guess)).mul_add(step_per_v, guess);
    let newton = newton.max(from).min(to).in_step();
    // if the parabola fits badly, Newton's step may lead back to the start of the half step: the lane then takes a part of the
    // way, and searches again from there
    let found = from.less(newton).or(part.less(R::splat(ON_BOUNDARY)));
    let closer = (R::splat(0.5) * part).mul_add(middle, from);
    let leaves = left.and(found);
    Leave {
        at: R::select(left, R::select(found, newton, closer), trial),
        change: R::select(leaves, change, zero),
        boundary,
        from,
        to,
    }
}

/// Where v meets the boundary, to a tenth of [`MISSED`]: by Newton's method from the estimate, with bisection where a step leaves
/// the bracket.
#[inline(always)]
fn refined<R: Real, const L: usize>(flow: &Flow<R>, series: &Series<R, L>, leave: &Leave<R>) -> R {
    let zero = R::splat(0.0);
    let tolerance = R::splat(0.1 * MISSED) * flow.epsilon_0;
    let (mut low, mut high, mut at) = (leave.from, leave.to, leave.at);
    for _ in 0..REFINEMENTS {
        // distance outward from the boundary
        let beyond = leave.change * (series.v_at(at) - leave.boundary);
        let is_met = beyond.abs().less(tolerance);
        let is_met = is_met.or((leave.change.abs() * flow.thin).less(R::splat(0.5)));
        if is_met.all() {
            break;
        }
        let is_out = zero.less(beyond);
        high = R::select(is_out, at, high);
        low = R::select(is_out, low, at);
        let newton = at - beyond / (leave.change * series.v_slope_at(at));
        let is_between = low.less(newton).and(newton.less(high));
        let closer = R::select(is_between, newton, R::splat(0.5) * (low + high));
        at = R::select(is_met, at, closer);
    }
    at
}

/// The value of x at its turn within the step, an extremum that the ends of steps do not show. If x does not turn, its value at
/// the step's end. Accurate to the third order of the step.
#[inline(always)]
pub fn turning<R: Real, const L: usize>(step: &Step<R, L>, end: &State<R>) -> R {
    let before = step.series.w[0];
    let turns = (before * end.w).less(R::splat(0.0));
    // 1 over the mean slope of w
    let inverse_slope = step.s / (end.w - before);
    let at = -(before * inverse_slope);
    let w = step.series.w_at(at);
    let x = step.series.x_at(at) - R::splat(0.5) * w * w * inverse_slope;
    R::select(turns, x, end.x)
}
