// Advances motion and tangent vectors by some forcing periods in Taylor steps, one instance in each lane, with a clock of its
// own. In measured periods it sums up growth and divergence and compares stroboscopic states. It carries the second vector in
// checked periods only.

@compute @workgroup_size(WORKGROUP_SIZE)
fn advance_tangent(@builtin(global_invocation_id) global: vec3<u32>) {
    let thread = global.x;
    let carried = lanes_to_carry(thread);
    if (!is_any(carried)) {
        return;
    }
    let values = load_values(thread);
    let flow = flow_new(values);
    let unit = values.unit_of_time;
    var orbit = load_orbits(thread);
    var tangent = load_tangents(thread);
    var sums = load_sums(thread);
    var goes_on = carried;
    let most = most_passes(unit);
    for (var n = 0u; n < span.periods; n++) {
        let index = span.first + n;
        if (span.watched != 0u && index == 0u) {
            orbit.x_min = orbit.x;
            orbit.x_max = orbit.x;
        }
        var state = state_start(flow, orbit.x, orbit.y * unit, select(Word(0u), Word(TICKS_PER_PERIOD), goes_on));
        let begun = Vector(orbit.x, orbit.y);
        var first = carried_new(Vector(tangent.x, tangent.y * unit));
        var area = area_new(first.vector);
        var divergence = Real(0.0);
        var taken = 0u;
        // a period begins with ticks to go, so that the test is made at a pass's end: threads in lockstep then do not wait for an
        // idle pass
        loop {
            taken++;
            let runs = state.left != Word(0u);
            let step = taylor_step(flow, state);
            let turn = turning(step);
            first.vector = update_vector(first.vector, vector_at(step.series, first.vector, step.s), runs);
            if (IS_CHECKED) {
                area.second = update_vector(area.second, vector_at(step.series, area.second, step.s), runs);
            }
            if (taken % RENEWAL_STEPS == 0u) {
                if (IS_CHECKED) {
                    let renewed = renew(area, first.vector, runs);
                    area.second = update_vector(area.second, renewed.second, runs);
                    area.product = update(area.product, renewed.product, runs);
                    area.log_product = update(area.log_product, renewed.log_product, runs);
                }
                let settled = carried_settle(first, area, runs);
                first = settled.carried;
                area = settled.area;
            }
            divergence = update(divergence, divergence + divergence_to(step.series, step.s), runs);
            orbit.x_min = min(orbit.x_min, min(turn, step.end.x));
            orbit.x_max = max(orbit.x_max, max(turn, step.end.x));
            state = step.end;
            continuing {
                break if !is_any(state.left != Word(0u)) || taken == most;
            }
        }
        let closed = carried_close(first, 1.0 / unit);
        var growth: Growth;
        if (IS_CHECKED) {
            let area_growth = area_close(area, first.vector);
            growth = checked_growth(Growth(closed.growth, area_growth - closed.growth), divergence);
        } else {
            growth = growth_of_first(closed.growth, divergence);
        }
        tangent = update_vector(tangent, closed.vector, goes_on);
        orbit.x = update(orbit.x, state.x, goes_on);
        orbit.y = update(orbit.y, state.w / unit, goes_on);
        let went_on = goes_on;
        goes_on = end_period(thread, went_on, orbit, state.left != Word(0u), span.elapsed + n + 1u);
        orbit = before_escape(orbit, begun, went_on);
        if (!is_any(goes_on)) {
            break;
        }
        if (span.watched != 0u) {
            sums = sums_with(sums, growth, birkhoff_weights[index], divergence, goes_on);
            if (index >= run.unrecorded) {
                record_states(thread, goes_on, index - run.unrecorded, orbit);
            }
        }
    }
    store_states(thread, carried, orbit);
    store_extremes(thread, carried, orbit);
    store_tangents(thread, carried, tangent);
    store_sums(thread, carried, sums);
}
