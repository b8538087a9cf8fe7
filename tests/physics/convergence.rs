//! The manual's tables of accuracy with heat and wear, over the whole range of zeta_k and near 4, at the paper's preset. Run
//! by `cargo test --test physics convergence -- --ignored --nocapture`.

use std::ops::ControlFlow;

use tribochaos::backend::Instance;
use tribochaos::backend::cpu::CpuBackend;
use tribochaos::experiment::{Integration, Precision, Preset, Sampling, Scheme, Settings};
use tribochaos::measure::{Class, Measurement, Status, measure_batch};
use tribochaos::parameters::{Parameter, ParameterSet};

/// Ends of zeta_k: its whole range, and where chaos sets in without heat.
const WHOLE: [f64; 2] = [0.0, 12.0];
const NEAR_4: [f64; 2] = [3.5, 4.5];

/// Points over a range of zeta_k.
const POINTS: u32 = 97;

fn points([low, high]: [f64; 2], k_w: f64) -> Vec<ParameterSet> {
    let set = Preset::Paper.parameters().with(Parameter::KW, k_w);
    let value = |i| low + (high - low) * f64::from(i) / f64::from(POINTS - 1);
    (0..POINTS).map(|i| set.with(Parameter::ZetaK, value(i))).collect()
}

/// The measurements with wear over 40 periods, and without over 200 + 100.
fn measure(zeta_k: [f64; 2], precision: Precision, modes: u32, tolerance: f64) -> [Vec<Measurement>; 2] {
    let settings = Settings {
        integration: Integration {
            modes,
            tolerance,
            ..Scheme::Radau.into()
        },
        sampling: Sampling {
            transient_periods: 200,
            periods: 100,
            ..Sampling::default()
        },
    };
    let wearing = Settings {
        sampling: Sampling {
            periods: 40,
            ..settings.sampling
        },
        ..settings
    };
    [(&wearing, 0.01), (&settings, 0.0)].map(|(settings, k_w)| {
        let mut backend = CpuBackend::new(precision);
        let instances = Instance::starts(&points(zeta_k, k_w));
        measure_batch(&mut backend, settings, &instances, &mut |_| ControlFlow::Continue(()))
            .unwrap()
            .unwrap()
    })
}

/// Errors of one quantity: median, 90 % and largest.
fn quantiles(mut errors: Vec<f64>) -> String {
    errors.retain(|error| error.is_finite());
    errors.sort_unstable_by(f64::total_cmp);
    let at = |part: f64| errors[((errors.len() - 1) as f64 * part) as usize];
    format!("{:.0e} / {:.0e} / {:.0e}", at(0.5), at(0.9), at(1.0))
}

fn row(name: &str, found: &[Vec<Measurement>; 2], exact: &[Vec<Measurement>; 2]) {
    type Of = fn(&Measurement) -> f64;
    let relative: [Of; 4] = [
        |m| m.contact.lost.unwrap_or(f64::NAN),
        |m| m.contact.final_wear,
        |m| m.contact.peak_pressure,
        |m| m.contact.peak_temperature,
    ];
    print!("| {name} |");
    for of in relative {
        let pairs = found[0].iter().zip(&exact[0]);
        print!(
            " {} |",
            quantiles(pairs.map(|(m, e)| (of(m) / of(e) - 1.0).abs()).collect())
        );
    }
    let finite = found[0].iter().zip(&exact[0]);
    print!(
        " {} |",
        quantiles(finite.map(|(m, e)| (m.lyapunov - e.lyapunov).abs()).collect())
    );
    let regular = found[1].iter().zip(&exact[1]);
    let regular = regular.filter(|(_, e)| e.class == Some(Class::Regular) && e.period.is_some());
    print!(
        " {} |",
        quantiles(regular.map(|(m, e)| (m.lyapunov - e.lyapunov).abs()).collect())
    );
    let all = found.iter().flatten();
    println!(" {} |", all.filter(|m| m.status != Status::Ok).count());
}

fn head(what: &str) {
    println!(
        "| {what} | tau_c | wear | peak pressure | peak temperature | exponent of finite time | exponent, k_w = 0 | not ok |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- |");
}

#[test]
#[ignore = "it prints the manual's tables"]
fn convergence_tables() {
    head("zeta_k = 0..12");
    let measured = |precision, modes, tolerance| measure(WHOLE, precision, modes, tolerance);
    let exact = measured(Precision::F64, 12, 1e-8);
    for precision in [Precision::F64, Precision::F32] {
        for tolerance in [1e-3, 2e-4, 1e-5, 1e-6] {
            row(
                &format!("{precision:?}, tolerance {tolerance:.0e}"),
                &measured(precision, 12, tolerance),
                &exact,
            );
        }
    }
    let exact = measured(Precision::F64, 48, 1e-6);
    for modes in [4, 6, 8, 12, 16, 24] {
        row(
            &format!("{modes} modes"),
            &measured(Precision::F64, modes, 1e-6),
            &exact,
        );
    }
    head("zeta_k = 3.5..4.5");
    let measured = |precision, modes, tolerance| measure(NEAR_4, precision, modes, tolerance);
    let exact = measured(Precision::F64, 48, 1e-8);
    for precision in [Precision::F64, Precision::F32] {
        let default = Integration::default().tolerance;
        for (modes, tolerance) in [(8, 1e-3), (8, default), (12, default)] {
            let found = measured(precision, modes, tolerance);
            row(
                &format!("{precision:?}, {modes} modes, tolerance {tolerance:.0e}"),
                &found,
                &exact,
            );
        }
    }
}
