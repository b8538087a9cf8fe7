// The Radau IIA scheme of order 5 for a bush rubbed under changing pressure: one trial step.
// Twin: src/dynamics/radau.rs, which says how the scheme works.

const SQRT_6 = 2.449489742783178;

// Nodes of a step of length 1; the last is its end.
const NODE_0 = (4.0 - SQRT_6) / 10.0;
const NODE_1 = (4.0 + SQRT_6) / 10.0;

// Column j: the j-th cardinal polynomial of the nodes integrated from 0 to each node.
const INTEGRALS = mat3x3<f32>(
    vec3((88.0 - 7.0 * SQRT_6) / 360.0, (296.0 + 169.0 * SQRT_6) / 1800.0, (16.0 - SQRT_6) / 36.0),
    vec3((296.0 - 169.0 * SQRT_6) / 1800.0, (88.0 + 7.0 * SQRT_6) / 360.0, (16.0 + SQRT_6) / 36.0),
    vec3((-2.0 + 3.0 * SQRT_6) / 225.0, (-2.0 - 3.0 * SQRT_6) / 225.0, 1.0 / 9.0),
);

// Column j: the coefficients of the j-th cardinal polynomial of the nodes.
const SCALE_0 = 1.0 / ((NODE_0 - NODE_1) * (NODE_0 - 1.0));
const SCALE_1 = 1.0 / ((NODE_1 - NODE_0) * (NODE_1 - 1.0));
const SCALE_2 = 1.0 / ((1.0 - NODE_0) * (1.0 - NODE_1));
const CARDINAL = mat3x3<f32>(
    vec3(NODE_1 * SCALE_0, -(NODE_1 + 1.0) * SCALE_0, SCALE_0),
    vec3(NODE_0 * SCALE_1, -(NODE_0 + 1.0) * SCALE_1, SCALE_1),
    vec3(NODE_0 * NODE_1 * SCALE_2, -(NODE_0 + NODE_1) * SCALE_2, SCALE_2),
);

// Hermite's cubics at the nodes: weights of the value and the slope at the start, and at the end.
const START_VALUE = vec3<f32>(
    (2.0 * NODE_0 - 3.0) * NODE_0 * NODE_0 + 1.0,
    (2.0 * NODE_1 - 3.0) * NODE_1 * NODE_1 + 1.0,
    0.0,
);
const START_SLOPE = vec3<f32>(
    ((NODE_0 - 2.0) * NODE_0 + 1.0) * NODE_0,
    ((NODE_1 - 2.0) * NODE_1 + 1.0) * NODE_1,
    0.0,
);
const END_VALUE = vec3<f32>((3.0 - 2.0 * NODE_0) * NODE_0 * NODE_0, (3.0 - 2.0 * NODE_1) * NODE_1 * NODE_1, 1.0);
const END_SLOPE = vec3<f32>((NODE_0 - 1.0) * NODE_0 * NODE_0, (NODE_1 - 1.0) * NODE_1 * NODE_1, 0.0);

// Their derivatives at the two inner nodes.
const START_VALUE_RATE = vec2<f32>((6.0 * NODE_0 - 6.0) * NODE_0, (6.0 * NODE_1 - 6.0) * NODE_1);
const START_SLOPE_RATE = vec2<f32>((3.0 * NODE_0 - 4.0) * NODE_0 + 1.0, (3.0 * NODE_1 - 4.0) * NODE_1 + 1.0);
const END_VALUE_RATE = vec2<f32>((6.0 - 6.0 * NODE_0) * NODE_0, (6.0 - 6.0 * NODE_1) * NODE_1);
const END_SLOPE_RATE = vec2<f32>((3.0 * NODE_0 - 2.0) * NODE_0, (3.0 * NODE_1 - 2.0) * NODE_1);

// Weight of the embedded error estimate.
override ERROR_WEIGHT: f32;

// Number of Newton's iterations after which a trial counts as failed.
override MAX_ITERATIONS: u32;

// The thermal part of the pressure, sum w_m q_m, and sum w_m r_m q_m, the rate at which it decays.
struct Heat {
    pressure: f32,
    falloff: f32,
}

// The sums over the heat modes at the end of a step: they are linear in the heat flux's coefficients in time.
struct Memory {
    // Sums that the state at the start alone would give.
    free: Heat,
    // Derivatives of the sums by each coefficient of the flux.
    pressure: vec3<f32>,
    falloff: vec3<f32>,
}

