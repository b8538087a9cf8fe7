// Loads instances from memory into the lanes of a thread, and stores them back. A thread carries neighbouring instances.
// Loops over lanes are unrolled when the shader is put together.

// The parameters of a thread's instances.
struct Values {
    zeta_k: Real,
    h1: Real,
    omega_k: Real,
    b: Real,
    epsilon: Real,
    f_0: Real,
    alpha: Real,
    beta: Real,
    epsilon_0: Real,
    step_units: Real,
    unit_of_time: Real,
}

// States and extremes of x.
struct Orbits {
    x: Real,
    y: Real,
    x_min: Real,
    x_max: Real,
}

// Sums over measured periods.
struct Sums {
    growth_first: Real,
    growth_second: Real,
    birkhoff: Real,
    divergence: Real,
}

// `values` with `value` in one lane.
fn put(values: Real, lane: u32, value: f32) -> Real {
    return select(values, Real(value), LANE == Word(lane));
}

// The instance of a lane. The last thread may have spare lanes: they read its last instance and write nothing.
fn instance_at(thread: u32, lane: u32) -> u32 {
    return span.first_instance + min(thread * LANES + lane, span.instances - 1u);
}

// The lanes that have an instance to advance: one that has run away or was given up is not advanced any more.
fn lanes_to_carry(thread: u32) -> Mask {
    var idle = Word(0u);
    for (var lane = 0u; lane < LANES; lane++) {
        let instance = instance_at(thread, lane);
        let is_idle = thread * LANES + lane >= span.instances || orbits[instance].runaway_period != 0u
            || orbits[instance].under_resolved != 0u;
        idle = select(idle, Word(u32(is_idle)), LANE == Word(lane));
    }
    return idle == Word(0u);
}

fn load_values(thread: u32) -> Values {
    var values: Values;
    for (var lane = 0u; lane < LANES; lane++) {
        let instance = instance_at(thread, lane);
        values.zeta_k = put(values.zeta_k, lane, parameters[instance].zeta_k);
        values.h1 = put(values.h1, lane, parameters[instance].h1);
        values.omega_k = put(values.omega_k, lane, parameters[instance].omega_k);
        values.b = put(values.b, lane, parameters[instance].b);
        values.epsilon = put(values.epsilon, lane, parameters[instance].epsilon);
        values.f_0 = put(values.f_0, lane, parameters[instance].f_0);
        values.alpha = put(values.alpha, lane, parameters[instance].alpha);
        values.beta = put(values.beta, lane, parameters[instance].beta);
        values.epsilon_0 = put(values.epsilon_0, lane, parameters[instance].epsilon_0);
        values.step_units = put(values.step_units, lane, parameters[instance].step_units);
        values.unit_of_time = put(values.unit_of_time, lane, parameters[instance].unit_of_time);
    }
    return values;
}

fn load_orbits(thread: u32) -> Orbits {
    var loaded: Orbits;
    for (var lane = 0u; lane < LANES; lane++) {
        let instance = instance_at(thread, lane);
        loaded.x = put(loaded.x, lane, orbits[instance].x);
        loaded.y = put(loaded.y, lane, orbits[instance].y);
        loaded.x_min = put(loaded.x_min, lane, orbits[instance].x_min);
        loaded.x_max = put(loaded.x_max, lane, orbits[instance].x_max);
    }
    return loaded;
}

fn load_tangents(thread: u32) -> Vector {
    var loaded: Vector;
    for (var lane = 0u; lane < LANES; lane++) {
        let tangent = tangents[instance_at(thread, lane)];
        loaded.x = put(loaded.x, lane, tangent.x);
        loaded.y = put(loaded.y, lane, tangent.y);
    }
    return loaded;
}

fn load_sums(thread: u32) -> Sums {
    var loaded: Sums;
    for (var lane = 0u; lane < LANES; lane++) {
        let instance = instance_at(thread, lane);
        loaded.growth_first = put(loaded.growth_first, lane, totals[instance].growth_first);
        loaded.growth_second = put(loaded.growth_second, lane, totals[instance].growth_second);
        loaded.birkhoff = put(loaded.birkhoff, lane, totals[instance].birkhoff);
        loaded.divergence = put(loaded.divergence, lane, totals[instance].divergence);
    }
    return loaded;
}

