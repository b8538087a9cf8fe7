// A pass: one step tried, and accepted where it is good. Twin: src/dynamics/adaptive/pass.rs.

// Shortest step, in ticks.
override SHORTEST_STEP: f32;

// Pressure beyond which the contact has run away.
override PRESSURE_BOUND: f32;

// The error of the pressure is relative down to this pressure, and absolute below.
override PRESSURE_FLOOR: f32;

// The error of v is relative above this speed.
override LARGE_SPEED: f32;

// A trial is rejected if its error calls for a step of this part of its length or less.
override REJECTED: f32;

// The next step is this part of the step that would have just the tolerated error.
override SAFETY: f32;

// The error allows a step to be at most this number of times as long as the one before.
override LONGER: f32;

// The drive over a step, and the growth of its phase as a rotation.
struct Turned {
    drive: Drive,
    turn: Rotation,
}

// sin and 1 - cos of an angle.
struct Rotation {
    sine: f32,
    versine: f32,
}

// Tries one step; `carries` tells whether a tangent vector is carried along.
fn orbit_pass(orbit: ptr<function, Orbit>, system: System, carries: bool) {
    let rubbing = system.rubbing;
    // The last two steps of a period share what is left. A very short last step would give a bad guess for the next one: its
    // accelerations differ by little more than rounding.
    let left = f32((*orbit).left);
    let step = select(min((*orbit).step, 0.5 * left), left, left < (*orbit).step);
    let ticks = min(u32(step), (*orbit).left);
    let length = f32(ticks);
    let h = length * system.tick;

    let elapsed = f32(TICKS - (*orbit).left) * system.tick;
    let start = begin(orbit, system);
    let turned = orbit_drive(orbit, system, length, h, elapsed);
    let drive = turned.drive;
    let memory = memory_new(h);
    let time = vec3(NODE_0, NODE_1, 1.0) * h + (*orbit).since;
    var guess = fma(vec3((*orbit).guess_3), time, vec3((*orbit).guess_2));
    guess = fma(fma(guess, time, vec3((*orbit).guess_1)), time, vec3((*orbit).guess_0));
    let trial = solve(rubbing, start, drive, memory, guess, run.newton);

    // allowed length of the next step over that of the trial: by the error, and by the end of the piece or of the contact
    let growth = orbit_growth(orbit, rubbing, start, trial, h);
    let sliding = cubic_new(start.v, trial.v);
    let cut = orbit_cut(orbit, rubbing, start, trial, sliding);
    let accepted = cut.stays && trial.converged && is_below(REJECTED, growth) && is_below(growth, LARGEST);
    let longer = clamp(growth * SAFETY, 0.2, LONGER);
    // a trial that has converged is the guess for the next one; one that has not is forgotten
    (*orbit).guess_0 = start.acceleration;
    (*orbit).guess_1 = 0.0;
    (*orbit).guess_2 = 0.0;
    (*orbit).guess_3 = 0.0;
    (*orbit).since = 0.0;
    var next = 0.25 * length;
    if (trial.converged) {
        let inverse_h = 1.0 / h;
        let square = inverse_h * inverse_h;
        let curve = cubic_new(start.acceleration, trial.acceleration);
        (*orbit).guess_1 = curve.c1 * inverse_h;
        (*orbit).guess_2 = curve.c2 * square;
        (*orbit).guess_3 = curve.c3 * square * inverse_h;
        next = length * min(select(longer, cut.part, cut.part < 1.0), 0.9);
    }
    if (accepted) {
        (*orbit).since = h;
        if (carries && ((*orbit).lost_periods < 0.0 || system.lasts)) {
            carry(orbit, system, start, trial, memory, h);
        }
        accept(orbit, system, start, turned, trial, memory, h, elapsed);
        (*orbit).left -= ticks;
    }

    orbit_switch(orbit, rubbing, start.v);
    if (accepted) {
        next = orbit_landing(orbit, rubbing, sliding, length, length * longer);
    }
    let longest = min(run.longest_step_periods * f32(TICKS) / system.long, swing_step(orbit, rubbing) / system.tick);
    (*orbit).step = f32(u32(clamp(next, 0.0, longest)));
    give_up(orbit, system, start, length);
}

// Growth of the shaft speed and of the fit from the start of a step of `h` to its nodes. Growth, not values, so that the digits
// of v are not lost. Also sine and 1 - cosine of the growth of the drive's phase.
fn orbit_drive(orbit: ptr<function, Orbit>, system: System, ticks: f32, h: f32, elapsed: f32) -> Turned {
    let angle = ticks * (TAU / f32(TICKS));
    let first = rotation(angle * NODE_0);
    let second = rotation(angle * NODE_1);
    let last = rotation(angle);
    let sines = vec3(first.sine, second.sine, last.sine);
    let versines = vec3(first.versine, second.versine, last.versine);
    let speed = system.rubbing.zeta_k * ((*orbit).cosine * sines - (*orbit).sine * versines);
    var growth = vec3(0.0);
    if (system.rubbing.ramp_rate < LARGEST) {
        let now = fma((*orbit).periods, system.period, elapsed);
        growth = vec3(fit(system, fma(NODE_0, h, now)), fit(system, fma(NODE_1, h, now)), fit(system, now + h))
            - fit(system, now);
    }
    return Turned(Drive(h, speed, growth), last);
}

