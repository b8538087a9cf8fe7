// Types and functions for the shaders' arithmetic, where a thread carries two instances. Twin: one_lane.wgsl.

const LANES: u32 = 2u;

alias Real = vec2<f32>;
alias Mask = vec2<bool>;
// A count, or the bits of a Real.
alias Word = vec2<u32>;

// The lanes' numbers.
const LANE = Word(0u, 1u);

fn real_at(values: Real, lane: u32) -> f32 {
    return values[lane];
}

fn is_at(mask: Mask, lane: u32) -> bool {
    return mask[lane];
}

fn is_any(mask: Mask) -> bool {
    return any(mask);
}

// The new value of a lane that goes on; a lane that does not go on keeps its value.
fn update(before: Real, after: Real, goes_on: Mask) -> Real {
    return select(before, after, goes_on);
}
