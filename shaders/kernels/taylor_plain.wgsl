// Carries the motion alone on by some forcing periods in Taylor steps, one thread an instance with a clock of its own.

@compute @workgroup_size(WORKGROUP_SIZE)
fn advance_plain(@builtin(global_invocation_id) thread: vec3<u32>) {
    if (thread.x >= span.instances) {
        return;
    }
    let instance = span.first_instance + thread.x;
    // nothing more is asked of an instance that has run away or was given up
    if (orbits[instance].runaway_period != 0u || orbits[instance].under_resolved != 0u) {
        return;
    }
    let flow = flow_new(parameters[instance]);
    let unit = parameters[instance].unit_of_time;
    var x = orbits[instance].x;
    var y = orbits[instance].y;
    for (var n = 0u; n < span.periods; n++) {
        var state = state_start(flow, x, y * unit, TICKS_PER_PERIOD);
        var taken = 0u;
        // a period begins with ticks to go: asked at a pass's end, threads that go in step do not wait for an idle one
        loop {
            state = taylor_step(flow, state).end;
            taken++;
            continuing {
                break if state.left == 0u || taken == MAX_PASSES;
            }
        }
        x = state.x;
        y = state.w / unit;
        if (has_run_away(x, y)) {
            orbits[instance].runaway_period = span.elapsed + n + 1u;
            break;
        }
        if (state.left != 0u) {
            orbits[instance].under_resolved = 1u;
            break;
        }
    }
    orbits[instance].x = x;
    orbits[instance].y = y;
}
