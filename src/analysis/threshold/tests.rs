//! Borders that are known: circles, strips, fractal curves, spheres; and a border of the model.

use std::collections::{BTreeSet, HashSet};

use super::lattice::{Inside, Lattice, Node, Shape};
use super::*;
use crate::engine;

const SQUARE: Shape = Shape {
    sides: 2,
    first: 32,
    levels: 5,
};

/// Refines until the border of a region is found; returns the points of each round.
fn refined(shape: Shape, region: &dyn Fn([f64; 3]) -> Inside) -> (Lattice, Vec<Vec<Node>>) {
    let mut lattice = Lattice::new(shape);
    let mut rounds = Vec::new();
    let cells = f64::from(shape.cells(shape.levels));
    let mut nodes = lattice.refine([]);
    while !nodes.is_empty() {
        let kinds = nodes
            .iter()
            .map(|node| region(node.map(|place| f64::from(place) / cells)));
        let found: Vec<(Node, Inside)> = nodes.iter().copied().zip(kinds).collect();
        rounds.push(nodes);
        nodes = lattice.refine(found);
    }
    (lattice, rounds)
}

/// The cells of the finest level that have corners of both kinds, by brute force.
fn dense(shape: Shape, region: &dyn Fn([f64; 3]) -> Inside) -> BTreeSet<Node> {
    let cells = shape.cells(shape.levels);
    let at = |x: u32, y: u32| region([x, y, 0].map(|place| f64::from(place) / f64::from(cells)));
    let mut found = BTreeSet::new();
    for y in 0..cells {
        for x in 0..cells {
            let corners = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
            if corners.contains(&Some(true)) && corners.contains(&Some(false)) {
                found.insert([x, y, 0]);
            }
        }
    }
    found
}

fn found(lattice: &Lattice) -> BTreeSet<Node> {
    lattice.squares().iter().map(|square| square[0]).collect()
}

#[expect(clippy::unnecessary_wraps, reason = "regions have this form")]
fn circle([x, y, _]: [f64; 3]) -> Inside {
    Some((x - 0.45).hypot(y - 0.52) < 0.31)
}

/// A strip, a tenth of a first cell wide, that crosses the circle.
#[expect(clippy::unnecessary_wraps, reason = "regions have this form")]
fn circle_and_strip(place: [f64; 3]) -> Inside {
    let [x, y, _] = place;
    let strip = (y - 0.3 * x - 0.2).abs() < 0.0016;
    Some(circle(place) == Some(true) || strip)
}

#[test]
fn a_smooth_border_is_found_whole_with_few_points() {
    let (lattice, rounds) = refined(SQUARE, &circle);
    assert_eq!(found(&lattice), dense(SQUARE, &circle));
    let part = lattice.known() as f64 / SQUARE.points();
    assert!(part < 0.011, "{part}");
    assert_eq!(rounds.iter().map(Vec::len).sum::<usize>(), lattice.known());
    let dimension = dimension(&lattice.boxes()).unwrap();
    assert!((dimension.value - 1.0).abs() < 0.03, "{dimension:?}");
}

/// A strip that is far thinner than the first cells is seen where it begins, and followed to its end.
#[test]
fn a_strip_is_followed_from_where_it_is_seen() {
    let (lattice, _) = refined(SQUARE, &circle_and_strip);
    assert_eq!(found(&lattice), dense(SQUARE, &circle_and_strip));
    assert!((lattice.known() as f64) < 0.03 * SQUARE.points());
}

/// No line ends but at the edge of the square: the side of a coarse cell never hides a change.
#[test]
fn lines_are_closed_or_end_at_the_edge() {
    let wavy = |[x, y, _]: [f64; 3]| Some((9.0 * x).sin() * (11.0 * y + 3.0 * x).cos() > 0.3 * (40.0 * x * y).sin());
    for region in [&circle as &dyn Fn([f64; 3]) -> Inside, &circle_and_strip, &wavy] {
        let (lattice, _) = refined(SQUARE, region);
        let end = SQUARE.cells(SQUARE.levels);
        let number = |[x, y, _]: Node| (y * (end + 1) + x) as usize;
        let node = |number: usize| [number as u32 % (end + 1), number as u32 / (end + 1), 0];
        let squares = lattice.squares().into_iter().map(|square| square.map(number));
        let lines = contour::lines_through(squares, |point| lattice.kind(node(point)));
        assert!(!lines.is_empty());
        for line in lines {
            let (first, last) = (line[0], line[line.len() - 1]);
            let at_edge = |edge: contour::Edge| {
                let [a, b] = [edge.from, edge.to].map(node);
                (0..2).any(|axis| a[axis] == b[axis] && (a[axis] == 0 || a[axis] == end))
            };
            assert!(
                first == last || (at_edge(first) && at_edge(last)),
                "{first:?} to {last:?}"
            );
        }
    }
}

