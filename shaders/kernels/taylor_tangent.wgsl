// Carries motion and tangent vectors on by some forcing periods in Taylor steps, one thread an instance with a clock of
// its own; where they are measured, sums up growth and divergence and compares stroboscopic states. Follows the second
// vector in checked periods alone.

@compute @workgroup_size(WORKGROUP_SIZE)
fn advance_tangent(@builtin(global_invocation_id) thread: vec3<u32>) {
    if (thread.x >= span.instances) {
        return;
    }
    let instance = span.first_instance + thread.x;
    var orbit = orbits[instance];
    // nothing more is asked of an instance that has run away or was given up
    if (orbit.runaway_period != 0u || orbit.under_resolved != 0u) {
        return;
    }
    let flow = flow_new(parameters[instance]);
    let unit = parameters[instance].unit_of_time;
    var tangent = tangents[instance];
    var sums = totals[instance];
    for (var n = 0u; n < span.periods; n++) {
        let index = span.first + n;
        if (span.measured != 0u && index == 0u) {
            orbit.x_min = orbit.x;
            orbit.x_max = orbit.x;
        }
        var state = state_start(flow, orbit.x, orbit.y * unit, TICKS_PER_PERIOD);
        var first = Vector(tangent.x, tangent.y * unit);
        var area = area_new(first);
        var divergence = 0.0;
        var taken = 0u;
        // a period begins with ticks to go: asked at a pass's end, threads that go in step do not wait for an idle one
        loop {
            taken++;
            let step = taylor_step(flow, state);
            let turn = turning(step);
            first = vector_at(step.series, first, step.s);
            if (IS_CHECKED) {
                area.second = vector_at(step.series, area.second, step.s);
                if (taken % RENEWAL_STEPS == 0u) {
                    area = renew(area, first);
                }
            }
            divergence += divergence_to(step.series, step.s);
            orbit.x_min = min(orbit.x_min, min(turn, step.end.x));
            orbit.x_max = max(orbit.x_max, max(turn, step.end.x));
            state = step.end;
            continuing {
                break if state.left == 0u || taken == MAX_PASSES;
            }
        }
        var growth: Growth;
        if (IS_CHECKED) {
            let closed = close(area, first, 1.0 / unit);
            first = closed.vector;
            growth = checked_growth(closed.growth, divergence);
        } else {
            let closed = close_first(first, 1.0 / unit);
            first = closed.vector;
            growth = growth_of_first(closed.growth, divergence);
        }
        tangent = vec2(first.x, first.y);
        orbit.x = state.x;
        orbit.y = state.w / unit;
        if (has_run_away(orbit.x, orbit.y)) {
            orbit.runaway_period = span.elapsed + n + 1u;
            break;
        }
        if (state.left != 0u) {
            orbit.under_resolved = 1u;
            break;
        }
        if (span.measured != 0u) {
            sums.growth_first += growth.first;
            sums.growth_second += growth.second;
            sums.birkhoff = fma(growth.first, birkhoff_weights[index], sums.birkhoff);
            sums.divergence += divergence;
            if (index >= run.unrecorded) {
                let recorded = index - run.unrecorded;
                orbit.candidates =
                    record(instance, recorded, orbit.x, orbit.y, run.period_tolerance, orbit.candidates);
            }
        }
    }
    tangents[instance] = tangent;
    totals[instance] = sums;
    orbits[instance] = orbit;
}