fn store_states(thread: u32, carried: Mask, orbit: Orbits) {
    for (var lane = 0u; lane < LANES; lane++) {
        if (is_at(carried, lane)) {
            let instance = instance_at(thread, lane);
            orbits[instance].x = real_at(orbit.x, lane);
            orbits[instance].y = real_at(orbit.y, lane);
        }
    }
}

fn store_extremes(thread: u32, carried: Mask, orbit: Orbits) {
    for (var lane = 0u; lane < LANES; lane++) {
        if (is_at(carried, lane)) {
            let instance = instance_at(thread, lane);
            orbits[instance].x_min = real_at(orbit.x_min, lane);
            orbits[instance].x_max = real_at(orbit.x_max, lane);
        }
    }
}

fn store_tangents(thread: u32, carried: Mask, vector: Vector) {
    for (var lane = 0u; lane < LANES; lane++) {
        if (is_at(carried, lane)) {
            tangents[instance_at(thread, lane)] = vec2(real_at(vector.x, lane), real_at(vector.y, lane));
        }
    }
}

fn store_sums(thread: u32, carried: Mask, sums: Sums) {
    for (var lane = 0u; lane < LANES; lane++) {
        if (is_at(carried, lane)) {
            totals[instance_at(thread, lane)] = Totals(
                real_at(sums.growth_first, lane),
                real_at(sums.growth_second, lane),
                real_at(sums.birkhoff, lane),
                real_at(sums.divergence, lane),
            );
        }
    }
}

// Ends the period `period`, counted from 1, of the lanes that went through it. Notes which of them have run away, and which are
// given up because the scheme left their period unfinished. Returns the lanes that go on.
fn end_period(thread: u32, went_on: Mask, orbit: Orbits, unfinished: Mask, period: u32) -> Mask {
    let ran_away = went_on & has_run_away(orbit.x, orbit.y);
    let given_up = went_on & !ran_away & unfinished;
    for (var lane = 0u; lane < LANES; lane++) {
        let instance = instance_at(thread, lane);
        if (is_at(ran_away, lane)) {
            orbits[instance].runaway_period = period;
        }
        if (is_at(given_up, lane)) {
            orbits[instance].under_resolved = 1u;
        }
    }
    return went_on & !ran_away & !given_up;
}

// Orbits at a period's end. Among the lanes that went through it, those that ran away get their state at its beginning.
fn before_escape(orbit: Orbits, begun: Vector, went_on: Mask) -> Orbits {
    let escaped = went_on & has_run_away(orbit.x, orbit.y);
    return Orbits(select(orbit.x, begun.x, escaped), select(orbit.y, begun.y, escaped), orbit.x_min, orbit.x_max);
}

// Takes the stroboscopic states of the lanes that go on.
fn record_states(thread: u32, goes_on: Mask, recorded: u32, orbit: Orbits) {
    for (var lane = 0u; lane < LANES; lane++) {
        if (is_at(goes_on, lane)) {
            let instance = instance_at(thread, lane);
            record(instance, recorded, real_at(orbit.x, lane), real_at(orbit.y, lane));
            if (recorded + 1u == run.window) {
                orbits[instance].period = period_of(instance);
            }
        }
    }
}

fn update_vector(before: Vector, after: Vector, goes_on: Mask) -> Vector {
    return Vector(update(before.x, after.x, goes_on), update(before.y, after.y, goes_on));
}

// Sums with a period's growth and divergence added in the lanes that go on.
fn sums_with(sums: Sums, growth: Growth, birkhoff_weight: f32, divergence: Real, goes_on: Mask) -> Sums {
    return Sums(
        update(sums.growth_first, sums.growth_first + growth.first, goes_on),
        update(sums.growth_second, sums.growth_second + growth.second, goes_on),
        update(sums.birkhoff, fma(growth.first, Real(birkhoff_weight), sums.birkhoff), goes_on),
        update(sums.divergence, sums.divergence + divergence, goes_on),
    );
}
