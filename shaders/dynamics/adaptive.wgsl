// Steps of the rubbed bush: their length, where they end, and what is taken from them. A pass tries one step, and keeps
// it where it is good. Twin: src/dynamics/adaptive.rs.

// Ticks of the clock in a forcing period.
override TICKS: u32;

// Shortest step, in ticks.
override SHORTEST_STEP: f32;

// Pressure beyond which the contact has run away.
override PRESSURE_BOUND: f32;

// Smallest squared norm, in the range of normal numbers.
override SMALLEST_SQUARE: f32;

// Near a boundary of the friction layer, in half-widths of the layer: how far beyond it a step is cut, how far beyond
// the cut aims, and from how far before it a thread that is on its way out is taken to have reached the next piece.
override CUT: f32;
override AIM: f32;
override REACHED: f32;

// A trial with an error above this many tolerances is tried again.
override PRESSURE_FLOOR: f32;
override REJECTED: f32;

const TAU = 6.283185307179586;

// Stands for an infinite number.
const LARGEST = 3.4028234e38;

// Bounds of a sliding velocity that meets no boundary.
const FAR = 1e30;

// What one instance is, apart from its state and its heat modes.
struct System {
    rubbing: Rubbing,
    // Forcing period in units of tau, and ticks to tau.
    period: f32,
    tick: f32,
    surface_temperature: f32,
    // Where there is wear, the tangent vector lives until contact is lost, and no longer.
    lasts: bool,
}

// Error of a trial in tolerances, and the factor by which the next step is longer.
struct TrialError {
    in_tolerances: f32,
    growth: f32,
}

// Whether a trial stays on its piece of the friction law and in its state of contact; else the part of it that does.
struct Part {
    part: f32,
    stays: bool,
}

// sin and 1 - cos of an angle.
struct Rotation {
    sine: f32,
    versine: f32,
}

fn system_new(value: Parameters) -> System {
    return System(
        rubbing_new(value),
        value.period,
        value.period * (1.0 / f32(TICKS)),
        value.surface_temperature,
        !(value.k_w > 0.0),
    );
}

// h_U at a time: 1 - exp(-delta tau^2), to rounding also where it is small.
fn fit(system: System, time: f32) -> f32 {
    if (system.rubbing.ramp_rate >= LARGEST) {
        return 1.0;
    }
    let z = max(system.rubbing.ramp_rate * time * time, 1e-30);
    return z * decay(z, 1.0 / z).moments[0];
}

// Divides the tangent vector by its norm and returns the norm. It is that of (X, Y) where there is wear, and else that of
// (X, Y) and the heat modes, these in units of the pressure that they make (none where they feed nothing back).
fn normalise(orbit: ptr<function, Orbit>, system: System) -> f32 {
    let with_heat = select(0.0, 1.0, system.lasts);
    var square = fma((*orbit).tangent_x, (*orbit).tangent_x, (*orbit).tangent_v * (*orbit).tangent_v);
    for (var m = 0u; m < HEAT_MODES; m++) {
        let pressure = with_heat * tangent_modes[m] * weights[m];
        square = fma(pressure, pressure, square);
    }
    let norm = sqrt(select(square, SMALLEST_SQUARE, square < SMALLEST_SQUARE));
    let inverse = 1.0 / norm;
    (*orbit).tangent_x *= inverse;
    (*orbit).tangent_v *= inverse;
    (*orbit).tangent_fit *= inverse;
    (*orbit).tangent_pressure *= inverse;
    (*orbit).tangent_falloff *= inverse;
    (*orbit).tangent_flux *= inverse;
    for (var m = 0u; m < HEAT_MODES; m++) {
        tangent_modes[m] *= inverse;
    }
    return norm;
}

fn piece_of(orbit: ptr<function, Orbit>, rubbing: Rubbing) -> f32 {
    let v = (*orbit).v;
    return select(0.0, 1.0, -rubbing.epsilon_0 < v)
        + select(0.0, 1.0, 0.0 < v)
        + select(0.0, 1.0, rubbing.epsilon_0 < v);
}

fn begin(orbit: ptr<function, Orbit>, system: System) -> Start {
    let speed = fma(system.rubbing.zeta_k, (*orbit).sine, system.rubbing.omega_k);
    let heat = Heat((*orbit).heat_pressure, (*orbit).heat_falloff);
    return start_new(system.rubbing, (*orbit).x, (*orbit).v, speed, (*orbit).fit, heat, (*orbit).contact);
}

