//! Mel'nikov's threshold over a second coordinate, and over the axes of a map.
//!
//! Owns which curve belongs to which axes; Mel'nikov's function M and the search along one axis are [`crate::model::melnikov`]'s.

use rayon::prelude::*;

use super::contour::{self, Edge};
use crate::design::{Axis, Coordinate, Design, Fixed};
use crate::experiment::Experiment;
use crate::machine::SiQuantity;
use crate::model::melnikov::{self, Melnikov, MelnikovError, Threshold};
use crate::parameters::{Parameter, ParameterSet};

/// The threshold on one axis at each value of another.
#[derive(Clone, Debug)]
pub struct Curve {
    /// The axis along which the threshold was searched.
    pub along: Axis,
    /// The other axis; the threshold was searched at each of its values.
    pub over: Axis,
    /// The values of everything that is not on the axes.
    pub fixed: Fixed,
    /// In the order of `over`.
    pub thresholds: Vec<Threshold>,
}

/// The threshold on the rising axis `along` at each value of `over`; `at` gives everything else. Where b is not positive, M does
/// not change sign.
///
/// # Errors
/// If both coordinates are the same, M does not depend on one of them, or no value of `over` has a homoclinic orbit.
pub fn threshold_curve(at: &Fixed, along: &Axis, over: &Axis) -> Result<Curve, CurveError> {
    if over.coordinate == along.coordinate {
        return Err(CurveError::SameParameter {
            name: over.coordinate.name(),
        });
    }
    melnikov::check_depends(at, over.coordinate)?;
    let found: Vec<Result<Threshold, MelnikovError>> = (0..over.count())
        .into_par_iter()
        .map(|index| melnikov::threshold(&at.at([(over.coordinate, over.value(index))]), along))
        .collect();
    if let Some(Err(error)) = found.iter().find(|found| found.is_err())
        && found.iter().all(Result::is_err)
    {
        return Err(error.clone().into());
    }
    Ok(Curve {
        along: along.clone(),
        over: over.clone(),
        fixed: *at,
        thresholds: found
            .into_iter()
            .map(|found| found.unwrap_or(Threshold::Never))
            .collect(),
    })
}

/// Values along either axis of a map between which the border is looked for.
const MAP_VALUES: usize = 41;

/// The border on a map between the region where M changes sign and the region where it does not, as points (x, y). NaN ends each
/// piece of the border. Regions that are narrower than a 40th of an axis may be missed.
///
/// # Errors
/// If M depends on neither axis; if there is no homoclinic orbit, or M has no meaning there; or if M changes sign nowhere, or
/// everywhere, on the map.
pub fn curve_over_map(experiment: &Experiment) -> Result<Vec<[f64; 2]>, CurveError> {
    let [x, y] = experiment.design.axes() else {
        return Err(CurveError::NoMap);
    };
    if experiment.has_heat_or_wear() {
        return Err(MelnikovError::Rubbed.into());
    }
    let fixed = experiment.design.fixed;
    if ![x, y].iter().any(|axis| melnikov::depends(&fixed, axis.coordinate)) {
        return Err(CurveError::NeitherAxis {
            x: x.coordinate.name(),
            y: y.coordinate.name(),
            known: melnikov::known(&fixed),
        });
    }
    let axes = [x, y].map(|axis| axis.resampled(MAP_VALUES));
    let design = Design::product(axes.to_vec(), fixed);
    let changes: Vec<Result<bool, MelnikovError>> = (0..design.len())
        .into_par_iter()
        .map(|index| melnikov::changes_sign(&design.point(index)))
        .collect();
    let inside: Vec<Option<bool>> = changes.iter().map(|changes| changes.as_ref().ok().copied()).collect();
    let lines = contour::lines(&inside, MAP_VALUES);
    if lines.is_empty() {
        return Err(match (inside.iter().find_map(|inside| *inside), &changes[0]) {
            (None, Err(error)) => error.clone().into(),
            (known, _) => CurveError::NotOnMap {
                place: if known == Some(true) { "everywhere" } else { "nowhere" },
            },
        });
    }
    // the edges take the time, and one line may have most of them
    let edges: Vec<Option<Edge>> = lines
        .into_iter()
        .flat_map(|line| line.into_iter().map(Some).chain([None]))
        .collect();
    let points = edges.into_par_iter().map(|edge| match edge {
        Some(edge) => crossing(&fixed, &axes, &inside, edge),
        None => Ok([f64::NAN; 2]),
    });
    Ok(points.collect::<Result<_, MelnikovError>>()?)
}

