// Advances the motion alone by some forcing periods in Taylor steps, one instance in each lane, with a clock of its own.

@compute @workgroup_size(WORKGROUP_SIZE)
fn advance_plain(@builtin(global_invocation_id) global: vec3<u32>) {
    let thread = global.x;
    let carried = lanes_to_carry(thread);
    if (!is_any(carried)) {
        return;
    }
    let values = load_values(thread);
    let flow = flow_new(values);
    let unit = values.unit_of_time;
    var orbit = load_orbits(thread);
    var goes_on = carried;
    let most = most_passes(unit);
    for (var n = 0u; n < span.periods; n++) {
        let begun = Vector(orbit.x, orbit.y);
        var state = state_start(flow, orbit.x, orbit.y * unit, select(Word(0u), Word(TICKS_PER_PERIOD), goes_on));
        var taken = 0u;
        // a period begins with ticks to go, so that the test is made at a pass's end: threads in lockstep then do not wait for an
        // idle pass
        loop {
            state = taylor_step(flow, state).end;
            taken++;
            continuing {
                break if !is_any(state.left != Word(0u)) || taken == most;
            }
        }
        orbit.x = update(orbit.x, state.x, goes_on);
        orbit.y = update(orbit.y, state.w / unit, goes_on);
        let went_on = goes_on;
        goes_on = end_period(thread, went_on, orbit, state.left != Word(0u), span.elapsed + n + 1u);
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