// The factor by which the trial must be longer for its error to be just the tolerance.
fn orbit_growth(orbit: ptr<function, Orbit>, rubbing: Rubbing, start: Start, trial: Trial, h: f32) -> f32 {
    // the error estimate: at the start, the extrapolated quadratics miss the values there; a stiff motion damps this error
    let weight = h * ERROR_WEIGHT;
    let slope = friction_slope(rubbing, start.piece, (*orbit).v);
    let rate = fma(rubbing.epsilon * start.pressure, slope, rubbing.damping);
    let forgets = fma(weight, max(rate, 0.0), 1.0);
    let inside = abs((*orbit).piece - 1.5) < 1.0;
    // at large |v|, where a motion runs away, the allowed error is relative to |v|
    let large = max(abs((*orbit).v) / LARGE_SPEED, 1.0);
    let scale = select(large, rubbing.layer, inside);
    let pressure = abs(start.pressure) + PRESSURE_FLOOR;
    let motion = abs(start.acceleration - parabola(trial.acceleration)[0]) * pressure;
    let heat = abs(start.flux - parabola(trial.flux)[0]) * rubbing.two_gamma * scale;
    let allowed = run.tolerance * forgets * pressure * scale;
    // the estimate is of order 3: its error grows with the fourth power of the step
    let error = max(max(motion, heat) * weight, 1e-12 * allowed);
    return sqrt(sqrt(allowed / error));
}

// The longest step, in tau, that resolves the slower of the two rates of the linearised motion. This rate is about by_x/by_y
// where the motion is overdamped, and else the root of by_x.
fn swing_step(orbit: ptr<function, Orbit>, rubbing: Rubbing) -> f32 {
    let stiff = abs(stiffness(rubbing, (*orbit).x));
    let piece = rubbing_piece(rubbing, (*orbit).piece);
    let pressure = (*orbit).contact * ((*orbit).fit + (*orbit).heat_pressure);
    let damping = abs(fma(rubbing.epsilon * pressure, friction_slope(rubbing, piece, (*orbit).v), rubbing.damping));
    return run.swing * fma(0.5, damping, sqrt(stiff)) / max(stiff, 1e-6);
}

// Gives the orbit up if its step has become too short, or if its state is beyond the bounds or is NaN. The last step started at
// `start` and had the length `ticks`.
fn give_up(orbit: ptr<function, Orbit>, system: System, start: Start, ticks: f32) {
    let y = fma(system.rubbing.zeta_k, (*orbit).sine, system.rubbing.omega_k) - (*orbit).v;
    let is_pressure_bounded = is_below(abs((*orbit).heat_pressure), PRESSURE_BOUND);
    if (!is_pressure_bounded || has_run_away((*orbit).x, y)) {
        (*orbit).runaway = 1u;
        // what reaches its bound, |x| + |y| or the pressure, grows nearly as an exponential over this step
        let size_before = abs(start.x) + abs(start.shaft_speed - start.v);
        let before = select(abs(start.heat.pressure), size_before, is_pressure_bounded);
        let to = select(abs((*orbit).heat_pressure), abs((*orbit).x) + abs(y), is_pressure_bounded);
        let bound = select(PRESSURE_BOUND, RUNAWAY_BOUND, is_pressure_bounded);
        let part = clamp(log(bound / before) / log(to / before), 0.0, 1.0);
        (*orbit).runaway_phase = 1.0 - (f32((*orbit).left) + (1.0 - part) * ticks) / f32(TICKS);
        (*orbit).left = 0u;
    } else if ((*orbit).step <= SHORTEST_STEP) {
        (*orbit).under_resolved = 1u;
        (*orbit).left = 0u;
    }
}

// sin and 1 - cos of an angle from 0 to 2 pi/16, by their series, so that neither loses digits.
fn rotation(angle: f32) -> Rotation {
    let square = angle * angle;
    var sine = fma(square, -1.0 / 5040.0, 1.0 / 120.0);
    sine = fma(sine, square, -1.0 / 6.0);
    sine = fma(sine, square, 1.0);
    var versine = fma(square, -1.0 / 40320.0, 1.0 / 720.0);
    versine = fma(versine, square, -1.0 / 24.0);
    versine = fma(versine, square, 0.5);
    return Rotation(angle * sine, square * versine);
}
