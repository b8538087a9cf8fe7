// Carries motion and tangent vectors on by some forcing periods, one thread an instance; where they are measured, sums
// up growth and divergence and compares stroboscopic states. The second vector is that of checked periods; in others nothing
// depends on it, and compilers leave it out.

@compute @workgroup_size(WORKGROUP_SIZE)
fn advance_tangent(@builtin(global_invocation_id) thread: vec3<u32>) {
    if (thread.x >= span.instances) {
        return;
    }
    let instance = span.first_instance + thread.x;
    var orbit = orbits[instance];
    // nothing more is asked of an instance that has run away
    if (orbit.runaway_period != 0u) {
        return;
    }
    let motion = motion_new(parameters[instance]);
    let h = step_size_new(parameters[instance].step_size);
    var state = State(orbit.x, orbit.y);
    var tangent = tangents[instance];
    var sums = totals[instance];
    for (var n = 0u; n < span.periods; n++) {
        let index = span.first + n;
        if (span.measured != 0u && index == 0u) {
            orbit.x_min = state.x;
            orbit.x_max = state.x;
        }
        var bases = bases_along(Vector(tangent.x, tangent.y));
        // the period's own sums come first: added to the slot's total one by one, small terms would lose more digits
        var both = Growth(0.0, 0.0);
        var divergence = 0.0;
        var start = shaft_speed(motion, 0.0);
        var step = 0u;
        while (step < run.steps_per_period) {
            let renormalised_at = min(step + run.renormalise_every, run.steps_per_period);
            for (; step < renormalised_at; step++) {
                let sin_z = drive_at(step);
                let speed = StageSpeeds(start, shaft_speed(motion, sin_z.x), shaft_speed(motion, sin_z.y));
                let end = step_with_tangent(motion, h, speed, state, bases);
                state = end.state;
                bases = end.bases;
                divergence += end.divergence;
                orbit.x_min = min(orbit.x_min, state.x);
                orbit.x_max = max(orbit.x_max, state.x);
                start = speed.end;
            }
            let renormalised = orthonormalise(bases);
            bases = renormalised.bases;
            both.first += renormalised.growth.first;
            both.second += renormalised.growth.second;
        }
        tangent = vec2(bases.first.x, bases.first.y);
        if (has_run_away(state.x, state.y)) {
            orbit.runaway_period = span.elapsed + n + 1u;
            break;
        }
        if (span.measured != 0u) {
            var growth = growth_of_first(both.first, divergence);
            if (IS_CHECKED) {
                growth = checked_growth(both, divergence);
            }
            sums.growth_first += growth.first;
            sums.growth_second += growth.second;
            sums.birkhoff = fma(growth.first, birkhoff_weights[index], sums.birkhoff);
            sums.divergence += divergence;
            if (index >= run.unrecorded) {
                let recorded = index - run.unrecorded;
                orbit.candidates =
                    record(instance, recorded, state.x, state.y, run.period_tolerance, orbit.candidates);
            }
        }
    }
    tangents[instance] = tangent;
    totals[instance] = sums;
    orbits[instance] = Orbit(
        state.x,
        state.y,
        orbit.x_min,
        orbit.x_max,
        orbit.candidates,
        orbit.runaway_period,
        orbit.under_resolved,
    );
}
