//! The reference itself, held against exact exponents, another integrator, another tolerance, its own divergence, the limit of
//! sharp friction, and figures that were found elsewhere.

use super::attractor::{Effort, Truth, follow, follow_motion};
use super::collocation::Bush;
use super::motion::{Motion, Orbit};
use super::points;
use super::sharp::Sharp;

/// The paper's parameters at the default point.
const PAPER: Bush = Bush {
    zeta_k: 3.9,
    omega_0: 2.0,
    omega_k: 0.4,
    b: 1.0,
    epsilon: 0.1,
    h1: 0.5,
    f_0: 0.3,
    alpha: 0.3,
    beta: 0.3,
    epsilon_0: 0.01,
};

const START: [f64; 2] = [0.1, 0.0];

/// A damped Duffing oscillator without friction or drive, which comes to rest in a well of stiffness 2.
const WELL: Bush = Bush {
    zeta_k: 0.0,
    omega_k: 0.0,
    f_0: 0.0,
    alpha: 0.0,
    beta: 0.0,
    epsilon: 1.0,
    ..PAPER
};

fn cycle(bush: &Bush, start: [f64; 2]) -> [f64; 2] {
    exponents(follow(bush, start, &Effort::USUAL), bush)
}

/// The maximal exponent and the divergence.
fn exponents(truth: Truth, bush: &Bush) -> [f64; 2] {
    match truth {
        Truth::Cycle {
            lyapunov, divergence, ..
        } => [lyapunov, divergence],
        other => panic!("{other:?} for a cycle: {bush:?}"),
    }
}

#[test]
fn a_linear_well_has_the_roots_of_its_equation_as_exponents() {
    for omega_0 in [0.02, 0.1, 0.5, 2.0, 10.0] {
        for damping in [0.05, 0.5, 2.0, 2.9, 5.0, 20.0] {
            let well = Bush {
                omega_0,
                h1: damping,
                ..WELL
            };
            let discriminant = 0.25 * damping * damping - 2.0;
            let expected = -0.5 * damping + discriminant.max(0.0).sqrt();
            let [lyapunov, divergence] = cycle(&well, [0.5, 0.0]);
            assert!(
                (lyapunov - expected).abs() < 1e-6,
                "{lyapunov} for {expected}: {well:?}"
            );
            assert!((divergence + damping).abs() < 1e-9, "{divergence}: {well:?}");
        }
    }
}

#[test]
fn figures_that_were_found_elsewhere_come_out() {
    let section_1 = Bush {
        zeta_k: 8.98,
        h1: 1.793,
        omega_0: 1.066,
        omega_k: 0.3685,
        b: 3.298,
        epsilon: 0.3294,
        f_0: 0.7489,
        alpha: 0.5981,
        beta: 0.5635,
        epsilon_0: 0.04231,
    };
    let section_6 = Bush {
        omega_0: 0.8752,
        alpha: 0.1045,
        beta: 0.2019,
        f_0: 0.8844,
        b: 1.467,
        omega_k: -0.1869,
        epsilon: 0.1055,
        epsilon_0: 0.01538,
        zeta_k: 4.2152,
        h1: 1.00408,
    };
    let slow = Bush {
        zeta_k: 2.0,
        omega_0: 0.03,
        ..PAPER
    };
    let thin = Bush {
        zeta_k: 500.0,
        epsilon_0: 1e-5,
        alpha: 0.0,
        beta: 0.0,
        h1: 2.0,
        ..PAPER
    };
    let regular = Bush { zeta_k: 3.5, ..PAPER };
    for (bush, start, expected, within) in [
        (section_1, [0.5542, -0.21], -1.97368, 6e-5),
        (section_6, [0.5394, 1.048], -0.26321, 3e-5),
        (slow, START, -0.109219, 1e-6),
        (thin, START, -0.10002, 1e-5),
        (regular, START, -0.2318, 1e-4),
    ] {
        let [lyapunov, _] = cycle(&bush, start);
        assert!(
            (lyapunov - expected).abs() < within,
            "{lyapunov} for {expected}: {bush:?}"
        );
    }
    for (b, expected) in [(-1.0, 4.3755), (-0.1, 7.5821)] {
        match follow(&Bush { b, ..PAPER }, START, &Effort::USUAL) {
            Truth::Runaway { times, .. } => assert!((times.time - expected).abs() < 1e-4, "{times:?} for {expected}"),
            other => panic!("{other:?}: b = {b}"),
        }
    }
}

