// The heat modes of a thread's instance, the lumped one last. They are in the thread's own memory during a dispatch, since
// every pass uses them several times. Unless there are many modes, loops over them are unrolled when the shader is put
// together, so that the modes can be held in registers.

// Whether a tangent vector is carried along.
override CARRIES_TANGENT: bool;

// r_m, 1/r_m, and 2 gamma c_m.
var<private> rates: array<f32, HEAT_MODES>;
var<private> inverse_rates: array<f32, HEAT_MODES>;
var<private> weights: array<f32, HEAT_MODES>;
// q_m, and the same of the tangent vector.
var<private> modes: array<f32, HEAT_MODES>;
var<private> tangent_modes: array<f32, HEAT_MODES>;
// The decay of each mode over the step of a pass.
var<private> steps: array<Decay, HEAT_MODES>;

fn load_modes(instance: u32) {
    for (var m = 0u; m < HEAT_MODES; m++) {
        let slot = m * run.instances + instance;
        let mode = heat_modes[slot];
        rates[m] = mode.rate;
        inverse_rates[m] = 1.0 / mode.rate;
        weights[m] = mode.weight;
        modes[m] = mode_states[slot];
        if (CARRIES_TANGENT) {
            tangent_modes[m] = mode_states[HEAT_MODES * run.instances + slot];
        }
    }
}

fn store_modes(instance: u32) {
    for (var m = 0u; m < HEAT_MODES; m++) {
        let slot = m * run.instances + instance;
        mode_states[slot] = modes[m];
        if (CARRIES_TANGENT) {
            mode_states[HEAT_MODES * run.instances + slot] = tangent_modes[m];
        }
    }
}