/// Where the border crosses an edge of the grid over the axes.
fn crossing(fixed: &Fixed, axes: &[Axis; 2], inside: &[Option<bool>], edge: Edge) -> Result<[f64; 2], MelnikovError> {
    let place = |point: usize| [axes[0].value(point % MAP_VALUES), axes[1].value(point / MAP_VALUES)];
    let (outer, inner) = if inside[edge.to] == Some(true) {
        (edge.from, edge.to)
    } else {
        (edge.to, edge.from)
    };
    let [outer, inner] = [outer, inner].map(place);
    // along the axis in which the ends differ
    let along = usize::from(outer[0] == inner[0]);
    let at = |value: f64| {
        let mut place = outer;
        place[along] = value;
        place
    };
    let parameters = |value: f64| {
        let values = axes.iter().map(|axis| axis.coordinate).zip(at(value));
        *fixed.at(values).parameters()
    };
    melnikov::border(&parameters, [outer[along], inner[along]]).map(at)
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

/// The axis along which a threshold is searched unless a range is given: 0 to 20, or the part of it that the parameter may have;
/// b begins at 0.1, since it must be positive. Of a machine's quantities, only the amplitude of the shaft's speed has such an
/// axis, on which zeta_k is from 0 to 20.
pub fn default_search(at: &Fixed, coordinate: Coordinate) -> Option<Axis> {
    let (start, stop) = match coordinate {
        Coordinate::Parameter(Parameter::B) => (0.1, 20.0),
        Coordinate::Parameter(parameter) => {
            let (low, high) = parameter.info().range;
            (low.max(0.0), high.min(20.0))
        }
        Coordinate::Si(SiQuantity::ShaftSpeedAmplitude) => (0.0, 20.0 / at.machine()?.scales().time),
        Coordinate::Si(_) => return None,
    };
    Axis::even(coordinate, start, stop, SEARCH_VALUES).ok()
}

/// Number of values of an axis along which a threshold is searched.
pub const SEARCH_VALUES: usize = 121;

/// Why there is no curve of thresholds.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages tell what each is")]
pub enum CurveError {
    #[error(transparent)]
    Melnikov(#[from] MelnikovError),
    #[error("the threshold in {name} cannot be drawn over {name} itself: give another parameter for one of the two")]
    SameParameter { name: &'static str },
    #[error("Mel'nikov's threshold is drawn over a map of two axes")]
    NoMap,
    #[error(
        "Mel'nikov's function depends neither on {x} nor on {y}: leave --overlay melnikov out, or give an axis of {known}"
    )]
    NeitherAxis {
        x: &'static str,
        y: &'static str,
        known: String,
    },
    #[error(
        "Mel'nikov's function changes sign {place} on the map: there is no threshold to draw; leave --overlay melnikov out, \
         or move the axes"
    )]
    NotOnMap { place: &'static str },
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Request;

    fn experiment(x: &str, y: &str) -> Experiment {
        let request = Request {
            axes: Some(vec![Axis::parse(x).unwrap(), Axis::parse(y).unwrap()]),
            ..Request::default()
        };
        request.resolve().unwrap()
    }

    /// The known thresholds lie on the curve, whatever the direction of the axes.
    #[test]
    fn the_curve_over_a_map_passes_through_the_checked_thresholds() {
        for (x, y, turned) in [
            ("zeta_k=3:5:10", "h1=0:1:3", false),
            ("h1=1:0:3", "zeta_k=5:3:10", true),
        ] {
            let mut curve = curve_over_map(&experiment(x, y)).unwrap();
            if turned {
                for point in &mut curve {
                    point.reverse();
                }
            }
            for [zeta_k, h1] in [[3.3047, 0.0], [3.6933, 0.5], [3.9609, 1.0]] {
                let is_there = |point: &[f64; 2]| (point[0] - zeta_k).abs() < 1e-4 && (point[1] - h1).abs() < 1e-12;
                assert!(curve.iter().any(is_there), "{x} {y}: {curve:?}");
            }
        }
    }

    #[test]
    fn a_curve_that_leaves_the_map_ends_at_its_edge() {
        for (x, y) in [("zeta_k=3:3.8:10", "h1=0:2:6"), ("zeta_k=3.5:5:10", "h1=1:0:3")] {
            let experiment = experiment(x, y);
            let curve = curve_over_map(&experiment).unwrap();
            let axis = &experiment.design.axes()[0];
            let inside = || curve.iter().map(|point| point[0]).filter(|value| value.is_finite());
            let ends = [inside().fold(f64::INFINITY, f64::min), inside().fold(0.0, f64::max)];
            assert!(
                (ends[0] - axis.first()).abs() < 1e-5 || (ends[1] - axis.last()).abs() < 1e-5,
                "{ends:?}"
            );
        }
    }

    #[test]
    fn an_axis_that_does_not_matter_gives_a_straight_line() {
        let curve = curve_over_map(&experiment("epsilon=0.05:0.2:3", "zeta_k=3:5:10")).unwrap();
        assert_eq!((curve[0][0], curve[MAP_VALUES - 1][0]), (0.05, 0.2));
        assert_eq!(curve.len(), MAP_VALUES + 1, "one piece");
        assert!(
            curve[..MAP_VALUES].iter().all(|point| (point[1] - 3.6933).abs() < 1e-4),
            "{curve:?}"
        );
    }

    /// M changes sign only below a certain damping h1: along this axis, the change of sign ends but never begins.
    #[test]
    fn a_map_without_zeta_k_has_its_border_in_all_directions() {
        let curve = curve_over_map(&experiment("omega_0=1:3:60", "h1=0:1.5:60")).unwrap();
        let mut checked = 0;
        for [omega_0, h1] in curve.into_iter().filter(|point| !point[0].is_nan()) {
            let changes = |h1: f64| {
                let at = ParameterSet::default().with(Parameter::Omega0, omega_0);
                melnikov::changes_sign(&at.with(Parameter::H1, h1)).unwrap()
            };
            assert!(
                changes(h1 - 1e-4) && !changes(h1 + 1e-4),
                "omega_0 = {omega_0}, h1 = {h1}"
            );
            checked += 1;
        }
        assert!(checked > MAP_VALUES, "{checked}");
    }

    #[test]
    fn maps_without_a_threshold_are_refused_with_a_reason() {
        for (x, y, reason) in [
            ("epsilon=0.05:0.2:3", "x0=0:1:3", "neither on epsilon nor on x0"),
            ("zeta_k=0:1:3", "h1=0:1:3", "nowhere"),
            ("zeta_k=5:6:3", "h1=0:1:3", "everywhere"),
            ("zeta_k=0:6:3", "b=-2:-1:3", "b > 0"),
            ("zeta_k=0:6:3", "gamma=0:1:3", "set gamma = 0"),
        ] {
            let message = curve_over_map(&experiment(x, y)).unwrap_err().to_string();
            assert!(message.contains(reason), "{x} {y}: {message}");
        }
    }
}
