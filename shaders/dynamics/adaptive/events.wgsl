// Where steps end: at the boundaries of the friction layer, and where contact is lost or comes back.
// Twin: src/dynamics/adaptive/events.rs.

// How far beyond a boundary of the friction layer a step is cut, in units of `run.reach`. The cut aims at a reach beyond, and
// an orbit on its way out has come to the next piece from a reach before the boundary on.
override CUT: f32;

// Part of the layer's half-width that is tried first in it.
override FIRST_PART: f32;

// Stands for infinity: bounds of a sliding velocity that meets no boundary.
const FAR = 1e30;

// Whether a trial stays on its piece of the friction law and in its state of contact; else the part of it that does.
struct Part {
    part: f32,
    stays: bool,
}

fn piece_of(orbit: ptr<function, Orbit>, rubbing: Rubbing) -> f32 {
    let v = (*orbit).v;
    return select(0.0, 1.0, -rubbing.epsilon_0 < v)
        + select(0.0, 1.0, 0.0 < v)
        + select(0.0, 1.0, rubbing.epsilon_0 < v);
}

fn orbit_cut(orbit: ptr<function, Orbit>, rubbing: Rubbing, start: Start, trial: Trial) -> Part {
    let bounds = orbit_bounds(orbit, rubbing);
    let reach = run.reach * rubbing.epsilon_0;
    let margin = CUT * reach;
    let above = stays(start.v, trial.v, bounds[1] + margin, bounds[1] + reach);
    let below = stays(-start.v, -trial.v, margin - bounds[0], reach - bounds[0]);

    // p in contact, and minus what it would be in the gap: falls below 0 where contact changes
    let gap = (*orbit).contact < 0.5;
    let before = select(-start.pressure, (*orbit).fit + (*orbit).heat_pressure, gap);
    let signals = select(-trial.pressure, trial.if_closed, gap);
    let allowed = contact_tolerance((*orbit).fit);
    let lasting = stays(before, signals, allowed, allowed * 0.5);
    return Part(min(min(above.part, below.part), lasting.part), above.stays && below.stays && lasting.stays);
}

// Whether what has the value `start` at a step's start and `values` at its nodes stays below `allowed`, between the nodes as
// well; else the part of the step after which it comes to `aim`.
fn stays(start: f32, values: vec3<f32>, allowed: f32, aim: f32) -> Part {
    let cubic = cubic_new(start, values);
    if (stays_below(cubic, allowed)) {
        return Part(1.0, true);
    }
    let inside = values < vec3(allowed);
    let highest = maximum(cubic);
    if (all(inside) && highest.value < allowed) {
        return Part(1.0, true);
    }
    // the first node beyond, or the turn between the nodes, and the node before it
    let before = select(0.0, select(NODE_0, select(NODE_1, 0.0, inside[2]), inside[1]), inside[0]);
    let beyond = select(NODE_0, select(NODE_1, select(1.0, highest.s, inside[2]), inside[1]), inside[0]);
    return Part(max(crossing(cubic, aim, before, beyond), 1e-3), false);
}

// The piece of the friction law that v is on; in the gap there is none.
fn orbit_bounds(orbit: ptr<function, Orbit>, rubbing: Rubbing) -> vec2<f32> {
    let free = (*orbit).contact < 0.5 || 0.5 * NO_LAYER < rubbing.epsilon_0;
    let piece = (*orbit).piece;
    return vec2(
        select((piece - 2.0) * rubbing.epsilon_0, -FAR, free || piece < 0.5),
        select((piece - 1.0) * rubbing.epsilon_0, FAR, free || piece > 2.5),
    );
}

// Moves the orbit to the piece that it has reached; returns the factor for its next step, 0 where it has not moved.
fn orbit_switch(orbit: ptr<function, Orbit>, rubbing: Rubbing, start: Start, trial: Trial) -> f32 {
    let bounds = orbit_bounds(orbit, rubbing);
    let reach = run.reach * rubbing.epsilon_0;
    let v = (*orbit).v;
    if (bounds[1] - reach < v && start.v < v) {
        (*orbit).piece += 1.0;
    } else if (v < bounds[0] + reach && v < start.v) {
        (*orbit).piece -= 1.0;
    } else {
        return 0.0;
    }
    // in the layer, a part of the way across its half; leaving it, what limited the step is gone
    if (abs((*orbit).piece - 1.5) >= 1.0) {
        return 4.0;
    }
    // v' through the last two nodes is good enough for the length of a step
    let slid = max(abs(trial.v[2] - trial.v[1]), 1e-20) * (1.0 / (1.0 - NODE_1));
    return min(FIRST_PART * rubbing.epsilon_0 / slid, 64.0);
}

// How far below zero a pressure counts as zero: p is a difference of numbers of the size of the worn depth.
fn contact_tolerance(fit: f32) -> f32 {
    return 4e-6 * (abs(fit) + 1.0);
}
