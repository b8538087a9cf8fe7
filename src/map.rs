//! A parameter map: results over two axes, and the border of chaos.
//!
//! Owns the border; neither computes nor draws nor stores results.

use std::ops::{Deref, DerefMut};

use crate::design::Axis;
use crate::experiment::Experiment;
use crate::measure::Class;
use crate::parameters::Parameter;
use crate::results::Results;

/// Results over two axes, x varying fastest.
#[derive(Clone, Debug)]
pub struct ParameterMap(Results);

impl Deref for ParameterMap {
    type Target = Results;
    fn deref(&self) -> &Results {
        &self.0
    }
}

impl DerefMut for ParameterMap {
    fn deref_mut(&mut self) -> &mut Results {
        &mut self.0
    }
}

impl TryFrom<Results> for ParameterMap {
    type Error = NoMap;
    fn try_from(results: Results) -> Result<Self, NoMap> {
        match results.experiment.design.axes().len() {
            2 => Ok(Self(results)),
            axes => Err(NoMap { axes }),
        }
    }
}

/// The error for results that do not have two axes.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "a map has two axes, and these results have {axes}: `tribochaos slice` draws a map out of more axes, `export` writes any \
     results as a table"
)]
pub struct NoMap {
    axes: usize,
}

impl ParameterMap {
    /// A map in which no point is computed yet.
    ///
    /// # Errors
    /// If the experiment does not have two axes.
    pub fn new(experiment: Experiment) -> Result<Self, NoMap> {
        Results::new(experiment).try_into()
    }

    /// The horizontal axis.
    pub fn x_axis(&self) -> &Axis {
        &self.experiment.design.axes()[0]
    }

    /// The vertical axis.
    pub fn y_axis(&self) -> &Axis {
        &self.experiment.design.axes()[1]
    }
}

/// A change between a chaotic point and a regular or quasi-periodic one. The two points lie in one row or one column. All points
/// between them, if there are any, are of neither kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// The axis along which the two points lie: 0 for x, 1 for y.
    pub along: usize,
    /// The middle between the two points, (x, y).
    pub place: [f64; 2],
    /// Half of the distance between the two points.
    pub half_width: f64,
    /// Whether chaos begins (true) or ends (false) as the coordinate of the axis increases. The direction of the axis does not
    /// matter.
    pub begins: bool,
}

/// Whether a map has a border of chaos. It has none if the contact wears at every point, since such points have no class. It
/// has none if an axis is an initial state, since initial states select among attractors, not among parameters.
pub fn has_border(experiment: &Experiment) -> bool {
    let is_initial = |axis: &Axis| [Parameter::X0.into(), Parameter::Y0.into()].contains(&axis.coordinate);
    !experiment.design.axes().iter().any(is_initial) && experiment.extent(Parameter::KW).0 == 0.0
}

/// The border of chaos: all changes along rows, then all along columns. Points that are undecided or unstable, ran away or are
/// under-resolved may lie between the two points of a change; they make its bracket wider. There is no change across points that
/// are not computed. Empty for a map without a border.
pub fn border(map: &ParameterMap) -> Vec<Change> {
    if !has_border(&map.experiment) {
        return Vec::new();
    }
    changes(map, &motions(map))
}

/// The border as it is drawn, simplified so that the eye can follow it. Open points (neither chaotic, regular nor quasi-periodic)
/// that are at most [`CLOSED`] points away from others take the kind of most of their neighbours. Regions of fewer than
/// [`least_region`] points are left out.
pub fn drawn_border(map: &ParameterMap) -> Vec<Change> {
    if !has_border(&map.experiment) {
        return Vec::new();
    }
    let columns = map.x_axis().count();
    let mut motions = motions(map);
    close(&mut motions, columns);
    // islands of chaos first: where chaos and the gaps in it are both small, the result is no chaos
    for region in [Side::Chaos, Side::NotChaotic] {
        fill_small(&mut motions, region, columns, least_region(map));
    }
    changes(map, &motions)
}

/// Width of the edge of an open region that is filled from its neighbours in the drawn border, in points.
pub const CLOSED: usize = 2;

/// The least number of points of an island of chaos, or of a gap in chaos, whose border is drawn. It is a 4000th of the map,
/// which is a square of 12 pixels in a picture of the usual size.
pub fn least_region(map: &ParameterMap) -> usize {
    map.experiment.design.len().div_ceil(4000)
}

/// The kind of motion at a point, as far as the border distinguishes it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Chaos,
    /// Regular or quasi-periodic.
    NotChaotic,
    /// Neither of the two, or not known which: undecided, unstable, runaway or under-resolved.
    Open,
    NotComputed,
}

fn motions(map: &ParameterMap) -> Vec<Side> {
    let motion = |index| match map.class(index) {
        _ if !map.is_computed(index) => Side::NotComputed,
        Some(Class::Chaotic) => Side::Chaos,
        Some(Class::Regular | Class::QuasiPeriodic) => Side::NotChaotic,
        Some(Class::Undecided | Class::Unstable) | None => Side::Open,
    };
    (0..map.experiment.design.len()).map(motion).collect()
}

