// Where steps end: at the boundaries of the friction layer, and where contact is lost or comes back.
// Twin: src/dynamics/adaptive/events.rs.

// A step is cut if v comes further than this beyond a boundary of the friction layer, in units of `run.reach`. The cut aims at
// one reach beyond the boundary. An orbit on its way out changes to the next piece from one reach before the boundary on.
override CUT: f32;

// A step may be this many times as long as its error allows, if it then ends at a boundary. A boundary that is farther, but nearer
// than two steps, is reached in two steps of equal length.
override STRETCH: f32;

// Stands for infinity: bounds of a sliding velocity that meets no boundary.
const FAR = 1e30;

// Whether a trial stays on its piece of the friction law and in its state of contact; if not, the part of it that does.
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

fn orbit_cut(orbit: ptr<function, Orbit>, rubbing: Rubbing, start: Start, trial: Trial, sliding: Cubic) -> Part {
    let bounds = orbit_bounds(orbit, rubbing);
    let reach = run.reach * rubbing.epsilon_0;
    let margin = CUT * reach;
    let above = stays(sliding, trial.v, bounds[1] + margin, bounds[1] + reach);
    let below = stays(negative(sliding), -trial.v, margin - bounds[0], reach - bounds[0]);

    // minus p in contact; in the gap, what p would be in contact: rises above 0 where contact changes
    let gap = (*orbit).contact < 0.5;
    let before = select(-start.pressure, (*orbit).fit + (*orbit).heat_pressure, gap);
    let signals = select(-trial.pressure, trial.if_closed, gap);
    let allowed = contact_tolerance((*orbit).fit);
    let lasting = stays(cubic_new(before, signals), signals, allowed, allowed * 0.5);
    return Part(min(min(above.part, below.part), lasting.part), above.stays && below.stays && lasting.stays);
}

// Whether a quantity stays below `allowed` over a step, between the nodes as well; if not, the part of the step after which it
// comes to `aim`. `values` are its values at the nodes, and `cubic` goes through them.
fn stays(cubic: Cubic, values: vec3<f32>, allowed: f32, aim: f32) -> Part {
    if (stays_below(cubic, allowed)) {
        return Part(1.0, true);
    }
    let inside = values < vec3(allowed);
    let highest = maximum(cubic);
    if (all(inside) && highest.value < allowed) {
        return Part(1.0, true);
    }
    // `beyond`: the first node beyond the level, or the maximum between the nodes; `before`: the node before it
    let before = select(0.0, select(NODE_0, select(NODE_1, 0.0, inside[2]), inside[1]), inside[0]);
    let beyond = select(NODE_0, select(NODE_1, select(1.0, highest.s, inside[2]), inside[1]), inside[0]);
    return Part(max(crossing(cubic, aim, before, beyond), 1e-3), false);
}

// The bounds of the piece of the friction law that v is on; in the gap, and without dry friction, there are none.
fn orbit_bounds(orbit: ptr<function, Orbit>, rubbing: Rubbing) -> vec2<f32> {
    let free = (*orbit).contact < 0.5 || 0.5 * NO_LAYER < rubbing.epsilon_0;
    let piece = (*orbit).piece;
    return vec2(
        select((piece - 2.0) * rubbing.epsilon_0, -FAR, free || piece < 0.5),
        select((piece - 1.0) * rubbing.epsilon_0, FAR, free || piece > 2.5),
    );
}

// Moves the orbit to the piece that it has reached. `before` is v at the start of the last step.
fn orbit_switch(orbit: ptr<function, Orbit>, rubbing: Rubbing, before: f32) {
    let bounds = orbit_bounds(orbit, rubbing);
    let reach = run.reach * rubbing.epsilon_0;
    let v = (*orbit).v;
    if (bounds[1] - reach < v && before < v) {
        (*orbit).piece += 1.0;
    } else if (v < bounds[0] + reach && v < before) {
        (*orbit).piece -= 1.0;
    }
}

// The length of the next step: it ends at the next boundary of the friction layer if v reaches it soon, and else is `free`. The
// last step had the length `ticks`; `sliding` is v in it.
fn orbit_landing(orbit: ptr<function, Orbit>, rubbing: Rubbing, sliding: Cubic, ticks: f32, free: f32) -> f32 {
    let bounds = orbit_bounds(orbit, rubbing);
    let reach = run.reach * rubbing.epsilon_0;
    let ahead = ticks * beyond(sliding, bounds[0] - reach, bounds[1] + reach);
    // two equal steps, in place of a whole one and a very short one
    return select(min(0.5 * ahead, free), ahead, ahead < STRETCH * free);
}

// A pressure that is less than this below zero counts as zero: p is a difference of numbers of the size of the worn depth.
fn contact_tolerance(fit: f32) -> f32 {
    return 4e-6 * (abs(fit) + 1.0);
}
