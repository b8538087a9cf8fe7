//! Motion with heat and without wear: its tangent maps against differences of orbits, and early decisions against long runs.

use std::ops::ControlFlow;

use nalgebra::DMatrix;
use tribochaos::backend::cpu::CpuBackend;
use tribochaos::backend::{Backend, EndState, HeatedState, Instance, Slice, Stage, Sums};
use tribochaos::dynamics::floquet::space::Monodromy;
use tribochaos::dynamics::history::history;
use tribochaos::experiment::{Integration, Precision, Preset, Sampling, Scheme, Settings};
use tribochaos::measure::{Class, Measurement, measure_batch};
use tribochaos::model::rubbing::HeatModes;
use tribochaos::model::thermal_modes::ThermalModes;
use tribochaos::parameters::{Parameter, ParameterSet};

fn heated(zeta_k: f64, gamma: f64) -> ParameterSet {
    let paper = Preset::Paper.parameters().with(Parameter::KW, 0.0);
    paper.with(Parameter::ZetaK, zeta_k).with(Parameter::Gamma, gamma)
}

fn settings(tolerance: f64, modes: u32) -> Settings {
    Settings {
        integration: Integration {
            tolerance,
            modes,
            ..Scheme::Radau.into()
        },
        ..Settings::from(Scheme::Radau)
    }
}

/// The instance after some periods of a stage, and their sums.
fn after(settings: &Settings, instance: &Instance, stage: Stage, periods: u32) -> (EndState, Sums) {
    let settings = Settings {
        sampling: Sampling {
            periods: periods.max(16),
            ..settings.sampling
        },
        ..*settings
    };
    let mut backend = CpuBackend::new(Precision::F64);
    backend.load(&settings, std::slice::from_ref(instance)).unwrap();
    backend
        .advance(&Slice {
            stage,
            first: 0,
            periods,
            elapsed: 0,
        })
        .unwrap();
    (backend.end_states().unwrap().remove(0), backend.collect().unwrap()[0])
}

/// The state (x, y, pressures of the heat modes).
fn state(end: &EndState) -> Vec<f64> {
    let heated = end.heated.as_ref().expect("heat stays");
    [end.x, end.y]
        .into_iter()
        .chain(heated.pressures.iter().copied())
        .collect()
}

/// The instance with `state`, and with a tangent vector along each axis.
fn at(instance: &Instance, state: &[f64]) -> Instance {
    let heated = instance.heated.as_deref().expect("heat stays");
    Instance {
        state: [state[0], state[1]],
        heated: Some(Box::new(HeatedState {
            pressures: state[2..].to_vec(),
            vectors: DMatrix::identity(state.len(), state.len()),
            ..heated.clone()
        })),
        ..instance.clone()
    }
}

/// The tangent map of one period at the end of a run.
fn tangent_map(settings: &Settings, from: &Instance, end: &EndState) -> DMatrix<f64> {
    let (linearised, _) = after(settings, &at(&from.at(end), &state(end)), Stage::Linearise, 1);
    linearised.heated.expect("heat stays").vectors
}

#[test]
fn the_tangent_map_of_the_full_state_is_the_derivative_of_its_stroboscopic_map() {
    let settings = settings(1e-9, 3);
    for (zeta_k, gamma) in [(3.9, 1.87), (3.5, 0.05), (4.4, 0.003)] {
        let start = Instance::from(heated(zeta_k, gamma));
        let (end, _) = after(&settings, &start, Stage::Transient, 5);
        let map = tangent_map(&settings, &start, &end);
        let from = state(&end);
        for axis in 0..from.len() {
            let shifted = |by: f64| {
                let mut shifted = from.clone();
                shifted[axis] += by;
                state(&after(&settings, &at(&start.at(&end), &shifted), Stage::Transient, 1).0)
            };
            let step = 1e-4;
            let (above, below) = (shifted(step), shifted(-step));
            for row in 0..from.len() {
                let difference = (above[row] - below[row]) / (2.0 * step);
                let (found, scale) = (map[(row, axis)], map.amax());
                assert!(
                    (found - difference).abs() < 1e-4 * scale,
                    "{zeta_k} {gamma}: d{row}/d{axis} is {found}, not {difference}"
                );
            }
        }
    }
}