/// Stiff enough for the layer to matter, not so much that rk4 cannot follow.
fn against_rk4() -> [Bush; 4] {
    [
        Bush { zeta_k: 3.5, ..PAPER },
        Bush {
            zeta_k: 0.5,
            h1: 1.0,
            omega_0: 0.7,
            f_0: 1.0,
            ..PAPER
        },
        Bush {
            zeta_k: 4.911,
            omega_0: 2.267,
            h1: 9.268,
            epsilon: 1.205,
            f_0: 0.6089,
            alpha: 0.8398,
            beta: 0.954,
            omega_k: -0.7969,
            b: 1.339,
            epsilon_0: 0.003602,
        },
        Bush {
            zeta_k: 6.281,
            omega_0: 0.4603,
            h1: 0.7027,
            epsilon: 1.168,
            f_0: 0.7322,
            alpha: 0.2936,
            beta: 0.3597,
            omega_k: -0.8067,
            b: 1.096,
            epsilon_0: 0.001587,
        },
    ]
}

#[test]
fn very_many_steps_of_rk4_find_the_same_motion_and_the_same_growth() {
    for bush in against_rk4() {
        let mut orbit = Orbit::new(bush, START, 1e-6, u64::MAX);
        let (periods, steps) = (2, 1_000_000);
        (0..periods).for_each(|_| orbit.advance_period().unwrap());
        let (state, growth) = rk4(&bush, START, periods, steps);
        let [x, y] = orbit.state();
        assert!(
            (x - state[0]).abs() < 1e-7 && (y - state[1]).abs() < 1e-7,
            "{x} {y} for {state:?}: {bush:?}"
        );
        // of the vector (X, Y) = (1, 0), whose dv is -Y
        let [dx, dv] = orbit.tangents().vectors[0];
        let reference = orbit.tangents().log_scale + dx.hypot(dv).ln();
        let within = 1e-6 * (10.0 + growth.abs());
        assert!(
            (reference - growth).abs() < within,
            "{reference} for {growth}: {bush:?}"
        );
    }
}

