//! How far a point is from what is to be avoided: the nearest such point, and the largest box without one.
//!
//! Owns the search; distances are parts of the coordinates' extents.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// The index of the point nearest to `at` among `points`, and its distance; None without points.
pub fn nearest<'a>(at: &[f64], points: impl Iterator<Item = (usize, &'a [f64])>) -> Option<(usize, f64)> {
    let distance = |point: &[f64]| at.iter().zip(point).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    let all = points.map(|(index, point)| (index, distance(point)));
    all.min_by(|one, other| one.1.total_cmp(&other.1))
}

/// A box: for each coordinate, the ends between which it lies. The ends do not belong to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Room {
    /// Low and high end along each coordinate.
    pub ends: Vec<[f64; 2]>,
    /// Whether no box is larger. If the search was broken off, larger ones may exist.
    pub is_largest: bool,
}

fn volume(ends: &[[f64; 2]]) -> f64 {
    ends.iter().map(|[low, high]| high - low).product()
}

/// Boxes that are looked at before the search is broken off.
const MOST_BOXES: usize = 200_000;

/// Comparisons of points with each other, and of points with boxes, before either is broken off: some seconds each.
const MOST_TESTS: usize = 1_000_000_000;

/// The first box reaches this far beyond the cube, so that the cube's faces belong to it, while an end at a point never does.
const BEYOND: f64 = 1e-9;

/// Boxes of equal volume are taken in the order in which they were found.
struct Candidate {
    ends: Vec<[f64; 2]>,
    volume: f64,
    number: usize,
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Candidate {}
impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        self.volume
            .total_cmp(&other.volume)
            .then(other.number.cmp(&self.number))
    }
}

/// The largest box within the unit cube that holds `at` and none of the points to be avoided, all of which lie in the cube. None if one
/// of them is at `at` itself.
///
/// Boxes are taken from the largest on. One with a point to be avoided is cut beside that point, once along each coordinate; the
/// first one without such a point is therefore the largest.
pub fn largest_room(at: &[f64], avoided: &[Vec<f64>]) -> Option<Room> {
    if avoided.iter().any(|point| point == at) {
        return None;
    }
    let near = undominated(at, avoided);
    let holds = |ends: &[[f64; 2]], point: &[f64]| {
        let mut within = ends.iter().zip(point);
        within.all(|(&[low, high], &value)| low < value && value < high)
    };
    let first_within = |ends: &[[f64; 2]]| near.iter().find(|point| holds(ends, point));
    let cut = |ends: &[[f64; 2]], point: &[f64]| -> Vec<Vec<[f64; 2]>> {
        let along = (0..at.len()).filter(|&axis| point[axis] != at[axis]);
        let cuts = along.map(|axis| {
            let mut cut = ends.to_vec();
            cut[axis][usize::from(point[axis] > at[axis])] = point[axis];
            cut
        });
        cuts.collect()
    };
    let whole = vec![[-BEYOND, 1.0 + BEYOND]; at.len()];
    let mut open = BinaryHeap::from([Candidate {
        volume: volume(&whole),
        ends: whole,
        number: 0,
    }]);
    let (mut number, mut tests) = (0, 0);
    while let Some(candidate) = open.pop() {
        let Some(point) = first_within(&candidate.ends) else {
            return Some(Room {
                ends: candidate.ends,
                is_largest: true,
            });
        };
        tests += near.len();
        if number > MOST_BOXES || tests > MOST_TESTS {
            // the largest cut each time
            let mut ends = candidate.ends;
            while let Some(point) = first_within(&ends) {
                ends = cut(&ends, point)
                    .into_iter()
                    .max_by(|one, other| volume(one).total_cmp(&volume(other)))?;
            }
            return Some(Room {
                ends,
                is_largest: false,
            });
        }
        for ends in cut(&candidate.ends, point) {
            number += 1;
            open.push(Candidate {
                volume: volume(&ends),
                ends,
                number,
            });
        }
    }
    None
}

