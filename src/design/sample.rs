//! Seeded samples of a box: a Latin hypercube, and a scrambled Sobol sequence.
//!
//! Owns the methods and their form in commands and files; does not know what the points are used for.

use std::str::FromStr;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};
use sobol::Sobol;
use sobol::params::JoeKuoD6;

use super::{Axis, AxisError, Coordinate, Spacing, first_twice};

/// How the points of a sample are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// One point in each of as many equal slices of every side as there are points, at random within them (McKay, Beckman and Conover
    /// 1979).
    LatinHypercube,
    /// Sobol's sequence with the direction numbers of Joe and Kuo (2008), whose digits are scrambled at random in the way of Owen
    /// (1995): powers of two are the best numbers of points.
    Sobol,
}

impl Method {
    const NAMES: [(&'static str, Self); 2] = [("lhs", Self::LatinHypercube), ("sobol", Self::Sobol)];
}

/// The method and the number of points of a sample, as they are typed: `sobol:4096`, or with a seed `sobol:4096:7`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// How points are chosen.
    pub method: Method,
    /// Number of points.
    pub points: usize,
    /// Samples of different seeds are independent of each other.
    pub seed: u32,
}

impl FromStr for Plan {
    type Err = SampleError;
    fn from_str(text: &str) -> Result<Self, SampleError> {
        let malformed = || SampleError::Malformed { text: text.to_owned() };
        let fields: Vec<&str> = text.split(':').map(str::trim).collect();
        let (method, points, seed) = match fields[..] {
            [method, points] => (method, points, "1"),
            [method, points, seed] => (method, points, seed),
            _ => return Err(malformed()),
        };
        let method = Method::NAMES.into_iter().find(|(name, _)| *name == method);
        Ok(Self {
            method: method.ok_or_else(malformed)?.1,
            points: points.parse().map_err(|_| malformed())?,
            seed: seed.parse().map_err(|_| malformed())?,
        })
    }
}

/// A side of the box that is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Side {
    /// What varies.
    pub parameter: Coordinate,
    /// The least value.
    pub start: f64,
    /// The greatest value.
    pub stop: f64,
    /// Whether equal ratios are equally likely, instead of equal differences.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub log: bool,
}

impl Side {
    /// Reads a side as it is typed: `NAME=START:STOP`, or `NAME=log:START:STOP`.
    ///
    /// # Errors
    /// If the text has another form, or an end is out of the coordinate's range.
    pub fn parse(text: &str) -> Result<Self, SampleError> {
        let malformed = || SampleError::MalformedSide { text: text.to_owned() };
        let (name, range) = text.split_once('=').ok_or_else(malformed)?;
        let (range, log) = match range.trim().strip_prefix("log:") {
            Some(range) => (range, true),
            None => (range, false),
        };
        let (start, stop) = range.split_once(':').ok_or_else(malformed)?;
        let number = |text: &str| text.trim().parse::<f64>().map_err(|_| malformed());
        let side = Self {
            parameter: Coordinate::from_name(name.trim()).map_err(AxisError::from)?,
            start: number(start)?,
            stop: number(stop)?,
            log,
        };
        side.check().map(|()| side)
    }

    fn check(&self) -> Result<(), SampleError> {
        let (name, start, stop) = (self.parameter.name(), self.start, self.stop);
        self.parameter.check(start)?;
        self.parameter.check(stop)?;
        if !(start < stop && stop.is_finite()) {
            return Err(SampleError::Empty { name, start, stop });
        }
        if self.log && start <= 0.0 {
            return Err(SampleError::NotPositive { name, start });
        }
        Ok(())
    }

    /// The value at a share of the way from one end to the other.
    pub fn at(&self, share: f64) -> f64 {
        let value = if self.log {
            self.start * (self.stop / self.start).powf(share)
        } else {
            self.start + (self.stop - self.start) * share
        };
        // rounding does not lead out of the side
        if share >= 1.0 {
            self.stop
        } else {
            value.clamp(self.start, self.stop)
        }
    }
}

impl From<&Axis> for Side {
    /// The side between the least and the greatest value of an axis.
    fn from(axis: &Axis) -> Self {
        let [start, stop] = axis.ends();
        Self {
            parameter: axis.coordinate,
            start,
            stop,
            log: matches!(axis.spacing(), Spacing::Logarithmic { .. }),
        }
    }
}

/// A sample of a box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sample {
    method: Method,
    points: usize,
    seed: u32,
    over: Vec<Side>,
}

impl Sample {
    /// The most points: their values are held in memory.
    pub const MOST_POINTS: usize = 100_000_000;

    /// A sample of the box that these sides span.
    ///
    /// # Errors
    /// If there are no sides or no points, too many points, or a coordinate is there twice.
    pub fn new(plan: Plan, over: Vec<Side>) -> Result<Self, SampleError> {
        let Plan { method, points, seed } = plan;
        let sample = Self {
            method,
            points,
            seed,
            over,
        };
        sample.check()?;
        Ok(sample)
    }