/// Takagi's curve y = sum of c^n s(2^n x), where s(x) is the distance to the next whole number: its oscillation over short intervals is
/// far greater than their length.
#[test]
fn a_fractal_curve_is_found_whole() {
    let takagi = |x: f64| -> f64 {
        let s = |x: f64| (x - x.round()).abs();
        (0..40).map(|n| 0.75f64.powi(n) * s(f64::from(n).exp2() * x)).sum()
    };
    // a shift keeps the corners of the lattice from the corners of the curve
    let below = |[x, y, _]: [f64; 3]| Some(y < 0.1 + 0.5 * takagi(0.837 * x + 0.0713));
    let shape = Shape { levels: 4, ..SQUARE };
    let (lattice, _) = refined(shape, &below);
    assert_eq!(found(&lattice), dense(shape, &below));
}

#[test]
fn a_smaller_width_begins_with_the_same_points() {
    let scale = |rounds: &[Vec<Node>], factor: u32| -> Vec<Vec<Node>> {
        let scaled = |node: &Node| node.map(|place| place * factor);
        rounds.iter().map(|nodes| nodes.iter().map(scaled).collect()).collect()
    };
    let (_, coarse) = refined(Shape { levels: 2, ..SQUARE }, &circle_and_strip);
    let (_, fine) = refined(SQUARE, &circle_and_strip);
    assert!(coarse.len() >= 3);
    assert_eq!(scale(&coarse, 8), fine[..coarse.len()]);
    let distinct: HashSet<&Node> = fine.iter().flatten().collect();
    assert_eq!(
        distinct.len(),
        fine.iter().map(Vec::len).sum::<usize>(),
        "no point twice"
    );
}

#[test]
fn a_sphere_is_found_in_a_cube_plane_by_plane() {
    let shape = Shape {
        sides: 3,
        first: 4,
        levels: 4,
    };
    let sphere = |[x, y, z]: [f64; 3]| Some((x - 0.5).hypot(y - 0.47).hypot(z - 0.51) < 0.33);
    let (lattice, _) = refined(shape, &sphere);
    let dimension = dimension(&lattice.boxes()).unwrap();
    assert!((dimension.value - 2.0).abs() < 0.15, "{dimension:?}");
    assert!((lattice.known() as f64) < 0.25 * shape.points());
    // every plane has the cells that it has by brute force
    for plane in 0..=shape.cells(shape.levels) {
        let z = f64::from(plane) / f64::from(shape.cells(shape.levels));
        let expected = dense(Shape { sides: 2, ..shape }, &|[x, y, _]| sphere([x, y, z]));
        let squares = lattice.squares().into_iter().filter(|square| square[0][2] == plane);
        let mixed = squares.filter(|square| {
            let kinds = square.map(|node| lattice.kind(node));
            kinds.contains(&Some(true)) && kinds.contains(&Some(false))
        });
        let mixed: BTreeSet<Node> = mixed.map(|square| [square[0][0], square[0][1], 0]).collect();
        assert_eq!(mixed, expected, "plane {plane}");
    }
}

#[test]
fn no_border_passes_beside_points_of_neither_kind() {
    let half = |[x, y, _]: [f64; 3]| if x < 0.5 { Some(y < 0.4) } else { None };
    let (lattice, _) = refined(SQUARE, &half);
    let squares = lattice.squares();
    assert!(!squares.is_empty() && squares.iter().all(|square| square[1][0] <= 512));
    let (lattice, _) = refined(SQUARE, &|[x, ..]| (x < 0.5).then_some(true));
    assert!(lattice.squares().is_empty());
    assert_eq!(dimension(&lattice.boxes()), None);
}

/// A border that runs towards points of neither kind is followed to them.
#[test]
fn a_border_beside_points_of_neither_kind_is_found() {
    let region = |[x, y, _]: [f64; 3]| {
        let border = 0.52 - 0.1 * x;
        (y >= border - 0.02).then_some(y > border)
    };
    let (lattice, _) = refined(SQUARE, &region);
    assert_eq!(found(&lattice), dense(SQUARE, &region));
}

#[test]
fn every_point_of_a_map_has_the_nearest_computed_point_of_its_cell() {
    let shape = Shape { levels: 3, ..SQUARE };
    let (lattice, _) = refined(shape, &circle);
    let (cells, finest) = (shape.cells(3), lattice.nearest(3, 0));
    assert_eq!(finest.len(), (cells as usize + 1).pow(2));
    for (index, node) in finest.into_iter().enumerate() {
        let here = [index as u32 % (cells + 1), index as u32 / (cells + 1), 0];
        assert!(lattice.kind(node).is_some());
        // within half of a first cell, and itself where it was computed
        assert!((0..2).all(|axis| here[axis].abs_diff(node[axis]) <= 4));
        let place = here.map(|place| f64::from(place) / f64::from(cells));
        assert_eq!(lattice.kind(node), circle(place), "{here:?}");
    }
    assert_eq!(lattice.nearest(0, 0).len(), 33 * 33);
}

