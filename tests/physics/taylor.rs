//! The Taylor scheme against the reference integrator, and its tangent recurrences against dual numbers.

use tribochaos::backend::cpu::{CpuBackend, InstructionSet};
use tribochaos::backend::{Backend, BackendKind, EndState, Slice, Stage};
use tribochaos::dynamics::reference::{Reference, ReferenceOrbit};
use tribochaos::dynamics::tangent::Vector;
use tribochaos::dynamics::taylor::series::{Local, Series};
use tribochaos::dynamics::taylor::{COEFFICIENTS, Flow, MISSED, step, unit_of_time};
use tribochaos::experiment::{Integration, Precision, Scheme, Settings};
use tribochaos::lanes::LONG_PERIOD_TICKS;
use tribochaos::measure::Status;
use tribochaos::parameters::{Parameter, ParameterSet};
use tribochaos::studies::benchmark::{self, accuracy::References};

use crate::common::{PRECISIONS, Random, measure, pinned_settings, point};
use crate::dual::Dual;

fn settings(steps_per_period: Option<u32>) -> Settings {
    let default = Integration::from(Scheme::Taylor);
    Settings {
        integration: Integration {
            steps_per_period: steps_per_period.unwrap_or(default.steps_per_period),
            ..default
        },
        ..pinned_settings()
    }
}

#[test]
fn exponents_are_within_the_stated_errors_on_every_instruction_set() {
    let references = References::compute(&benchmark::points(9).expect("the grid is valid"));
    assert!(references.len() > 350, "{} points tell", references.len());
    for instructions in InstructionSet::available() {
        for (precision, median, most) in [(Precision::F64, 1e-7, 2e-5), (Precision::F32, 1e-6, 1e-4)] {
            let mut backend = CpuBackend::with_instructions(precision, instructions);
            let errors = references.errors(&mut backend, &settings(None)).unwrap();
            let found = (errors.median(), errors.quantile(0.99));
            println!("{} {precision:?}: {found:?}", instructions.name());
            assert!(
                found.0 < median && found.1 < most,
                "{instructions:?} {precision:?}: {found:?}"
            );
        }
    }
}

/// x, y and the growth of the first vector over some periods, by the scheme and by the reference.
fn both(p: &ParameterSet, settings: &Settings, periods: u32) -> ([f64; 3], [f64; 3], EndState, Reference) {
    let mut backend = CpuBackend::new(Precision::F64);
    backend.load(settings, &[(*p).into()]).unwrap();
    let slice = Slice {
        stage: Stage::Measure,
        first: 0,
        periods,
        elapsed: 0,
    };
    backend.advance(&slice).unwrap();
    let (end, sums) = (backend.end_states().unwrap().remove(0), backend.collect().unwrap()[0]);
    let mut orbit = ReferenceOrbit::new(p);
    (0..periods).for_each(|_| orbit.period());
    let r = *orbit.state();
    ([end.x, end.y, sums.growth[0]], [r.x, r.y, r.growth], end, r)
}

/// A fast shaft keeps the sliding speed away from the layer: nothing but the series' order is seen.
#[test]
fn between_events_the_scheme_has_its_order() {
    let smooth = point(&[
        (Parameter::OmegaK, 6.0),
        (Parameter::ZetaK, 2.0),
        (Parameter::Beta, 0.02),
    ]);
    let error = |steps| {
        let (found, exact, ..) = both(&smooth, &settings(Some(steps)), 3);
        (0..3).map(|i| (found[i] - exact[i]).abs()).fold(0.0, f64::max)
    };
    let (coarse, fine) = (error(16), error(32));
    let ratio = coarse / fine;
    assert!((128.0..1024.0).contains(&ratio), "{coarse:e}/{fine:e} = {ratio}");
}

#[test]
fn extremes_of_the_angle_are_found_between_steps() {
    for (zeta_k, h1) in [(1.0, 0.5), (3.5, 0.5), (8.0, 1.0), (12.0, 0.7)] {
        let p = point(&[(Parameter::ZetaK, zeta_k), (Parameter::H1, h1)]);
        let (_, _, end, reference) = both(&p, &settings(None), 5);
        let error = (end.x_min - reference.x_min)
            .abs()
            .max((end.x_max - reference.x_max).abs());
        assert!(error < 2e-4, "zeta_k = {zeta_k}: {error:e}");
    }
}

/// Slow shafts, strong friction, thin layers: the bush sticks for much of the period, where the layer's rate is up to 30
/// times what a step of a 28th of a period could follow. Without the bound [`LAYER_STEP`] over that rate the motion comes
/// out wrong here.
///
/// [`LAYER_STEP`]: tribochaos::dynamics::taylor::LAYER_STEP
#[test]
fn sticking_is_resolved() {
    for (zeta_k, f_0, epsilon_0) in [
        (0.5, 1.0, 0.005),
        (1.0, 2.0, 0.005),
        (0.3, 3.0, 0.01),
        (2.0, 1.0, 0.001),
    ] {
        let p = point(&[
            (Parameter::ZetaK, zeta_k),
            (Parameter::F0, f_0),
            (Parameter::Epsilon0, epsilon_0),
            (Parameter::OmegaK, 0.1),
        ]);
        let (found, exact, end, _) = both(&p, &settings(None), 5);
        assert!(!end.under_resolved);
        let state = (found[0] - exact[0]).abs().max((found[1] - exact[1]).abs());
        // v rests at the boundary v = 0, where a crossing by less than the tolerance is not seen
        let exponent = (found[2] - exact[2]).abs() / (5.0 * std::f64::consts::PI);
        assert!(
            state < 1e-5 && exponent < 1e-4,
            "zeta_k = {zeta_k}, f_0 = {f_0}: {found:?}, reference {exact:?}"
        );
    }
}