// Tries one step; `carries` tells whether a tangent vector is carried along.
fn orbit_pass(orbit: ptr<function, Orbit>, system: System, carries: bool) {
    let rubbing = system.rubbing;
    let ticks = min(u32((*orbit).step), (*orbit).left);
    let length = f32(ticks);
    let h = length * system.tick;

    let elapsed = f32(TICKS - (*orbit).left) * system.tick;
    let start = begin(orbit, system);
    let drive = orbit_drive(orbit, system, length, h, elapsed);
    let memory = memory_new(h);
    let time = vec3(NODE_0, NODE_1, 1.0) * h + (*orbit).since;
    let guess = fma(fma(vec3((*orbit).guess_2), time, vec3((*orbit).guess_1)), time, vec3((*orbit).guess_0));
    let trial = solve(rubbing, start, drive, memory, guess);

    // what the trial calls for: a part of itself, if it is to be tried again
    let error = trial_error(orbit, rubbing, start, trial, h);
    let cut = orbit_cut(orbit, rubbing, start, trial);
    let kept = cut.stays && trial.converged && is_below(error.in_tolerances, REJECTED);
    // whatever has converged guesses the next; what has not is forgotten
    (*orbit).guess_0 = start.acceleration;
    (*orbit).guess_1 = 0.0;
    (*orbit).guess_2 = 0.0;
    (*orbit).since = 0.0;
    var next = 0.25 * length;
    if (trial.converged) {
        let inverse_h = 1.0 / h;
        let curve = parabola(trial.acceleration);
        (*orbit).guess_0 = curve[0];
        (*orbit).guess_1 = curve[1] * inverse_h;
        (*orbit).guess_2 = curve[2] * inverse_h * inverse_h;
        // a cut is exact enough only where the trial is
        next = length * select(min(error.growth, 0.9), cut.part, cut.part < 1.0);
    }
    if (kept) {
        (*orbit).since = h;
        if (carries && ((*orbit).lost_periods < 0.0 || system.lasts)) {
            carry(orbit, system, start, trial, memory, h);
        }
        keep(orbit, system, start, drive, trial, memory, h, elapsed);
        (*orbit).left -= ticks;
    }

    let moved = orbit_switch(orbit, rubbing, start, trial);
    if (kept) {
        // a step cut short by the end of the period says nothing of the next one
        let free = select(length * error.growth, (*orbit).step, length < (*orbit).step);
        next = select(free, length * moved, 0.0 < moved);
    }
    (*orbit).step = f32(u32(clamp(next, 0.0, run.longest)));
    give_up(orbit);
}

// Shaft speed and fit over a step of `h`: growth since its start, at the nodes. Growth, not values, so that the digits
// of v are kept.
fn orbit_drive(orbit: ptr<function, Orbit>, system: System, ticks: f32, h: f32, elapsed: f32) -> Drive {
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
    return Drive(h, speed, growth);
}

fn trial_error(orbit: ptr<function, Orbit>, rubbing: Rubbing, start: Start, trial: Trial, h: f32) -> TrialError {
    // the quadratics extrapolated to the start miss the values there; a stiff motion forgets the error
    let unforgotten = h * ERROR_WEIGHT;
    let rate = fma(rubbing.epsilon * start.pressure, friction_slope(rubbing, (*orbit).v), rubbing.damping);
    let weight = unforgotten / fma(unforgotten, max(rate, 0.0), 1.0);
    let inside = abs((*orbit).piece - 1.5) < 1.0;
    let scale = select(1.0, min(rubbing.epsilon_0, 1.0), inside);
    let motion = abs(start.acceleration - parabola(trial.acceleration)[0]) * weight / scale;
    let missed = abs(start.flux - parabola(trial.flux)[0]);
    let heat = missed * weight * rubbing.two_gamma / (abs(start.pressure) + PRESSURE_FLOOR);
    let error = max(motion, heat) / run.tolerance;
    // the estimate is of order 3: its error grows with the fourth power of the step
    let growth = 0.9 / sqrt(sqrt(max(error, 1e-12)));
    return TrialError(error, clamp(growth, 0.2, 3.0));
}

