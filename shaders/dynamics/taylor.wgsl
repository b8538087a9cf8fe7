// The Taylor scheme whose steps end at the boundaries of the friction layer, around the generated text of the series.
// Twin: src/dynamics/taylor.rs.

// The constants of an orbit, in the units of the series.
struct Flow {
    linear: Real,
    minus_b: Real,
    minus_damping: Real,
    omega_k: Real,
    zeta_k: Real,
    friction: Friction,
    epsilon_0: Real,
    // Whether the layer is thin.
    thin: Mask,
    longest: Real,
    longest_in_layer: Real,
    // Outside the layer, a step is at most this over the rates at its start.
    free_step: Real,
    // The angular speed times this counts as the square of a rate.
    stiffening: Real,
}

// A state within a period.
struct State {
    x: Real,
    // Angular speed times the unit of time.
    w: Real,
    // zeta_k sin z and zeta_k cos z, times the unit of time. Steps advance them by rotation; each period sets them anew.
    drive: Real,
    drive_slope: Real,
    // Index of the piece of the friction law that v moves on.
    piece: Real,
    // Ticks to the period's end.
    left: Word,
}

// A step that was taken: its series, its length, its end.
struct Step {
    series: Series,
    s: Real,
    end: State,
}

// Sine and cosine of the drive's phase, with the factor that they had before the rotation.
struct Rotated {
    sin_z: Real,
    cos_z: Real,
}

// Where a step is to end (`at`): the change of the piece's index there, the boundary that is met, and the part of the step, from
// `start` to `stop`, in which v comes from inside the boundary to outside.
struct Leave {
    at: Real,
    change: Real,
    boundary: Real,
    start: Real,
    stop: Real,
}

fn flow_new(value: Values) -> Flow {
    let unit = value.unit_of_time;
    let linear = unit * unit;
    let is_dry = Real(0.0) < value.epsilon * value.f_0;
    let epsilon_0 = select(Real(NO_LAYER), unit * value.epsilon_0, is_dry);
    let speed = abs(value.omega_k) + value.zeta_k + OWN_SPEED;
    let drag = 3.0 * value.epsilon * abs(value.beta) * speed * speed;
    // F(v) as a function of U v
    let friction =
        friction_new(linear * value.epsilon, value.f_0, value.alpha / unit, value.beta / (linear * unit), epsilon_0);
    return Flow(
        linear,
        -(linear * value.b),
        -(unit * value.epsilon * value.h1),
        unit * value.omega_k,
        unit * value.zeta_k,
        friction,
        epsilon_0,
        is_dry & (value.epsilon_0 < Real(THIN)),
        value.step_units,
        // an absent layer limits nothing
        LAYER_STEP / max(friction.two_f_0_over_epsilon_0, Real(1e-9)),
        select(Real(FREE_STEP), Real(STIFF_FREE_STEP), Real(STIFF) < drag * unit * value.step_units),
        sqrt(3.0 * linear * abs(value.b)),
    );
}

// The state at the beginning of a period.
fn state_start(flow: Flow, x: Real, w: Real, ticks: Word) -> State {
    return State(x, w, Real(0.0), flow.zeta_k, piece_index(flow.friction, flow.omega_k - w), ticks);
}

// Takes a step: to the boundary of the piece, or as far as the step may reach. A lane whose period is over keeps its state.
fn taylor_step(flow: Flow, before: State) -> Step {
    var state = before;
    let v = flow.omega_k + state.drive - state.w;
    if (is_any(flow.thin)) {
        // an orbit that crosses a thin layer in less than the least step misses it, and v is then on its other side
        let piece = friction_piece(flow.friction, state.piece, flow.epsilon_0);
        let margin = MISSED * flow.epsilon_0;
        let is_lost = flow.thin & ((v < piece.lower - margin) | (piece.upper + margin < v));
        state.piece = select(state.piece, piece_index(flow.friction, v), is_lost);
    }
    let piece = friction_piece(flow.friction, state.piece, flow.epsilon_0);
    let series = series_new(Local(
        flow.linear,
        flow.minus_b,
        flow.minus_damping,
        piece.a_0,
        piece.a_1,
        piece.a_2,
        flow.friction.beta,
        state.drive,
        state.drive_slope,
        state.x,
        state.w,
        v,
    ));
    let trial = trial_step(flow, piece, series, state.left);
    let leave = piece_leave(flow, piece, series, trial);
    var at = leave.at;
    if (is_any(flow.thin)) {
        at = refined(flow, series, leave);
    }

    return step_end(state, series, at, leave.change);
}