// Where a trial starts.
struct Start {
    x: f32,
    v: f32,
    shaft_speed: f32,
    // h_U - u_w.
    fit: f32,
    heat: Heat,
    // 1 in contact, 0 in the gap.
    contact: f32,
    // The piece of the friction law that the trial follows.
    piece: Piece,
    // p, F(v), the acceleration and the heat flux here.
    pressure: f32,
    friction: f32,
    acceleration: f32,
    flux: f32,
}

// The inputs of a trial: its length, and at each node the growth of the shaft's speed and of the fit h_U since the start.
struct Drive {
    h: f32,
    speed: vec3<f32>,
    fit: vec3<f32>,
}

// A solved trial: values at the nodes, and the linearisation there.
struct Trial {
    converged: bool,
    x: vec3<f32>,
    v: vec3<f32>,
    // p; and the pressure that there would be in contact: it decides whether contact returns.
    pressure: vec3<f32>,
    if_closed: vec3<f32>,
    friction: vec3<f32>,
    acceleration: vec3<f32>,
    // Q = F(v) v p.
    flux: vec3<f32>,
    // d(friction)/dv.
    slope: vec3<f32>,
    // Inverse of d(residual)/d(v).
    newton: mat3x3<f32>,
    // dp/d(p at fixed heat and wear): the response of the pressure to a change of its own source.
    response: mat3x3<f32>,
    // dp/dv.
    by_v: mat3x3<f32>,
}

// Thermal part of the pressure at the nodes, by Hermite's cubics: offset + by_flux * (flux at the nodes).
struct InnerHeat {
    offset: vec3<f32>,
    by_flux: mat3x3<f32>,
}

// A perturbation of the motion: of x, v, the fit h_U - u_w, and the sums of the heat modes.
struct Perturbation {
    x: f32,
    v: f32,
    fit: f32,
    heat: Heat,
    // Of the heat flux at the step's start.
    flux: f32,
}

struct Perturbed {
    end: Perturbation,
    // Of the heat flux at the nodes.
    flux: vec3<f32>,
}

// A quadratic's coefficients in time from its values at the nodes.
fn parabola(values: vec3<f32>) -> vec3<f32> {
    return CARDINAL * values;
}

// The integrals from 0 to each node of the quadratic with these values at the nodes.
fn integrals(values: vec3<f32>) -> vec3<f32> {
    return INTEGRALS * values;
}

// The same, to the step's end.
fn integral(values: vec3<f32>) -> f32 {
    return dot(vec3(INTEGRALS[0][2], INTEGRALS[1][2], INTEGRALS[2][2]), values);
}

// Sums over the modes for a step of length `h`; keeps each mode's own numbers in `steps`.
fn memory_new(h: f32) -> Memory {
    let inverse_h = 1.0 / h;
    var memory: Memory;
    for (var m = 0u; m < HEAT_MODES; m++) {
        let step = decay(rates[m] * h, inverse_rates[m] * inverse_h);
        let left = step.factor * modes[m];
        let faster = weights[m] * rates[m];
        memory.free.pressure = fma(weights[m], left, memory.free.pressure);
        memory.free.falloff = fma(faster, left, memory.free.falloff);
        memory.pressure = fma(vec3(weights[m]), step.moments, memory.pressure);
        memory.falloff = fma(vec3(faster), step.moments, memory.falloff);
        steps[m] = step;
    }
    return Memory(memory.free, memory.pressure * h, memory.falloff * h);
}

// The sums at the end, given the flux's coefficients in time.
fn memory_end(memory: Memory, flux: vec3<f32>) -> Heat {
    return Heat(
        memory.free.pressure + dot(memory.pressure, flux),
        memory.free.falloff + dot(memory.falloff, flux),
    );
}

fn start_new(
    rubbing: Rubbing,
    piece: Piece,
    x: f32,
    v: f32,
    shaft_speed: f32,
    fit: f32,
    heat: Heat,
    contact: f32,
) -> Start {
    let pressure = contact * (fit + heat.pressure);
    let friction = rubbing_friction(rubbing, piece, v);
    let rubbed = pressure * friction;
    return Start(
        x,
        v,
        shaft_speed,
        fit,
        heat,
        contact,
        piece,
        pressure,
        friction,
        acceleration(rubbing, x, shaft_speed - v, rubbed),
        rubbed * v,
    );
}

