// The period of the motion from stroboscopic states. Twin: src/dynamics/stroboscope.rs.

// The longest period that is looked for, and the number of last states that are kept.
override MAX_PERIOD: u32;

// Takes the next state at drive phase 0 and strikes out the candidates that it contradicts; states agree whose x and y
// differ by less than the tolerance. `recorded` states were taken before.
fn record(instance: u32, recorded: u32, x: f32, y: f32, tolerance: f32, candidates_before: u32) -> u32 {
    var candidates = candidates_before;
    for (var k = 1u; k <= min(recorded, MAX_PERIOD); k++) {
        let before = last_states[(recorded - k) % MAX_PERIOD * run.instances + instance];
        if (!(abs(x - before.x) < tolerance && abs(y - before.y) < tolerance)) {
            candidates &= ~(1u << (k - 1u));
        }
    }
    last_states[recorded % MAX_PERIOD * run.instances + instance] = vec2(x, y);
    return candidates;
}
