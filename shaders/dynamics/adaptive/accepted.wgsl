// Evaluation of an accepted step: its end becomes the new state, and extremes and changes of contact are noted.
// Twin: src/dynamics/adaptive/accepted.rs.

// Relative error that the surface temperature within a step may have where it is not computed anew.
override ROUGH: f32;

// Takes the end of a trial as the new state.
fn accept(
    orbit: ptr<function, Orbit>,
    system: System,
    start: Start,
    turned: Turned,
    trial: Trial,
    memory: Memory,
    h: f32,
    elapsed: f32,
) {
    let flux = parabola(trial.flux);
    let heat = memory_end(memory, flux);
    peaks_of(orbit, system, start, trial, flux, heat, h, elapsed);
    let put_in = flux * h;
    for (var m = 0u; m < HEAT_MODES; m++) {
        modes[m] = advanced(steps[m], modes[m], put_in);
    }

    (*orbit).x_min = -raised(-(*orbit).x_min, cubic_new(-start.x, -trial.x));
    (*orbit).x_max = raised((*orbit).x_max, cubic_new(start.x, trial.x));

    (*orbit).fit = (*orbit).fit + turned.drive.fit[2] - worn(trial, system.rubbing, h);
    (*orbit).x = trial.x[2];
    (*orbit).v = trial.v[2];
    (*orbit).heat_pressure = heat.pressure;
    (*orbit).heat_falloff = heat.falloff;
    let sine = (*orbit).sine;
    let cosine = (*orbit).cosine;
    (*orbit).sine = sine + (cosine * turned.turn.sine - sine * turned.turn.versine);
    (*orbit).cosine = cosine - (sine * turned.turn.sine + cosine * turned.turn.versine);

    // the signal is positive as long as the state of contact lasts
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

// Notes the peaks of the pressure and of the surface temperature in a step. The heat flux of the step has the coefficients
// `flux`; `heat` are the sums over the heat modes at its end.
fn peaks_of(
    orbit: ptr<function, Orbit>,
    system: System,
    start: Start,
    trial: Trial,
    flux: vec3<f32>,
    heat: Heat,
    h: f32,
    elapsed: f32,
) {
    let pressure = cubic_new(start.pressure, trial.pressure);
    if (!stays_below(pressure, (*orbit).peak_pressure)) {
        let highest = maximum(pressure);
        if ((*orbit).peak_pressure < highest.value) {
            (*orbit).peak_pressure = highest.value;
            (*orbit).peak_periods = (*orbit).periods;
            (*orbit).peak_time = fma(highest.s, h, elapsed);
        }
    }
    // within the step the temperature is known only roughly: it is computed anew if it may exceed the peak
    let rough = cubic_new(start.heat.falloff, trial_falloff(trial, system.rubbing, start, h, heat));
    if (!stays_below(rough, (*orbit).peak_temperature / system.surface_temperature * (1.0 - ROUGH))) {
        let temperature = falloff_within(flux, maximum(rough).s, h) * system.surface_temperature;
        (*orbit).peak_temperature = max((*orbit).peak_temperature, temperature);
    }
}

// The sum w_m r_m q_m of the surface temperature after a part of a step. The step's heat flux has the coefficients `flux`.
fn falloff_within(flux: vec3<f32>, part: f32, length: f32) -> f32 {
    let h = part * length;
    let inverse_h = 1.0 / h;
    let put_in = flux * vec3(h, h * part, h * part * part);
    var falloff = 0.0;
    for (var m = 0u; m < HEAT_MODES; m++) {
        let step = decay(rates[m] * h, inverse_rates[m] * inverse_h);
        falloff = fma(weights[m] * rates[m], advanced(step, modes[m], put_in), falloff);
    }
    return falloff;
}

// A mode after a step; `flux` are the coefficients of the heat flux times the step's length.
fn advanced(step: Decay, mode: f32, flux: vec3<f32>) -> f32 {
    return fma(step.factor, mode, dot(step.moments, flux));
}

// The greater of `record` and the greatest value of the cubic.
fn raised(record: f32, cubic: Cubic) -> f32 {
    if (stays_below(cubic, record)) {
        return record;
    }
    return max(record, maximum(cubic).value);
}
