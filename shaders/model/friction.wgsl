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
    let u = v * friction.inverse_epsilon_0;
    return select(3.0, select(2.0, select(1.0, 0.0, u < -1.0), u < 0.0), u < 1.0);
}

// The piece of an index.
fn friction_piece(friction: Friction, index: f32, epsilon_0: f32) -> Piece {
    let left = index < 1.5;
    let side = select(1.0, -1.0, left);
    let inside = abs(index - 1.5) < 1.0;
    let curvature = 0.5 * friction.two_f_0_over_epsilon_0 * friction.inverse_epsilon_0;
    let near = select(epsilon_0, 0.0, inside);
    let other = select(NO_BOUNDARY, epsilon_0, inside);
    return Piece(
        select(side * friction.f_0, 0.0, inside),
        friction.minus_alpha + select(0.0, friction.two_f_0_over_epsilon_0, inside),
        select(0.0, -side * curvature, inside),
        select(near, -other, left),
        select(other, -near, left),
    );
}
