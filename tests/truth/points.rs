//! Points drawn from a wide box of all parameters of the reduced model, edges included.
//!
//! Owns the box. Values have four digits, so that a point's arguments give it exactly.

use tribochaos::parameters::{Parameter, ParameterSet};

use super::collocation::Bush;
use super::common::Random;

/// `count` points of a seed:
///
/// | parameter | drawn from |
/// | --- | --- |
/// | zeta_k | 0..12, 15 % from 12..1000 (logarithmic), 8 % exactly 0 |
/// | omega_0 | 0.01..10 (logarithmic) |
/// | h1 | -0.5..2 and 2..20, half each |
/// | epsilon | 0.01..2 (logarithmic) |
/// | f_0 | 0..2, 10 % exactly 0 |
/// | alpha | 0..1, 10 % exactly 0 |
/// | beta | 0..1, 10 % exactly 0, 2 % from -0.2..0 |
/// | omega_k | -1..1, 10 % exactly 0 |
/// | b | 0..4, 4 % from -1..0 |
/// | epsilon_0 | 1e-9..0.1 (logarithmic) |
/// | x0, y0 | -2..2 |
pub fn draw(count: usize, seed: u64) -> Vec<ParameterSet> {
    let mut random = Random::new(seed);
    (0..count).map(|_| one(&mut random)).collect()
}

fn one(random: &mut Random) -> ParameterSet {
    let mut chosen = ParameterSet::default();
    let mut set = |parameter, value: f64| {
        chosen[parameter] = format!("{value:.3e}").parse().expect("a number is printed as one");
    };
    let kind = random.uniform(0.0, 1.0);
    let (usual, tail) = (random.uniform(0.0, 12.0), logarithmic(random, 12.0, 1000.0));
    set(
        Parameter::ZetaK,
        if kind < 0.08 {
            0.0
        } else if kind < 0.23 {
            tail
        } else {
            usual
        },
    );
    set(Parameter::Omega0, logarithmic(random, 0.01, 10.0));
    let weak = random.uniform(0.0, 1.0) < 0.5;
    set(
        Parameter::H1,
        if weak {
            random.uniform(-0.5, 2.0)
        } else {
            random.uniform(2.0, 20.0)
        },
    );
    set(Parameter::Epsilon, logarithmic(random, 0.01, 2.0));
    set(Parameter::F0, or_zero(random, 0.0, 2.0));
    set(Parameter::Alpha, or_zero(random, 0.0, 1.0));
    let falls = random.uniform(0.0, 1.0) < 0.02;
    let (falling, rising) = (random.uniform(-0.2, 0.0), or_zero(random, 0.0, 1.0));
    set(Parameter::Beta, if falls { falling } else { rising });
    set(Parameter::OmegaK, or_zero(random, -1.0, 1.0));
    let softens = random.uniform(0.0, 1.0) < 0.04;
    set(
        Parameter::B,
        if softens {
            random.uniform(-1.0, 0.0)
        } else {
            random.uniform(0.0, 4.0)
        },
    );
    set(Parameter::Epsilon0, logarithmic(random, 1e-9, 0.1));
    set(Parameter::X0, random.uniform(-2.0, 2.0));
    set(Parameter::Y0, random.uniform(-2.0, 2.0));
    chosen
}

fn logarithmic(random: &mut Random, low: f64, high: f64) -> f64 {
    random.uniform(low.ln(), high.ln()).exp()
}

fn or_zero(random: &mut Random, low: f64, high: f64) -> f64 {
    let value = random.uniform(low, high);
    if random.uniform(0.0, 1.0) < 0.1 { 0.0 } else { value }
}

/// The parameters as the reference takes them.
pub fn bush(p: &ParameterSet) -> Bush {
    Bush {
        zeta_k: p[Parameter::ZetaK],
        omega_0: p[Parameter::Omega0],
        omega_k: p[Parameter::OmegaK],
        b: p[Parameter::B],
        epsilon: p[Parameter::Epsilon],
        h1: p[Parameter::H1],
        f_0: p[Parameter::F0],
        alpha: p[Parameter::Alpha],
        beta: p[Parameter::Beta],
        epsilon_0: p[Parameter::Epsilon0],
    }
}

/// The arguments that give the point to the program.
pub fn arguments(p: &ParameterSet) -> String {
    use Parameter::{Alpha, B, Beta, Epsilon, Epsilon0, F0, H1, Omega0, OmegaK, X0, Y0, ZetaK};
    [ZetaK, Omega0, H1, Epsilon, F0, Alpha, Beta, OmegaK, B, Epsilon0, X0, Y0]
        .map(|parameter| format!("--set {parameter}={}", p[parameter]))
        .join(" ")
}