/// The points that matter for boxes around `at`, the nearest first. A point does not matter if another one lies between it and `at` in
/// every coordinate: a box with the farther one then has the nearer one as well. Beyond [`MOST_TESTS`] all points are kept.
fn undominated(at: &[f64], points: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let distance = |point: &[f64]| at.iter().zip(point).map(|(a, b)| (a - b).abs()).sum::<f64>();
    let mut sorted: Vec<&Vec<f64>> = points.iter().collect();
    sorted.sort_by(|one, other| distance(one).total_cmp(&distance(other)));
    let (mut kept, mut tests): (Vec<Vec<f64>>, usize) = (Vec::new(), 0);
    for point in sorted {
        let stands_before = |other: &Vec<f64>| {
            (0..at.len()).all(|axis| {
                let [here, there] = [at[axis], point[axis]];
                (here.min(there)..=here.max(there)).contains(&other[axis])
            })
        };
        tests += kept.len();
        if tests > MOST_TESTS || !kept.iter().any(stands_before) {
            kept.push(point.clone());
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    use super::*;
    use crate::design::uniform;

    /// The largest box by brute force: every pair of ends among the points' coordinates.
    fn brute(at: &[f64], avoided: &[Vec<f64>]) -> f64 {
        fn over(axis: usize, at: &[f64], avoided: &[Vec<f64>], ends: &mut Vec<[f64; 2]>, best: &mut f64) {
            if axis == at.len() {
                let within = |point: &Vec<f64>| {
                    point
                        .iter()
                        .zip(&*ends)
                        .all(|(value, [low, high])| low < value && value < high)
                };
                if !avoided.iter().any(within) {
                    *best = best.max(volume(ends));
                }
                return;
            }
            let mut values: Vec<f64> = avoided.iter().map(|point| point[axis]).chain([0.0, 1.0]).collect();
            values.sort_by(f64::total_cmp);
            for &low in values.iter().filter(|&&low| low <= at[axis]) {
                for &high in values.iter().filter(|&&high| high >= at[axis]) {
                    ends.push([low, high]);
                    over(axis + 1, at, avoided, ends, best);
                    ends.pop();
                }
            }
        }
        let mut best = 0.0;
        over(0, at, avoided, &mut Vec::new(), &mut best);
        best
    }

    #[test]
    fn the_largest_room_is_that_of_all_boxes() {
        let mut generator = ChaCha8Rng::seed_from_u64(3);
        for (sides, points) in [(1, 5), (2, 12), (3, 7)] {
            for _ in 0..20 {
                let mut random = || (0..sides).map(|_| uniform(&mut generator)).collect::<Vec<f64>>();
                let at = random();
                let avoided: Vec<Vec<f64>> = (0..points).map(|_| random()).collect();
                let room = largest_room(&at, &avoided).unwrap();
                assert!(room.is_largest);
                assert!(
                    (volume(&room.ends) - brute(&at, &avoided)).abs() < 1e-8,
                    "{at:?} {avoided:?}"
                );
                assert!(
                    room.ends
                        .iter()
                        .zip(&at)
                        .all(|([low, high], at)| low <= at && at <= high)
                );
            }
        }
        assert_eq!(largest_room(&[0.5], &[vec![0.5]]), None);
        assert!((volume(&largest_room(&[0.5, 0.5], &[]).unwrap().ends) - 1.0).abs() < 1e-8);
        // a point on a face of the cube takes the face away
        let room = largest_room(&[0.5, 0.5], &[vec![1.0, 0.5], vec![0.2, 1.0]]).unwrap();
        assert!(room.ends[0][1] == 1.0 && room.ends[1][1] == 1.0);
    }

    #[test]
    fn the_nearest_point_has_the_least_distance() {
        let points = [[0.0, 0.0], [0.9, 0.5], [0.5, 0.8]];
        let all = points.iter().enumerate().map(|(index, point)| (index, &point[..]));
        let (index, distance) = nearest(&[0.5, 0.5], all).unwrap();
        assert!(index == 2 && (distance - 0.3).abs() < 1e-12);
        assert_eq!(nearest(&[0.5], std::iter::empty()), None);
    }
}
