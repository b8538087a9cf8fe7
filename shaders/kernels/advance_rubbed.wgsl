// Advances instances of the full model by some forcing periods, one instance in each thread, with a tangent vector or without.
// In measured periods it sums up growth and compares stroboscopic states.

// Passes that a period may take, times `System.long`. An instance that needs more is under-resolved.
override PASS_BUDGET: f32;

// Number of passes after which a tangent vector far from length 1 is scaled back, before it overflows or underflows.
override SETTLING_PASSES: u32;

// Begins a forcing period.
fn begin_period(orbit: ptr<function, Orbit>) {
    // the drive's phase is 0 exactly: rounding does not grow from period to period
    (*orbit).sine = 0.0;
    (*orbit).cosine = 1.0;
    (*orbit).left = TICKS;
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn advance_rubbed(@builtin(global_invocation_id) thread: vec3<u32>) {
    if (thread.x >= span.instances) {
        return;
    }
    let instance = span.first_instance + thread.x;
    var orbit = orbits[instance];
    // an instance that has been given up is not advanced any more
    if (orbit.given_up_period != 0u) {
        return;
    }
    let system = system_new(parameters[instance]);
    load_modes(instance);
    var sums = totals[instance];
    if (span.watched != 0u && span.first == 0u) {
        orbit.x_min = orbit.x;
        orbit.x_max = orbit.x;
    }
    let budget = u32(PASS_BUDGET * system.long);
    var passes = 0u;
    var period = 0u;
    var growth = 0.0;
    // one flat loop: threads whose periods end at different passes do not wait for each other
    begin_period(&orbit);
    loop {
        orbit_pass(&orbit, system, CARRIES_TANGENT);
        passes++;
        if (orbit.left != 0u) {
            if (CARRIES_TANGENT && passes % SETTLING_PASSES == 0u) {
                growth += settle(&orbit, system);
            }
            if (passes < budget) {
                continue;
            }
            orbit.under_resolved = 1u;
        }
        // the drive's phase is 0
        let y = system.rubbing.omega_k - orbit.v;
        if (has_run_away(orbit.x, y)) {
            orbit.runaway = 1u;
        }
        if ((orbit.under_resolved | orbit.runaway) != 0u) {
            orbit.given_up_period = span.elapsed + period + 1u;
            break;
        }
        orbit.periods += 1.0;
        if (CARRIES_TANGENT) {
            growth += normalise(&orbit, system);
        }
        if (span.watched != 0u) {
            let index = span.first + period;
            sums.growth += growth;
            sums.birkhoff = fma(growth, birkhoff_weights[index], sums.birkhoff);
            if (index >= run.unrecorded) {
                let recorded = index - run.unrecorded;
                record(instance, recorded, orbit.x, y);
                if (recorded + 1u == run.window) {
                    orbit.period = period_of(instance);
                }
            }
        }
        period++;
        if (period == span.periods) {
            break;
        }
        passes = 0u;
        growth = 0.0;
        begin_period(&orbit);
    }
    store_modes(instance);
    orbits[instance] = orbit;
    totals[instance] = sums;
}
