// The tangent vector of the full state. Twin: src/dynamics/adaptive/tangent.rs.

// A norm is far from 1 if it is greater than this or less than the inverse of this.
override COMFORTABLE: f32;

// Smallest squared norm, in the range of normal numbers.
override SMALLEST_SQUARE: f32;

// Divides the tangent vector by its norm and returns the logarithm of the norm. Where there is wear, the norm is that of (X, Y).
// Elsewhere it is that of (X, Y) and the heat modes, these in units of the pressure that they make (none where they feed nothing
// back).
fn normalise(orbit: ptr<function, Orbit>, system: System) -> f32 {
    let norm = tangent_norm(orbit, system);
    divide(orbit, norm);
    return log(norm);
}

// Divides the vector by its norm if the norm is far from 1, before it overflows or underflows. Returns the logarithm of the
// divisor.
fn settle(orbit: ptr<function, Orbit>, system: System) -> f32 {
    let norm = tangent_norm(orbit, system);
    if (1.0 / COMFORTABLE < norm && norm < COMFORTABLE) {
        return 0.0;
    }
    divide(orbit, norm);
    return log(norm);
}

fn tangent_norm(orbit: ptr<function, Orbit>, system: System) -> f32 {
    let with_heat = select(0.0, 1.0, system.lasts);
    var square = fma((*orbit).tangent_x, (*orbit).tangent_x, (*orbit).tangent_v * (*orbit).tangent_v);
    for (var m = 0u; m < HEAT_MODES; m++) {
        let pressure = with_heat * tangent_modes[m] * weights[m];
        square = fma(pressure, pressure, square);
    }
    return sqrt(select(square, SMALLEST_SQUARE, square < SMALLEST_SQUARE));
}

fn divide(orbit: ptr<function, Orbit>, norm: f32) {
    let inverse = 1.0 / norm;
    (*orbit).tangent_x *= inverse;
    (*orbit).tangent_v *= inverse;
    (*orbit).tangent_fit *= inverse;
    (*orbit).tangent_pressure *= inverse;
    (*orbit).tangent_falloff *= inverse;
    (*orbit).tangent_flux *= inverse;
    for (var m = 0u; m < HEAT_MODES; m++) {
        tangent_modes[m] *= inverse;
    }
}

// Carries the tangent vector over an accepted step.
fn carry(
    orbit: ptr<function, Orbit>,
    system: System,
    start: Start,
    trial: Trial,
    memory: Memory,
    h: f32,
) {
    var free: Heat;
    for (var m = 0u; m < HEAT_MODES; m++) {
        let left = weights[m] * steps[m].factor * tangent_modes[m];
        free.pressure += left;
        free.falloff = fma(rates[m], left, free.falloff);
    }
    let at = Perturbation(
        (*orbit).tangent_x,
        (*orbit).tangent_v,
        (*orbit).tangent_fit,
        Heat((*orbit).tangent_pressure, (*orbit).tangent_falloff),
        (*orbit).tangent_flux,
    );
    let perturbed_memory = Memory(free, memory.pressure, memory.falloff);
    let after = perturbed(trial, system.rubbing, start, h, perturbed_memory, at);
    let flux = parabola(after.flux) * h;
    for (var m = 0u; m < HEAT_MODES; m++) {
        tangent_modes[m] = advanced(steps[m], tangent_modes[m], flux);
    }
    (*orbit).tangent_x = after.end.x;
    (*orbit).tangent_v = after.end.v;
    (*orbit).tangent_fit = after.end.fit;
    (*orbit).tangent_pressure = after.end.heat.pressure;
    (*orbit).tangent_falloff = after.end.heat.falloff;
    (*orbit).tangent_flux = after.end.flux;
}
