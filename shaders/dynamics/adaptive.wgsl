// The constants of an instance of the full model, without its heat modes. Twin: src/dynamics/adaptive.rs.

// Ticks of the clock in a forcing period.
override TICKS: u32;

const TAU = 6.283185307179586;

// Rate of the linear growth of y times the longest step, times the least number of steps in a period.
const REPULSION_STEPS = 6.4;

// Stands for an infinite number.
const LARGEST = 3.4028234e38;

// The constants of one instance, without its heat modes.
struct System {
    rubbing: Rubbing,
    // Forcing period, and one tick, in units of tau.
    period: f32,
    tick: f32,
    // Factor by which a period has more steps than usual: it is above 1 if the period is long or damping is negative.
    long: f32,
    surface_temperature: f32,
    // False if there is wear: the tangent vector is then carried only until contact is lost.
    lasts: bool,
}

fn system_new(value: Parameters) -> System {
    return System(
        rubbing_new(value),
        value.period,
        value.period * (1.0 / f32(TICKS)),
        max(value.period * max(2.0 / TAU, value.epsilon * (value.alpha - value.h1) / REPULSION_STEPS), 1.0),
        value.surface_temperature,
        !(value.k_w > 0.0),
    );
}

// h_U at a time: 1 - exp(-delta tau^2), exact to rounding also where it is small.
fn fit(system: System, time: f32) -> f32 {
    if (system.rubbing.ramp_rate >= LARGEST) {
        return 1.0;
    }
    let z = max(system.rubbing.ramp_rate * time * time, 1e-30);
    return z * decay(z, 1.0 / z).moments[0];
}
