// Data that the host and the device share: the structs of src/backend/gpu/reduced/layout.rs, held equal by a test, and the
// bindings. Scalars only, so that both languages lay them out alike.

// Data that all instances of a batch share.
struct Run {
    instances: u32,
    steps_per_period: u32,
    renormalise_every: u32,
    // Measured periods before the stroboscopic window.
    unrecorded: u32,
    // Number of states in that window, and the longest period that is looked for in them.
    window: u32,
    max_period: u32,
    period_tolerance: f32,
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
    // Length of the steps of rk4, or of the longest step of taylor, in units of time.
    step_units: f32,
    // The scheme's unit of time, in units of tau; it is 1 for rk4.
    unit_of_time: f32,
}

// One instance as it is carried along: state, extremes of x, and what its periods showed.
struct Orbit {
    x: f32,
    y: f32,
    x_min: f32,
    x_max: f32,
    // Forcing periods after which the motion repeats, once the run has ended; 0 if it does not.
    period: u32,
    // The period, counted from 1, at whose end the instance was found to have run away; 0 if it has not.
    runaway_period: u32,
    // 1 once the scheme has given the instance up, else 0.
    under_resolved: u32,
}

// One instance's sums over measured periods since they were last collected.
struct Totals {
    growth_first: f32,
    growth_second: f32,
    birkhoff: f32,
    divergence: f32,
}

@group(0) @binding(0) var<uniform> run: Run;
@group(0) @binding(1) var<uniform> span: Span;
// sin z at the middle and the end of each step, two steps to an entry: a uniform is read faster than storage.
@group(0) @binding(2) var<uniform> drive: array<vec4<f32>, 4096>;
@group(0) @binding(3) var<storage, read> birkhoff_weights: array<f32>;
@group(0) @binding(4) var<storage, read> parameters: array<Parameters>;
@group(0) @binding(5) var<storage, read_write> orbits: array<Orbit>;
// The first tangent vectors, of length 1. The second ones are perpendicular to them and are not stored.
@group(0) @binding(6) var<storage, read_write> tangents: array<vec2<f32>>;
@group(0) @binding(7) var<storage, read_write> totals: array<Totals>;
// The last stroboscopic states, [slot][instance], so that neighbouring threads touch neighbouring memory.
@group(0) @binding(8) var<storage, read_write> last_states: array<vec2<f32>>;

// sin z at the middle and the end of a step of the period. Two scalar loads are faster than the load of an entry
// that is then taken apart.
fn drive_at(step: u32) -> vec2<f32> {
    let at = step % 2u * 2u;
    return vec2(drive[step / 2u][at], drive[step / 2u][at + 1u]);
}
