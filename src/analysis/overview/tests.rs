//! Overviews of results that are known: functions with published indices, and regions with known shares.

use std::f64::consts::PI;

use super::*;
use crate::design::{Axis, Points, Sample, Side};
use crate::experiment::{Experiment, Request};

/// Results whose exponent is a function of the values of the coordinates, chaotic where it is positive.
fn results(experiment: Experiment, exponent: &dyn Fn(&[f64]) -> f64) -> Results {
    let mut results = Results::of(experiment, &[Quantity::Lyapunov, Quantity::Class, Quantity::Status]);
    for index in 0..results.experiment.design.len() {
        let values = results.experiment.design.varied.values(index);
        let values: Vec<f64> = values.into_iter().map(|(_, value)| value).collect();
        let exponent = exponent(&values);
        let class = if exponent > 0.0 { Class::Chaotic } else { Class::Regular };
        results.set_value(Quantity::Lyapunov, index, exponent);
        results.set_value(Quantity::Class, index, f64::from(class as u8));
        results.set_value(Quantity::Status, index, 0.0);
    }
    results
}

fn over_axes(texts: &[&str]) -> Experiment {
    let axes = texts.iter().map(|text| Axis::parse(text).unwrap()).collect();
    Request::over(axes).resolve().unwrap()
}

fn over_sample(plan: &str, texts: &[&str]) -> Experiment {
    let sides = texts.iter().map(|text| Side::parse(text).unwrap()).collect();
    let request = Request {
        points: Some(Points::from(Sample::new(plan.parse().unwrap(), sides).unwrap())),
        ..Request::default()
    };
    request.resolve().unwrap()
}

/// Ishigami and Homma (1990), with a = 7 and b = 0.1; the coordinates run from 0 to 2.
fn ishigami(values: &[f64]) -> f64 {
    let [one, two, three] = [0, 1, 2].map(|axis| PI * (values[axis] - 1.0));
    one.sin() + 7.0 * two.sin().powi(2) + 0.1 * three.powi(4) * one.sin()
}

const FIRST: [f64; 3] = [0.3139, 0.4424, 0.0];
const TOTAL: [f64; 3] = [0.5576, 0.4424, 0.2437];

#[test]
fn indices_over_a_product_are_the_published_ones() {
    // middles of equal intervals, so that sums are close to integrals
    let axes = ["h1=0.025:1.975:40", "alpha=0.025:1.975:40", "beta=0.025:1.975:40"];
    let results = results(over_axes(&axes), &ishigami);
    let indices = Overview::new(&results).sensitivity_of(Quantity::Lyapunov).unwrap();
    for (axis, found) in indices.iter().enumerate() {
        assert!((found.first - FIRST[axis]).abs() < 2e-3, "{indices:?}");
        assert!((found.total.unwrap() - TOTAL[axis]).abs() < 2e-3, "{indices:?}");
        assert_eq!(found.first_error, 0.0);
    }
}

#[test]
fn indices_of_a_sample_are_the_published_ones_within_their_errors() {
    for plan in ["sobol:4096", "lhs:4000:5"] {
        let results = results(over_sample(plan, &["h1=0:2", "alpha=0:2", "beta=0:2"]), &ishigami);
        let indices = Overview::new(&results).sensitivity_of(Quantity::Lyapunov).unwrap();
        for (axis, found) in indices.iter().enumerate() {
            // a bin of 1/40 smooths the curve a little
            let error = (found.first - FIRST[axis]).abs();
            assert!(error < 4.0 * found.first_error + 5e-3, "{plan}: {indices:?}");
            assert!(found.first_error > 0.0 && found.first_error < 0.05);
            assert_eq!(found.total, None);
        }
    }
}

#[test]
fn chaos_that_one_coordinate_decides_alone_has_the_index_1() {
    let results = results(over_axes(&["zeta_k=0:10:11", "h1=0:1:3"]), &|values| values[0] - 3.5);
    let indices = Overview::new(&results).sensitivity_of_chaos().unwrap();
    assert!((indices[0].first - 1.0).abs() < 1e-12 && (indices[0].total.unwrap() - 1.0).abs() < 1e-12);
    assert!(indices[1].first.abs() < 1e-12 && indices[1].total.unwrap().abs() < 1e-12);
    let all_alike = results.clone();
    assert_eq!(Overview::new(&all_alike).sensitivity_of(Quantity::Period), None);
}

#[test]
fn shares_are_those_of_the_points_of_each_bin() {
    let results = results(over_axes(&["zeta_k=10:0:11", "h1=0:1:100"]), &|values| {
        values[0] - 3.5 - values[1]
    });
    let overview = Overview::new(&results);
    let all: u64 = (0..11)
        .map(|k| (0..100).filter(|&j| f64::from(k) > 3.5 + f64::from(j) / 99.0).count() as u64)
        .sum();
    assert_eq!(overview.share(), Share { of: all, all: 1100 });
    let shares = overview.shares();
    // bins rise, although the axis falls; 100 values make 40 bins
    assert_eq!((shares[0].len(), shares[1].len()), (11, 40));
    assert_eq!(shares[0][3], Share { of: 0, all: 100 });
    assert_eq!(shares[0][4], Share { of: 50, all: 100 });
    assert_eq!(shares[0][10], Share { of: 100, all: 100 });
    let summed = shares[1]
        .iter()
        .fold((0, 0), |sum, share| (sum.0 + share.of, sum.1 + share.all));
    assert_eq!(summed, (all, 1100));
    let pair = overview.shares_of_pair([0, 1]);
    assert_eq!(pair.len(), 11 * 40);
    let column: u64 = pair.iter().skip(4).step_by(11).map(|share| share.of).sum();
    assert_eq!(column, 50);
}

#[test]
fn margins_are_told_in_the_values_of_the_coordinates() {
    let results = results(over_axes(&["zeta_k=0:10:11", "gamma=log:0.001:1:4"]), &|values| {
        if values[0] > 6.5 || (values[0] < 2.5 && values[1] > 0.5) {
            1.0
        } else {
            -1.0
        }
    });
    let overview = Overview::new(&results);
    let margin = overview.margin(&[4.0, 0.01]);
    // at (7, 0.01): 3 of 10
    let (index, distance) = margin.nearest.unwrap();
    assert!((distance - 0.3).abs() < 1e-12);
    assert_eq!(results.experiment.design.varied.values(index)[0].1, 7.0);
    // 7 by 3 values below gamma = 1, or 3..6 by all 4: sides (0.7 by 1) or (0.5 by 1)
    let room = margin.room.unwrap();
    assert_eq!(room[0], [0.0, 6.0]);
    assert!(
        (room[1][0] - 0.001).abs() < 1e-12 && (room[1][1] - 0.1).abs() < 1e-12,
        "{room:?}"
    );
    assert_eq!(margin.within, 21);
    assert!(overview.margin(&[8.0, 0.01]).room.is_none());
}
