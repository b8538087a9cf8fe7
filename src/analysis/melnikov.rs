//! Mel'nikov's threshold over a second parameter, and over the axes of a map.
//!
//! Owns which curve belongs to which axes; M and the search in one parameter are [`crate::model::melnikov`]'s.

use rayon::prelude::*;

use crate::experiment::Experiment;
use crate::grid::{Axis, Fixed};
use crate::model::melnikov::{self, Melnikov, MelnikovError, Search, Threshold};
use crate::parameters::{Parameter, ParameterSet};

/// The threshold in one parameter at each value of an axis.
#[derive(Clone, Debug)]
pub struct Curve {
    pub search: Search,
    pub over: Axis,
    /// All else.
    pub fixed: Fixed,
    /// In the order of the axis.
    pub thresholds: Vec<Threshold>,
}

/// The threshold in `search`'s parameter over `over`, all else being that of `at`; where b is not positive
/// there is none.
///
/// # Errors
/// If both parameters are the same, or no value of the axis has a homoclinic orbit.
pub fn threshold_curve(at: &Fixed, search: &Search, over: &Axis) -> Result<Curve, CurveError> {
    if over.coordinate == search.parameter.into() {
        return Err(CurveError::SameParameter {
            name: over.coordinate.name(),
        });
    }
    let thresholds = thresholds(over, |value| {
        melnikov::threshold(at.at([(over.coordinate, value)]).parameters(), search)
    })?;
    Ok(Curve {
        search: *search,
        over: *over,
        fixed: *at,
        thresholds,
    })
}

/// What `find` finds at each value of the axis; nothing where there is no homoclinic orbit.
fn thresholds(
    over: &Axis,
    find: impl Fn(f64) -> Result<Threshold, MelnikovError> + Sync,
) -> Result<Vec<Threshold>, CurveError> {
    let found: Vec<Result<Threshold, MelnikovError>> = (0..over.count)
        .into_par_iter()
        .map(|index| find(over.value(index)))
        .collect();
    if let Some(Err(error)) = found.iter().find(|found| found.is_err())
        && found.iter().all(Result::is_err)
    {
        return Err(CurveError::Melnikov(error.clone()));
    }
    Ok(found
        .into_iter()
        .map(|found| found.unwrap_or(Threshold::Never))
        .collect())
}

/// Values at which the curve over a map is computed.
const MAP_VALUES: usize = 81;
/// Steps of the search along a map's axis.
const MAP_STEPS: u32 = 60;

/// The curve of the threshold over the axes of a map, as points (x, y); NaN parts its pieces. It is the threshold in the
/// x axis' parameter for each y or, where there is none of that kind on the map (M need not depend on that parameter, or may
/// change sign below a value of it instead of above), the threshold in the y axis' parameter for each x.
///
/// # Errors
/// If M depends on neither axis, has no homoclinic orbit there, or changes sign nowhere, or everywhere, on the map.
pub fn curve_over_map(experiment: &Experiment) -> Result<Vec<[f64; 2]>, CurveError> {
    let [x, y] = experiment.grid.axes[..] else {
        return Err(CurveError::NoMap);
    };
    let fixed = &experiment.grid.fixed;
    let depends = |axis: &Axis| {
        let mut moved = melnikov::PARAMETERS.iter();
        moved.any(|parameter| fixed.moves(axis.coordinate, *parameter))
    };
    let along_x = depends(&x).then(|| curve_along(fixed, &x, &y));
    if let Some(Ok(points)) = along_x {
        return Ok(points);
    }
    let along_y = depends(&y).then(|| curve_along(fixed, &y, &x));
    match (along_x, along_y) {
        (_, Some(Ok(points))) => Ok(points.into_iter().map(|[y, x]| [x, y]).collect()),
        (Some(Err(error)), _) | (_, Some(Err(error))) => Err(error),
        _ => Err(CurveError::NeitherAxis {
            x: x.coordinate.name(),
            y: y.coordinate.name(),
        }),
    }
}

/// Points (threshold along `along`, value of `over`).
fn curve_along(fixed: &Fixed, along: &Axis, over: &Axis) -> Result<Vec<[f64; 2]>, CurveError> {
    let (low, high) = (along.start.min(along.stop), along.start.max(along.stop));
    let over = Axis {
        count: over.count.min(MAP_VALUES),
        ..*over
    };
    let find = |row: f64| {
        let at = |value: f64| {
            *fixed
                .at([(over.coordinate, row), (along.coordinate, value)])
                .parameters()
        };
        melnikov::threshold_along(&at, [low, high], MAP_STEPS)
    };
    let thresholds = thresholds(&over, find)?;
    if thresholds.iter().all(|threshold| threshold.value().is_none()) {
        let below = thresholds.contains(&Threshold::BelowRange);
        return Err(CurveError::NotOnMap {
            name: along.coordinate.name(),
            low,
            high,
            place: if below { "at the lower end already" } else { "nowhere" },
        });
    }
    let mut points: Vec<[f64; 2]> = Vec::new();
    for (index, threshold) in thresholds.iter().enumerate() {
        let (row, value) = (over.value(index), threshold.value());
        if let Some(&[before, row_before]) = points.last() {
            let last = match (before.is_finite(), value) {
                (true, None) => end_between(&find, row_before, row),
                (false, Some(_)) => end_between(&find, row, row_before),
                _ => None,
            };
            points.extend(last);
        }
        points.push([value.unwrap_or(f64::NAN), row]);
    }
    Ok(points)
}

