// Carries the motion alone on by some forcing periods, one thread an instance.

@compute @workgroup_size(WORKGROUP_SIZE)
fn advance_plain(@builtin(global_invocation_id) thread: vec3<u32>) {
    if (thread.x >= span.instances) {
        return;
    }
    let instance = span.first_instance + thread.x;
    // nothing more is asked of an instance that has run away
    if (orbits[instance].runaway_period != 0u) {
        return;
    }
    let motion = motion_new(parameters[instance]);
    let h = step_size_new(parameters[instance].step_size);
    var state = State(orbits[instance].x, orbits[instance].y);
    for (var n = 0u; n < span.periods; n++) {
        var start = shaft_speed(motion, 0.0);
        for (var step = 0u; step < run.steps_per_period; step++) {
            let sin_z = drive_at(step);
            let speed = StageSpeeds(start, shaft_speed(motion, sin_z.x), shaft_speed(motion, sin_z.y));
            state = rk4_step(motion, h, speed, state);
            start = speed.end;
        }
        if (has_run_away(state.x, state.y)) {
            orbits[instance].runaway_period = span.elapsed + n + 1u;
            break;
        }
    }
    orbits[instance].x = state.x;
    orbits[instance].y = state.y;
}