fn inner_heat_new(rubbing: Rubbing, h: f32, start: Heat, start_flux: f32, memory: Memory) -> InnerHeat {
    // derivatives by the flux at node j instead of the coefficient of s^k
    let end = memory.pressure * CARDINAL;
    let end_falloff = h * (memory.falloff * CARDINAL);
    let start_slope = h * fma(rubbing.two_gamma, start_flux, -start.falloff);
    let own = h * rubbing.two_gamma;
    let offset = START_VALUE * start.pressure + START_SLOPE * start_slope
        + END_VALUE * memory.free.pressure - END_SLOPE * (h * memory.free.falloff);
    return InnerHeat(
        offset,
        mat3x3(
            END_VALUE * end[0] - END_SLOPE * end_falloff[0],
            END_VALUE * end[1] - END_SLOPE * end_falloff[1],
            END_VALUE * end[2] - END_SLOPE * (end_falloff[2] - own),
        ),
    );
}

// Solves a trial. `guess` are accelerations at the nodes to begin with. `closeness` is the largest allowed last correction of
// Newton's method, relative to the larger of |v| and the friction layer's width.
fn solve(rubbing: Rubbing, start: Start, drive: Drive, memory: Memory, guess: vec3<f32>, closeness: f32) -> Trial {
    let h = drive.h;
    let heat = inner_heat_new(rubbing, h, start.heat, start.flux, memory);
    let by_flux = heat.by_flux * start.contact;
    let weights = h * INTEGRALS;
    let worn = (start.contact * rubbing.k_w) * weights;
    let speed = start.shaft_speed + drive.speed;
    let aim = start.v + drive.speed;
    let piece = start.piece;

    var trial: Trial;
    trial.if_closed = start.fit + drive.fit + heat.offset;
    var v = aim - weights * guess;
    var correction = vec3(0.0);
    for (var i = 0u; i < MAX_ITERATIONS; i++) {
        let y = speed - v;
        trial.x = start.x + weights * y;
        trial.friction = vec3(
            rubbing_friction(rubbing, piece, v[0]),
            rubbing_friction(rubbing, piece, v[1]),
            rubbing_friction(rubbing, piece, v[2]),
        );
        trial.slope = vec3(
            friction_slope(rubbing, piece, v[0]),
            friction_slope(rubbing, piece, v[1]),
            friction_slope(rubbing, piece, v[2]),
        );
        // in contact p = response * if_closed: the flux and the wear at the nodes are linear in p
        let slid = abs(v);
        let heated = trial.friction * v;
        trial.response = inverse(mat3x3(
            vec3(1.0, 0.0, 0.0) + slid[0] * worn[0] - heated[0] * by_flux[0],
            vec3(0.0, 1.0, 0.0) + slid[1] * worn[1] - heated[1] * by_flux[1],
            vec3(0.0, 0.0, 1.0) + slid[2] * worn[2] - heated[2] * by_flux[2],
        ));
        trial.pressure = trial.response * (start.contact * trial.if_closed);
        let rubbed = trial.pressure * trial.friction;
        trial.acceleration = vec3(
            acceleration(rubbing, trial.x[0], y[0], rubbed[0]),
            acceleration(rubbing, trial.x[1], y[1], rubbed[1]),
            acceleration(rubbing, trial.x[2], y[2], rubbed[2]),
        );
        let residual = v - aim + weights * trial.acceleration;

        let by_heat = fma(trial.slope, v, trial.friction) * trial.pressure;
        let by_wear = select(-trial.pressure, trial.pressure, v < vec3(0.0));
        trial.by_v = trial.response * mat3x3(
            by_flux[0] * by_heat[0] + worn[0] * by_wear[0],
            by_flux[1] * by_heat[1] + worn[1] * by_wear[1],
            by_flux[2] * by_heat[2] + worn[2] * by_wear[2],
        );
        let by_pressure = rubbing.epsilon * trial.friction;
        let by_x = vec3(
            stiffness(rubbing, trial.x[0]),
            stiffness(rubbing, trial.x[1]),
            stiffness(rubbing, trial.x[2]),
        );
        let own = fma(rubbing.epsilon * trial.pressure, trial.slope, vec3(rubbing.damping));
        let jacobian = weights * mat3x3(
            by_pressure * trial.by_v[0] - by_x * weights[0] + vec3(own[0], 0.0, 0.0),
            by_pressure * trial.by_v[1] - by_x * weights[1] + vec3(0.0, own[1], 0.0),
            by_pressure * trial.by_v[2] - by_x * weights[2] + vec3(0.0, 0.0, own[2]),
        );
        trial.newton = inverse(mat3x3(
            vec3(1.0, 0.0, 0.0) + jacobian[0],
            vec3(0.0, 1.0, 0.0) + jacobian[1],
            vec3(0.0, 0.0, 1.0) + jacobian[2],
        ));
        correction = trial.newton * residual;
        v = v - correction;
        let bound = closeness * max(abs(v), vec3(rubbing.layer));
        trial.converged = all(are_below(abs(correction), bound));
        if (trial.converged) {
            break;
        }
    }
    // what depends on v was evaluated before the last correction; it is corrected linearly, to an error of second order
    trial.v = v;
    trial.x += weights * correction;
    trial.pressure -= trial.by_v * correction;
    trial.friction -= trial.slope * correction;
    let rubbed = trial.pressure * trial.friction;
    trial.flux = rubbed * v;
    trial.acceleration = vec3(
        acceleration(rubbing, trial.x[0], speed[0] - v[0], rubbed[0]),
        acceleration(rubbing, trial.x[1], speed[1] - v[1], rubbed[1]),
        acceleration(rubbing, trial.x[2], speed[2] - v[2], rubbed[2]),
    );
    return trial;
}

