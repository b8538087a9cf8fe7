// A quantity within a collocation step: the cubic through its values at the step's start and three nodes.
// Twin: src/dynamics/dense.rs.

// Stands for a time that does not come.
const NEVER = 1e30;

// value(s) = c0 + c1 s + c2 s^2 + c3 s^3 for s from 0 to 1, the step's start and end.
struct Cubic {
    c0: f32,
    c1: f32,
    c2: f32,
    c3: f32,
}

// Greatest value of a cubic and where it is.
struct Maximum {
    value: f32,
    s: f32,
}

// The cubic through `start` and the values at the nodes.
fn cubic_new(start: f32, values: vec3<f32>) -> Cubic {
    // divided differences over 0, c1, c2, 1
    let first = (values[0] - start) * (1.0 / NODE_0);
    let second = ((values[1] - values[0]) * (1.0 / (NODE_1 - NODE_0)) - first) * (1.0 / NODE_1);
    let last = ((values[2] - values[1]) * (1.0 / (1.0 - NODE_1)) - (values[1] - values[0]) * (1.0 / (NODE_1 - NODE_0)))
        * (1.0 / (1.0 - NODE_0));
    let third = last - second;
    return Cubic(
        start,
        fma(third, NODE_0 * NODE_1, fma(second, -NODE_0, first)),
        fma(third, -(NODE_0 + NODE_1), second),
        third,
    );
}

// The cubic with all values negated.
fn negative(cubic: Cubic) -> Cubic {
    return Cubic(-cubic.c0, -cubic.c1, -cubic.c2, -cubic.c3);
}

fn cubic_at(cubic: Cubic, s: f32) -> f32 {
    return fma(fma(fma(cubic.c3, s, cubic.c2), s, cubic.c1), s, cubic.c0);
}

fn cubic_slope(cubic: Cubic, s: f32) -> f32 {
    return fma(fma(3.0 * cubic.c3, s, 2.0 * cubic.c2), s, cubic.c1);
}

// Where the cubic takes the value `level`. This place is known to lie between s = `first` (before it) and `last` (beyond it).
// Newton's method starts from the secant and is kept between these.
fn crossing(cubic: Cubic, level: f32, first: f32, last: f32) -> f32 {
    let before = cubic_at(cubic, first) - level;
    let beyond = cubic_at(cubic, last) - level;
    var s = first + (last - first) * (before / (before - beyond));
    for (var i = 0; i < 4; i++) {
        s = clamp(s - (cubic_at(cubic, s) - level) / cubic_slope(cubic, s), first, last);
    }
    return s;
}

// The time from s = 1 until the cubic comes to `low` or to `high`. At s = 1 its value must be between them. The time is that of the
// parabola that touches the cubic there, corrected by one step of Newton's method. The result is NEVER if the value is not between
// them or moves to neither.
fn beyond(cubic: Cubic, low: f32, high: f32) -> f32 {
    let value = cubic.c0 + cubic.c1 + cubic.c2 + cubic.c3;
    let rate = fma(3.0, cubic.c3, fma(2.0, cubic.c2, cubic.c1));
    let four_bend = 4.0 * fma(3.0, cubic.c3, cubic.c2);
    // ahead, or behind if the parabola turns before
    let rises = 0.0 < rate;
    let ahead = select(low, high, rises) - value;
    let behind = select(high, low, rises) - value;
    let turns = fma(rate, rate, four_bend * ahead) < 0.0;
    let distance = select(ahead, behind, turns);
    // the first root after 1, without cancellation; the parabola has this slope there
    let steepness = sqrt(max(fma(rate, rate, four_bend * distance), 0.0));
    let slope = select(steepness, -steepness, distance < 0.0);
    let toward = rate + slope;
    // the quotient is formed only if it is positive and not too large
    let comes = abs(distance) < 0.5 * NEVER && 0.0 < steepness && (0.0 < toward) == (0.0 < distance);
    if (!(comes && abs(distance) < 1e9 * abs(toward))) {
        return NEVER;
    }
    let time = 2.0 * distance / toward;
    let third = cubic.c3 * time * time;
    let corrected = time - third * time / fma(3.0, third, slope);
    return clamp(corrected, 0.5 * time, 1.5 * time);
}

// Whether the cubic surely stays below `level` between s = 0 and 1: true if its Bezier points do.
fn stays_below(cubic: Cubic, level: f32) -> bool {
    let first = fma(1.0 / 3.0, cubic.c1, cubic.c0);
    let second = fma(1.0 / 3.0, cubic.c1 + cubic.c2, first);
    let last = cubic.c0 + cubic.c1 + cubic.c2 + cubic.c3;
    return max(max(first, second), max(last, cubic.c0)) < level;
}

// The greatest value between s = 0 and 1 and its place, if there is a maximum inside; else the value at 1. The value at 0 is not
// needed: it was the end of the step before.
fn maximum(cubic: Cubic) -> Maximum {
    // the root of 3 c3 s^2 + 2 c2 s + c1 at which the slope falls; the sign of c2 tells which form of it has no cancellation
    let discriminant = sqrt(max(fma(cubic.c2, cubic.c2, -3.0 * cubic.c3 * cubic.c1), 0.0));
    let rising = cubic.c2 < 0.0;
    let numerator = select(-(cubic.c2 + discriminant), cubic.c1, rising);
    let denominator = select(3.0 * cubic.c3, discriminant - cubic.c2, rising);
    // the quotient is formed only if it is between 0 and 1
    let within = (numerator > 0.0) == (denominator > 0.0) && abs(numerator) < abs(denominator);
    let s = select(1.0, numerator / select(1.0, denominator, within), within);
    let inside = cubic_at(cubic, s);
    let end = cubic_at(cubic, 1.0);
    if (end < inside && cubic.c0 < inside) {
        return Maximum(inside, s);
    }
    return Maximum(end, 1.0);
}
