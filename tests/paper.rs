//! The onsets of chaos that the model's equations give, where the paper gives them: for h1 = 0, 0.5 and 1.
//!
//! An onset is the first zeta_k of an upward grid with spacing 0.0025 whose exponent over 100 measured periods, after 380
//! of transient, is above 0.005. The scans begin 0.4 below the expected onset: further down there is no chaos, but long
//! transients and quasi-periodic motion let some exponents of 100 periods stand above 0.005.

#![cfg(feature = "pictures")]

mod common;

use common::{from_state, measure, pinned_settings, point};
use tribochaos::experiment::{Integration, Precision, Sampling, Settings};
use tribochaos::parameters::{Parameter, ParameterSet};

const SPACING: f64 = 0.0025;

struct Onset {
    h1: f64,
    /// The onset is the first of all these initial states.
    states: &'static [[f64; 2]],
    /// With the friction layer resolved, to the grid's spacing.
    zeta_k: f64,
}

/// The paper gives 3.78, 3.8 and 4.25. The last is not what its equations give.
const ONSETS: [Onset; 4] = [
    Onset {
        h1: 0.0,
        states: &[[0.1, 0.0], [1.0, 0.0], [-1.0, 0.0]],
        zeta_k: 3.7775,
    },
    Onset {
        h1: 0.5,
        states: &[[1.0, 0.0], [-1.0, 0.0]],
        zeta_k: 3.8025,
    },
    Onset {
        h1: 0.5,
        states: &[[0.1, 0.0]],
        zeta_k: 3.8875,
    },
    Onset {
        h1: 1.0,
        states: &[[0.1, 0.0], [1.0, 0.0], [-1.0, 0.0]],
        zeta_k: 4.3025,
    },
];

/// Scans from 0.4 below to 0.02 above the expected onset.
fn first_chaos(onset: &Onset, precision: Precision, steps_per_period: u32) -> Option<f64> {
    let settings = Settings {
        integration: Integration {
            steps_per_period,
            renormalise_every: steps_per_period / 4,
            ..pinned_settings().integration
        },
        sampling: Sampling {
            transient_periods: 380,
            periods: 100,
            ..pinned_settings().sampling
        },
    };
    let first = ((onset.zeta_k - 0.4) / SPACING).round() as u32;
    let last = ((onset.zeta_k + 0.02) / SPACING).round() as u32;
    let scan: Vec<f64> = (first..=last).map(|n| f64::from(n) * SPACING).collect();
    let instances: Vec<ParameterSet> = scan
        .iter()
        .flat_map(|&zeta_k| {
            let p = point(&[(Parameter::ZetaK, zeta_k), (Parameter::H1, onset.h1)]);
            onset.states.iter().map(move |&state| from_state(p, state))
        })
        .collect();
    let measured = measure(precision, &settings, &instances);
    scan.into_iter()
        .zip(measured.chunks(onset.states.len()))
        .find(|(_, states)| states.iter().any(|m| m.lyapunov > 0.005))
        .map(|(zeta_k, _)| zeta_k)
}

fn assert_onsets(precision: Precision, steps_per_period: u32, tolerance: f64) {
    for onset in &ONSETS {
        let found = first_chaos(onset, precision, steps_per_period).expect("chaos begins within the scan");
        println!("h1 = {}, from {:?}: {found:.4}", onset.h1, onset.states);
        let rounding = 1e-9;
        assert!(
            (found - onset.zeta_k).abs() < tolerance + rounding,
            "h1 = {} from {:?}: {found:.4}, expected {}",
            onset.h1,
            onset.states,
            onset.zeta_k
        );
    }
}

#[test]
fn onsets_of_chaos_are_met_with_the_layer_resolved() {
    assert_onsets(Precision::F64, 4000, SPACING);
}

#[test]
fn onsets_of_chaos_are_met_with_the_paper_s_step() {
    assert_onsets(Precision::F64, 628, 0.01);
}

#[test]
fn onsets_of_chaos_are_met_with_the_paper_s_step_in_single_precision() {
    assert_onsets(Precision::F32, 628, 0.01);
}
