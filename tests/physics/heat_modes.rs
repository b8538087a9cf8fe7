//! The library's heat modes against the exact kernels and the finite volumes, for heat sources given in advance: how
//! fast pressure and surface temperature converge with the number of modes.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use rayon::prelude::*;
use tribochaos::backend::cpu::CpuBackend;
use tribochaos::experiment::{MAX_MODES, Precision, Request};
use tribochaos::measure::{Measurement, measure_batch};
use tribochaos::model::thermal_modes::ThermalModes;
use tribochaos::parameters::Parameter;

use crate::thermal_oracle::{Case, Convolution, Shaft, finite_volume, greatest, preset, relative_difference, volterra};

/// What Q(tau), linear between times kh, does to the thermal part of the pressure and to theta(1), by the exact
/// kernels.
fn driven_kernels(case: &Case, h: f64, heatings: &[f64]) -> [Vec<f64>; 2] {
    let [pressure, surface] = Convolution::both(case, h, heatings.len());
    [(2.0, pressure), (1.0, surface)].map(|(factor, kernel)| {
        (0..heatings.len())
            .map(|n| factor * case.gamma * (kernel.past(&heatings[..n]) + kernel.own(n) * heatings[n]))
            .collect()
    })
}

/// The same by finite volumes.
fn driven_shaft(case: &Case, h: f64, heatings: &[f64], rings: usize) -> [Vec<f64>; 2] {
    let mut shaft = Shaft::new(case.biot, case.omega_tilde, rings, h);
    let mut histories = [vec![0.0], vec![0.0]];
    for ends in heatings.windows(2) {
        shaft.conduct(case.gamma * f64::midpoint(ends[0], ends[1]));
        histories[0].push(2.0 * shaft.heat());
        histories[1].push(shaft.surface_temperature(case.gamma * ends[1]));
    }
    histories
}

/// The same, with theta(r), by `count` modes and the lumped one, integrated exactly; at last theta(r) with a
/// quasi-static rest instead.
fn driven_modes(case: &Case, h: f64, heatings: &[f64], count: usize, r: f64) -> [Vec<f64>; 3] {
    let modes = ThermalModes::new(case.biot, count);
    let w = case.omega_tilde;
    let weights = modes.temperature_weights(r);
    let quasi_static = (weights.lumped / modes.lumped_rate + weights.direct) / w;
    let lumped = (modes.lumped_rate * w, modes.lumped_weight, weights.lumped, 0.0);
    let each = modes.roots.iter().zip(&modes.pressure_weights).zip(&weights.modes);
    let mut histories = [(); 3].map(|()| vec![0.0; heatings.len()]);
    for (rate, c, d, d_quasi_static) in each.map(|((mu, c), d)| (mu * mu * w, *c, *d, *d)).chain([lumped]) {
        let z = rate * h;
        let phi_1 = -(-z).exp_m1() / z;
        let phi_2 = (1.0 - phi_1) / z;
        let mut q = 0.0;
        for n in 1..heatings.len() {
            q = (-z).exp() * q + h * ((phi_1 - phi_2) * heatings[n - 1] + phi_2 * heatings[n]);
            histories[0][n] += 2.0 * case.gamma * c * q;
            histories[1][n] += case.gamma * d * q;
            histories[2][n] += case.gamma * d_quasi_static * q;
        }
    }
    for (n, q) in heatings.iter().enumerate() {
        histories[1][n] += case.gamma * weights.direct / w * q;
        histories[2][n] += case.gamma * quasi_static * q;
    }
    histories
}

/// A source that lasts half a time unit.
fn pulse(h: f64) -> Vec<f64> {
    let value = |tau: f64| if tau < 0.5 { (2.0 * PI * tau).sin().powi(2) } else { 0.0 };
    (0..(2.0 / h) as usize).map(|n| value(n as f64 * h)).collect()
}

#[test]
fn finite_volumes_conduct_a_given_pulse_as_the_kernels_do() {
    let h = 2.5e-4;
    // pressure and theta(1); the latter's errors at large Bi are those of its steep start
    for (biot, tolerances) in [
        (0.01, [1e-5, 1e-4]),
        (1.0, [1e-5, 1e-4]),
        (10.0, [5e-5, 1e-4]),
        (1e3, [1e-4, 1e-3]),
    ] {
        let case = Case { biot, ..preset(3.9) };
        let exact = driven_kernels(&case, h, &pulse(h));
        let shaft = driven_shaft(&case, h, &pulse(h), 200);
        for i in [0, 1] {
            let off = relative_difference(&shaft[i], &exact[i]);
            assert!(off < tolerances[i], "{biot} {i}: {off:e}");
        }
    }
}