fn orbit_cut(orbit: ptr<function, Orbit>, rubbing: Rubbing, start: Start, trial: Trial) -> Part {
    var cut = Part(1.0, true);

    let bounds = orbit_bounds(orbit, rubbing);
    let margin = CUT * rubbing.epsilon_0;
    let lowest = bounds[0] - margin;
    let highest = bounds[1] + margin;
    let inside = vec3(lowest) < trial.v & trial.v < vec3(highest);
    if (!all(inside)) {
        let aim = AIM * rubbing.epsilon_0;
        // the first node beyond, and the one before it
        let before = select(0.0, select(NODE_0, NODE_1, inside[1]), inside[0]);
        let beyond = select(NODE_0, select(NODE_1, 1.0, inside[1]), inside[0]);
        let v = select(trial.v[0], select(trial.v[1], trial.v[2], inside[1]), inside[0]);
        let level = select(bounds[1] + aim, bounds[0] - aim, v < bounds[0]);
        let part = crossing(cubic_new(start.v, trial.v), level, before, beyond);
        cut = Part(max(part, 1e-3), false);
    }

    // p in contact, and minus what it would be in the gap: falls below 0 where contact changes
    let gap = (*orbit).contact < 0.5;
    let signals = select(trial.pressure, -trial.if_closed, gap);
    let allowed = -contact_tolerance((*orbit).fit);
    let lasts = vec3(allowed) < signals;
    if (!all(lasts)) {
        let signal = select(start.pressure, -((*orbit).fit + (*orbit).heat_pressure), gap);
        let before = select(0.0, select(NODE_0, NODE_1, lasts[1]), lasts[0]);
        let beyond = select(NODE_0, select(NODE_1, 1.0, lasts[1]), lasts[0]);
        let part = crossing(cubic_new(signal, signals), allowed * 0.5, before, beyond);
        cut = Part(min(cut.part, max(part, 1e-3)), false);
    }
    return cut;
}

// The piece of the friction law that v is on; in the gap there is none.
fn orbit_bounds(orbit: ptr<function, Orbit>, rubbing: Rubbing) -> vec2<f32> {
    let gap = (*orbit).contact < 0.5;
    let piece = (*orbit).piece;
    return vec2(
        select((piece - 2.0) * rubbing.epsilon_0, -FAR, gap || piece < 0.5),
        select((piece - 1.0) * rubbing.epsilon_0, FAR, gap || piece > 2.5),
    );
}

// Carries the tangent vector over a kept step.
fn carry(
    orbit: ptr<function, Orbit>,
    system: System,
    start: Start,
    trial: Trial,
    memory: Memory,
    h: f32,
) {
    var free: Heat;
    for (var m = 0u; m < HEAT_MODES; m++) {
        let left = weights[m] * steps[m].factor * tangent_modes[m];
        free.pressure += left;
        free.falloff = fma(rates[m], left, free.falloff);
    }
    let at = Perturbation(
        (*orbit).tangent_x,
        (*orbit).tangent_v,
        (*orbit).tangent_fit,
        Heat((*orbit).tangent_pressure, (*orbit).tangent_falloff),
        (*orbit).tangent_flux,
    );
    let perturbed_memory = Memory(free, memory.pressure, memory.falloff);
    let after = perturbed(trial, system.rubbing, start, h, perturbed_memory, at);
    let flux = parabola(after.flux) * h;
    for (var m = 0u; m < HEAT_MODES; m++) {
        tangent_modes[m] = advanced(steps[m], tangent_modes[m], flux);
    }
    (*orbit).tangent_x = after.end.x;
    (*orbit).tangent_v = after.end.v;
    (*orbit).tangent_fit = after.end.fit;
    (*orbit).tangent_pressure = after.end.heat.pressure;
    (*orbit).tangent_falloff = after.end.heat.falloff;
    (*orbit).tangent_flux = after.end.flux;
}

