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
    var cut = Part(1.0, true);

    let bounds = orbit_bounds(orbit, rubbing);
    let reach = run.reach * rubbing.epsilon_0;
    let margin = CUT * reach;
    let lowest = bounds[0] - margin;
    let highest = bounds[1] + margin;
    let inside = vec3(lowest) < trial.v & trial.v < vec3(highest);
    if (!all(inside)) {
        // the first node beyond, and the one before it
        let before = select(0.0, select(NODE_0, NODE_1, inside[1]), inside[0]);
        let beyond = select(NODE_0, select(NODE_1, 1.0, inside[1]), inside[0]);
        let v = select(trial.v[0], select(trial.v[1], trial.v[2], inside[1]), inside[0]);
        let level = select(bounds[1] + reach, bounds[0] - reach, v < bounds[0]);
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
