//! What the results of a whole design say: how much of it is chaotic, which coordinates matter, and how far a point is from chaos.
//!
//! Owns the statistics; computes no point.
//!
//! Of the points of a design, those count that are computed. A share of chaos is that of the chaotic ones among them.

pub mod coordinate;
mod margin;
mod sensitivity;
mod share;
#[cfg(test)]
mod tests;

use self::coordinate::{Extent, Places};
pub use self::sensitivity::Indices;
pub use self::share::Share;
use crate::design::Varied;
use crate::measure::{Class, Quantity};
use crate::results::Results;

/// The results of a design, to be looked at as a whole. They must hold [`Quantity::Class`].
pub struct Overview<'a> {
    results: &'a Results,
    places: Places<'a>,
    /// With bins of which pairs have enough points.
    places_of_pairs: Places<'a>,
}

/// How far a point is from chaos.
#[derive(Clone, Debug, PartialEq)]
pub struct Margin {
    /// The nearest chaotic point, by its index, and its distance: the root of the sum of squares of the differences, each as a part of its
    /// coordinate's extent. None without chaos.
    pub nearest: Option<(usize, f64)>,
    /// For each coordinate, the least and the greatest value of the computed points, and of the given one, in the largest box around it
    /// in which all computed points are regular or quasi-periodic.
    pub room: Option<Vec<[f64; 2]>>,
    /// Computed points in that box.
    pub within: usize,
    /// Whether no such box is larger; else the search was broken off.
    pub is_largest: bool,
}

impl<'a> Overview<'a> {
    /// Of some results.
    pub fn new(results: &'a Results) -> Self {
        Self {
            results,
            places: Places::new(&results.experiment.design, 1),
            places_of_pairs: Places::new(&results.experiment.design, 2),
        }
    }

    /// The coordinates of the design.
    pub fn extents(&self) -> &[Extent] {
        &self.places.extents
    }

    /// The coordinates with the bins of [`Overview::shares_of_pair`].
    pub fn extents_of_pairs(&self) -> &[Extent] {
        &self.places_of_pairs.extents
    }

    fn computed(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.results.experiment.design.len()).filter(|&index| self.results.is_computed(index))
    }

    fn is_chaotic(&self, index: usize) -> bool {
        self.results.class(index) == Some(Class::Chaotic)
    }

    /// The share of chaos.
    pub fn share(&self) -> Share {
        let mut share = Share::default();
        self.computed().for_each(|index| share.add(self.is_chaotic(index)));
        share
    }

    /// The share of chaos in each bin of each coordinate.
    pub fn shares(&self) -> Vec<Vec<Share>> {
        let mut shares: Vec<Vec<Share>> = self
            .extents()
            .iter()
            .map(|extent| vec![Share::default(); extent.bins.len()])
            .collect();
        for index in self.computed() {
            let is_chaotic = self.is_chaotic(index);
            for (coordinate, shares) in shares.iter_mut().enumerate() {
                shares[self.places.bin(coordinate, index)].add(is_chaotic);
            }
        }
        shares
    }

    /// The share of chaos in each pair of bins of two coordinates, the bins of the first varying fastest.
    pub fn shares_of_pair(&self, [one, other]: [usize; 2]) -> Vec<Share> {
        let [columns, rows] = [one, other].map(|coordinate| self.extents_of_pairs()[coordinate].bins.len());
        let mut shares = vec![Share::default(); columns * rows];
        for index in self.computed() {
            let [column, row] = [one, other].map(|coordinate| self.places_of_pairs.bin(coordinate, index));
            shares[row * columns + column].add(self.is_chaotic(index));
        }
        shares
    }

    /// The sensitivity of chaos (1 where the motion is chaotic, else 0) to each coordinate; None where all points are alike.
    pub fn sensitivity_of_chaos(&self) -> Option<Vec<Indices>> {
        let mut values = vec![f64::NAN; self.results.experiment.design.len()];
        for index in self.computed() {
            values[index] = f64::from(u8::from(self.is_chaotic(index)));
        }
        self.sensitivity(&values)
    }

    /// The sensitivity of a quantity to each coordinate; None where it does not vary, or is not held.
    pub fn sensitivity_of(&self, quantity: Quantity) -> Option<Vec<Indices>> {
        self.sensitivity(&self.results.values(quantity).collect::<Vec<_>>())
    }

    fn sensitivity(&self, values: &[f64]) -> Option<Vec<Indices>> {
        let is_product = matches!(self.results.experiment.design.varied, Varied::Axes(_));
        sensitivity::indices(&self.places, values, is_product)
    }

    /// How far a point, given by the value of each coordinate, is from chaos.
    pub fn margin(&self, at: &[f64]) -> Margin {
        let at_parts: Vec<f64> = self
            .extents()
            .iter()
            .zip(at)
            .map(|(extent, &value)| extent.part(value))
            .collect();
        let (mut chaotic, mut avoided, mut others) = (Vec::new(), Vec::new(), Vec::new());
        for index in self.computed() {
            let parts = self.places.parts(index);
            if self.is_chaotic(index) {
                chaotic.push((index, parts.clone()));
            }
            match self.results.class(index) {
                Some(Class::Regular | Class::QuasiPeriodic) => others.push((index, parts)),
                _ => avoided.push(parts),
            }
        }
        let nearest = margin::nearest(&at_parts, chaotic.iter().map(|(index, parts)| (*index, &parts[..])));
        let Some(room) = margin::largest_room(&at_parts, &avoided) else {
            return Margin {
                nearest,
                room: None,
                within: 0,
                is_largest: true,
            };
        };
        let mut values: Vec<[f64; 2]> = at.iter().map(|&value| [value; 2]).collect();
        let mut within = 0;
        for (index, parts) in others {
            let mut ends = parts.iter().zip(&room.ends);
            let is_within = ends.all(|(part, [low, high])| low < part && part < high);
            if is_within {
                within += 1;
                let of_point = self.results.experiment.design.varied.values(index);
                for (ends, (_, value)) in values.iter_mut().zip(of_point) {
                    *ends = [ends[0].min(value), ends[1].max(value)];
                }
            }
        }
        Margin {
            nearest,
            room: Some(values),
            within,
            is_largest: room.is_largest,
        }
    }
}