// Takes the end of a trial as the new state.
fn keep(
    orbit: ptr<function, Orbit>,
    system: System,
    start: Start,
    drive: Drive,
    trial: Trial,
    memory: Memory,
    h: f32,
    elapsed: f32,
) {
    let coefficients = parabola(trial.flux);
    let heat = memory_end(memory, coefficients);
    let flux = coefficients * h;
    for (var m = 0u; m < HEAT_MODES; m++) {
        modes[m] = advanced(steps[m], modes[m], flux);
    }

    let pressure = maximum(cubic_new(start.pressure, trial.pressure));
    if ((*orbit).peak_pressure < pressure.value) {
        (*orbit).peak_pressure = pressure.value;
        (*orbit).peak_periods = (*orbit).periods;
        (*orbit).peak_time = fma(pressure.s, h, elapsed);
    }
    let falloff = trial_falloff(trial, system.rubbing, start, h, heat);
    let temperature = maximum(cubic_new(start.heat.falloff, falloff)).value * system.surface_temperature;
    (*orbit).peak_temperature = max(temperature, (*orbit).peak_temperature);

    let highest = maximum(cubic_new(start.x, trial.x)).value;
    let lowest = maximum(cubic_new(-start.x, -trial.x)).value;
    (*orbit).x_min = min((*orbit).x_min, -lowest);
    (*orbit).x_max = max((*orbit).x_max, highest);

    (*orbit).fit = (*orbit).fit + drive.fit[2] - worn(trial, system.rubbing, h);
    (*orbit).x = trial.x[2];
    (*orbit).v = trial.v[2];
    (*orbit).heat_pressure = heat.pressure;
    (*orbit).heat_falloff = heat.falloff;
    let turn = rotation(h / system.period * TAU);
    let sine = (*orbit).sine;
    let cosine = (*orbit).cosine;
    (*orbit).sine = sine + (cosine * turn.sine - sine * turn.versine);
    (*orbit).cosine = cosine - (sine * turn.sine + cosine * turn.versine);

    // contact changes where its signal has come down to zero
    let signal = select(trial.pressure[2], -trial.if_closed[2], (*orbit).contact < 0.5);
    if (signal < 0.0) {
        if ((*orbit).contact > 0.5 && (*orbit).lost_periods < 0.0) {
            (*orbit).lost_periods = (*orbit).periods;
            (*orbit).lost_time = elapsed + h;
        }
        (*orbit).contact = 1.0 - (*orbit).contact;
        (*orbit).piece = piece_of(orbit, system.rubbing);
    }
}

// Moves the orbit to the piece that it has reached; returns the factor for its next step, 0 where it has not moved.
fn orbit_switch(orbit: ptr<function, Orbit>, rubbing: Rubbing, start: Start, trial: Trial) -> f32 {
    let bounds = orbit_bounds(orbit, rubbing);
    let reached = REACHED * rubbing.epsilon_0;
    let v = (*orbit).v;
    if (bounds[1] - reached < v && start.v < v) {
        (*orbit).piece += 1.0;
    } else if (v < bounds[0] + reached && v < start.v) {
        (*orbit).piece -= 1.0;
    } else {
        return 0.0;
    }
    // entering the layer, the next boundary is a layer's half-width away at most; leaving it, what limited the step is
    // gone
    if (abs((*orbit).piece - 1.5) >= 1.0) {
        return 4.0;
    }
    // v' through the last two nodes is good enough for the length of a step
    let slid = max(abs(trial.v[2] - trial.v[1]), 1e-20) * (1.0 / (1.0 - NODE_1));
    return min(1.1 * rubbing.epsilon_0 / slid, 64.0);
}

// Gives the orbit up if its step has become too short or its state is no longer a number of this world.
fn give_up(orbit: ptr<function, Orbit>) {
    if (!is_below(abs((*orbit).heat_pressure), PRESSURE_BOUND)) {
        (*orbit).runaway = 1u;
        (*orbit).left = 0u;
    } else if ((*orbit).step <= SHORTEST_STEP) {
        (*orbit).under_resolved = 1u;
        (*orbit).left = 0u;
    }
}

// A mode after a step; `flux` are the coefficients of the heat flux times the step's length.
fn advanced(step: Decay, mode: f32, flux: vec3<f32>) -> f32 {
    return fma(step.factor, mode, dot(step.moments, flux));
}

// How far below zero a pressure counts as zero: p is a difference of numbers of the size of the worn depth.
fn contact_tolerance(fit: f32) -> f32 {
    return 4e-6 * (abs(fit) + 1.0);
}

// sin and 1 - cos of an angle of 0 to 2 pi/16, by their series: no digits are lost in either.
fn rotation(angle: f32) -> Rotation {
    let square = angle * angle;
    var sine = fma(square, -1.0 / 42.0, 1.0);
    sine = fma(square * (-1.0 / 20.0), sine, 1.0);
    sine = fma(square * (-1.0 / 6.0), sine, 1.0);
    var versine = fma(square, -1.0 / 56.0, 1.0);
    versine = fma(square * (-1.0 / 30.0), versine, 1.0);
    versine = fma(square * (-1.0 / 12.0), versine, 1.0);
    return Rotation(angle * sine, square * 0.5 * versine);
}
