// The period of the motion from stroboscopic states. Twin: src/dynamics/stroboscope.rs.

// The motion must repeat at least over this number of the last forcing periods.
override LEAST_WINDOW: u32;

// Keeps the next state at drive phase 0, after `recorded` others.
fn record(instance: u32, recorded: u32, x: f32, y: f32) {
    last_states[recorded * run.instances + instance] = vec2(x, y);
}

// The number of the window's last states over which a motion must repeat for k to be its period.
fn span_of(k: u32) -> u32 {
    return min(run.window, max(LEAST_WINDOW, 2u * k));
}

// Whether all states that are k periods apart agree; compared from the last ones back.
fn repeats(instance: u32, k: u32) -> bool {
    let compared = span_of(k) - k;
    for (var back = 1u; back <= compared; back++) {
        let n = run.window - back;
        let apart = abs(last_states[n * run.instances + instance] - last_states[(n - k) * run.instances + instance]);
        if (!(apart.x < run.period_tolerance && apart.y < run.period_tolerance)) {
            return false;
        }
    }
    return true;
}

// The least period after which the states of the window repeat; 0 if there is none.
fn period_of(instance: u32) -> u32 {
    for (var k = 1u; k <= min(run.max_period, run.window / 2u); k++) {
        if (repeats(instance, k)) {
            return k;
        }
    }
    return 0u;
}
