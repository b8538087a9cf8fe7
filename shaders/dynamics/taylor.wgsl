// The Taylor scheme whose steps end at the boundaries of the friction layer, around the generated text of the series.
// Twin: src/dynamics/taylor.rs.

// What does not change along an orbit, in the units of the series.
struct Flow {
    linear: Real,
    minus_b: Real,
    minus_damping: Real,
    omega_k: Real,
    zeta_k: Real,
    friction: Friction,
    epsilon_0: Real,
    longest: Real,
    longest_in_layer: Real,
}

// A state within a period.
struct State {
    x: Real,
    // Angular speed times the unit of time.
    w: Real,
    // Zeta_k sin z and zeta_k cos z, times the unit of time: advanced by rotation; a period's start sets them anew.
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

// Sine and cosine of the drive's phase, times what they were times.
struct Rotated {
    sin_z: Real,
    cos_z: Real,
}

// Where v leaves a piece, and the change of the piece's index there.
struct Leave {
    s: Real,
    change: Real,
}

fn flow_new(value: Values) -> Flow {
    let unit = value.unit_of_time;
    let linear = unit * unit;
    let epsilon_0 = unit * value.epsilon_0;
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
        value.step_size,
        // an absent layer limits nothing
        LAYER_STEP / max(friction.two_f_0_over_epsilon_0, Real(1e-9)),
    );
}

// The state at the beginning of a period.
fn state_start(flow: Flow, x: Real, w: Real, ticks: Word) -> State {
    return State(x, w, Real(0.0), flow.zeta_k, piece_index(flow.friction, flow.omega_k - w), ticks);
}

// Takes a step: to the boundary of the piece, or as far as it may reach. A lane whose period is over stays where it is.
fn taylor_step(flow: Flow, state: State) -> Step {
    let piece = friction_piece(flow.friction, state.piece, flow.epsilon_0);
    let v = flow.omega_k + state.drive - state.w;
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
    let reached = leave(flow, piece, series, trial);

    let ticks = min(Word(max(reached.s, Real(LEAST_STEP)) * TICKS_PER_UNIT), state.left);
    let s = Real(ticks) / TICKS_PER_UNIT;
    let drive = rotated(state.drive, state.drive_slope, s);
    // a series that overflows is no number even at its start
    let runs = state.left != Word(0u);
    let end = State(
        update(state.x, x_at(series, s), runs),
        update(state.w, w_at(series, s), runs),
        drive.sin_z,
        drive.cos_z,
        state.piece + reached.change,
        state.left - ticks,
    );
    return Step(series, s, end);
}

// As far as the series may be followed.
fn trial_step(flow: Flow, piece: Piece, series: Series, ticks_left: Word) -> Real {
    let left = Real(ticks_left) / TICKS_PER_UNIT;
    let longest = min(flow.longest, left);
    let v = series.v_0;
    let slope = series.v_1;
    let distance = select(piece.upper - v, v - piece.lower, slope < Real(0.0));
    // a start at the boundary has just come from there
    let way_across = select(distance, flow.epsilon_0, distance < AT_BOUNDARY * flow.epsilon_0);
    let is_in_layer = piece.upper - piece.lower < 1.5 * flow.epsilon_0;
    let rates = abs(series.by_w_0) + sqrt(abs(series.by_x_0));
    let way = select(Real(FREE_STEP), REACH * way_across, is_in_layer);
    let speed = select(rates, abs(slope), is_in_layer);
    let bound = min(longest, select(longest, flow.longest_in_layer, is_in_layer));
    // a speed of zero bounds nothing
    return select(bound, min(bound, way / speed), speed > Real(1e-30));
}

// Where v leaves the piece on the way to the trial step's end, and the change of the piece's index there; the trial step
// itself and 0 if it does not.
fn leave(flow: Flow, piece: Piece, series: Series, trial: Real) -> Leave {
    let margin = BEYOND * flow.epsilon_0;
    let lower = piece.lower - margin;
    let upper = piece.upper + margin;
    let middle = 0.5 * trial;
    let v_middle = v_at(series, middle);
    let v_end = v_at(series, trial);
    let left_early = (v_middle < lower) | (upper < v_middle);
    let left = left_early | (v_end < lower) | (upper < v_end);

    let start = select(middle, Real(0.0), left_early);
    let stop = select(trial, middle, left_early);
    let v_start = select(v_middle, series.v_0, left_early);
    let v_stop = select(v_end, v_middle, left_early);
    let rises = piece.upper < v_stop;
    let boundary = select(piece.lower, piece.upper, rises);
    let change = select(Real(-1.0), Real(1.0), rises);

    // outward from the boundary, in parts of the half step: beyond + slope part + bend part^2, where it rises through 0
    let beyond = change * (v_start - boundary);
    let bend = change * 0.5 * (series.v_0 - 2.0 * v_middle + v_end);
    let slope = change * (v_stop - v_start) - bend;
    let root = sqrt(max(fma(slope, slope, -(4.0 * bend * beyond)), Real(SMALLEST_SLOPE_SQUARE)));
    let goes_out = Real(0.0) < slope;
    let part = select(root - slope, -2.0 * beyond, goes_out) / select(2.0 * bend, slope + root, goes_out);
    let guess = clamp(fma(part, middle, start), start, stop);
    // the parabola's slope there, which is the root, serves as that of v
    let step_per_v = change * middle / root;
    let newton = clamp(fma(boundary - v_at(series, guess), step_per_v, guess), start, stop);
    // where the parabola is no guide, Newton's step may go astray, back to where it started from: the lane then takes a
    // part of the way, and looks again from there
    let found = (start < newton) | (part < Real(ON_BOUNDARY));
    let closer = fma(0.5 * part, middle, start);
    return Leave(
        select(trial, select(closer, newton, found), left),
        select(Real(0.0), change, left & found),
    );
}

// Where x turns within the step, or else x at its end.
fn turning(step: Step) -> Real {
    let before = step.series.w_0;
    let turns = before * step.end.w < Real(0.0);
    // over the mean slope of w
    let inverse_slope = step.s / select(Real(1.0), step.end.w - before, turns);
    let at = -(before * inverse_slope);
    let w = w_at(step.series, at);
    let x = x_at(step.series, at) - 0.5 * w * w * inverse_slope;
    return select(step.end.x, x, turns);
}
