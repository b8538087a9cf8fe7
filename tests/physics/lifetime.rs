//! How long chaos lasts: where it is transient, where it lasts, and where there is none.

use std::ops::ControlFlow;

use tribochaos::analysis::lifetime::{Decay, Fit, Survival, exponent};
use tribochaos::analysis::settling::{End, Fate, follow};
use tribochaos::backend::cpu::CpuBackend;
use tribochaos::engine::initial_states;
use tribochaos::experiment::{Precision, Sampling, Settings};
use tribochaos::parameters::{Parameter, ParameterSet};

const STATES: u32 = 400;

fn fates(zeta_k: f64, h1: f64, seed: u32, longest: u32) -> Vec<Fate> {
    let at = ParameterSet::default()
        .with(Parameter::ZetaK, zeta_k)
        .with(Parameter::H1, h1);
    fates_of(&at, seed, longest)
}

fn fates_of(at: &ParameterSet, seed: u32, longest: u32) -> Vec<Fate> {
    let settings = Settings {
        sampling: Sampling {
            seed,
            initial_states: STATES + 1,
            ..Sampling::default()
        },
        ..Settings::default()
    };
    let starts = initial_states::offsets(&settings.sampling);
    let backend = &mut CpuBackend::new(Precision::F64);
    follow(backend, &settings, at, &starts, longest, &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap()
    .unwrap()
}

#[track_caller]
fn fit(fates: &[Fate], longest: u32) -> Fit {
    match Survival::of(fates, longest).decay() {
        Decay::Exponential(fit) => fit,
        other => panic!("{other:?}"),
    }
}

/// Within the window of period 3, beyond the crisis in which the chaotic attractor of its edge has ended.
#[test]
fn transient_chaos_has_a_lifetime_that_no_choice_moves() {
    let of = |seed: u32, longest: u32| fit(&fates(4.67, 0.28, seed, longest), longest);
    let first = of(1, 2000);
    assert!(
        first.escapes > 250 && (140.0..200.0).contains(&first.lifetime),
        "{first:?}"
    );
    // other states, and a time by which half of the states have not settled
    for (seed, longest) in [(2, 2000), (3, 120)] {
        let other = of(seed, longest);
        let difference = (other.lifetime - first.lifetime).abs();
        assert!(difference < 3.0 * other.error.hypot(first.error), "{first:?} {other:?}");
    }
    assert!(of(3, 120).escapes < STATES as usize * 3 / 5);
    let [rate, error] = exponent(&fates(4.67, 0.28, 1, 2000), first.start).unwrap();
    assert!(rate > 0.2 && error < 0.05 * rate, "{rate} +- {error} a period");
}

#[test]
fn no_state_escapes_from_a_chaotic_attractor() {
    let fates = fates(3.9, 0.5, 1, 1000);
    let decay = Survival::of(&fates, 1000).decay();
    let Decay::Lasting {
        start,
        left,
        least_lifetime,
    } = decay
    else {
        panic!("{decay:?}")
    };
    // a fifth of the box is the basin of a cycle
    assert!(start < 50 && (280..360).contains(&left), "{decay:?}");
    assert_eq!(least_lifetime, left as f64 * f64::from(1000 - start) / 3.0);
}

#[test]
fn cycles_and_tori_are_reached_without_chaos() {
    for (zeta_k, h1) in [(3.5, 0.5), (0.5, 0.5), (0.15, 0.07)] {
        let fates = fates(zeta_k, h1, 1, 1000);
        assert!(fates.iter().all(|fate| fate.end != End::Lasting), "{zeta_k} {h1}");
        let survival = Survival::of(&fates, 1000);
        let is_chaotic = exponent(&fates, survival.decay().start()).is_some_and(|[rate, error]| rate > 3.0 * error);
        assert!(!is_chaotic, "{zeta_k} {h1}");
    }
}

/// Taylor gives such orbits up on their way out, against friction that grows with the speed.
#[test]
fn running_away_is_an_end() {
    let at = ParameterSet::default().with(Parameter::B, -0.1);
    let fates = fates_of(&at, 1, 100);
    assert!(
        fates.iter().all(|fate| matches!(fate.end, End::Settled(1..=20))),
        "{fates:?}"
    );
}
