// The bush's motion under constant contact pressure, equation (3.2), and its linearisation (3.3).
// Twin: src/model/motion.rs.

// The oscillator x'' = x - b x^3 + eps F(v) - eps h1 y with y = x' and v = (shaft speed) - y. The damping goes into the
// friction's linear term: -eps h1 y = eps h1 v - eps h1 (shaft speed).
struct Motion {
    minus_b: Real,
    minus_three_b: Real,
    minus_damping: Real,
    omega_k: Real,
    zeta_k: Real,
    friction: Friction,
}

// The acceleration and its derivatives at one state.
struct Linearised {
    acceleration: Real,
    by_x: Real,
    // Also the divergence of the flow.
    by_y: Real,
}

fn motion_new(value: Values) -> Motion {
    return Motion(
        -value.b,
        -3.0 * value.b,
        -(value.epsilon * value.h1),
        value.omega_k,
        value.zeta_k,
        friction_new(value.epsilon, value.f_0, value.alpha - value.h1, value.beta, value.epsilon_0),
    );
}

// Speed of the shaft omega_k + zeta_k sin z, given sin z.
fn shaft_speed(motion: Motion, sin_z: Real) -> Real {
    return fma(motion.zeta_k, sin_z, motion.omega_k);
}

// Acceleration of the bush at angle x and sliding velocity v.
fn acceleration(motion: Motion, x: Real, v: Real, shaft_speed: Real) -> Real {
    let restoring = fma(motion.minus_b, x * x, Real(1.0));
    return plus_force(motion.friction, fma(x, restoring, motion.minus_damping * shaft_speed), v);
}

// Acceleration with its derivatives, for the tangent equations (3.3).
fn linearised(motion: Motion, x: Real, v: Real, shaft_speed: Real) -> Linearised {
    return Linearised(
        acceleration(motion, x, v, shaft_speed),
        fma(motion.minus_three_b, x * x, Real(1.0)),
        -slope(motion.friction, v),
    );
}