/// State, and growth of (X, Y) = (1, 0), after some periods of `steps`.
fn rk4(bush: &Bush, start: [f64; 2], periods: u32, steps: u32) -> ([f64; 2], f64) {
    let slope = |tau: f64, [x, y, dx, dy]: [f64; 4]| {
        let v = bush.omega_k + bush.zeta_k * (bush.omega_0 * tau).sin() - y;
        let (width, size) = (bush.epsilon_0, v.abs());
        let (sign, rise) = if size >= width {
            (v.signum(), 0.0)
        } else {
            ((2.0 - size / width) * v / width, 2.0 / width * (1.0 - size / width))
        };
        let friction = bush.f_0 * sign - bush.alpha * v + bush.beta * v.powi(3);
        let friction_rise = bush.f_0 * rise - bush.alpha + 3.0 * bush.beta * v * v;
        [
            y,
            x - bush.b * x.powi(3) + bush.epsilon * (friction - bush.h1 * y),
            dy,
            (1.0 - 3.0 * bush.b * x * x) * dx - bush.epsilon * (friction_rise + bush.h1) * dy,
        ]
    };
    let h = bush.period() / f64::from(steps);
    let mut s = [start[0], start[1], 1.0, 0.0];
    let mut growth = 0.0;
    for n in 0..periods * steps {
        let tau = f64::from(n % steps) * h;
        let moved = |k: [f64; 4], by: f64| -> [f64; 4] { std::array::from_fn(|i| s[i] + by * k[i]) };
        let k1 = slope(tau, s);
        let k2 = slope(tau + 0.5 * h, moved(k1, 0.5 * h));
        let k3 = slope(tau + 0.5 * h, moved(k2, 0.5 * h));
        let k4 = slope(tau + h, moved(k3, h));
        s = std::array::from_fn(|i| s[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        if n % 1000 == 999 {
            let size = s[2].hypot(s[3]);
            growth += size.ln();
            s[2] /= size;
            s[3] /= size;
        }
    }
    ([s[0], s[1]], growth + s[2].hypot(s[3]).ln())
}

/// Of the wide box, over two periods: a tenth of the tolerance moves neither the state nor the tangent vectors, and the
/// determinant is the exponential of the integral of the divergence, where it has digits.
#[test]
fn a_smaller_tolerance_changes_nothing_and_the_determinant_is_that_of_the_divergence() {
    let mut determinants = 0;
    for point in points::draw(150, 3) {
        let bush = points::bush(&point);
        let mut pair = [1e-6, 1e-7].map(|tolerance| Orbit::new(bush, START, tolerance, u64::MAX));
        if pair
            .iter_mut()
            .any(|orbit| (0..2).any(|_| orbit.advance_period().is_err()))
        {
            continue;
        }
        let [coarse, fine] = &mut pair;
        let ([x, y], state) = (coarse.state(), fine.state());
        let growth = (coarse.tangents.log_scale - fine.tangents.log_scale).exp();
        let scale = 1.0 + fine.tangents.log_scale.exp();
        let moved = (x - state[0]).hypot(y - state[1]);
        assert!(
            moved < 1e-8 * scale * (1.0 + state[0].hypot(state[1])),
            "{moved:e}: {}",
            points::arguments(&point)
        );
        assert!(
            (growth - 1.0).abs() < 1e-5 * scale,
            "{growth}: {}",
            points::arguments(&point)
        );
        let [[a, b], [c, d]] = fine.tangents.vectors;
        let by_divergence = (fine.tangents.divergence - 2.0 * fine.tangents.log_scale).exp();
        if by_divergence > 1e-6 {
            determinants += 1;
            let ratio = (a * d - b * c) / by_divergence;
            assert!((ratio - 1.0).abs() < 1e-5, "{ratio}: {}", points::arguments(&point));
        }
    }
    assert!(determinants >= 10, "{determinants}");
}

#[test]
fn exponents_tend_to_the_limit_of_sharp_friction_as_the_layer_becomes_thin() {
    let crossing = Bush { zeta_k: 3.5, ..PAPER };
    let sticking = Bush {
        zeta_k: 0.3,
        omega_k: 0.0,
        f_0: 2.0,
        ..PAPER
    };
    let both = Bush {
        zeta_k: 1.5,
        f_0: 1.0,
        h1: 1.0,
        ..PAPER
    };
    let fast = Bush {
        zeta_k: 500.0,
        alpha: 0.0,
        beta: 0.0,
        h1: 2.0,
        ..PAPER
    };
    for (bush, start) in [(crossing, START), (sticking, [0.9, 0.0]), (both, START), (fast, START)] {
        let [limit, _] = exponents(follow_motion(Sharp::new(bush, start), &Effort::USUAL), &bush);
        let differences = [1e-2, 1e-3, 1e-5, 1e-7, 1e-9].map(|epsilon_0| {
            let [lyapunov, _] = cycle(&Bush { epsilon_0, ..bush }, start);
            (lyapunov - limit).abs()
        });
        assert!(
            differences[4] < 1e-8 && differences[3] < 1e-6 && differences[2] < 1e-4,
            "{differences:?} from {limit}: {bush:?}"
        );
    }
}
