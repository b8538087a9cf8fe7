// Data that the host and the device share where heat and wear change the pressure: the structs of
// src/backend/gpu/rubbed/layout.rs, held equal by a test, and the bindings. Scalars only, so that both languages lay
// them out alike. The host defines HEAT_MODES, the number of heat modes with the lumped one, in front of this text.

// Data that all instances of a batch share.
struct Run {
    instances: u32,
    // Measured periods before the stroboscopic window.
    unrecorded: u32,
    // Number of states in that window, and the longest period that is looked for in them.
    window: u32,
    max_period: u32,
    period_tolerance: f32,
    // Tolerated error of a step: absolute for v outside the friction layer, in units of its width for v inside it, relative
    // for p.
    tolerance: f32,
    // Largest allowed last correction of Newton's method, relative to the larger of |v| and the friction layer's width.
    newton: f32,
    // How near to a boundary of the friction layer a step must end, in half-widths of the layer.
    reach: f32,
    // Longest step, in forcing periods.
    longest_step_periods: f32,
    // Longest step in tau, times the slower of the two rates of the bush's motion.
    swing: f32,
}

// One instance's parameters.
struct Parameters {
    zeta_k: f32,
    h1: f32,
    omega_k: f32,
    b: f32,
    epsilon: f32,
    f_0: f32,
    alpha: f32,
    beta: f32,
    epsilon_0: f32,
    gamma: f32,
    k_w: f32,
    // LARGEST where there is no ramp.
    ramp_rate: f32,
    // Forcing period in units of tau.
    period: f32,
    // theta(1) = this times the sum of 2 gamma c_m r_m q_m.
    surface_temperature: f32,
}

// One heat mode of one instance: its rate of decay and its weight in the pressure.
struct HeatMode {
    rate: f32,
    weight: f32,
}

// One instance as it is carried along: state, clock, tangent vector, and what its contact and its periods showed.
struct Orbit {
    x: f32,
    // Sliding velocity (shaft speed) - y.
    v: f32,
    // h_U - u_w.
    fit: f32,
    // sum w_m q_m, and sum w_m r_m q_m, the rate at which the former decays.
    heat_pressure: f32,
    heat_falloff: f32,
    // 1 in contact, 0 in the gap.
    contact: f32,
    // Drive phase: its sine and cosine, and the ticks left of the period.
    sine: f32,
    cosine: f32,
    left: u32,
    // Completed periods.
    periods: f32,
    // Length of the next step, in ticks.
    step: f32,
    // Piece of the friction law: 0 below the layer, 1 and 2 its halves, 3 above.
    piece: f32,
    // Acceleration as a cubic in time around the last trial's start, and the time since then: the guess for the next trial.
    guess_0: f32,
    guess_1: f32,
    guess_2: f32,
    guess_3: f32,
    since: f32,
    tangent_x: f32,
    tangent_v: f32,
    tangent_fit: f32,
    tangent_pressure: f32,
    tangent_falloff: f32,
    tangent_flux: f32,
    // Greatest pressure, and its time: completed periods, and tau since.
    peak_pressure: f32,
    peak_periods: f32,
    peak_time: f32,
    peak_temperature: f32,
    // Time at which contact was first lost: completed periods, and tau since. The periods are negative while it has not been.
    lost_periods: f32,
    lost_time: f32,
    // Least and greatest x since they were last set.
    x_min: f32,
    x_max: f32,
    // Forcing periods after which the motion repeats, once the run has ended; 0 if it does not.
    period: u32,
    // 1 if the instance was given up for this reason, else 0; and the period, counted from 1, in which it was given up.
    under_resolved: u32,
    runaway: u32,
    given_up_period: u32,
    // Time at which it ran away, as a part of that period.
    runaway_phase: f32,
}

// One instance's sums over measured periods since they were last collected.
struct Totals {
    growth: f32,
    birkhoff: f32,
}

@group(0) @binding(0) var<uniform> run: Run;
@group(0) @binding(1) var<uniform> span: Span;
@group(0) @binding(2) var<storage, read> birkhoff_weights: array<f32>;
@group(0) @binding(3) var<storage, read> parameters: array<Parameters>;
// The next three are laid out [slot][instance], so that neighbouring threads touch neighbouring memory: the heat modes, the
// lumped one last; the states q_m of the modes, followed by those of the tangent vector; the last stroboscopic states.
@group(0) @binding(4) var<storage, read> heat_modes: array<HeatMode>;
@group(0) @binding(5) var<storage, read_write> mode_states: array<f32>;
@group(0) @binding(6) var<storage, read_write> last_states: array<vec2<f32>>;
@group(0) @binding(7) var<storage, read_write> orbits: array<Orbit>;
@group(0) @binding(8) var<storage, read_write> totals: array<Totals>;
