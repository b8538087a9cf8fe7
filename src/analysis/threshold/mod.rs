//! The border of chaos in two or three parameters, to a given width, with few points.
//!
//! Owns what a round of refinement computes, and what is told of the border; where the results of a round come from, its caller decides.
//!
//! Chaos is where a point's class is chaotic. Regular, quasi-periodic and undecided points lie outside of it: chaos is not shown there.
//! Points that are unstable, ran away or are under-resolved are neither, and no border passes beside them.

mod dimension;
mod lattice;
#[cfg(test)]
mod tests;

use std::collections::HashMap;

pub use self::dimension::{Dimension, dimension};
use self::lattice::{Inside, Lattice, Node, Shape};
use super::contour;
use crate::design::{Axis, AxisError, Coordinate, Points, PointsError, Side};
use crate::experiment::{Experiment, ExperimentError, Request};
use crate::map::{NoMap, ParameterMap};
use crate::measure::{Class, Quantity, Status};
use crate::results::{Results, Tally};

/// A box of parameters in which the border of chaos is looked for, and how narrowly.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    sides: Vec<Side>,
    shape: Shape,
    /// The most points that may be computed.
    most: usize,
}

impl Plan {
    /// Cells along each side with which refinement begins, of a box with two sides and of one with three. What is smaller than such a
    /// cell on all sides can be missed.
    pub const FIRST: [u32; 2] = [32, 16];
    /// The most points unless another number is given.
    pub const MOST: usize = 2_000_000;
    /// The least width: a ten millionth of a side.
    pub const LEAST_WIDTH: f64 = 1e-7;

    /// The border in the box that these sides span, between points that are no further apart than `width`, a part of each side's
    /// length (of its ratio, if it is logarithmic). Refinement begins with `first` cells along each side.
    ///
    /// # Errors
    /// If the box does not have two or three different sides, `width` is below [`Plan::LEAST_WIDTH`] or not below 1 / `first`, or there
    /// are fewer than 2 first cells or they have more points than `most`.
    pub fn new(sides: Vec<Side>, width: f64, first: Option<u32>, most: usize) -> Result<Self, ThresholdError> {
        if !(2..=3).contains(&sides.len()) {
            return Err(ThresholdError::Sides { count: sides.len() });
        }
        let coordinates: Vec<Coordinate> = sides.iter().map(|side| side.parameter).collect();
        if let Some(twice) = crate::design::first_twice(&coordinates) {
            return Err(ThresholdError::Twice { name: twice.name() });
        }
        let first = first.unwrap_or(Self::FIRST[sides.len() - 2]);
        let points = (f64::from(first) + 1.0).powi(sides.len() as i32);
        if first < 2 || points > most as f64 {
            return Err(ThresholdError::First { first, points, most });
        }
        let widest = 1.0 / f64::from(first);
        if !(width >= Self::LEAST_WIDTH && width < widest) {
            return Err(ThresholdError::Width { width, widest, first });
        }
        let levels = (1.0 / (width * f64::from(first))).log2().ceil() as u32;
        let shape = Shape {
            sides: sides.len(),
            first,
            levels,
        };
        Ok(Self { sides, shape, most })
    }

    /// The sides of the box.
    pub fn sides(&self) -> &[Side] {
        &self.sides
    }

    /// The side of a finest cell, as a part of the box's side: at most the width that was asked for.
    pub fn width(&self) -> f64 {
        1.0 / f64::from(self.shape.cells(self.shape.levels))
    }

    /// Cells along a side at each level, from the first on.
    pub fn cells(&self) -> Vec<u32> {
        (0..=self.shape.levels).map(|level| self.shape.cells(level)).collect()
    }

    /// Points of the even grid over the box whose neighbours are as close as in finest cells.
    pub fn points_of_grid(&self) -> f64 {
        self.shape.points()
    }

    /// The experiment over an even grid of `cells` cells along each side.
    ///
    /// # Errors
    /// As [`Request::resolve`]; if the contact wears somewhere, since the motion has no class then.
    pub fn over_grid(&self, request: &Request, cells: u32) -> Result<Experiment, ThresholdError> {
        let axis = |side: &Side| {
            let count = cells as usize + 1;
            if side.log {
                Axis::logarithmic(side.parameter, side.start, side.stop, count)
            } else {
                Axis::even(side.parameter, side.start, side.stop, count)
            }
        };
        let axes = self.sides.iter().map(axis).collect::<Result<Vec<_>, _>>()?;
        let request = Request {
            axes: Some(axes),
            points: None,
            ..request.clone()
        };
        let experiment = request.resolve()?;
        if experiment.wears() {
            return Err(ThresholdError::Wears);
        }
        Ok(experiment)
    }

