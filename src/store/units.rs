//! Units: the ranges of points that are computed and written at once, as blocks of a product of axes.
//!
//! Owns which points and which chunk a unit is; knows no files.

use std::ops::Range;

/// How a product of axes falls into units. A unit is a block that has the first axes whole, a part of one axis, and one value of each
/// later axis, so that its points follow each other. At the far end of the divided axis blocks are cut off.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Units {
    /// Number of values of each axis; the first varies fastest.
    sides: Vec<usize>,
    /// The same of a block that is not cut off.
    block: Vec<usize>,
}

impl Units {
    /// Units of at most `points` points each, and of one point at least. Blocks along the divided axis are as equal as possible: chunks
    /// are stored in full, also where the last block is cut off.
    ///
    /// # Panics
    /// If an axis has no values.
    pub fn new(sides: &[usize], points: usize) -> Self {
        assert!(sides.iter().all(|&side| side > 0), "an axis has values");
        let mut left = points.max(1);
        let block = sides.iter().map(|&side| {
            let most = side.min(left);
            // behind the divided axis nothing is left but one value of each
            left = if most == side { left / side } else { 1 };
            side.div_ceil(side.div_ceil(most))
        });
        Self {
            block: block.collect(),
            sides: sides.to_vec(),
        }
    }

    /// The units whose blocks have so many values of each axis; None unless the points of each follow each other.
    pub fn of_block(sides: &[usize], block: &[usize]) -> Option<Self> {
        let fits = |(side, values): (&usize, &usize)| (1..=*side).contains(values);
        let divided = sides.iter().zip(block).position(|(side, values)| values < side);
        let behind = divided.map_or(&[][..], |at| block.get(at + 1..).unwrap_or_default());
        let follows =
            sides.len() == block.len() && sides.iter().zip(block).all(fits) && behind.iter().all(|&values| values == 1);
        follows.then(|| Self {
            sides: sides.to_vec(),
            block: block.to_vec(),
        })
    }

    /// Number of values of each axis in a block that is not cut off, the first axis first.
    pub fn block(&self) -> &[usize] {
        &self.block
    }

    /// Number of points in a block that is not cut off.
    pub fn block_points(&self) -> usize {
        self.block.iter().product()
    }

    /// Number of units.
    pub fn count(&self) -> usize {
        self.blocks().product()
    }

    /// Number of blocks along each axis.
    fn blocks(&self) -> impl Iterator<Item = usize> {
        self.sides
            .iter()
            .zip(&self.block)
            .map(|(side, block)| side.div_ceil(*block))
    }

    /// Which block a unit is along each axis, the first axis first.
    pub fn place(&self, unit: usize) -> Vec<usize> {
        let mut rest = unit;
        let place = self.blocks().map(|blocks| {
            let at = rest % blocks;
            rest /= blocks;
            at
        });
        place.collect()
    }

    /// The points of a unit, as indices into the design.
    pub fn points(&self, unit: usize) -> Range<usize> {
        let place = self.place(unit);
        let (mut first, mut count, mut stride) = (0, 1, 1);
        for ((side, block), at) in self.sides.iter().zip(&self.block).zip(place) {
            first += at * block * stride;
            count *= (*block).min(side - at * block);
            stride *= side;
        }
        first..first + count
    }

    /// The unit of a point.
    pub fn of_point(&self, index: usize) -> usize {
        let (mut rest, mut unit, mut stride) = (index, 0, 1);
        for ((side, block), blocks) in self.sides.iter().zip(&self.block).zip(self.blocks()) {
            unit += rest % side / block * stride;
            rest /= side;
            stride *= blocks;
        }
        unit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_have_the_first_axes_whole_and_at_most_as_many_points_as_asked_for() {
        let block = |sides: &[usize], points| Units::new(sides, points).block().to_vec();
        assert_eq!(block(&[300, 201], 4096), [300, 13]);
        assert_eq!(block(&[300, 201], 1 << 20), [300, 201]);
        assert_eq!(block(&[300, 201], 299), [150, 1]);
        assert_eq!(block(&[50, 40, 20, 2], 16384), [50, 40, 7, 1]);
        assert_eq!(block(&[50, 1, 20, 2], 49), [25, 1, 1, 1]);
        assert_eq!(block(&[7], 3), [3]);
        assert!(block(&[], 3).is_empty());
    }

    #[test]
    fn units_follow_each_other_and_have_every_point_once() {
        for (sides, points) in [
            (vec![7, 5], 21),
            (vec![7, 5], 3),
            (vec![4, 3, 5, 2], 25),
            (vec![4, 1, 5], 8),
            (vec![11], 4),
            (vec![], 1),
        ] {
            let units = Units::new(&sides, points);
            let mut next = 0;
            for unit in 0..units.count() {
                let range = units.points(unit);
                assert_eq!(range.start, next, "{sides:?}");
                assert!((1..=points).contains(&range.len()));
                assert!(range.clone().all(|index| units.of_point(index) == unit));
                next = range.end;
            }
            assert_eq!(next, sides.iter().product::<usize>());
            assert_eq!(Units::of_block(&sides, units.block()), Some(units));
        }
        assert_eq!(Units::of_block(&[7, 5], &[6, 1]).unwrap().points(3), 13..14);
        assert_eq!(Units::of_block(&[7, 5], &[3, 2]), None);
        assert_eq!(Units::of_block(&[7, 5], &[7, 6]), None);
        assert_eq!(Units::of_block(&[7, 5], &[0, 1]), None);
        assert_eq!(Units::of_block(&[7, 5], &[7]), None);
    }
}