    /// # Errors
    /// As [`Sample::new`].
    pub(super) fn check(&self) -> Result<(), SampleError> {
        if self.over.is_empty() {
            return Err(SampleError::NoSides);
        }
        if !(1..=Self::MOST_POINTS).contains(&self.points) {
            return Err(SampleError::Points { points: self.points });
        }
        if let Some(twice) = first_twice(&self.coordinates()) {
            return Err(SampleError::Twice { name: twice.name() });
        }
        self.over.iter().try_for_each(Side::check)
    }

    /// What varies.
    pub fn coordinates(&self) -> Vec<Coordinate> {
        self.over.iter().map(|side| side.parameter).collect()
    }

    /// Whether equal ratios of a side are equally likely.
    pub(super) fn is_logarithmic(&self, side: usize) -> bool {
        self.over[side].log
    }

    /// The values of all points, row by row.
    pub(super) fn values(&self) -> Vec<f64> {
        let sides = self.over.len();
        let shares = match self.method {
            Method::LatinHypercube => latin_hypercube(self.points, sides, self.seed),
            Method::Sobol => sobol(self.points, sides, self.seed),
        };
        let values = shares
            .chunks(sides)
            .flat_map(|row| self.over.iter().zip(row).map(|(side, &share)| side.at(share)));
        values.collect()
    }
}

