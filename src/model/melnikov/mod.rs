//! Mel'nikov's function of the reduced system (contact pressure p = 1), equations (4.1) to (4.4) and (A.1).
//!
//! Owns the function in two independent forms, its extremes over a drive period, whether it changes sign, and where it begins or
//! ceases to do so; draws no curves and runs no scans over grids.
//!
//! To first order in epsilon, M(tau0) is the distance between the stable and the unstable manifold of the saddle at rest. Its
//! sign is the paper's: epsilon M is the energy of the stable manifold less that of the unstable one, so that M is minus the
//! usual integral of y0 (F - h1 y0). Where M changes sign, the manifolds cross, and chaos may occur.

mod extremes;
mod integrals;
mod quadrature;
mod roots;
mod threshold;

pub use self::extremes::Extremes;
pub use self::integrals::Integrals;
pub use self::threshold::{Threshold, border, changes_sign, threshold};

use crate::design::{Coordinate, Fixed};
use crate::machine::SiQuantity;
use crate::parameters::{Parameter, ParameterSet};

/// The parameters that M depends on. The strength epsilon of the perturbation is a factor of the whole distance, the layer
/// epsilon_0 is taken to its limit 0, and the initial state belongs to one orbit only.
pub const PARAMETERS: [Parameter; 8] = [
    Parameter::ZetaK,
    Parameter::H1,
    Parameter::Omega0,
    Parameter::OmegaK,
    Parameter::B,
    Parameter::F0,
    Parameter::Alpha,
    Parameter::Beta,
];

/// The integrals over all times are cut at this |t|: sech t is 8.5e-18 there.
const END: f64 = 40.0;

/// Mel'nikov's function at one set of parameters.
///
/// M(tau0) = - Int y0 [F0 sgn w - alpha w + beta w^3 - h1 y0] dt with w(t) = omega_k + zeta_k sin(omega_0 (t + tau0)) - y0(t)
/// along the homoclinic orbit x0 = sqrt(2/b)/cosh t, y0 = x0'. All quantities are dimensionless.
#[derive(Clone, Debug)]
pub struct Melnikov {
    zeta_k: f64,
    h1: f64,
    omega_0: f64,
    omega_k: f64,
    f_0: f64,
    alpha: f64,
    beta: f64,
    /// sqrt(2/b), the greatest angle on the homoclinic orbit.
    amplitude: f64,
    integrals: Integrals,
}

impl Melnikov {
    /// # Errors
    /// [`MelnikovError::NoHomoclinicOrbit`] unless b > 0, [`MelnikovError::Rubbed`] if there is frictional heat or wear.
    pub fn new(parameters: &ParameterSet) -> Result<Self, MelnikovError> {
        if parameters.has_heat_or_wear() {
            return Err(MelnikovError::Rubbed);
        }
        let b = parameters[Parameter::B];
        // false for NaN too
        let has_wells = b > 0.0;
        if !has_wells {
            return Err(MelnikovError::NoHomoclinicOrbit { b });
        }
        let omega_0 = parameters[Parameter::Omega0];
        Ok(Self {
            zeta_k: parameters[Parameter::ZetaK],
            h1: parameters[Parameter::H1],
            omega_0,
            omega_k: parameters[Parameter::OmegaK],
            f_0: parameters[Parameter::F0],
            alpha: parameters[Parameter::Alpha],
            beta: parameters[Parameter::Beta],
            amplitude: (2.0 / b).sqrt(),
            integrals: Integrals::new(omega_0, b),
        })
    }

    /// Period 2 pi/omega_0 of M in tau0.
    pub fn period(&self) -> f64 {
        std::f64::consts::TAU / self.omega_0
    }

    /// M(tau0) in closed form (4.2), with dry friction's part (4.3) from the roots of w.
    pub fn closed_form(&self, tau_0: f64) -> f64 {
        self.dry_part(tau_0) + self.smooth_part(tau_0)
    }

    /// I(tau0) of (4.3): 2 F0 sum of sgn(w'(t_m)) x0(t_m) over the roots of w; a point where w only touches zero adds nothing.
    fn dry_part(&self, tau_0: f64) -> f64 {
        if self.f_0 == 0.0 {
            return 0.0;
        }
        let mut sum = 0.0;
        roots::for_each_crossing(self, tau_0, &mut |t, upward| {
            let x = self.amplitude / t.cosh();
            sum += if upward { x } else { -x };
        });
        2.0 * self.f_0 * sum
    }

