// Types and functions for the shaders' arithmetic, where a thread carries one instance. Twin: two_lanes.wgsl.

const LANES: u32 = 1u;

alias Real = f32;
alias Mask = bool;
// A count, or the bits of a Real.
alias Word = u32;

// The lane's number.
const LANE = Word(0u);

fn real_at(values: Real, lane: u32) -> f32 {
    return values;
}

fn is_at(mask: Mask, lane: u32) -> bool {
    return mask;
}

fn is_any(mask: Mask) -> bool {
    return mask;
}

// The new value of a lane that goes on. A thread that goes on has no other lane.
fn update(before: Real, after: Real, goes_on: Mask) -> Real {
    return after;
}