fn sides(texts: &[&str]) -> Vec<Side> {
    texts.iter().map(|text| Side::parse(text).unwrap()).collect()
}

#[test]
fn plans_are_checked() {
    let plan = |texts: &[&str], width, first| Plan::new(sides(texts), width, first, 100_000).map(|plan| plan.width());
    let two = ["zeta_k=3:5", "h1=0:1.5"];
    assert_eq!(plan(&two, 1e-3, None).unwrap(), 1.0 / 1024.0);
    assert_eq!(plan(&two, 0.01, Some(10)).unwrap(), 1.0 / 160.0);
    assert_eq!(plan(&two, 1.0 / 64.0, None).unwrap(), 1.0 / 64.0);
    for (texts, width, first, reason) in [
        (&["zeta_k=3:5"][..], 0.01, None, "these are 1"),
        (&["zeta_k=3:5", "zeta_k=1:2"], 0.01, None, "two sides"),
        (&two, 0.5, None, "below 0.03125"),
        (&two, 0.0, None, "out of range"),
        (&two, f64::NAN, None, "out of range"),
        (&two, 0.01, Some(1), "at least 2"),
        (&two, 1e-6, Some(1000), "1002001 points"),
    ] {
        let message = plan(texts, width, first).unwrap_err().to_string();
        assert!(message.contains(reason), "{message}");
    }
    let wearing = Request {
        set: [("k_w".to_owned(), 0.1)].into(),
        ..Request::default()
    };
    let plan = Plan::new(sides(&two), 0.01, None, Plan::MOST).unwrap();
    assert!(matches!(plan.over_grid(&wearing, 4), Err(ThresholdError::Wears)));
}

/// The first onset of chaos of the default system, point by point against a map of every point.
#[test]
fn the_border_of_the_model_is_that_of_its_map() {
    let plan = Plan::new(sides(&["zeta_k=3.6:4.2", "h1=0.3:0.7"]), 1.0 / 16.0, Some(4), 1000).unwrap();
    let mut request = Request::default();
    request.sampling.transient_periods = 40;
    request.sampling.align_periods = 20;
    request.sampling.periods = 60;
    let compute = &mut |round: &Round| -> Result<Results, ThresholdError> {
        Ok(engine::run(&round.experiment).expect("a device"))
    };
    let border = search(&plan, &request, compute).unwrap();
    let map = engine::run(&plan.over_grid(&request, 16).unwrap()).expect("a device");
    let filled = border.maps(100, 2).unwrap().remove(0).1;
    assert_eq!(filled.experiment.design.len(), 17 * 17);
    let mut computed = 0;
    for index in 0..map.experiment.design.len() {
        let node = [index as u32 % 17, index as u32 / 17, 0];
        if border.places.contains_key(&node) {
            computed += 1;
            assert_eq!(border.lattice.kind(node), inside(&map, index));
            assert_eq!(filled.class(index), map.class(index));
        }
    }
    assert_eq!(computed, border.points());
    assert!(computed < 17 * 17 && border.tally().points() == computed as u64);
    assert!(!border.lines().is_empty());
    for line in border.lines() {
        for crossing in line {
            let width = [0.6, 0.4][crossing.along] / 16.0;
            assert!((2.0 * crossing.half_width - width).abs() < 1e-12);
        }
    }
    let few = Plan::new(plan.sides().to_vec(), 1.0 / 16.0, Some(4), 25).unwrap();
    let stopped = search(&few, &request, compute).map(|_| ());
    assert!(matches!(stopped, Err(ThresholdError::TooMany { most: 25, .. })));
}

/// Refinement finds three quarters of the border's cells of the default system, told by maps of every point, from a small part of the
/// points.
#[test]
#[ignore = "computes two maps of 513 x 513 points: four minutes"]
fn most_of_the_border_of_chaos_is_found() {
    let cells = 512;
    for (texts, most) in [(["zeta_k=3:5", "h1=0:1.5"], 0.16), (["zeta_k=0:12", "h1=0:2"], 0.05)] {
        let plan = Plan::new(sides(&texts), 1.0 / f64::from(cells), None, Plan::MOST).unwrap();
        let map = engine::run(&plan.over_grid(&Request::default(), cells).unwrap()).expect("a device");
        let index = |[x, y, _]: Node| (y * (cells + 1) + x) as usize;
        let region = |place: [f64; 3]| inside(&map, index(place.map(|part| (part * f64::from(cells)).round() as u32)));
        let (lattice, _) = refined(plan.shape, &region);
        let (all, found) = (dense(plan.shape, &region), found(&lattice));
        assert!(found.is_subset(&all));
        let part = lattice.known() as f64 / plan.shape.points();
        let share = found.len() as f64 / all.len() as f64;
        assert!(
            part < most && share > 0.75,
            "{texts:?}: {part} of the points find {share} of the cells"
        );
    }
}