fn changes(map: &ParameterMap, motions: &[Side]) -> Vec<Change> {
    let axes = [map.x_axis(), map.y_axis()];
    let values = axes.map(Axis::values);
    let mut changes = Vec::new();
    for along in [0, 1] {
        let (axis, other) = (axes[along], axes[1 - along]);
        let order = axis.rising();
        for line in 0..other.count() {
            let mut last = None;
            for &here in &order {
                let index = if along == 0 {
                    line * axis.count() + here
                } else {
                    here * other.count() + line
                };
                let begins = match motions[index] {
                    Side::Chaos => true,
                    Side::NotChaotic => false,
                    Side::Open => continue,
                    Side::NotComputed => {
                        last = None;
                        continue;
                    }
                };
                let value = values[along][here];
                if let Some((before, was_chaos)) = last
                    && was_chaos != begins
                {
                    let mut place = [0.5 * (before + value); 2];
                    place[1 - along] = values[1 - along][line];
                    changes.push(Change {
                        along,
                        place,
                        half_width: 0.5 * (value - before),
                        begins,
                    });
                }
                last = Some((value, begins));
            }
        }
    }
    changes
}

/// The points above, below, to the left and to the right.
fn neighbours(index: usize, columns: usize, points: usize) -> impl Iterator<Item = usize> {
    let column = index % columns;
    let all = [
        (column > 0).then(|| index - 1),
        (column + 1 < columns).then_some(index + 1),
        index.checked_sub(columns),
        Some(index + columns).filter(|&next| next < points),
    ];
    all.into_iter().flatten()
}

/// Fills open regions from their edges, by one point in each of [`CLOSED`] passes: an open point takes the motion of most of its
/// chaotic or ordered neighbours, and order if there are as many of both. Points that are still open count as not computed then,
/// so that there is no border across them.
fn close(motions: &mut [Side], columns: usize) {
    for _ in 0..CLOSED {
        let before = motions.to_vec();
        for (index, motion) in motions
            .iter_mut()
            .enumerate()
            .filter(|(_, motion)| **motion == Side::Open)
        {
            let count = |what| {
                let beside = neighbours(index, columns, before.len());
                beside.filter(|&there| before[there] == what).count()
            };
            match (count(Side::Chaos), count(Side::NotChaotic)) {
                (0, 0) => {}
                (chaos, order) if chaos > order => *motion = Side::Chaos,
                _ => *motion = Side::NotChaotic,
            }
        }
    }
    for motion in motions.iter_mut().filter(|motion| **motion == Side::Open) {
        *motion = Side::NotComputed;
    }
}

