// Regularised dry friction, equations (3.1), (3.2) and (3.4). Twin: src/model/friction.rs.

// Kinetic friction times a constant scale, in the clamped form that needs no branch.
struct Friction {
    epsilon_0: f32,
    f_0: f32,
    minus_alpha: f32,
    beta: f32,
    two_f_0_over_epsilon_0: f32,
    minus_f_0_over_epsilon_0_squared: f32,
    three_beta: f32,
}

fn friction_new(scale: f32, f_0: f32, alpha: f32, beta: f32, epsilon_0: f32) -> Friction {
    let inverse_epsilon_0 = 1.0 / epsilon_0;
    return Friction(
        epsilon_0,
        scale * f_0,
        -(scale * alpha),
        scale * beta,
        2.0 * scale * f_0 * inverse_epsilon_0,
        -(scale * f_0 * inverse_epsilon_0 * inverse_epsilon_0),
        3.0 * scale * beta,
    );
}

// Sliding velocity, clamped to the layer.
fn clamped(friction: Friction, v: f32) -> f32 {
    return clamp(v, -friction.epsilon_0, friction.epsilon_0);
}

// rest + scale * F(v), equations (3.1) and (3.2).
fn plus_force(friction: Friction, rest: f32, v: f32) -> f32 {
    let c = clamped(friction, v);
    let dry = fma(friction.minus_f_0_over_epsilon_0_squared, abs(c), friction.two_f_0_over_epsilon_0);
    let polynomial = fma(v, fma(friction.beta, v * v, friction.minus_alpha), rest);
    return fma(c, dry, polynomial);
}

// scale * F'(v), equation (3.4).
fn slope(friction: Friction, v: f32) -> f32 {
    let c = clamped(friction, v);
    let dry = fma(friction.minus_f_0_over_epsilon_0_squared, abs(c), friction.two_f_0_over_epsilon_0);
    let polynomial = fma(friction.three_beta, v * v, friction.minus_alpha - friction.two_f_0_over_epsilon_0);
    return fma(2.0, dry, polynomial);
}

// The law between two neighbouring boundaries -eps0, 0, +eps0 of the layer, where it is a polynomial:
// scale F(v) = a_0 + a_1 v + a_2 v^2 + beta v^3 for lower <= v <= upper.
struct Piece {
    a_0: f32,
    a_1: f32,
    a_2: f32,
    lower: f32,
    upper: f32,
}

// Stands for a boundary at infinity; finite, so that no difference with it is NaN.
const NO_BOUNDARY: f32 = 1e30;

// Index of the piece that v lies on, from the left: 0 below -eps0, 1 and 2 in the layer, 3 above eps0.
fn piece_index(friction: Friction, v: f32) -> f32 {
    let epsilon_0 = friction.epsilon_0;
    return select(3.0, select(2.0, select(1.0, 0.0, v < -epsilon_0), v < 0.0), v < epsilon_0);
}

// The piece of an index.
fn friction_piece(friction: Friction, index: f32, epsilon_0: f32) -> Piece {
    let left = index < 1.5;
    let side = select(1.0, -1.0, left);
    let inside = abs(index - 1.5) < 1.0;
    let near = select(epsilon_0, 0.0, inside);
    let other = select(NO_BOUNDARY, epsilon_0, inside);
    return Piece(
        select(side * friction.f_0, 0.0, inside),
        friction.minus_alpha + select(0.0, friction.two_f_0_over_epsilon_0, inside),
        select(0.0, side * friction.minus_f_0_over_epsilon_0_squared, inside),
        select(near, -other, left),
        select(other, -near, left),
    );
}