/// The logarithm of a volume in the full state changes by the integral of the divergence, -eps p F'(v) - eps h1 - sum r_m + F(v) v sum
/// w_m. Here a quadrature along the orbit gives it.
#[test]
fn volumes_of_the_full_state_shrink_as_its_divergence_says() {
    let settings = settings(1e-9, 1);
    for (zeta_k, gamma) in [(3.9, 0.3), (3.2, 0.01)] {
        let set = heated(zeta_k, gamma);
        let start = Instance::from(set);
        let (end, _) = after(&settings, &start, Stage::Transient, 8);
        let found = tangent_map(&settings, &start, &end).determinant().ln();

        let samples = 20_000;
        let modes = HeatModes::new(&set, &ThermalModes::new(set[Parameter::Biot], 1));
        let run = history(&set, &settings.integration, 8..9, samples);
        let friction = |v: f64| {
            let (f_0, alpha, beta) = (set[Parameter::F0], set[Parameter::Alpha], set[Parameter::Beta]);
            let part = v / set[Parameter::Epsilon0];
            let [sign, slope] = if part.abs() < 1.0 {
                [
                    part * (2.0 - part.abs()),
                    2.0 * (1.0 - part.abs()) / set[Parameter::Epsilon0],
                ]
            } else {
                [part.signum(), 0.0]
            };
            let cubic = v * (beta * v * v - alpha);
            [f_0 * sign + cubic, f_0 * slope - alpha + 3.0 * beta * v * v]
        };
        let rates: Vec<f64> = run
            .samples
            .iter()
            .map(|sample| {
                let [value, slope] = friction(sample.v);
                let heat = value * sample.v * modes.weights.iter().sum::<f64>() - modes.rates.iter().sum::<f64>();
                heat - set[Parameter::Epsilon] * (sample.pressure * slope + set[Parameter::H1])
            })
            .collect();
        let ends = 0.5 * (rates[0] + rates[rates.len() - 1]);
        let expected = (rates.iter().sum::<f64>() - ends) * set.forcing_period() / f64::from(samples);
        assert!(
            (found - expected).abs() < 1e-3 * expected.abs(),
            "{found}, not {expected}"
        );
    }
}

#[test]
fn two_vectors_grow_along_a_cycle_by_its_multipliers() {
    let settings = settings(1e-6, 4);
    let set = heated(3.9, 1.87);
    let start = Instance::from(set);
    let (settled, _) = after(&settings, &start, Stage::Align, 60);
    let on_cycle = start.at(&settled);
    assert_eq!(on_cycle.heated.as_ref().unwrap().vectors.ncols(), 2);
    let (_, sums) = after(&settings, &on_cycle, Stage::Measure, 64);
    let multipliers = Monodromy::new(vec![tangent_map(&settings, &start, &settled)])
        .multipliers()
        .unwrap();
    for i in 0..2 {
        let (found, expected) = (sums.growth[i] / 64.0, multipliers.log_moduli[i]);
        assert!((found - expected).abs() < 2e-4, "{i}: {found}, not {expected}");
    }
}

#[test]
fn a_heated_run_that_is_taken_up_again_goes_on_as_if_it_had_not_been_interrupted() {
    for (precision, close) in [(Precision::F64, 1e-7), (Precision::F32, 2e-3)] {
        let settings = settings(1e-7, 8);
        let points = [heated(3.9, 1.87), heated(3.5, 0.05), heated(3.2, 0.002)];
        let mut backend = CpuBackend::new(precision);
        let mut advance = |instances: Option<Vec<Instance>>, stage| {
            if let Some(instances) = instances {
                backend.load(&settings, &instances).unwrap();
            }
            backend
                .advance(&Slice {
                    stage,
                    first: 0,
                    periods: 20,
                    elapsed: 0,
                })
                .unwrap();
            (backend.end_states().unwrap(), backend.collect().unwrap())
        };
        let starts = Instance::starts(&points);
        let (middle, _) = advance(Some(starts.clone()), Stage::Align);
        let (expected, expected_sums) = advance(None, Stage::Measure);
        let again = starts.iter().zip(&middle).map(|(start, end)| start.at(end)).collect();
        let (found, sums) = advance(Some(again), Stage::Measure);
        for i in 0..points.len() {
            for (a, b) in state(&found[i]).iter().zip(state(&expected[i])) {
                assert!(
                    (a - b).abs() < close * (1.0 + b.abs()),
                    "{precision:?} {i}: {a}, not {b}"
                );
            }
            let [found, expected] = [&found[i], &expected[i]].map(|end| end.heated.as_ref().unwrap());
            assert_eq!((found.periods, found.is_in_contact), (40.0, expected.is_in_contact));
            let peaks = |heated: &HeatedState| [heated.contact.peak_pressure, heated.contact.peak_temperature];
            for (a, b) in peaks(found).into_iter().zip(peaks(expected)) {
                assert!((a - b).abs() < close * (1.0 + b.abs()), "{a}, not {b}");
            }
            for n in 0..2 {
                let (a, b) = (sums[i].growth[n], expected_sums[i].growth[n]);
                assert!(
                    (a - b).abs() < 100.0 * close * (1.0 + b.abs()),
                    "{precision:?} {i} {n}: {a}, not {b}"
                );
            }
        }
    }
}