    fn value(&self, node: Node, axis: usize) -> f64 {
        let cells = f64::from(self.shape.cells(self.shape.levels));
        self.sides[axis].at(f64::from(node[axis]) / cells)
    }
}

/// Points that are computed together.
pub struct Round {
    /// From 0 on.
    pub number: usize,
    /// A list of points.
    pub experiment: Experiment,
}

/// Searches for the border. `compute` returns the results of a round, which must hold [`Quantity::Class`] and [`Quantity::Status`]. The
/// points of a round follow from the results of those before it, so that a search can be done again from kept results; a search to
/// a smaller width begins with the same rounds.
///
/// # Errors
/// If a round cannot be computed, if a machine does not exist somewhere in the box, or [`ThresholdError::TooMany`].
pub fn search<E: From<ThresholdError>>(
    plan: &Plan,
    request: &Request,
    compute: &mut dyn FnMut(&Round) -> Result<Results, E>,
) -> Result<Border, E> {
    let whole = plan.over_grid(request, plan.shape.first)?;
    let mut request = Request {
        axes: None,
        ..request.clone()
    };
    // what is left open must not be decided anew by the points of each round
    request.set_settings(&whole.settings);
    let coordinates: Vec<Coordinate> = plan.sides.iter().map(|side| side.parameter).collect();
    let mut lattice = Lattice::new(plan.shape);
    let (mut rounds, mut places): (Vec<Results>, HashMap<Node, [u32; 2]>) = (Vec::new(), HashMap::new());
    let mut nodes = lattice.refine([]);
    while !nodes.is_empty() {
        if lattice.known() + nodes.len() > plan.most {
            return Err(ThresholdError::TooMany {
                points: lattice.known() + nodes.len(),
                most: plan.most,
            }
            .into());
        }
        let row = |&node: &Node| (0..plan.sides.len()).map(|axis| plan.value(node, axis)).collect();
        let rows: Vec<Vec<f64>> = nodes.iter().map(row).collect();
        let points = Points::new(coordinates.clone(), &rows).map_err(ThresholdError::from)?;
        request.points = Some(points);
        let round = Round {
            number: rounds.len(),
            experiment: request.resolve().map_err(ThresholdError::from)?,
        };
        let results = compute(&round)?;
        let kinds: Vec<Inside> = (0..nodes.len()).map(|index| inside(&results, index)).collect();
        for (index, &node) in nodes.iter().enumerate() {
            places.insert(node, [rounds.len() as u32, index as u32]);
        }
        rounds.push(results);
        nodes = lattice.refine(nodes.into_iter().zip(kinds));
    }
    Ok(Border {
        plan: plan.clone(),
        request,
        lattice,
        rounds,
        places,
    })
}

/// Whether there is chaos at a point; None where that has no meaning.
fn inside(results: &Results, index: usize) -> Inside {
    match results.class(index)? {
        Class::Chaotic => Some(true),
        Class::Regular | Class::QuasiPeriodic | Class::Undecided => Some(false),
        Class::Unstable => None,
    }
}

/// The border of chaos in a box.
pub struct Border {
    plan: Plan,
    request: Request,
    lattice: Lattice,
    rounds: Vec<Results>,
    /// The round of each point, and its place there.
    places: HashMap<Node, [u32; 2]>,
}

/// Where a line of the border crosses an edge of a finest cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The middle of the edge, in the units of the box's sides; 0 for a third side that is not there.
    pub place: [f64; 3],
    /// The side along which the edge lies.
    pub along: usize,
    /// Half of the edge's length.
    pub half_width: f64,
}

impl Border {
    /// Number of points that were computed.
    pub fn points(&self) -> usize {
        self.lattice.known()
    }

    /// Number of rounds.
    pub fn rounds(&self) -> usize {
        self.rounds.len()
    }

    /// The points that were computed, by their kind of motion.
    pub fn tally(&self) -> Tally {
        let codes = self.rounds.iter().flat_map(|results| {
            let codes = |quantity| {
                results
                    .values(quantity)
                    .map(|code| (!code.is_nan()).then_some(code as usize))
            };
            let status = codes(Quantity::Status).map(|code| code.unwrap_or(Status::UnderResolved.code().into()));
            status.zip(codes(Quantity::Class))
        });
        Tally::counted(codes)
    }

    /// How many cells of each level, as [`Plan::cells`] lists them, the border passes through.
    pub fn boxes(&self) -> Vec<usize> {
        self.lattice.boxes()
    }