/// Changes regions of fewer than `least` points from chaos to order, or from order to chaos; `region` tells from which.
fn fill_small(motions: &mut [Side], region: Side, columns: usize, least: usize) {
    let filled = if region == Side::Chaos {
        Side::NotChaotic
    } else {
        Side::Chaos
    };
    let mut seen = vec![false; motions.len()];
    for start in 0..motions.len() {
        if motions[start] != region || seen[start] {
            continue;
        }
        let (mut members, mut next) = (vec![start], 0);
        seen[start] = true;
        while let Some(&here) = members.get(next) {
            next += 1;
            for there in neighbours(here, columns, motions.len()) {
                if motions[there] == region && !seen[there] {
                    seen[there] = true;
                    members.push(there);
                }
            }
        }
        if members.len() < least {
            for index in members {
                motions[index] = filled;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::BackendKind;
    use crate::experiment::Request;
    use crate::measure::{Measurement, Quantity};
    use crate::results::{Column, NO_CODE};

    const C: Option<Class> = Some(Class::Chaotic);
    const R: Option<Class> = Some(Class::Regular);
    const U: Option<Class> = Some(Class::Undecided);

    /// A map whose first points have these classes, where None is a runaway. All further points are not computed.
    fn map(x: &str, y: &str, classes: &[Option<Class>]) -> ParameterMap {
        let request = Request {
            axes: Some(vec![Axis::parse(x).unwrap(), Axis::parse(y).unwrap()]),
            ..Request::default()
        };
        let mut map = ParameterMap::new(request.resolve().unwrap()).unwrap();
        for (index, class) in classes.iter().enumerate() {
            let measurement = Measurement {
                class: *class,
                ..Measurement::runaway(0.0, BackendKind::CpuF64)
            };
            map.set(index, &measurement);
        }
        map
    }

    /// The changes along the first row as (x, half width, whether chaos begins).
    fn row(x: &str, classes: &[Option<Class>]) -> Vec<(f64, f64, bool)> {
        let changes = border(&map(x, "h1=0:1:2", classes));
        assert!(changes.iter().all(|change| change.along == 0 && change.place[1] == 0.0));
        changes
            .iter()
            .map(|change| (change.place[0], change.half_width, change.begins))
            .collect()
    }

    #[test]
    fn every_change_is_the_middle_of_its_bracket_with_its_direction() {
        let x = "zeta_k=0:4:5";
        assert_eq!(
            row(x, &[R, R, C, R, C]),
            [(1.5, 0.5, true), (2.5, 0.5, false), (3.5, 0.5, true)]
        );
        // open points of every kind widen the bracket; between two points of the same kind they make no change
        for open in [U, None, Some(Class::Unstable)] {
            assert_eq!(row(x, &[R, open, C, open, C]), [(1.0, 1.0, true)]);
            assert_eq!(row(x, &[open, C, open, open, R]), [(2.5, 1.5, false)]);
        }
        assert_eq!(row(x, &[Some(Class::QuasiPeriodic), C, C, C, C]), [(0.5, 0.5, true)]);
        assert_eq!(row(x, &[C; 5]), []);
        assert_eq!(row("zeta_k=4:0:5", &[C, C, C, R, R]), [(1.5, 0.5, true)]);
    }

    #[test]
    fn there_is_no_change_across_points_that_are_not_computed() {
        let mut map = map("zeta_k=0:4:5", "h1=0:1:2", &[R, R, C, C, R]);
        let row = |map: &ParameterMap| border(map).iter().map(|change| change.place[0]).collect::<Vec<_>>();
        assert_eq!(row(&map), [1.5, 3.5]);
        map.replace(Quantity::Status, 3, &Column::Code(vec![NO_CODE]));
        assert_eq!(row(&map), [1.5]);
    }

    /// Rows of `#` for chaos, `.` for regular and `?` for undecided motion.
    fn drawn(x: &str, y: &str, picture: &[&str]) -> ParameterMap {
        let points = picture.iter().flat_map(|row| row.chars());
        let classes: Vec<Option<Class>> = points
            .map(|point| match point {
                '#' => C,
                '.' => R,
                _ => U,
            })
            .collect();
        map(x, y, &classes)
    }

    #[test]
    fn the_border_of_exchanged_axes_is_the_transposed_one() {
        let picture = ["..##.", ".###.", "..?#.", "#...#"];
        let transposed = ["...#", ".#..", "##?.", "###.", "...#"];
        let one = drawn("zeta_k=0:4:5", "h1=0:3:4", &picture);
        let other = drawn("h1=0:3:4", "zeta_k=0:4:5", &transposed);
        for of in [border, drawn_border] {
            let exchanged = of(&other).into_iter().map(|change| Change {
                along: 1 - change.along,
                place: [change.place[1], change.place[0]],
                ..change
            });
            let (mut exchanged, mut changes): (Vec<_>, Vec<_>) = (exchanged.collect(), of(&one));
            let order = |a: &Change, b: &Change| format!("{a:?}").cmp(&format!("{b:?}"));
            exchanged.sort_by(order);
            changes.sort_by(order);
            assert!(changes.len() > 10);
            assert_eq!(changes, exchanged);
        }
    }

    #[test]
    fn small_islands_and_gaps_are_not_drawn_and_open_points_hide_no_border() {
        // 120 x 100 points: regions of fewer than 3 points are left out
        let mut rows = vec![format!("{}{}", ".".repeat(60), "#".repeat(60)); 100];
        rows[10].replace_range(10..12, "##");
        rows[10].replace_range(90..92, "..");
        rows[20].replace_range(10..13, "###");
        // an open point takes the kind of most of its neighbours
        rows[30].replace_range(60..61, "?");
        // an open region of three points on either side of the border: there is no border across it
        for row in &mut rows[50..57] {
            row.replace_range(57..63, "??????");
        }
        let picture: Vec<&str> = rows.iter().map(String::as_str).collect();
        let map = drawn("zeta_k=0:119:120", "h1=0:99:100", &picture);
        assert_eq!(least_region(&map), 3);
        let at = |changes: &[Change], row: f64| -> Vec<f64> {
            let here = changes
                .iter()
                .filter(|change| change.along == 0 && change.place[1] == row);
            here.map(|change| change.place[0]).collect()
        };
        let (all, drawn) = (border(&map), drawn_border(&map));
        assert_eq!(at(&all, 10.0), [9.5, 11.5, 59.5, 89.5, 91.5]);
        assert_eq!(at(&drawn, 10.0), [59.5]);
        assert_eq!(at(&drawn, 20.0), [9.5, 12.5, 59.5]);
        assert_eq!((at(&all, 30.0), at(&drawn, 30.0)), (vec![60.0], vec![59.5]));
        assert_eq!((at(&all, 53.0), at(&drawn, 53.0)), (vec![59.5], vec![]));
    }

    #[test]
    fn initial_states_and_wear_have_no_border() {
        let picture = ["..##", "..##", "####"];
        let has = |x: &str, y: &str| !border(&drawn(x, y, &picture)).is_empty();
        assert!(has("zeta_k=0:3:4", "h1=0:2:3") && has("zeta_k=0:3:4", "k_w=0:0.2:3"));
        for (x, y) in [
            ("x0=0:3:4", "h1=0:2:3"),
            ("zeta_k=0:3:4", "y0=0:2:3"),
            ("zeta_k=0:3:4", "k_w=0.1:0.2:3"),
        ] {
            assert!(!has(x, y), "{x} {y}");
        }
    }
}
