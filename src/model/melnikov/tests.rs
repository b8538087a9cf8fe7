use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::*;
use crate::design::Axis;
use crate::machine::{self, Description, SiQuantity};

struct Random(ChaCha8Rng);

impl Random {
    fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }
    fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64)
    }
}

fn point(values: &[(Parameter, f64)]) -> ParameterSet {
    values
        .iter()
        .fold(ParameterSet::default(), |set, &(p, value)| set.with(p, value))
}

/// Int_0^60 y0^j sin^k(omega t) cos^l(omega t) dt by Simpson's rule, which is no part of the library.
fn numerical(omega: f64, b: f64, [j, k, l]: [i32; 3]) -> f64 {
    const INTERVALS: u32 = 60_000;
    let h = 60.0 / f64::from(INTERVALS);
    let f = |n: u32| {
        let t = h * f64::from(n);
        let y = -(2.0 / b).sqrt() * t.sinh() / t.cosh().powi(2);
        y.powi(j) * (omega * t).sin().powi(k) * (omega * t).cos().powi(l)
    };
    let inner: f64 = (1..INTERVALS).map(|n| f(n) * if n % 2 == 1 { 4.0 } else { 2.0 }).sum();
    h / 3.0 * (f(0) + inner + f(INTERVALS))
}

#[test]
fn all_ten_integrals_are_what_they_stand_for() {
    let mut random = Random::new(1);
    for _ in 0..12 {
        let (omega, b) = (random.uniform(0.3, 4.0), random.uniform(0.2, 3.0));
        let i = Integrals::new(omega, b);
        for (closed, jkl) in [
            (i.i200, [2, 0, 0]),
            (i.i400, [4, 0, 0]),
            (i.i110, [1, 1, 0]),
            (i.i111, [1, 1, 1]),
            (i.i201, [2, 0, 1]),
            (i.i220, [2, 2, 0]),
            (i.i202, [2, 0, 2]),
            (i.i310, [3, 1, 0]),
            (i.i112, [1, 1, 2]),
            (i.i130, [1, 3, 0]),
        ] {
            let numerical = numerical(omega, b, jkl);
            assert!(
                (closed - numerical).abs() < 1e-10,
                "I{jkl:?} at omega_0 = {omega}, b = {b}: {closed} against {numerical}"
            );
        }
    }
}

#[test]
fn integrals_of_a_fast_drive_are_finite() {
    let i = Integrals::new(1000.0, 1.0);
    assert_eq!((i.i110, i.i220, i.i201), (0.0, 1.0 / 3.0, 0.0));
}

#[test]
fn closed_form_and_quadrature_agree() {
    let mut random = Random::new(2);
    let mut checked = 0;
    while checked < 40 {
        let set = point(&[
            (Parameter::ZetaK, random.uniform(0.0, 8.0)),
            (Parameter::H1, random.uniform(-0.5, 2.0)),
            (Parameter::Omega0, random.uniform(0.4, 4.0)),
            (Parameter::OmegaK, random.uniform(-2.0, 2.0)),
            (Parameter::B, random.uniform(0.3, 2.5)),
            (Parameter::F0, random.uniform(0.0, 1.0)),
            (Parameter::Alpha, random.uniform(0.0, 0.6)),
            (Parameter::Beta, random.uniform(0.0, 0.6)),
        ]);
        let m = Melnikov::new(&set).unwrap();
        let tau_0 = random.uniform(-4.0, 4.0);
        let (closed, quadrature) = (m.closed_form(tau_0), m.quadrature(tau_0));
        assert!(
            (closed - quadrature).abs() < 1e-8,
            "{set:?} at {tau_0}: {closed} against {quadrature}"
        );
        checked += 1;
    }
}

/// If |omega_k| < zeta_k, the shaft itself keeps reversing, and w has roots at all times. If |omega_k| = zeta_k, the roots become
/// tangential as the orbit comes to rest.
#[test]
fn roots_for_ever_and_tangential_ones_are_counted_rightly() {
    for (omega_k, zeta_k) in [
        (0.4, 3.9),
        (1.0, 1.0),
        (1.0, 1.0 + 1e-9),
        (-1.0, 1.0 - 1e-9),
        (0.0, 2.0),
        (0.3, 0.0),
    ] {
        let m = Melnikov::new(&point(&[(Parameter::OmegaK, omega_k), (Parameter::ZetaK, zeta_k)])).unwrap();
        for tau_0 in [0.0, 0.3, 1.7] {
            let (closed, quadrature) = (m.closed_form(tau_0), m.quadrature(tau_0));
            assert!(
                (closed - quadrature).abs() < 1e-8,
                "omega_k = {omega_k}, zeta_k = {zeta_k}: {closed} against {quadrature}"
            );
        }
    }
    let m = Melnikov::new(&point(&[])).unwrap();
    let mut crossings = Vec::new();
    roots::for_each_crossing(&m, 0.3, &mut |t, upward| crossings.push((t, upward)));
    assert!(crossings.len() > 48, "{}", crossings.len());
    assert!(
        crossings
            .windows(2)
            .all(|pair| pair[0].0 < pair[1].0 && pair[0].1 != pair[1].1)
    );
    assert!(crossings.iter().all(|&(t, _)| m.sliding(t, 0.3).abs() < 1e-12));
}