// Takes a step of about `length`, in whole ticks. At its end the index of the piece has changed by `change`.
fn step_end(state: State, series: Series, length: Real, change: Real) -> Step {
    let ticks = min(Word(max(length * TICKS_PER_UNIT, Real(LEAST_TICKS))), state.left);
    let s = Real(ticks) / TICKS_PER_UNIT;
    let drive = rotated(state.drive, state.drive_slope, s);
    // only lanes that run are updated: a series that overflows is NaN even at s = 0
    let runs = state.left != Word(0u);
    let end = State(
        update(state.x, x_at(series, s), runs),
        update(state.w, w_at(series, s), runs),
        drive.sin_z,
        drive.cos_z,
        state.piece + change,
        state.left - ticks,
    );
    return Step(series, s, end);
}

// Length of the trial step: as far as the series may be followed.
fn trial_step(flow: Flow, piece: Piece, series: Series, ticks_left: Word) -> Real {
    let left = Real(ticks_left) / TICKS_PER_UNIT;
    let longest = min(flow.longest, left);
    let v = series.v_0;
    let slope = series.v_1;
    let distance = select(piece.upper - v, v - piece.lower, slope < Real(0.0));
    // an orbit that starts at the boundary has just come from there
    let way_across = select(distance, flow.epsilon_0, distance < AT_BOUNDARY * flow.epsilon_0);
    let is_in_layer = piece.upper - piece.lower < 1.5 * flow.epsilon_0;
    // where x passes through 0 fast, its rate is small for a moment only: the rate that it soon comes to is taken
    let swing = sqrt(max(abs(series.by_x_0), flow.stiffening * abs(series.w_0)));
    let rates = max(abs(series.by_w_0) + swing, SWING * swing);
    let way = select(flow.free_step, REACH * way_across, is_in_layer);
    let speed = select(rates, abs(slope), is_in_layer);
    let bound = min(longest, select(longest, flow.longest_in_layer, is_in_layer));
    // a speed of zero bounds nothing
    return select(bound, min(bound, way / speed), speed > Real(1e-30));
}