/// A number from 0 to below 1.
pub(crate) fn uniform(generator: &mut ChaCha8Rng) -> f64 {
    (generator.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

fn latin_hypercube(points: usize, sides: usize, seed: u32) -> Vec<f64> {
    let mut generator = ChaCha8Rng::seed_from_u64(seed.into());
    let mut shares = vec![0.0; points * sides];
    for side in 0..sides {
        let mut slices: Vec<usize> = (0..points).collect();
        // Fisher and Yates
        for last in (1..points).rev() {
            let other = (uniform(&mut generator) * (last + 1) as f64) as usize;
            slices.swap(last, other);
        }
        for (point, slice) in slices.into_iter().enumerate() {
            shares[point * sides + side] = (slice as f64 + uniform(&mut generator)) / points as f64;
        }
    }
    shares
}

fn sobol(points: usize, sides: usize, seed: u32) -> Vec<f64> {
    let mut generator = ChaCha8Rng::seed_from_u64(seed.into());
    let seeds: Vec<u32> = (0..sides).map(|_| generator.next_u32()).collect();
    let sequence = Sobol::<u32>::new(sides, &JoeKuoD6::minimal());
    let scrambled = |row: Vec<u32>| {
        let digits = row
            .into_iter()
            .zip(&seeds)
            .map(|(digits, &seed)| scramble(digits, seed));
        // the middle of the interval that the digits name
        digits
            .map(|digits| (f64::from(digits) + 0.5) / 2f64.powi(32))
            .collect::<Vec<_>>()
    };
    sequence.take(points).flat_map(scrambled).collect()
}

/// Owen's scrambling by a hash: each binary digit is flipped or not. This depends on a hash of the seed and of all digits before it. The
/// hash is that of Laine and Karras (2011) with the constants of Vegdahl (2021); it works on the digits in reverse.
fn scramble(digits: u32, seed: u32) -> u32 {
    let mut x = digits.reverse_bits();
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

/// Why something is no sample.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages tell what each is")]
pub enum SampleError {
    #[error(
        "`{text}` is no sample: write sobol:POINTS or lhs:POINTS, or with a seed sobol:POINTS:SEED, such as sobol:4096"
    )]
    Malformed { text: String },
    #[error("`{text}` is no side of a sample: write NAME=START:STOP or NAME=log:START:STOP, such as zeta_k=3:5")]
    MalformedSide { text: String },
    #[error(transparent)]
    Coordinate(#[from] AxisError),
    #[error("{name} = {start}:{stop} has no values: give the lower end first")]
    Empty { name: &'static str, start: f64, stop: f64 },
    #[error("{name} begins at {start}: the values of a logarithmic side are above 0")]
    NotPositive { name: &'static str, start: f64 },
    #[error("a sample needs at least one side: write NAME=START:STOP, such as zeta_k=3:5")]
    NoSides,
    #[error("a sample of {points} points cannot be: it has from 1 to {most}", most = Sample::MOST_POINTS)]
    Points { points: usize },
    #[error("two sides are {name}: give each its own")]
    Twice { name: &'static str },
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first points of Joe and Kuo's own table, new-joe-kuo-6.21201, as their program prints them for three dimensions.
    #[test]
    fn the_sequence_begins_as_published() {
        let published = [
            [0.0, 0.0, 0.0],
            [0.5, 0.5, 0.5],
            [0.75, 0.25, 0.25],
            [0.25, 0.75, 0.75],
            [0.375, 0.375, 0.625],
            [0.875, 0.875, 0.125],
            [0.625, 0.125, 0.875],
            [0.125, 0.625, 0.375],
            [0.1875, 0.3125, 0.9375],
            [0.6875, 0.8125, 0.4375],
        ];
        let sequence = Sobol::<u32>::new(3, &JoeKuoD6::minimal());
        for (point, expected) in sequence.zip(published) {
            let shares: Vec<f64> = point
                .into_iter()
                .map(|digits| f64::from(digits) / 2f64.powi(32))
                .collect();
            assert_eq!(shares, expected);
        }
    }

    /// Of 2^k points, each interval of length 2^-k has one, in every dimension. In the plane of the first two dimensions, so has each
    /// cell of the area 2^-k.
    #[test]
    fn scrambled_points_lie_as_evenly_as_those_of_the_sequence() {
        let (points, sides) = (256, 5);
        for seed in [1, 2] {
            let shares = sobol(points, sides, seed);
            let row = |point: usize| &shares[point * sides..][..sides];
            let is_one_in_each = |cell: &dyn Fn(usize) -> usize| {
                let mut seen = vec![false; points];
                (0..points).for_each(|point| seen[cell(point)] = true);
                seen.into_iter().all(|seen| seen)
            };
            for side in 0..sides {
                assert!(is_one_in_each(&|point| (row(point)[side] * 256.0) as usize), "{side}");
            }
            for (across, up) in [(16.0, 16.0), (4.0, 64.0), (128.0, 2.0)] {
                let cell =
                    |point: usize| (row(point)[0] * across) as usize * up as usize + (row(point)[1] * up) as usize;
                assert!(is_one_in_each(&cell), "{across} x {up}");
            }
        }
        assert_ne!(sobol(8, 2, 1), sobol(8, 2, 2));
        // a shorter sample is the beginning of a longer one
        assert_eq!(sobol(64, 3, 1)[..30], sobol(10, 3, 1)[..]);
    }

    #[test]
    fn a_latin_hypercube_has_one_point_in_each_slice_of_every_side() {
        let (points, sides) = (37, 4);
        let shares = latin_hypercube(points, sides, 5);
        for side in 0..sides {
            let mut slices: Vec<usize> = (0..points)
                .map(|point| (shares[point * sides + side] * 37.0) as usize)
                .collect();
            assert_ne!(slices, (0..points).collect::<Vec<_>>());
            slices.sort_unstable();
            assert_eq!(slices, (0..points).collect::<Vec<_>>());
        }
        assert_eq!(shares, latin_hypercube(points, sides, 5));
        assert_ne!(shares, latin_hypercube(points, sides, 6));
    }

    #[test]
    fn samples_fill_their_box_evenly_or_by_ratios() {
        let over = ["zeta_k=3:5", "gamma=log:0.01:1"].map(|side| Side::parse(side).unwrap());
        let sample = Sample::new("sobol:1024:3".parse().unwrap(), over.to_vec()).unwrap();
        let values = sample.values();
        let mean =
            |column: usize, of: &dyn Fn(f64) -> f64| values.chunks(2).map(|row| of(row[column])).sum::<f64>() / 1024.0;
        assert!((mean(0, &|value| value) - 4.0).abs() < 1e-3);
        assert!((mean(1, &f64::log10) + 1.0).abs() < 1e-3);
        assert!(
            values
                .chunks(2)
                .all(|row| (3.0..5.0).contains(&row[0]) && (0.01..1.0).contains(&row[1]))
        );
    }

    #[test]
    fn what_is_no_sample_is_refused_with_a_reason() {
        for text in ["sobol", "sobol:x", "grid:10", "sobol:8:1:2", "lhs:-3"] {
            assert!(text.parse::<Plan>().is_err(), "{text}");
        }
        for (text, expected) in [
            ("zeta_k", "is no side"),
            ("zeta_k=3", "is no side"),
            ("zeta_k=5:3", "lower end first"),
            ("zeta_k=3:3", "has no values"),
            ("gamma=log:0:1", "above 0"),
            ("zeta=1:2", "zeta_k"),
            ("zeta_k=-1:2", "out of range"),
        ] {
            let message = Side::parse(text).unwrap_err().to_string();
            assert!(message.contains(expected), "{text}: {message}");
        }
        let side = Side::parse("zeta_k=3:5").unwrap();
        let new = |plan: &str, over: &[Side]| Sample::new(plan.parse().unwrap(), over.to_vec());
        assert!(matches!(new("lhs:0", &[side]), Err(SampleError::Points { points: 0 })));
        assert!(matches!(new("lhs:8", &[]), Err(SampleError::NoSides)));
        assert!(matches!(new("lhs:8", &[side, side]), Err(SampleError::Twice { .. })));
    }
}
