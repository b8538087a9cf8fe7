// Regularised dry friction, equations (3.1), (3.2) and (3.4). Twin: src/model/friction.rs.

// Kinetic friction times a constant scale, in the clamped form that needs no branch.
struct Friction {
    epsilon_0: Real,
    f_0: Real,
    minus_alpha: Real,
    beta: Real,
    two_f_0_over_epsilon_0: Real,
    minus_f_0_over_epsilon_0_squared: Real,
    three_beta: Real,
}

fn friction_new(scale: Real, f_0: Real, alpha: Real, beta: Real, epsilon_0: Real) -> Friction {
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
fn clamped(friction: Friction, v: Real) -> Real {
    return clamp(v, -friction.epsilon_0, friction.epsilon_0);
}

// rest + scale * F(v), equations (3.1) and (3.2).
fn plus_force(friction: Friction, rest: Real, v: Real) -> Real {
    let c = clamped(friction, v);
    let dry = fma(friction.minus_f_0_over_epsilon_0_squared, abs(c), friction.two_f_0_over_epsilon_0);
    let polynomial = fma(v, fma(friction.beta, v * v, friction.minus_alpha), rest);
    return fma(c, dry, polynomial);
}

// scale * F'(v), equation (3.4).
fn slope(friction: Friction, v: Real) -> Real {
    let c = clamped(friction, v);
    let dry = fma(friction.minus_f_0_over_epsilon_0_squared, abs(c), friction.two_f_0_over_epsilon_0);
    let polynomial = fma(friction.three_beta, v * v, friction.minus_alpha - friction.two_f_0_over_epsilon_0);
    return fma(Real(2.0), dry, polynomial);
}

// The law between two neighbouring boundaries -eps0, 0, +eps0 of the layer, where it is a polynomial:
// scale F(v) = a_0 + a_1 v + a_2 v^2 + beta v^3 for lower <= v <= upper.
struct Piece {
    a_0: Real,
    a_1: Real,
    a_2: Real,
    lower: Real,
    upper: Real,
}

// Stands for a boundary at infinity; finite, so that no difference with it is NaN.
const NO_BOUNDARY: f32 = 1e30;

// Index of the piece that v lies on, from the left: 0 below -eps0, 1 and 2 in the layer, 3 above eps0.
fn piece_index(friction: Friction, v: Real) -> Real {
    let epsilon_0 = friction.epsilon_0;
    let left = select(Real(1.0), Real(0.0), v < -epsilon_0);
    return select(Real(3.0), select(Real(2.0), left, v < Real(0.0)), v < epsilon_0);
}

// The piece of an index.
fn friction_piece(friction: Friction, index: Real, epsilon_0: Real) -> Piece {
    let left = index < Real(1.5);
    let side = select(Real(1.0), Real(-1.0), left);
    let inside = abs(index - 1.5) < Real(1.0);
    let near = select(epsilon_0, Real(0.0), inside);
    let other = select(Real(NO_BOUNDARY), epsilon_0, inside);
    return Piece(
        select(side * friction.f_0, Real(0.0), inside),
        friction.minus_alpha + select(Real(0.0), friction.two_f_0_over_epsilon_0, inside),
        select(Real(0.0), side * friction.minus_f_0_over_epsilon_0_squared, inside),
        select(near, -other, left),
        select(other, -near, left),
    );
}
