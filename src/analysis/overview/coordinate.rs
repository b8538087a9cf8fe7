//! The coordinates of a design, each brought to the interval from 0 to 1 and divided into bins.
//!
//! Owns where a point lies along each; knows no results.

use crate::design::{Axis, Coordinate, Design, Points, Spacing, Varied};

/// The most bins along a coordinate.
pub const MOST_BINS: usize = 40;

/// Points that a bin of a list should have at least.
const LEAST_POINTS: usize = 25;

/// One coordinate of a design.
#[derive(Clone, Debug)]
pub struct Extent {
    /// What varies.
    pub coordinate: Coordinate,
    /// Whether equal ratios count as equal distances.
    pub is_logarithmic: bool,
    /// Least value. Infinite values do not count, unless there are no others.
    pub low: f64,
    /// Greatest value, of those that count.
    pub high: f64,
    /// The middle of each bin, rising.
    pub bins: Vec<f64>,
    /// An axis whose values are the middles of the bins; None if all values are equal.
    pub axis: Option<Axis>,
    /// The bin of each value of an axis; empty for a list of points.
    bin_of_value: Vec<usize>,
}

impl Extent {
    /// The coordinates of a design, in its order, with bins that are looked at `together` at a time: one coordinate alone, or pairs.
    fn all(design: &Design, together: u32) -> Vec<Self> {
        match &design.varied {
            Varied::Axes(axes) => axes.iter().map(Self::of_axis).collect(),
            Varied::Points(points) => (0..points.coordinates().len())
                .map(|column| Self::of_column(points, column, together))
                .collect(),
        }
    }

    fn of_axis(axis: &Axis) -> Self {
        let [low, high] = axis.ends();
        let rising = axis.rising();
        let count = rising.len();
        let bins = count.min(MOST_BINS);
        let mut bin_of_value = vec![0; count];
        let mut members = vec![Vec::new(); bins];
        for (rank, &index) in rising.iter().enumerate() {
            let bin = rank * bins / count;
            bin_of_value[index] = bin;
            members[bin].push(axis.value(index));
        }
        let is_logarithmic = matches!(axis.spacing(), Spacing::Logarithmic { .. });
        let middle = |values: &Vec<f64>| {
            let (first, last) = (values[0], values[values.len() - 1]);
            if is_logarithmic {
                (first * last).sqrt()
            } else {
                0.5 * (first + last)
            }
        };
        let middles: Vec<f64> = members.iter().map(middle).collect();
        let of_bins = match axis.spacing() {
            _ if bins == count => Some(axis.clone()),
            Spacing::Listed(_) => Axis::listed(axis.coordinate, middles.clone()).ok(),
            Spacing::Even { .. } | Spacing::Logarithmic { .. } => {
                axis_between(axis.coordinate, is_logarithmic, &middles)
            }
        };
        Self {
            coordinate: axis.coordinate,
            is_logarithmic,
            low,
            high,
            bins: middles,
            axis: of_bins,
            bin_of_value,
        }
    }

    fn of_column(points: &Points, column: usize, together: u32) -> Self {
        // a rate may be infinite: it lies at the greatest of the others
        let finite = || {
            (0..points.len())
                .map(|index| points.row(index)[column])
                .filter(|value| value.is_finite())
        };
        let (low, high) = match finite().next() {
            Some(_) => (
                finite().fold(f64::INFINITY, f64::min),
                finite().fold(f64::NEG_INFINITY, f64::max),
            ),
            None => (f64::INFINITY, f64::INFINITY),
        };
        let filled = points.len() as f64 / LEAST_POINTS as f64;
        let bins = (filled.powf(1.0 / f64::from(together)) as usize).clamp(2, MOST_BINS);
        let mut extent = Self {
            coordinate: points.coordinates()[column],
            is_logarithmic: points.is_logarithmic(column),
            low,
            high,
            bins: Vec::new(),
            axis: None,
            bin_of_value: Vec::new(),
        };
        extent.bins = (0..bins)
            .map(|bin| extent.value((bin as f64 + 0.5) / bins as f64))
            .collect();
        extent.axis = axis_between(extent.coordinate, extent.is_logarithmic, &extent.bins);
        extent
    }

    /// Where a value lies between the least one, 0, and the greatest, 1. Where all values are equal it is 1/2.
    pub fn part(&self, value: f64) -> f64 {
        let [value, low, high] =
            [value, self.low, self.high].map(|value| if self.is_logarithmic { value.ln() } else { value });
        if high > low {
            ((value - low) / (high - low)).clamp(0.0, 1.0)
        } else {
            0.5
        }
    }

    /// The value that lies there.
    pub fn value(&self, part: f64) -> f64 {
        if self.high <= self.low {
            self.low
        } else if self.is_logarithmic {
            self.low * (self.high / self.low).powf(part)
        } else {
            self.low + part * (self.high - self.low)
        }
    }
}

/// The axis with these values, which are evenly spread.
fn axis_between(coordinate: Coordinate, is_logarithmic: bool, values: &[f64]) -> Option<Axis> {
    let (first, last) = (values[0], values[values.len() - 1]);
    if is_logarithmic {
        Axis::logarithmic(coordinate, first, last, values.len()).ok()
    } else {
        Axis::even(coordinate, first, last, values.len()).ok()
    }
}

/// Where the points of a design lie.
pub struct Places<'a> {
    design: &'a Design,
    /// One for each coordinate.
    pub extents: Vec<Extent>,
    /// From one value of each axis to the next, in points.
    strides: Vec<usize>,
}

impl<'a> Places<'a> {
    /// Of a design, with bins of `together` coordinates at a time.
    pub fn new(design: &'a Design, together: u32) -> Self {
        Self {
            design,
            extents: Extent::all(design, together),
            strides: design.strides(),
        }
    }

    /// Number of points from one value of each axis to the next, and of values, for a product of axes.
    pub fn strides(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let counts = self.design.axes().iter().map(Axis::count);
        self.strides.iter().copied().zip(counts)
    }

    /// The bin of a point along a coordinate.
    pub fn bin(&self, coordinate: usize, index: usize) -> usize {
        let extent = &self.extents[coordinate];
        match &self.design.varied {
            Varied::Axes(_) => extent.bin_of_value[index / self.strides[coordinate] % extent.bin_of_value.len()],
            Varied::Points(points) => {
                let part = extent.part(points.row(index)[coordinate]);
                ((part * extent.bins.len() as f64) as usize).min(extent.bins.len() - 1)
            }
        }
    }

    /// Where a point lies, from 0 to 1 along each coordinate.
    pub fn parts(&self, index: usize) -> Vec<f64> {
        let values = self.design.varied.values(index);
        let parts = self.extents.iter().zip(values);
        parts.map(|(extent, (_, value))| extent.part(value)).collect()
    }
}