// The sum w_m r_m q_m of the surface temperature at the nodes, from the balance of heat: (w . q)' = 2 gamma Q - (this sum).
fn trial_falloff(trial: Trial, rubbing: Rubbing, start: Start, h: f32, end: Heat) -> vec3<f32> {
    let start_slope = h * fma(rubbing.two_gamma, start.flux, -start.heat.falloff);
    let end_slope = h * fma(rubbing.two_gamma, trial.flux[2], -end.falloff);
    let slope = START_VALUE_RATE * start.heat.pressure + START_SLOPE_RATE * start_slope
        + END_VALUE_RATE * end.pressure + END_SLOPE_RATE * end_slope;
    return vec3(rubbing.two_gamma * trial.flux.xy - slope * (1.0 / h), end.falloff);
}

// Pressure lost by wear over the step.
fn worn(trial: Trial, rubbing: Rubbing, h: f32) -> f32 {
    return rubbing.k_w * h * integral(abs(trial.v) * trial.pressure);
}

// Carries a perturbation over the step, by the derivative of the step itself. Returns the perturbation at the end, without its
// heat modes, and the perturbation of the flux at the nodes, which drives these modes.
fn perturbed(trial: Trial, rubbing: Rubbing, start: Start, h: f32, memory: Memory, at: Perturbation) -> Perturbed {
    // the perturbed memory is the same linear map: `memory` has the free sums of the perturbed modes, and `response` and `by_v`
    // already include what the flux adds
    let offset = inner_heat_new(rubbing, h, at.heat, at.flux, memory).offset;
    let free = trial.response * (start.contact * (offset + at.fit));
    // perturbation of the acceleration at the nodes if v were not perturbed there: that of x is then `at.x`
    let pull = vec3(
        stiffness(rubbing, trial.x[0]),
        stiffness(rubbing, trial.x[1]),
        stiffness(rubbing, trial.x[2]),
    ) * at.x + rubbing.epsilon * trial.friction * free;
    let v = trial.newton * (at.v - h * integrals(pull));
    let pressure = free + trial.by_v * v;
    let by_heat = fma(trial.slope, trial.v, trial.friction) * trial.pressure;
    let flux = trial.friction * trial.v * pressure + by_heat * v;
    let pressed = select(trial.pressure, -trial.pressure, trial.v < vec3(0.0));
    return Perturbed(
        Perturbation(
            // x' = y and the shaft is not perturbed
            at.x - h * integral(v),
            v[2],
            at.fit - rubbing.k_w * h * integral(abs(trial.v) * pressure + pressed * v),
            memory_end(memory, parabola(flux)),
            flux[2],
        ),
        flux,
    );
}
