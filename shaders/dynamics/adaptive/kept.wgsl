// What is taken from a kept step: its end as the new state, and what it shows of extremes and of contact.
// Twin: src/dynamics/adaptive/kept.rs.

// Takes the end of a trial as the new state.
fn keep(
    orbit: ptr<function, Orbit>,
    system: System,
    start: Start,
    drive: Drive,
    trial: Trial,
    memory: Memory,
    h: f32,
    elapsed: f32,
) {
    let coefficients = parabola(trial.flux);
    let heat = memory_end(memory, coefficients);
    let flux = coefficients * h;
    for (var m = 0u; m < HEAT_MODES; m++) {
        modes[m] = advanced(steps[m], modes[m], flux);
    }

    let pressure = maximum(cubic_new(start.pressure, trial.pressure));
    if ((*orbit).peak_pressure < pressure.value) {
        (*orbit).peak_pressure = pressure.value;
        (*orbit).peak_periods = (*orbit).periods;
        (*orbit).peak_time = fma(pressure.s, h, elapsed);
    }
    let falloff = trial_falloff(trial, system.rubbing, start, h, heat);
    let temperature = maximum(cubic_new(start.heat.falloff, falloff)).value * system.surface_temperature;
    (*orbit).peak_temperature = max(temperature, (*orbit).peak_temperature);

    let highest = maximum(cubic_new(start.x, trial.x)).value;
    let lowest = maximum(cubic_new(-start.x, -trial.x)).value;
    (*orbit).x_min = min((*orbit).x_min, -lowest);
    (*orbit).x_max = max((*orbit).x_max, highest);

    (*orbit).fit = (*orbit).fit + drive.fit[2] - worn(trial, system.rubbing, h);
    (*orbit).x = trial.x[2];
    (*orbit).v = trial.v[2];
    (*orbit).heat_pressure = heat.pressure;
    (*orbit).heat_falloff = heat.falloff;
    let turn = rotation(h / system.period * TAU);
    let sine = (*orbit).sine;
    let cosine = (*orbit).cosine;
    (*orbit).sine = sine + (cosine * turn.sine - sine * turn.versine);
    (*orbit).cosine = cosine - (sine * turn.sine + cosine * turn.versine);

    // contact changes where its signal has come down to zero
    let signal = select(trial.pressure[2], -trial.if_closed[2], (*orbit).contact < 0.5);
    if (signal < 0.0) {
        if ((*orbit).contact > 0.5 && (*orbit).lost_periods < 0.0) {
            (*orbit).lost_periods = (*orbit).periods;
            (*orbit).lost_time = elapsed + h;
        }
        (*orbit).contact = 1.0 - (*orbit).contact;
        (*orbit).piece = piece_of(orbit, system.rubbing);
    }
}

// A mode after a step; `flux` are the coefficients of the heat flux times the step's length.
fn advanced(step: Decay, mode: f32, flux: vec3<f32>) -> f32 {
    return fma(step.factor, mode, dot(step.moments, flux));
}