/// Errors of a pulse's pressure and theta(1) fall like M^-5 and faster; the bounds are about twice what is measured.
#[test]
fn heat_modes_converge_to_the_kernels() {
    let h = 1e-3;
    for (biot, bounds) in [
        (0.01, [(8, 4e-7, 6e-4), (12, 4e-8, 8e-5), (24, 5e-9, 3e-6)]),
        (1.0, [(8, 4e-5, 7e-4), (12, 5e-6, 1e-4), (24, 2e-7, 3e-6)]),
        (10.0, [(8, 8e-4, 1.4e-3), (12, 1.1e-4, 2e-4), (24, 4e-6, 6e-6)]),
        (1e3, [(8, 1.1e-2, 2e-4), (12, 3e-3, 5e-5), (24, 4e-4, 4e-6)]),
    ] {
        let case = Case { biot, ..preset(3.9) };
        let exact = driven_kernels(&case, h, &pulse(h));
        for (count, for_pressure, for_temperature) in bounds {
            let modes = driven_modes(&case, h, &pulse(h), count, 1.0);
            let off = [0, 1].map(|i| relative_difference(&modes[i], &exact[i]));
            println!("Bi {biot} M {count}: {}", off.map(|off| format!("{off:.1e}")).join(" "));
            assert!(
                off[0] < for_pressure && off[1] < for_temperature,
                "{biot} {count}: {off:?}"
            );
        }
    }
}

#[test]
fn heat_modes_give_the_temperature_within_the_shaft() {
    let h = 1e-3;
    for biot in [0.01, 10.0, 1e3] {
        let case = Case { biot, ..preset(3.9) };
        let heatings = pulse(h);
        for r in [0.0, 0.5, 0.9, 0.98] {
            let mut shaft = Shaft::new(case.biot, case.omega_tilde, 200, h);
            let conducted = heatings.windows(2).map(|ends| {
                shaft.conduct(case.gamma * f64::midpoint(ends[0], ends[1]));
                shaft.temperature(r)
            });
            let expected: Vec<_> = std::iter::once(0.0).chain(conducted).collect();
            let off = [8, 24].map(|count| {
                let [_, found, _] = driven_modes(&case, h, &heatings, count, r);
                relative_difference(&found, &expected)
            });
            println!("Bi {biot} r {r}: {:.1e} {:.1e}", off[0], off[1]);
            // at the axis, where little heat arrives at the end of the run, 4e-2 with 8 modes; with 24 modes much of
            // it is the rings' error
            assert!(off[0] < 0.06 && off[1] < 5e-4, "{biot} {r}: {off:?}");
        }
    }
}

/// The preset's heat source, up to tau = 8: the lumped mode against a quasi-static rest of theta(1).
///
/// Measured, in units of the peak, with M = 8, 12, 24: peak off by +3.7e-3, +3.8e-4, +7.1e-6, history by 4.5e-3,
/// 7.3e-4, 2.3e-5; with a quasi-static rest -1.0e-2, -4.6e-3, -6.6e-4 and 3.3e-2, 1.1e-2, 1.4e-3.
#[test]
fn the_lumped_mode_gives_the_surface_temperature_of_the_preset() {
    let h = 1e-3;
    let case = preset(3.9);
    let heatings: Vec<_> = volterra(&case, 8.0, h).samples.iter().map(|s| s.heating).collect();
    let exact = driven_kernels(&case, h, &heatings);
    for (count, for_pressure, for_peak, for_history) in
        [(8, 1e-3, 4e-3, 5e-3), (12, 2e-4, 5e-4, 1e-3), (24, 1e-5, 2e-5, 5e-5)]
    {
        let [pressure, lumped, quasi_static] = driven_modes(&case, h, &heatings, count, 1.0);
        let peak_off = |found: &[f64]| greatest(found) / greatest(&exact[1]) - 1.0;
        let histories_off = [&lumped, &quasi_static].map(|found| relative_difference(found, &exact[1]));
        println!(
            "M {count}: pressure {:.1e}, peak theta(1) {:.1e}, quasi-static {:.1e}, histories {:.1e}, {:.1e}",
            relative_difference(&pressure, &exact[0]),
            peak_off(&lumped),
            peak_off(&quasi_static),
            histories_off[0],
            histories_off[1],
        );
        assert!(relative_difference(&pressure, &exact[0]) < for_pressure);
        assert!(peak_off(&lumped).abs() < for_peak);
        assert!(histories_off[0] < for_history && 5.0 * histories_off[0] < histories_off[1]);
    }
}

