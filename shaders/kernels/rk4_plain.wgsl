// Advances the motion alone by some forcing periods, one instance in each lane.

@compute @workgroup_size(WORKGROUP_SIZE)
fn advance_plain(@builtin(global_invocation_id) global: vec3<u32>) {
    let thread = global.x;
    let carried = lanes_to_carry(thread);
    if (!is_any(carried)) {
        return;
    }
    let values = load_values(thread);
    let motion = motion_new(values);
    let h = step_size_new(values.step_units);
    var orbit = load_orbits(thread);
    var goes_on = carried;
    for (var n = 0u; n < span.periods; n++) {
        let begun = Vector(orbit.x, orbit.y);
        var state = State(orbit.x, orbit.y);
        var start = shaft_speed(motion, Real(0.0));
        for (var step = 0u; step < run.steps_per_period; step++) {
            let sin_z = drive_at(step);
            let speed =
                StageSpeeds(start, shaft_speed(motion, Real(sin_z.x)), shaft_speed(motion, Real(sin_z.y)));
            state = rk4_step(motion, h, speed, state);
            start = speed.end;
        }
        orbit.x = update(orbit.x, state.x, goes_on);
        orbit.y = update(orbit.y, state.y, goes_on);
        let went_on = goes_on;
        goes_on = end_period(thread, went_on, orbit, Mask(false), span.elapsed + n + 1u);
        orbit = before_escape(orbit, begun, went_on);
        if (!is_any(goes_on)) {
            break;
        }
        let index = span.first + n;
        if (span.watched != 0u && index >= run.unrecorded) {
            record_states(thread, goes_on, index - run.unrecorded, orbit);
        }
    }
    store_states(thread, carried, orbit);
}