/// v falls, turns behind the boundary of a thin layer, and rises again, all within a step that shows it outside at its start, its
/// middle and its end: x'' = x - x^3 from just before the bottom of the well, at the shaft's speed.
#[test]
fn a_dip_into_a_thin_layer_ends_a_step_at_its_boundary() {
    let epsilon_0 = 1e-3;
    let p = point(&[
        (Parameter::ZetaK, 0.0),
        (Parameter::OmegaK, 1.0),
        (Parameter::H1, 0.0),
        (Parameter::F0, 1e-3),
        (Parameter::Alpha, 0.0),
        (Parameter::Beta, 0.0),
        (Parameter::Epsilon0, epsilon_0),
    ]);
    let unit = unit_of_time(p[Parameter::Omega0]);
    let flow = Flow::<f64>::of(&p, 28);
    // by the linear motion v falls by 4e-4 within 0.02, and is back after 0.04; a step takes 0.11
    let state = flow.start(0.98, (1.0 - 1.2 * epsilon_0) * unit, LONG_PERIOD_TICKS);
    assert_eq!(state.piece, 3.0);
    let (step, end) = step::<f64, COEFFICIENTS, true>(&flow, &state);
    let found = step.series.v_at(step.s) / unit;
    assert!((found - epsilon_0).abs() < MISSED * epsilon_0, "{found}");
    assert!(
        step.s * unit < 0.02 && end.piece == 2.0,
        "after {} on piece {}",
        step.s * unit,
        end.piece
    );
}

/// In f32 v comes to the layer's boundary, is rounded to just beyond it, goes on away from it, and turns: of the two crossings
/// ahead the one at the start is none. A search that took it stepped by the least step until v had turned.
#[test]
fn a_turn_behind_the_boundary_is_no_crossing() {
    let turns = point(&[
        (Parameter::ZetaK, 0.075_471_698_113_207_54),
        (Parameter::H1, 0.360_504_201_680_672_26),
    ]);
    for precision in PRECISIONS {
        let measured = measure(precision, &settings(None), &[turns]);
        assert_eq!(measured[0].status, Status::Ok, "{precision:?}");
    }
}

#[test]
fn what_is_too_stiff_is_left_to_radau() {
    let stiff = point(&[
        (Parameter::ZetaK, 0.2),
        (Parameter::F0, 1000.0),
        (Parameter::Epsilon0, 1e-3),
        (Parameter::OmegaK, 0.0),
    ]);
    let regular = point(&[(Parameter::ZetaK, 3.5)]);
    for precision in PRECISIONS {
        let measured = measure(precision, &settings(None), &[regular, stiff, regular]);
        assert_eq!(measured[1].backend, BackendKind::CpuF64, "{precision:?}");
        assert_eq!(measured[1].status, Status::Ok, "{precision:?}: {:?}", measured[1]);
        for m in [measured[0], measured[2]] {
            assert!(m.status == Status::Ok, "{m:?}");
        }
    }
}

#[test]
fn vectors_are_the_derivative_of_the_series() {
    fn local<R: tribochaos::lanes::Real>(c: &[f64; 9], x: R, w: R, shaft: f64) -> Local<R> {
        let [linear, minus_b, minus_damping, a_0, a_1, a_2, cubic, drive, drive_slope] = c.map(R::splat);
        Local {
            linear,
            minus_b,
            minus_damping,
            a_0,
            a_1,
            a_2,
            cubic,
            drive,
            drive_slope,
            x,
            w,
            v: R::splat(shaft) - w,
        }
    }

    let mut random = Random::new(11);
    for _ in 0..1000 {
        let mut parameter = |low, high| random.uniform(low, high);
        let constants = [
            parameter(0.005, 0.02),
            parameter(-0.02, 0.02),
            parameter(-0.02, 0.02),
            parameter(-0.01, 0.01),
            parameter(-0.3, 0.3),
            parameter(-1.0, 1.0),
            parameter(-1.0, 1.0),
            parameter(-1.0, 1.0),
            parameter(-1.0, 1.0),
        ];
        let (x, w, s) = (parameter(-1.5, 1.5), parameter(-0.3, 0.3), parameter(0.1, 1.1));
        let shaft = parameter(-0.3, 0.3);
        let start = Vector {
            x: parameter(-1.0, 1.0),
            y: parameter(-1.0, 1.0),
        };
        let series = Series::<f64, 9>::new(&local(&constants, x, w, shaft));
        let end = series.vector_at(start, s);
        let dual = |value, slope| Dual {
            value,
            derivatives: [slope, 0.0],
        };
        let along = Series::<Dual, 9>::new(&local(&constants, dual(x, start.x), dual(w, start.y), shaft));
        let (x_end, w_end) = (along.x_at(dual(s, 0.0)), along.w_at(dual(s, 0.0)));
        for (value, expected) in [(end.x, x_end.derivatives[0]), (end.y, w_end.derivatives[0])] {
            assert!(
                (value - expected).abs() < 1e-12 * (1.0 + expected.abs()),
                "{value} {expected}"
            );
        }
        assert!((series.x_at(s) - x_end.value).abs() < 1e-12);
    }
}