/// The same with twice and four times the rings: order 2, and what heat modes make of the whole run's source.
#[test]
#[ignore = "half a minute"]
fn the_preset_s_loss_of_contact_converges() {
    let runs: Vec<_> = [(1e-4, 100), (1e-4, 200), (1e-4, 400), (5e-5, 400)]
        .into_iter()
        .map(|(h, rings)| {
            let run = finite_volume(&preset(3.9), 73.0, h, rings);
            let figures = [
                run.tau_c.unwrap(),
                run.samples.last().unwrap().wear,
                run.peak(|s| s.pressure).pressure,
                run.peak(|s| s.temperature).temperature,
            ];
            println!("{h} {rings}: {figures:.6?}");
            (run, figures)
        })
        .collect();
    for i in 0..4 {
        let [coarse, middle, fine] = [0, 1, 2].map(|run| runs[run].1[i]);
        let order = ((middle - coarse) / (fine - middle)).log2();
        let limit = fine + (fine - middle) / 3.0;
        println!("limit {limit:.6}, order {order:.2}");
        assert!((1.7..2.3).contains(&order));
    }

    // theta(1) about its peak at 69.174, the sharpest of the run: measured with M = 8, 12, 24 is +1.2e-2, +1.5e-3,
    // +3.0e-5, and -1.1e-2, -8.8e-3, -1.4e-3 with a quasi-static rest
    let h = 1e-4;
    let case = preset(3.9);
    let heatings: Vec<_> = runs[2]
        .0
        .samples
        .iter()
        .map(|s| s.heating)
        .take((69.3 / h) as usize)
        .collect();
    let [_, surface] = Convolution::both(&case, h, heatings.len());
    let from = (69.05 / h) as usize;
    let exact: Vec<_> = (from..heatings.len())
        .step_by(4)
        .map(|n| case.gamma * (surface.past(&heatings[..n]) + surface.own(n) * heatings[n]))
        .collect();
    for (count, bound) in [(8, 0.02), (12, 2e-3), (24, 1e-4)] {
        let [_, lumped, quasi_static] = driven_modes(&case, h, &heatings, count, 1.0);
        let off = [lumped, quasi_static].map(|found| greatest(&found[from..]) / greatest(&exact) - 1.0);
        println!(
            "M {count}, peak {}: off by {:.1e}, {:.1e}",
            greatest(&exact),
            off[0],
            off[1]
        );
        assert!(off[0].abs() < bound);
    }
}

/// Where friction heats and wears: gamma, k_w, biot, omega_tilde and ramp_rate by orders of magnitude, from a Halton sequence.
fn heated_box(index: u32) -> Request {
    let halton = |base: u32| {
        let (mut part, mut rest, mut value) = (1.0, index, 0.0);
        while rest > 0 {
            part /= f64::from(base);
            value += part * f64::from(rest % base);
            rest /= base;
        }
        value
    };
    let logarithmic = |base, low: f64, high: f64| low * (high / low).powf(halton(base));
    let mut request = Request::default();
    for (parameter, value) in [
        (Parameter::ZetaK, 0.5 + 7.5 * halton(2)),
        (Parameter::H1, 2.0 * halton(3)),
        (Parameter::Gamma, logarithmic(5, 0.05, 5.0)),
        (Parameter::KW, logarithmic(7, 1e-3, 0.1)),
        (Parameter::Biot, logarithmic(11, 0.1, 1e3)),
        (Parameter::OmegaTilde, logarithmic(13, 1e-3, 10.0)),
        (Parameter::RampRate, logarithmic(17, 0.1, 10.0)),
    ] {
        request.set.insert(parameter.name().to_owned(), value);
    }
    request
}

/// Relative errors of a point's peak pressure, wear, peak temperature and the time at which contact is lost, with the modes that
/// its experiment takes, against the most there are; and how many modes these are.
fn error_of_modes(index: u32) -> (u32, [f64; 4]) {
    let mut request = heated_box(index);
    request.integration.tolerance = Some(1e-7);
    request.sampling.periods = 16;
    let contact = |request: &Request| {
        let experiment = request.resolve_point().unwrap();
        let mut backend = CpuBackend::new(Precision::F64);
        let point = [experiment.design.point(0).into()];
        let go_on = &mut |_| ControlFlow::Continue(());
        let measured = measure_batch(&mut backend, &experiment.settings, &point, go_on)
            .unwrap()
            .unwrap();
        let Measurement { contact, .. } = measured[0];
        let lost = contact.lost.unwrap_or(1.0);
        let figures = [
            contact.peak_pressure,
            contact.final_wear,
            contact.peak_temperature,
            lost,
        ];
        (experiment.settings.integration.modes, figures)
    };
    let (modes, found) = contact(&request);
    request.integration.modes = Some(MAX_MODES);
    let (_, exact) = contact(&request);
    (modes, std::array::from_fn(|i| (found[i] / exact[i] - 1.0).abs()))
}

/// Measured at 200 points: pressure 9.7e-4, wear 3.6e-4, temperature 6.6e-3 and beyond 1e-3 at four points, time 8.9e-5.
#[test]
fn modes_are_as_many_as_the_parameters_take() {
    let points = 100;
    let errors: Vec<_> = (1..=points).into_par_iter().map(error_of_modes).collect();
    for (index, (modes, [pressure, wear, _, lost])) in (1..).zip(&errors) {
        assert!(
            *pressure < 1e-3 && *wear < 1e-3 && *lost < 1e-3,
            "{modes} modes miss pressure by {pressure:e}, wear by {wear:e} and time by {lost:e}: {:?}",
            heated_box(index).set
        );
    }
    let flashes = errors.iter().filter(|(_, [_, _, temperature, _])| *temperature > 1e-3);
    assert!(flashes.count() <= 5);
    // more than the usual ones, and fewer than all
    let between = errors.iter().filter(|(modes, _)| (20..50).contains(modes));
    assert!(between.count() > 20);
}