fn measured(sampling: Sampling, points: &[ParameterSet]) -> Vec<Measurement> {
    let settings = Settings {
        sampling,
        ..Settings::from(Scheme::Radau)
    };
    let mut backend = CpuBackend::new(Precision::F64);
    let instances = Instance::starts(points);
    measure_batch(&mut backend, &settings, &instances, &mut |_| ControlFlow::Continue(()))
        .unwrap()
        .unwrap()
}

/// A run at four times the usual length.
fn long() -> Sampling {
    Sampling {
        transient_periods: 1200,
        periods: 1000,
        decide_early: false,
        ..Sampling::default()
    }
}

fn grid(zeta_k: &[f64], gamma: &[f64]) -> Vec<ParameterSet> {
    gamma
        .iter()
        .flat_map(|&gamma| zeta_k.iter().map(move |&zeta_k| heated(zeta_k, gamma)))
        .collect()
}

/// Asserts that what was decided early agrees with long runs; returns the share of the full length that the runs took.
fn assert_agreement(early: &[Measurement], long: &[Measurement]) -> f64 {
    let full = Sampling::default().transient_periods + Sampling::default().periods;
    for (e, l) in early.iter().zip(long) {
        if e.integrated_periods >= full {
            continue;
        }
        assert_eq!(e.class, l.class, "{e:?}\n{l:?}");
        let error = e.lyapunov_error.hypot(l.lyapunov_error);
        assert!((e.lyapunov - l.lyapunov).abs() < 3.0 * error + 1e-6, "{e:?}\n{l:?}");
        if e.class == Some(Class::Regular) {
            assert!(
                e.lyapunov_second <= e.lyapunov && e.lyapunov_second_error.is_finite(),
                "{e:?}"
            );
            let peaks = [e, l].map(|m| m.contact.peak_pressure);
            assert!((peaks[0] / peaks[1] - 1.0).abs() < 0.02, "{e:?}\n{l:?}");
            let ranges = [e, l].map(|m| [m.x_min, m.x_max]);
            assert!(
                (0..2).all(|i| (ranges[0][i] - ranges[1][i]).abs() < 1e-2),
                "{e:?}\n{l:?}"
            );
        }
    }
    let periods: u32 = early.iter().map(|m| m.integrated_periods).sum();
    f64::from(periods) / (f64::from(full) * early.len() as f64)
}

#[test]
fn heated_points_that_are_decided_early_agree_with_runs_four_times_as_long() {
    let zeta_k: Vec<f64> = (0..13).map(|i| 3.02 + 0.24 * f64::from(i)).collect();
    let points = grid(&zeta_k, &[0.001, 0.004, 0.02, 0.06, 0.4, 1.87]);
    let (early, long) = (measured(Sampling::default(), &points), measured(long(), &points));
    let share = assert_agreement(&early, &long);
    assert!(share < 0.15, "{share}");
    let same = early.iter().zip(&long).filter(|(e, l)| e.period == l.period).count();
    assert!(same + 2 >= points.len(), "{same} of {}", points.len());
}

/// The shaft takes a hundred times longer to warm up than a leg of the run takes.
#[test]
fn a_cycle_is_measured_with_the_steady_heat_of_the_shaft_also_if_that_is_far_ahead() {
    let slow = |zeta_k, gamma| heated(zeta_k, gamma).with(Parameter::OmegaTilde, 0.002);
    let points = [slow(3.2, 0.002), slow(3.2, 0.02), slow(5.0, 0.02), slow(3.6, 0.1)];
    let early = measured(Sampling::default(), &points);
    let long = measured(
        Sampling {
            transient_periods: 4000,
            ..long()
        },
        &points,
    );
    assert!(assert_agreement(&early, &long) < 0.5);
    assert!(
        early.iter().filter(|m| m.class == Some(Class::Regular)).count() >= 3,
        "{early:?}"
    );
}

/// While the fit grows, the bush may repeat its motion, but that is no cycle.
#[test]
fn nothing_is_decided_before_the_ramp_of_the_fit_has_ended() {
    let ramped = heated(3.2, 0.01).with(Parameter::RampRate, 1e-4);
    let measured = measured(Sampling::default(), &[heated(3.2, 0.01), ramped]);
    let [at_once, ramped] = &measured[..] else {
        panic!("two points were asked for")
    };
    // the exponent of the fit's exponential is 37 after 608 tau
    assert!(
        at_once.integrated_periods < 40 && ramped.integrated_periods > 190,
        "{measured:?}"
    );
    assert_eq!((at_once.class, at_once.period), (ramped.class, ramped.period));
    assert!((at_once.lyapunov - ramped.lyapunov).abs() < 1e-4, "{measured:?}");
}

