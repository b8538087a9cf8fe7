//! The hand-written derivatives against dual numbers, and the order of the scheme.

use std::f64::consts::TAU;

use tribochaos::dynamics::drive::DriveTable;
use tribochaos::dynamics::rk4::{StageSpeeds, State, StepSize, step, step_with_tangent};
use tribochaos::dynamics::tangent::{Bases, Vector};
use tribochaos::lanes::Real;
use tribochaos::model::motion::Motion;
use tribochaos::parameters::{Parameter, ParameterSet};

use crate::common::{Random, point};
use crate::dual::Dual;

/// A parameter set with a wide layer, a state, and drive phases at the start, middle and end of a step; every other
/// state slides inside the layer.
struct Case {
    parameters: ParameterSet,
    h: f64,
    x: f64,
    y: f64,
    /// sin z at the three stages.
    sines: [f64; 3],
}

const CASES: usize = 2000;

fn cases() -> impl Iterator<Item = Case> {
    let mut random = Random::new(6);
    (0..CASES).map(move |n| {
        let parameters = point(&[
            (Parameter::ZetaK, random.uniform(0.1, 8.0)),
            (Parameter::H1, random.uniform(-0.5, 2.0)),
            (Parameter::OmegaK, random.uniform(-1.0, 1.0)),
            (Parameter::B, random.uniform(-1.0, 2.0)),
            (Parameter::Epsilon, random.uniform(0.0, 0.5)),
            (Parameter::F0, random.uniform(0.0, 0.6)),
            (Parameter::Alpha, random.uniform(-0.5, 0.5)),
            (Parameter::Beta, random.uniform(-0.5, 0.5)),
            (Parameter::Epsilon0, random.uniform(0.01, 0.3)),
        ]);
        let (z, h) = (random.uniform(0.0, TAU), random.uniform(0.001, 0.02));
        let sines = [0.0, 0.5, 1.0].map(|t| (z + t * 2.0 * h).sin());
        let speed = parameters[Parameter::OmegaK] + parameters[Parameter::ZetaK] * sines[0];
        let epsilon_0 = parameters[Parameter::Epsilon0];
        let y = if n.is_multiple_of(2) {
            speed - random.uniform(-epsilon_0, epsilon_0)
        } else {
            random.uniform(-2.0, 2.0)
        };
        let x = random.uniform(-1.5, 1.5);
        Case {
            parameters,
            h,
            x,
            y,
            sines,
        }
    })
}

impl Case {
    fn motion<R: Real>(&self) -> Motion<R> {
        Motion::new(|parameter| R::splat(self.parameters[parameter]))
    }

    fn speeds<R: Real>(&self) -> StageSpeeds<R> {
        let [start, middle, end] = self.sines.map(|sine| self.motion().shaft_speed(R::splat(sine)));
        StageSpeeds { start, middle, end }
    }
}

/// Equal but for rounding, relative to the size of the sums' terms.
fn assert_close(value: f64, expected: f64, scale: f64, label: &str) {
    assert!(
        (value - expected).abs() < 1e-13 * scale,
        "{label}: {value}, by dual numbers {expected}"
    );
}

#[test]
fn tangent_vectors_are_the_derivative_of_the_step() {
    let mut random = Random::new(7);
    for case in cases() {
        let mut vector = || Vector {
            x: random.uniform(-1.0, 1.0),
            y: random.uniform(-1.0, 1.0),
        };
        let (first, second) = (vector(), vector());
        let dual = State {
            x: Dual {
                value: case.x,
                derivatives: [first.x, second.x],
            },
            y: Dual {
                value: case.y,
                derivatives: [first.y, second.y],
            },
        };
        let expected = step(&case.motion(), &StepSize::new(|_| case.h), case.speeds(), dual);

        let h = StepSize::new(|_| case.h);
        let state = State { x: case.x, y: case.y };
        let plain = step(&case.motion(), &h, case.speeds(), state);
        let (end, bases, _) = step_with_tangent(&case.motion(), &h, case.speeds(), state, [first, second]);

        for (value, dual) in [
            (end.x, expected.x),
            (end.y, expected.y),
            (plain.x, expected.x),
            (plain.y, expected.y),
        ] {
            assert_close(value, dual.value, 10.0, "state");
        }
        // the layer's rate times h reaches about 1
        for (value, expected) in [
            (bases[0].x, expected.x.derivatives[0]),
            (bases[1].x, expected.x.derivatives[1]),
            (bases[0].y, expected.y.derivatives[0]),
            (bases[1].y, expected.y.derivatives[1]),
        ] {
            assert_close(value, expected, 10.0, "vector");
        }
    }
}

