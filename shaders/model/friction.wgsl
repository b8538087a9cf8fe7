// Regularised dry friction, equations (3.1), (3.2) and (3.4). Twin: src/model/friction.rs.

// Kinetic friction times a constant scale, in the clamped form that needs no branch.
struct Friction {
    inverse_epsilon_0: f32,
    f_0: f32,
    minus_alpha: f32,
    beta: f32,
    two_f_0_over_epsilon_0: f32,
    three_beta: f32,
}

fn friction_new(scale: f32, f_0: f32, alpha: f32, beta: f32, epsilon_0: f32) -> Friction {
    let inverse_epsilon_0 = 1.0 / epsilon_0;
    return Friction(
        inverse_epsilon_0,
        scale * f_0,
        -(scale * alpha),
        scale * beta,
        2.0 * scale * f_0 * inverse_epsilon_0,
        3.0 * scale * beta,
    );
}

// Sliding velocity in units of the layer's half-width, clamped to -1..1.
fn clamped(friction: Friction, v: f32) -> f32 {
    return clamp(v * friction.inverse_epsilon_0, -1.0, 1.0);
}

// scale * F(v), equations (3.1) and (3.2).
fn force(friction: Friction, v: f32) -> f32 {
    let u = clamped(friction, v);
    let polynomial = v * fma(friction.beta, v * v, friction.minus_alpha);
    return fma(friction.f_0, u * (2.0 - abs(u)), polynomial);
}

// scale * F'(v), equation (3.4).
fn slope(friction: Friction, v: f32) -> f32 {
    let inside = 1.0 - abs(clamped(friction, v));
    let polynomial = fma(friction.three_beta, v * v, friction.minus_alpha);
    return fma(friction.two_f_0_over_epsilon_0, inside, polynomial);
}