    /// The border as lines from crossing to crossing; a closed line ends with its first crossing. In a box of three sides each line lies in
    /// a plane of one value of the third side.
    pub fn lines(&self) -> Vec<Vec<Crossing>> {
        let across = u64::from(self.plan.shape.cells(self.plan.shape.levels)) + 1;
        let number = |[x, y, z]: Node| ((u64::from(z) * across + u64::from(y)) * across + u64::from(x)) as usize;
        let node = |number: usize| {
            let number = number as u64;
            [number % across, number / across % across, number / across / across].map(|place| place as u32)
        };
        let squares = self.lattice.squares().into_iter().map(|square| square.map(number));
        let lines = contour::lines_through(squares, |point| self.lattice.kind(node(point)));
        let crossing = |edge: contour::Edge| self.crossing(node(edge.from), node(edge.to));
        lines
            .into_iter()
            .map(|line| line.into_iter().map(crossing).collect())
            .collect()
    }

    fn crossing(&self, from: Node, to: Node) -> Crossing {
        let sides = self.plan.sides.len();
        let along = (0..sides).find(|&axis| from[axis] != to[axis]).unwrap_or(0);
        let mut place: [f64; 3] =
            std::array::from_fn(|axis| if axis < sides { self.plan.value(from, axis) } else { 0.0 });
        let end = self.plan.value(to, along);
        let half_width = 0.5 * (end - place[along]);
        place[along] += half_width;
        Crossing {
            place,
            along,
            half_width,
        }
    }

    /// Maps of the box in which each point has the results of the nearest computed point of its cell: one map of a box of two sides, and
    /// at most `planes` maps of a box of three, in planes of the third side, each with its value of that side. A map has at most `most`
    /// points along a side, if refinement began with fewer.
    ///
    /// # Errors
    /// As [`Request::resolve`].
    ///
    /// # Panics
    /// If fewer than 2 planes are asked for.
    pub fn maps(&self, most: u32, planes: u32) -> Result<Vec<(f64, ParameterMap)>, ThresholdError> {
        assert!(planes >= 2, "a box has two ends");
        let shape = self.plan.shape;
        let level = (0..=shape.levels).rev().find(|&level| shape.cells(level) < most);
        let level = level.unwrap_or(0);
        if self.plan.sides.len() == 2 {
            return Ok(vec![(0.0, self.map(&self.request, level, 0)?)]);
        }
        // planes of the first cells, in which points are known everywhere
        let last = planes.min(shape.first + 1) - 1;
        let maps = (0..=last).map(|index| {
            let plane = (index * shape.first / last) << shape.levels;
            let (third, value) = (self.plan.sides[2].parameter, self.plan.value([0, 0, plane], 2));
            let mut request = self.request.clone();
            request.set.insert(third.name().to_owned(), value);
            Ok((value, self.map(&request, level, plane)?))
        });
        maps.collect()
    }

    /// The map over the first two sides in a plane.
    fn map(&self, request: &Request, level: u32, plane: u32) -> Result<ParameterMap, ThresholdError> {
        let of_plane = Plan {
            sides: self.plan.sides[..2].to_vec(),
            ..self.plan.clone()
        };
        let experiment = of_plane.over_grid(request, self.plan.shape.cells(level))?;
        let quantities = self.rounds[0].quantities();
        let mut map = ParameterMap::try_from(Results::of(experiment, &quantities))?;
        for (index, node) in self.lattice.nearest(level, plane).into_iter().enumerate() {
            let [round, place] = self.places[&node];
            for &quantity in &quantities {
                let value = self.rounds[round as usize].value(quantity, place as usize);
                map.set_value(quantity, index, value);
            }
        }
        Ok(map)
    }
}

/// Why there is no search for a border.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages tell what each is")]
pub enum ThresholdError {
    #[error(
        "a border is looked for in two or three parameters, and these are {count}: give one --x NAME=START:STOP for each"
    )]
    Sides { count: usize },
    #[error("{name} spans two sides of the box: give different parameters")]
    Twice { name: &'static str },
    #[error(
        "{first} first cells along each side have {points} points: there must be at least 2 cells, and at most {most} points"
    )]
    First { first: u32, points: f64, most: usize },
    #[error(
        "the width {width} is out of range: as a part of each side it must be at least {} and below {widest}, the side of one of the \
         first {first} cells",
        Plan::LEAST_WIDTH
    )]
    Width { width: f64, widest: f64, first: u32 },
    #[error(
        "the contact wears (k_w > 0), so that its motion is a transient and has no class: there is no border of chaos, set k_w to 0"
    )]
    Wears,
    #[error("{points} points would be computed, and at most {most} may be: take a greater width, or allow more points")]
    TooMany { points: usize, most: usize },
    #[error(transparent)]
    Axis(#[from] AxisError),
    #[error(transparent)]
    Points(#[from] PointsError),
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
    #[error(transparent)]
    NoMap(#[from] NoMap),
}