/// Halvings of the step in which a curve ends.
const HALVINGS: u32 = 24;

/// Where a curve ends between a value that has a threshold and one that has none: as (threshold, value); the curve would
/// else stop up to a step short of the map's edge.
fn end_between(
    find: &impl Fn(f64) -> Result<Threshold, MelnikovError>,
    mut with: f64,
    mut without: f64,
) -> Option<[f64; 2]> {
    let mut end = None;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (with + without);
        match find(middle).ok().and_then(|threshold| threshold.value()) {
            Some(value) => (end, with) = (Some([value, middle]), middle),
            None => without = middle,
        }
    }
    end
}

/// M over `count` values of tau0 from `low` to `high`, both included: pairs (tau0, M).
///
/// # Errors
/// [`MelnikovError::NoHomoclinicOrbit`].
pub fn sampled(at: &ParameterSet, low: f64, high: f64, count: usize) -> Result<Vec<[f64; 2]>, MelnikovError> {
    let function = Melnikov::new(at)?;
    let tau_0 = |index: usize| low + (high - low) * index as f64 / (count - 1) as f64;
    Ok((0..count)
        .into_par_iter()
        .map(|index| [tau_0(index), function.closed_form(tau_0(index))])
        .collect())
}

/// The range in which a threshold in a parameter is looked for unless another is given: 0 to 20 or, where the parameter's
/// range is narrower, that.
pub fn default_range(parameter: Parameter) -> (f64, f64) {
    let (low, high) = parameter.info().range;
    (low.max(0.0), high.min(20.0))
}

#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CurveError {
    #[error(transparent)]
    Melnikov(#[from] MelnikovError),
    #[error("the threshold in {name} cannot be drawn over {name} itself: give another parameter for one of the two")]
    SameParameter { name: &'static str },
    #[error("Mel'nikov's threshold is drawn over a map of two axes")]
    NoMap,
    #[error(
        "Mel'nikov's function depends neither on {x} nor on {y}: leave --overlay melnikov out, or give an axis of {known}",
        known = melnikov::PARAMETERS.map(Parameter::name).join(", ")
    )]
    NeitherAxis { x: &'static str, y: &'static str },
    #[error(
        "Mel'nikov's function changes sign {place} on the map, whose {name} runs from {low} to {high}: there is no \
         threshold to draw; leave --overlay melnikov out, or move the axis"
    )]
    NotOnMap {
        name: &'static str,
        low: f64,
        high: f64,
        place: &'static str,
    },
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Request;

    fn experiment(x: &str, y: &str) -> Experiment {
        let request = Request {
            x: Axis::parse(x).unwrap(),
            y: Axis::parse(y).unwrap(),
            ..Request::default()
        };
        request.resolve().unwrap()
    }

    #[test]
    fn the_curve_over_a_map_passes_through_the_checked_thresholds() {
        let curve = curve_over_map(&experiment("zeta_k=3:5:10", "h1=0:1:3")).unwrap();
        for (point, expected) in curve.iter().zip([[3.3047, 0.0], [3.6933, 0.5], [3.9609, 1.0]]) {
            assert!(
                (point[0] - expected[0]).abs() < 1e-4 && point[1] == expected[1],
                "{point:?}"
            );
        }
    }

    #[test]
    fn a_curve_that_leaves_the_map_ends_at_its_edge() {
        for (x, y) in [("zeta_k=3:3.8:10", "h1=0:2:6"), ("zeta_k=3.5:5:10", "h1=1:0:3")] {
            let experiment = experiment(x, y);
            let curve = curve_over_map(&experiment).unwrap();
            let axis = experiment.grid.axes[0];
            let inside = || curve.iter().map(|point| point[0]).filter(|value| value.is_finite());
            let ends = [inside().fold(f64::INFINITY, f64::min), inside().fold(0.0, f64::max)];
            assert!(
                (ends[0] - axis.start).abs() < 1e-5 || (ends[1] - axis.stop).abs() < 1e-5,
                "{ends:?}"
            );
        }
    }

    #[test]
    fn an_axis_that_does_not_matter_gives_a_straight_line() {
        let curve = curve_over_map(&experiment("epsilon=0.05:0.2:3", "zeta_k=3:5:10")).unwrap();
        assert_eq!(
            curve.iter().map(|point| point[0]).collect::<Vec<_>>(),
            [0.05, 0.125, 0.2]
        );
        assert!(curve.iter().all(|point| (point[1] - 3.6933).abs() < 1e-4), "{curve:?}");
    }

    #[test]
    fn a_parameter_that_hinders_chaos_may_be_the_first_axis() {
        let curve = curve_over_map(&experiment("h1=0:1:3", "zeta_k=3:5:10")).unwrap();
        assert_eq!(curve[1][0], 0.5);
        assert!((curve[1][1] - 3.6933).abs() < 1e-4, "{curve:?}");
    }

    #[test]
    fn maps_without_a_threshold_are_refused_with_a_reason() {
        for (x, y, reason) in [
            ("epsilon=0.05:0.2:3", "x0=0:1:3", "neither on epsilon nor on x0"),
            ("zeta_k=0:1:3", "h1=0:1:3", "nowhere"),
            ("zeta_k=5:6:3", "h1=0:1:3", "at the lower end already"),
            ("zeta_k=0:6:3", "b=-2:-1:3", "b > 0"),
        ] {
            let message = curve_over_map(&experiment(x, y)).unwrap_err().to_string();
            assert!(message.contains(reason), "{x} {y}: {message}");
        }
    }
}