#[test]
fn the_linearisation_is_the_derivative_of_the_acceleration() {
    for case in cases() {
        let (motion, dual_motion) = (case.motion::<f64>(), case.motion::<Dual>());
        let (sine, cosine) = (case.sines[0], (1.0 - case.sines[0].powi(2)).sqrt());
        let speed = motion.shaft_speed(sine);
        let linearised = motion.linearised(case.x, speed - case.y, speed);

        let variable = |value, derivatives| Dual { value, derivatives };
        let (x, y) = (variable(case.x, [1.0, 0.0]), variable(case.y, [0.0, 1.0]));
        let by_state = dual_motion.acceleration(x, Dual::splat(speed) - y, Dual::splat(speed));
        // friction inside the layer is as steep as 60 per unit of speed
        assert_close(linearised.acceleration, by_state.value, 100.0, "acceleration");
        assert_close(linearised.by_x, by_state.derivatives[0], 10.0, "by x");
        assert_close(linearised.by_y, by_state.derivatives[1], 100.0, "by y");

        let dual_speed = dual_motion.shaft_speed(variable(sine, [cosine, 0.0]));
        let by_phase = dual_motion.acceleration(Dual::splat(case.x), dual_speed - Dual::splat(case.y), dual_speed);
        let by_hand = motion.by_phase(speed - case.y, cosine);
        assert_close(by_hand, by_phase.derivatives[0], 1000.0, "by phase");
    }
}

/// Angle, angular speed and the first tangent vector after three forcing periods.
fn orbit(parameters: &ParameterSet, steps_per_period: u32) -> [f64; 4] {
    let motion = Motion::<f64>::new(|parameter| parameters[parameter]);
    let h = StepSize::new(|_| TAU / (parameters[Parameter::Omega0] * f64::from(steps_per_period)));
    let drive = DriveTable::new::<f64>(steps_per_period);
    let mut state = State {
        x: parameters[Parameter::X0],
        y: parameters[Parameter::Y0],
    };
    let mut bases = [Bases::start().first];
    for _ in 0..3 {
        let mut start = motion.shaft_speed(0.0);
        for &[middle, end] in drive.steps() {
            let speed = StageSpeeds {
                start,
                middle: motion.shaft_speed(middle),
                end: motion.shaft_speed(end),
            };
            assert!((speed.start - state.y).abs() > 1.0, "the friction layer is met");
            (state, bases, _) = step_with_tangent(&motion, &h, speed, state, bases);
            start = speed.end;
        }
    }
    [state.x, state.y, bases[0].x, bases[0].y]
}

/// A fast shaft keeps the sliding speed away from the layer, so that the right-hand side is smooth along the orbit.
#[test]
fn away_from_the_friction_layer_halving_the_step_divides_the_error_by_sixteen() {
    let smooth = point(&[
        (Parameter::OmegaK, 6.0),
        (Parameter::ZetaK, 2.0),
        (Parameter::Beta, 0.02),
    ]);
    let exact = orbit(&smooth, 8192);
    let error = |steps| {
        let [x, y, tangent_x, tangent_y] = orbit(&smooth, steps);
        let of_state = (x - exact[0]).hypot(y - exact[1]);
        let of_tangent = (tangent_x - exact[2]).hypot(tangent_y - exact[3]);
        [of_state, of_tangent]
    };
    let (coarse, fine) = (error(256), error(512));
    for (what, (coarse, fine)) in ["state", "tangent"].into_iter().zip(coarse.into_iter().zip(fine)) {
        let ratio = coarse / fine;
        assert!((15.0..17.0).contains(&ratio), "{what}: {coarse:e}/{fine:e} = {ratio}");
    }
}
