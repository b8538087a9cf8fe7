// The bush's motion where frictional heat and wear change the contact pressure, equations (2.1) to (2.5).
// Twin: src/model/rubbing.rs.

// The system
//
//     x'' = x - b x^3 + eps p F(v) - eps h1 y           y = x',  v = (shaft speed) - y
//     p   = h_U - u_w + sum_m w_m q_m                   w_m = 2 gamma c_m, the lumped mode last
//     q_m' = -r_m q_m + Q                               r_m = mu_m^2 omega-tilde,  Q = F(v) v p
//     u_w' = k_w |v| p
//
// in contact; in the gap after contact is lost p = 0.
struct Rubbing {
    minus_b: f32,
    minus_three_b: f32,
    omega_k: f32,
    zeta_k: f32,
    // Strength eps of the friction in the equation of motion.
    epsilon: f32,
    // eps h1.
    damping: f32,
    k_w: f32,
    // 2 gamma.
    two_gamma: f32,
    // delta of the fit h_U = 1 - exp(-delta tau^2).
    ramp_rate: f32,
    // Half-width of the friction layer; NO_LAYER where there is no dry friction.
    epsilon_0: f32,
    // Width of the friction layer, but at most 1: the unit of v in the layer.
    layer: f32,
    friction: Friction,
}

// Stands for the half-width of a layer that is not there: no speed reaches its boundaries.
const NO_LAYER = 1e30;

fn rubbing_new(value: Parameters) -> Rubbing {
    // dry friction moves the bush by epsilon, and heats by gamma
    let epsilon_0 = select(NO_LAYER, value.epsilon_0, 0.0 < (value.epsilon + value.gamma) * value.f_0);
    return Rubbing(
        -value.b,
        -3.0 * value.b,
        value.omega_k,
        value.zeta_k,
        value.epsilon,
        value.epsilon * value.h1,
        value.k_w,
        2.0 * value.gamma,
        value.ramp_rate,
        epsilon_0,
        min(2.0 * epsilon_0, 1.0),
        friction_new(1.0, value.f_0, value.alpha, value.beta, epsilon_0),
    );
}

// The piece of the friction law that has this index.
fn rubbing_piece(rubbing: Rubbing, index: f32) -> Piece {
    return friction_piece(rubbing.friction, index, rubbing.epsilon_0);
}

// Kinetic friction F(v) by a piece of the law, also beyond its boundaries.
fn rubbing_friction(rubbing: Rubbing, piece: Piece, v: f32) -> f32 {
    return fma(fma(fma(rubbing.friction.beta, v, piece.a_2), v, piece.a_1), v, piece.a_0);
}

// F'(v), likewise.
fn friction_slope(rubbing: Rubbing, piece: Piece, v: f32) -> f32 {
    return fma(fma(3.0 * rubbing.friction.beta, v, 2.0 * piece.a_2), v, piece.a_1);
}

// Acceleration of the bush, given the product of pressure and friction.
fn acceleration(rubbing: Rubbing, x: f32, y: f32, rubbed: f32) -> f32 {
    let restoring = fma(rubbing.minus_b, x * x, 1.0);
    return fma(x, restoring, rubbing.epsilon * rubbed - rubbing.damping * y);
}

// d(acceleration)/dx = 1 - 3 b x^2.
fn stiffness(rubbing: Rubbing, x: f32) -> f32 {
    return fma(rubbing.minus_three_b, x * x, 1.0);
}