// Where v leaves the piece within the trial step; the end of the trial step if v does not leave it.
fn piece_leave(flow: Flow, piece: Piece, series: Series, trial: Real) -> Leave {
    let margin = BEYOND * flow.epsilon_0;
    let lower = piece.lower - margin;
    let upper = piece.upper + margin;
    let middle = 0.5 * trial;
    let v_middle = v_at(series, middle);
    let v_end = v_at(series, trial);
    var left_early = (v_middle < lower) | (upper < v_middle);
    var left = left_early | (v_end < lower) | (upper < v_end);

    let v_begin = series.v_0;
    var start = select(middle, Real(0.0), left_early);
    var stop = select(trial, middle, left_early);
    var v_stop = select(v_end, v_middle, left_early);

    let second = v_begin - 2.0 * v_middle + v_end;
    if (is_any(flow.thin)) {
        // v_begin + rise t + curve t^2, t = 0..1 over the trial step, may turn within it beyond a boundary
        let curve = second + second;
        let rise = v_end - v_begin - curve;
        let bulge = select(upper, lower, Real(0.0) < curve);
        let goes_on = (abs(curve) + abs(curve) < abs(rise)) | (Real(0.0) < rise * curve);
        let room = fma(4.0 * curve, v_begin - bulge, Real(SMALLEST_SLOPE_SQUARE));
        let stays = goes_on | (rise * rise < room) | left_early | !flow.thin;
        if (is_any(!stays)) {
            let turn = clamp(-(rise / select(curve + curve, Real(1.0), stays)) * trial, Real(0.0), trial);
            let v_turn = v_at(series, turn);
            let touches = !stays & !((lower < v_turn) & (v_turn < upper));
            start = select(start, Real(0.0), touches);
            stop = select(stop, turn, touches);
            v_stop = select(v_stop, v_turn, touches);
            left_early = left_early | touches;
            left = left | touches;
        }
    }
    let v_start = select(v_middle, v_begin, left_early);
    let v_half_on = select(v_end, v_middle, left_early);
    let rises = piece.upper < v_stop;
    let boundary = select(piece.lower, piece.upper, rises);
    let change = select(Real(-1.0), Real(1.0), rises);

    // distance of v outward from the boundary: beyond + slope part + bend part^2, with `part` from 0 to 1 over the half
    // step; it is sought where this rises through 0
    let beyond = change * (v_start - boundary);
    let bend = change * 0.5 * second;
    let slope = change * (v_half_on - v_start) - bend;
    let root = sqrt(max(fma(slope, slope, -(4.0 * bend * beyond)), Real(SMALLEST_SLOPE_SQUARE)));
    let goes_out = Real(0.0) < slope;
    let part = select(root - slope, -2.0 * beyond, goes_out) / select(2.0 * bend, slope + root, goes_out);
    let guess = clamp(fma(part, middle, start), start, stop);
    // the parabola's slope there is `root`: it is taken for the slope of v
    let step_per_v = change * middle / root;
    let newton = clamp(fma(boundary - v_at(series, guess), step_per_v, guess), start, stop);
    // where the parabola is a poor estimate, Newton's step may lead back to its start: the lane then takes a part of the way,
    // and searches again from there
    let found = (start < newton) | (part < Real(ON_BOUNDARY));
    let closer = fma(0.5 * part, middle, start);
    return Leave(
        select(trial, select(closer, newton, found), left),
        select(Real(0.0), change, left & found),
        boundary,
        start,
        stop,
    );
}

// Where v meets the boundary of a thin layer: by Newton's steps from the estimate, or by bisection where these leave the bracket.
fn refined(flow: Flow, series: Series, leave: Leave) -> Real {
    let leaves_thin = flow.thin & (Real(0.5) < abs(leave.change));
    let tolerance = 0.1 * MISSED * flow.epsilon_0;
    var low = leave.start;
    var high = leave.stop;
    var at = leave.at;
    for (var n = 0u; n < REFINEMENTS; n++) {
        // distance of v outward from the boundary
        let beyond = leave.change * (v_at(series, at) - leave.boundary);
        let is_met = (abs(beyond) < tolerance) | !leaves_thin;
        if (!is_any(!is_met)) {
            break;
        }
        let is_out = Real(0.0) < beyond;
        high = select(high, at, is_out);
        low = select(at, low, is_out);
        let newton = at - beyond / select(leave.change * v_slope_at(series, at), Real(1.0), is_met);
        let is_between = (low < newton) & (newton < high);
        at = select(select(0.5 * (low + high), newton, is_between), at, is_met);
    }
    return at;
}

// Number of passes after which a thread gives up its instances that have not finished their period.
fn most_passes(unit_of_time: Real) -> u32 {
    let long = max(unit_of_time * LONG_PER_UNIT, Real(1.0));
    var longest = 1.0;
    for (var lane = 0u; lane < LANES; lane++) {
        longest = max(longest, real_at(long, lane));
    }
    return u32(MAX_PASSES * longest);
}

// The value of x where it turns within the step; if it does not turn, x at the step's end.
fn turning(step: Step) -> Real {
    let before = step.series.w_0;
    let turns = before * step.end.w < Real(0.0);
    // 1 over the mean slope of w
    let inverse_slope = step.s / select(Real(1.0), step.end.w - before, turns);
    let at = -(before * inverse_slope);
    let w = w_at(step.series, at);
    let x = x_at(step.series, at) - 0.5 * w * w * inverse_slope;
    return select(step.end.x, x, turns);
}
