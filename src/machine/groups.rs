//! The formulas from SI quantities to dimensionless groups and scales: equations (2.6) and (2.7) of the paper.
//!
//! Owns the formulas, over any number type; checks nothing and knows no file.

use std::f64::consts::PI;

use super::dual::Number;
use super::quantities::SiQuantity as Q;
use crate::parameters::Parameter;

/// Number of parameters that a machine determines.
pub(super) const DETERMINED: usize = 13;

/// The dimensionless groups of a machine, and the scales that convert results to SI units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Groups<T> {
    /// k* in N/m^2: the negative stiffness of the springs at angle 0, over R2^2.
    pub spring: T,
    /// t* in s.
    pub time: T,
    /// T* in K.
    pub temperature: T,
    /// P* in Pa.
    pub pressure: T,
    /// U* in m.
    pub length: T,
    /// V* in m/s.
    pub speed: T,
    pub parameters: [(Parameter, T); DETERMINED],
}

/// The groups, by the formulas of the paper
///
/// ```text
/// k* = k1 (l0/l1 - 1)(1 + l1/R2) - k2          t* = sqrt(B2/(k* R2^2))       V* = R1/t*
/// T* = U*/(alpha1 (1 + nu1) R1)                P* = alpha1 E1 T*/(1 - 2 nu1)
/// b  = { k3 R2^4 - (2/3) k2 R2^2 + k1 R2 (R2 + l1)/6 [(l0/l1)(1 + 3 R2/l1 + 3 (R2/l1)^2) - 1] } t*^2/B2
/// epsilon = 2 pi R1^2 P* t*^2/B2               h1 = 2 h/epsilon,   h = c R2^2 t*/(2 B2)
/// omega_tilde = t* a1/R1^2                     Bi = alphaT R1/lambda1        k_w = P* Kw R1/U*
/// gamma = (1 - eta) E1 alpha1 a1/(lambda1 (1 - 2 nu1))
/// F0 = f0, alpha = f1 V*, beta = f3 V*^3       omega_0 = omega' t*, omega_k = Omega_k t*, zeta_k = Omega_a t*
/// ```
///
/// with k1, k2, k3, c and B2 divided by the contact length. Factors that cancel are left out of the code, so that a derivative
/// that is 0 is exactly 0, without rounding errors: t*^2/B2 is 1/(k* R2^2), P* is E1 U*/((1 + nu1)(1 - 2 nu1) R1), k_w does not
/// contain U*, and only k* and epsilon, and through epsilon h1, contain the contact length. `gamma` is the paper's gamma times
/// its omega-tilde; without eta it is E alpha/((1 - 2 nu) rho c), the Grueneisen parameter of the shaft's material, which is
/// between 1 and 2.5 for most metals. Where k* is not positive, t* is no number; nor are the groups that depend on it.
pub(super) fn groups<T: Number>(of: impl Fn(Q) -> T) -> Groups<T> {
    let number = T::constant;
    let one = number(1.0);
    let contact_length = of(Q::Length);
    let [k1, k2, k3, c, b2] = [
        Q::RadialStiffness,
        Q::TangentStiffness,
        Q::TangentCubicStiffness,
        Q::Damping,
        Q::Inertia,
    ]
    .map(&of);
    let (r1, r2) = (of(Q::ShaftRadius), of(Q::BushRadius));
    let (l0, l1) = (of(Q::SpringFreeLength), of(Q::SpringLength));
    let (expansion, poisson, young) = (of(Q::ThermalExpansion), of(Q::PoissonsRatio), of(Q::YoungsModulus));
    let (conductivity, diffusivity) = (of(Q::ThermalConductivity), of(Q::ThermalDiffusivity));
    let interference = of(Q::Interference);

    // for the whole contact length, as the springs are
    let spring = k1 * (l0 / l1 - one) * (one + l1 / r2) - k2;
    let stiffness = spring * r2 * r2;
    let time = (b2 / stiffness).sqrt();
    let temperature = interference / (expansion * (one + poisson) * r1);
    let lateral = one - number(2.0) * poisson;
    let modulus = young / ((one + poisson) * lateral);
    let pressure = modulus * interference / r1;
    let speed = r1 / time;

    let ratio = r2 / l1;
    let radial =
        k1 * r2 * (r2 + l1) / number(6.0) * (l0 / l1 * (one + number(3.0) * ratio + number(3.0) * ratio * ratio) - one);
    let tangent = k3 * r2 * r2 * r2 * r2 - number(2.0 / 3.0) * k2 * r2 * r2;
    let epsilon = number(2.0 * PI) * r1 * r1 * pressure * contact_length / stiffness;
    let h = c * r2 * r2 * time / (number(2.0) * b2);
    let heat = (one - of(Q::WearEnergyShare)) * young * expansion * diffusivity / (conductivity * lateral);
    Groups {
        spring: spring / contact_length,
        time,
        temperature,
        pressure,
        length: interference,
        speed,
        parameters: [
            (Parameter::ZetaK, of(Q::ShaftSpeedAmplitude) * time),
            (Parameter::H1, number(2.0) * h / epsilon),
            (Parameter::Omega0, of(Q::ShaftSpeedFrequency) * time),
            (Parameter::OmegaK, of(Q::ShaftSpeedMean) * time),
            (Parameter::B, (tangent + radial) / stiffness),
            (Parameter::Epsilon, epsilon),
            (Parameter::F0, of(Q::FrictionDry)),
            (Parameter::Alpha, of(Q::FrictionLinear) * speed),
            (Parameter::Beta, of(Q::FrictionCubic) * speed * speed * speed),
            (Parameter::Gamma, heat),
            (Parameter::KW, modulus * of(Q::WearCoefficient)),
            (Parameter::Biot, of(Q::HeatTransfer) * r1 / conductivity),
            (Parameter::OmegaTilde, time * diffusivity / (r1 * r1)),
        ],
    }
}

/// The quantity to change in order to change the parameter; None if no machine determines the parameter.
pub fn governing(parameter: Parameter) -> Option<Q> {
    Some(match parameter {
        Parameter::ZetaK => Q::ShaftSpeedAmplitude,
        Parameter::H1 => Q::Damping,
        Parameter::Omega0 => Q::ShaftSpeedFrequency,
        Parameter::OmegaK => Q::ShaftSpeedMean,
        Parameter::B => Q::TangentCubicStiffness,
        Parameter::Epsilon => Q::Interference,
        Parameter::F0 => Q::FrictionDry,
        Parameter::Alpha => Q::FrictionLinear,
        Parameter::Beta => Q::FrictionCubic,
        Parameter::Gamma => Q::WearEnergyShare,
        Parameter::KW => Q::WearCoefficient,
        Parameter::Biot => Q::HeatTransfer,
        Parameter::OmegaTilde => Q::ThermalDiffusivity,
        Parameter::Epsilon0 | Parameter::RampRate | Parameter::X0 | Parameter::Y0 => return None,
    })
}