    /// M without the part of dry friction, from the half-line integrals.
    fn smooth_part(&self, tau_0: f64) -> f64 {
        let (s, c) = (self.omega_0 * tau_0).sin_cos();
        let i = &self.integrals;
        let (zeta, omega) = (self.zeta_k, self.omega_k);
        let linear = -zeta * c * i.i110 + i.i200;
        let cubic = 3.0 * omega * omega * zeta * c * i.i110
            + 6.0 * omega * zeta * zeta * s * c * i.i111
            + zeta.powi(3) * (c.powi(3) * i.i130 + 3.0 * c * s * s * i.i112)
            - 3.0
                * (omega * omega * i.i200
                    + zeta * zeta * (c * c * i.i220 + s * s * i.i202)
                    + 2.0 * omega * zeta * s * i.i201)
            + 3.0 * zeta * c * i.i310
            - i.i400;
        -2.0 * (self.alpha * linear + self.beta * cubic - self.h1 * i.i200)
    }

    /// y0(t), the homoclinic orbit's angular speed.
    fn orbit_speed(&self, t: f64) -> f64 {
        -self.amplitude * t.tanh() / t.cosh()
    }

    /// w(t), the sliding velocity along the homoclinic orbit.
    fn sliding(&self, t: f64, tau_0: f64) -> f64 {
        self.omega_k + self.zeta_k * (self.omega_0 * (t + tau_0)).sin() - self.orbit_speed(t)
    }

    /// w and w', with x0'' = x0 - b x0^3; the hyperbolic functions come from one exponential, because most of the computing time
    /// is spent here.
    fn sliding_and_rate(&self, t: f64, tau_0: f64) -> [f64; 2] {
        let (sin, cos) = (self.omega_0 * (t + tau_0)).sin_cos();
        let decay = (-t.abs()).exp();
        let (square, inverse) = (decay * decay, 1.0 / (1.0 + decay * decay));
        let sech = 2.0 * decay * inverse;
        let speed = -self.amplitude * ((1.0 - square) * inverse).copysign(t) * sech;
        let acceleration = self.amplitude * sech * (1.0 - 2.0 * sech * sech);
        [
            self.omega_k + self.zeta_k * sin - speed,
            self.zeta_k * self.omega_0 * cos - acceleration,
        ]
    }
}

/// Why there is no value of Mel'nikov's function, or no threshold.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages tell what each is")]
pub enum MelnikovError {
    #[error("b = {b}: Mel'nikov's function needs a homoclinic orbit, which the springs have for b > 0 only")]
    NoHomoclinicOrbit { b: f64 },
    #[error(
        "Mel'nikov's function is that of constant contact pressure, without frictional heat and wear: set gamma = 0 and k_w = 0 \
         (of a machine, wear_energy_share = 1 and wear_coefficient = 0)"
    )]
    Rubbed,
    #[error("Mel'nikov's function does not depend on {name}: what it depends on is {known}")]
    NotAParameter { name: &'static str, known: String },
}

/// Whether M depends on a coordinate: one of [`PARAMETERS`], or a quantity of a machine that changes one of them.
pub fn depends(at: &Fixed, coordinate: Coordinate) -> bool {
    // a contact length that the machine does not have changes nothing
    let is_there = match (coordinate, at.machine()) {
        (Coordinate::Si(quantity), Some(machine)) => machine.quantities().any(|own| own == quantity),
        _ => true,
    };
    is_there && PARAMETERS.iter().any(|&parameter| at.moves(coordinate, parameter))
}

/// Checks that M depends on a coordinate.
///
/// # Errors
/// [`MelnikovError::NotAParameter`].
pub fn check_depends(at: &Fixed, coordinate: Coordinate) -> Result<(), MelnikovError> {
    if depends(at, coordinate) {
        return Ok(());
    }
    Err(MelnikovError::NotAParameter {
        name: coordinate.name(),
        known: known(at),
    })
}

/// The names of the parameters that M depends on; if there is a machine, of its quantities.
pub fn known(at: &Fixed) -> String {
    let names: Vec<&str> = match at.machine() {
        None => PARAMETERS.map(Parameter::name).to_vec(),
        Some(machine) => machine
            .quantities()
            .filter(|&quantity| depends(at, quantity.into()))
            .map(SiQuantity::name)
            .collect(),
    };
    names.join(", ")
}

#[cfg(test)]
mod tests;