/// w has two roots that are as close as wanted. They are found down to rounding, and no root is found if w only just misses zero.
#[test]
fn narrow_pairs_of_roots_are_not_overlooked() {
    // without drive w = omega_k - y0; y0 is greatest, 1/2 for amplitude 1, at sinh t = -1
    let count = |omega_k: f64| {
        let set = point(&[
            (Parameter::OmegaK, omega_k),
            (Parameter::ZetaK, 0.0),
            (Parameter::B, 2.0),
        ]);
        let mut count = 0;
        roots::for_each_crossing(&Melnikov::new(&set).unwrap(), 0.0, &mut |_, _| count += 1);
        count
    };
    for gap in [1e-2, 1e-6, 1e-12] {
        assert_eq!((count(0.5 - gap), count(0.5 + gap)), (2, 0), "{gap}");
    }
}

#[test]
fn bounds_of_the_homoclinic_orbit_hold() {
    for k in 0..100_000 {
        let t = f64::from(k) * 1e-4;
        let sech = 1.0 / t.cosh();
        assert!(sech * (1.0 - 2.0 * sech * sech).abs() <= 1.0);
        assert!(sech * t.tanh() * (1.0 - 6.0 * sech * sech).abs() <= 1.6);
    }
}

fn extremes(zeta_k: f64, h1: f64) -> Extremes {
    Melnikov::new(&point(&[(Parameter::ZetaK, zeta_k), (Parameter::H1, h1)]))
        .unwrap()
        .extremes()
}

#[test]
fn signs_are_those_of_figure_4_1() {
    for (zeta_k, h1, changes) in [
        (3.2, 0.0, false),
        (3.81, 0.0, true),
        (3.5, 0.5, false),
        (3.9, 0.5, true),
        (3.9, 1.0, false),
        (4.2, 1.0, true),
    ] {
        assert_eq!(
            extremes(zeta_k, h1).change_sign(),
            changes,
            "zeta_k = {zeta_k}, h1 = {h1}"
        );
    }
}

#[test]
fn extremes_bound_the_function() {
    let m = Melnikov::new(&point(&[])).unwrap();
    let extremes = m.extremes();
    let values: Vec<f64> = (0..5000)
        .map(|k| m.closed_form(f64::from(k) / 5000.0 * m.period()))
        .collect();
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let greatest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    assert!(extremes.minimum <= least && least - extremes.minimum < 1e-3);
    assert!(extremes.maximum >= greatest && extremes.maximum - greatest < 1e-3);
    assert!((m.closed_form(extremes.minimum_at) - extremes.minimum).abs() < 1e-9);
}

/// The threshold along an axis from `low` to `high`.
fn find(at: ParameterSet, parameter: Parameter, low: f64, high: f64) -> Threshold {
    threshold(&at.into(), &Axis::even(parameter, low, high, 121).unwrap()).unwrap()
}

#[test]
fn thresholds_are_the_checked_ones() {
    for (h1, value) in [(0.0, 3.3047), (0.5, 3.6933), (1.0, 3.9609)] {
        let found = find(point(&[(Parameter::H1, h1)]), Parameter::ZetaK, 0.0, 12.0);
        let Threshold::Begins(found) = found else {
            panic!("h1 = {h1}: {found:?}")
        };
        assert!((found - value).abs() < 6e-5, "h1 = {h1}: {found}");
        // M touches zero there
        let touch = extremes(found, h1);
        assert!(touch.minimum.abs().min(touch.maximum.abs()) < 1e-6, "{touch:?}");
    }
}