/// A motion may be chaotic while the shaft is cold, and regular once it is warm. The heat of these points is too small to change
/// their motion: `slow` differs from `at_once` only by the time in which the shaft warms up.
#[test]
fn chaos_is_not_decided_before_the_shaft_is_warm() {
    let chaotic = [4.2, 4.25, 4.3].map(|zeta_k| heated(zeta_k, 1e-5));
    let slow = chaotic.map(|set| set.with(Parameter::OmegaTilde, 0.005));
    let full = Sampling::default().transient_periods + Sampling::default().periods;
    let at_once = measured(Sampling::default(), &chaotic);
    let slow = measured(Sampling::default(), &slow);
    for m in at_once.iter().chain(&slow) {
        assert_eq!(m.class, Some(Class::Chaotic));
        assert!(m.lyapunov_second < m.lyapunov && m.lyapunov_second_error > 0.0, "{m:?}");
    }
    let early = |m: &Measurement| m.integrated_periods < full;
    assert!(at_once.iter().any(early), "{at_once:?}");
    assert!(!slow.iter().any(early), "{slow:?}");
}

#[test]
fn states_that_a_heated_motion_cannot_go_on_from_are_refused() {
    let settings = settings(1e-4, 8);
    let start = Instance::from(heated(3.9, 1.87));
    let (end, _) = after(&settings, &start, Stage::Align, 2);
    let goes_on = start.at(&end);
    let mut backend = CpuBackend::new(Precision::F64);
    let mut said = Vec::new();
    let mut is_taken = |instance: &Instance, modes| {
        let loaded = backend.load(&self::settings(1e-4, modes), std::slice::from_ref(instance));
        loaded.map_err(|error| said.push(error.to_string())).is_ok()
    };
    assert!(is_taken(&goes_on, 8) && !is_taken(&goes_on, 9));
    let changed = |change: &dyn Fn(&mut Instance)| {
        let mut changed = goes_on.clone();
        change(&mut changed);
        changed
    };
    assert!(!is_taken(
        &changed(&|instance| instance.parameters[Parameter::KW] = 0.1),
        8
    ));
    let vectors =
        |vectors: DMatrix<f64>| changed(&|instance| instance.heated.as_mut().unwrap().vectors = vectors.clone());
    assert!(!is_taken(&vectors(DMatrix::zeros(11, 0)), 8) && !is_taken(&vectors(DMatrix::zeros(10, 2)), 8));
    assert!(is_taken(&vectors(DMatrix::identity(11, 11)), 8));
    let number = "with the number of heat modes with which it began";
    for (said, expected) in said
        .iter()
        .zip([number, "without wear goes on with heat modes", number, number])
    {
        assert!(said.contains(expected), "{said}");
    }
    assert_eq!(said.len(), 4);
}

/// A heat so small that f32 knows none of it changes nothing, and is no error.
#[test]
fn heat_below_the_smallest_number_of_a_lane_is_none() {
    for precision in [Precision::F64, Precision::F32] {
        let settings = Settings::from(Scheme::Radau);
        let points = [heated(3.2, 1e-50), heated(3.2, 0.01), heated(4.4, 1e-50)];
        let mut backend = CpuBackend::new(precision);
        let measured = measure_batch(&mut backend, &settings, &Instance::starts(&points), &mut |_| {
            ControlFlow::Continue(())
        });
        let measured = measured.unwrap().unwrap();
        assert_eq!(measured[0].class, Some(Class::Regular));
        assert_eq!(measured[2].class, Some(Class::Chaotic));
    }
}

/// Lanes work side by side, and each has its own clock and its own steps.
#[test]
fn a_heated_point_does_not_depend_on_its_neighbours() {
    let points = grid(&[3.1, 3.7, 4.3, 4.9, 5.6], &[0.002, 0.05, 1.87]);
    let sampling = Sampling {
        transient_periods: 60,
        periods: 32,
        ..Sampling::default()
    };
    for precision in [Precision::F64, Precision::F32] {
        for decide_early in [true, false] {
            let settings = Settings {
                sampling: Sampling {
                    decide_early,
                    ..sampling
                },
                ..Settings::from(Scheme::Radau)
            };
            let mut backend = CpuBackend::new(precision);
            let mut text = |points: &[ParameterSet]| -> Vec<String> {
                let instances = Instance::starts(points);
                let measured = measure_batch(&mut backend, &settings, &instances, &mut |_| ControlFlow::Continue(()));
                measured.unwrap().unwrap().iter().map(|m| format!("{m:?}")).collect()
            };
            let together = text(&points);
            let apart: Vec<String> = points.iter().flat_map(|&point| text(&[point])).collect();
            assert_eq!(together, apart, "{precision:?}");
        }
    }
}
