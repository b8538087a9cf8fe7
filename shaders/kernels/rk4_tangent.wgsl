// Advances motion and tangent vectors by some forcing periods, one instance in each lane. In measured periods it sums up growth
// and divergence and compares stroboscopic states. The second vector is needed in checked periods only; in others nothing
// depends on it, and compilers leave it out.

@compute @workgroup_size(WORKGROUP_SIZE)
fn advance_tangent(@builtin(global_invocation_id) global: vec3<u32>) {
    let thread = global.x;
    let carried = lanes_to_carry(thread);
    if (!is_any(carried)) {
        return;
    }
    let values = load_values(thread);
    let motion = motion_new(values);
    let h = step_size_new(values.step_units);
    var orbit = load_orbits(thread);
    var tangent = load_tangents(thread);
    var sums = load_sums(thread);
    var goes_on = carried;
    for (var n = 0u; n < span.periods; n++) {
        let index = span.first + n;
        if (span.watched != 0u && index == 0u) {
            orbit.x_min = orbit.x;
            orbit.x_max = orbit.x;
        }
        var state = State(orbit.x, orbit.y);
        var x_min = orbit.x_min;
        var x_max = orbit.x_max;
        var bases = bases_along(tangent);
        // sums over the period come first: small terms that are added to the instance's total one by one would lose more digits
        var both = Growth(Real(0.0), Real(0.0));
        var divergence = Real(0.0);
        var start = shaft_speed(motion, Real(0.0));
        var step = 0u;
        while (step < run.steps_per_period) {
            let renormalised_at = min(step + run.renormalise_every, run.steps_per_period);
            for (; step < renormalised_at; step++) {
                let sin_z = drive_at(step);
                let speed =
                    StageSpeeds(start, shaft_speed(motion, Real(sin_z.x)), shaft_speed(motion, Real(sin_z.y)));
                let end = step_with_tangent(motion, h, speed, state, bases);
                state = end.state;
                bases = end.bases;
                divergence += end.divergence;
                x_min = min(x_min, state.x);
                x_max = max(x_max, state.x);
                start = speed.end;
            }
            let renormalised = orthonormalise(bases);
            bases = renormalised.bases;
            both.first += renormalised.growth.first;
            both.second += renormalised.growth.second;
        }
        tangent = update_vector(tangent, bases.first, goes_on);
        let begun = Vector(orbit.x, orbit.y);
        orbit = Orbits(
            update(orbit.x, state.x, goes_on),
            update(orbit.y, state.y, goes_on),
            update(orbit.x_min, x_min, goes_on),
            update(orbit.x_max, x_max, goes_on),
        );
        let went_on = goes_on;
        goes_on = end_period(thread, went_on, orbit, Mask(false), span.elapsed + n + 1u);
        orbit = before_escape(orbit, begun, went_on);
        if (!is_any(goes_on)) {
            break;
        }
        if (span.watched != 0u) {
            var growth = growth_of_first(both.first, divergence);
            if (IS_CHECKED) {
                growth = checked_growth(both, divergence);
            }
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