#[test]
fn thresholds_in_other_parameters_meet_those_in_zeta_k() {
    let at = |zeta_k: f64, h1: f64| point(&[(Parameter::ZetaK, zeta_k), (Parameter::H1, h1)]);
    // damping hinders: M changes sign up to some h1
    for zeta_k in [3.6933, 3.9] {
        let found = find(at(zeta_k, 0.0), Parameter::H1, 0.0, 3.0);
        let Threshold::Ceases(h1) = found else {
            panic!("{found:?}")
        };
        let back = find(at(0.0, h1), Parameter::ZetaK, 0.0, 12.0);
        assert!((back.value().unwrap() - zeta_k).abs() < 1e-7, "{h1}: {back:?}");
    }
    assert_eq!(find(at(3.6933, 0.0), Parameter::H1, 0.0, 0.4), Threshold::Always);
    assert_eq!(find(at(3.6933, 0.0), Parameter::H1, 0.6, 1.0), Threshold::Never);
    for (parameter, low, high) in [(Parameter::Beta, 0.3, 1.0), (Parameter::OmegaK, 0.4, 2.0)] {
        let found = find(at(3.5, 0.5), parameter, low, high);
        let value = found.value().unwrap_or_else(|| panic!("{parameter}: {found:?}"));
        let back = find(at(0.0, 0.5).with(parameter, value), Parameter::ZetaK, 0.0, 12.0);
        assert!(
            (back.value().unwrap() - 3.5).abs() < 1e-7,
            "{parameter} = {value}: {back:?}"
        );
    }
}

/// If a range has at most one threshold, the function at its ends shows both sides.
#[test]
fn what_is_said_of_the_sides_of_a_threshold_is_what_the_function_does_there() {
    let at = point(&[(Parameter::ZetaK, 3.6933), (Parameter::H1, 0.0)]);
    let mut kinds = Vec::new();
    for (parameter, low, high) in [
        (Parameter::ZetaK, 3.0, 4.0),
        (Parameter::H1, 0.0, 3.0),
        (Parameter::H1, 0.0, 0.4),
        (Parameter::H1, 0.6, 1.0),
    ] {
        let found = find(at, parameter, low, high);
        let ends = [low, high].map(|value| changes_sign(&at.with(parameter, value)).unwrap());
        assert_eq!(
            found.changes_sign(),
            ends,
            "{parameter} from {low} to {high}: {found:?}"
        );
        kinds.push(std::mem::discriminant(&found));
    }
    kinds.dedup();
    assert_eq!(kinds.len(), 4);
}

/// Every quantity of a machine that changes a parameter of M has a threshold where these parameters have one.
#[test]
fn thresholds_in_quantities_of_a_machine_are_those_of_its_parameters() {
    let description = Description::from_toml(machine::TEMPLATE).unwrap();
    let cold = [(SiQuantity::WearCoefficient, 0.0), (SiQuantity::WearEnergyShare, 1.0)];
    let fixed = Fixed::new(point(&[]), Some(description.complete(&cold).unwrap()));
    let mut searched = Vec::new();
    for quantity in fixed.machine().unwrap().quantities() {
        let value = fixed.machine().unwrap().value(quantity);
        let Ok(axis) = Axis::even(quantity, 0.9 * value, 1.1 * value, 41) else {
            continue;
        };
        let found = match threshold(&fixed, &axis) {
            Ok(found) => found,
            // the latter if a part of the range has too little compression of the springs
            Err(MelnikovError::NotAParameter { .. } | MelnikovError::NoHomoclinicOrbit { .. }) => continue,
            Err(error) => panic!("{quantity}: {error}"),
        };
        searched.push(quantity);
        if let Some(value) = found.value() {
            let at = |value: f64| *fixed.at([(quantity.into(), value)]).parameters();
            let sides = [0.999, 1.001].map(|factor| changes_sign(&at(factor * value)).unwrap());
            assert_eq!(sides, found.changes_sign(), "{quantity}: {found:?}");
        }
    }
    assert!(searched.contains(&SiQuantity::ShaftSpeedAmplitude) && searched.contains(&SiQuantity::Damping));
    assert!(!searched.contains(&SiQuantity::HeatTransfer) && !searched.contains(&SiQuantity::Length));
}

#[test]
fn what_cannot_be_searched_is_refused() {
    let axis = Axis::even(Parameter::Epsilon0, 0.1, 1.0, 9).unwrap();
    let error = threshold(&point(&[]).into(), &axis).unwrap_err();
    assert!(error.to_string().contains("does not depend on epsilon_0"));
    let error = Melnikov::new(&point(&[(Parameter::B, -1.0)])).unwrap_err();
    assert!(error.to_string().contains("b > 0"));
    let error = Melnikov::new(&point(&[(Parameter::Gamma, 1.87)])).unwrap_err();
    assert!(error.to_string().contains("gamma = 0"));
}
