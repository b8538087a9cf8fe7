//! Axes: the values of one coordinate, and how they are typed.
//!
//! Owns their spacing and the form in commands and files; knows nothing of other axes.

use serde::{Deserialize, Serialize};

use super::error::MOST_VALUES;
use super::{AxisError, Coordinate};

/// Values of one coordinate, given by two ends and a count, or one by one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub struct Axis {
    /// The coordinate that takes the values; they are in its unit.
    pub coordinate: Coordinate,
    spacing: Spacing,
}

/// How the values of an axis lie. `start` is the first value and may be the greater end; `count` is the number of values.
#[derive(Clone, Debug, PartialEq)]
pub enum Spacing {
    /// At equal distances, both ends included.
    #[allow(missing_docs, reason = "the doc of the type explains the fields of both kinds")]
    Even { start: f64, stop: f64, count: usize },
    /// At equal ratios, both ends included.
    #[allow(missing_docs, reason = "the doc of the type explains the fields of both kinds")]
    Logarithmic { start: f64, stop: f64, count: usize },
    /// One by one, in any order.
    Listed(Vec<f64>),
}

/// The form of an axis in files.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    parameter: Coordinate,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    spacing: Option<WrittenSpacing>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    start: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    stop: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    count: Option<usize>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    values: Option<Vec<f64>>,
}

#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum WrittenSpacing {
    Even,
    Log,
}

impl TryFrom<Written> for Axis {
    type Error = AxisError;
    fn try_from(written: Written) -> Result<Self, AxisError> {
        let Written {
            parameter,
            spacing,
            start,
            stop,
            count,
            values,
        } = written;
        match (start, stop, count, values) {
            (Some(start), Some(stop), Some(count), None) => match spacing.unwrap_or(WrittenSpacing::Even) {
                WrittenSpacing::Even => Self::even(parameter, start, stop, count),
                WrittenSpacing::Log => Self::logarithmic(parameter, start, stop, count),
            },
            (None, None, None, Some(values)) if spacing.is_none() => Self::listed(parameter, values),
            _ => Err(AxisError::Incomplete { name: parameter.name() }),
        }
    }
}

impl From<Axis> for Written {
    fn from(axis: Axis) -> Self {
        let (spacing, ends, values) = match axis.spacing {
            Spacing::Even { start, stop, count } => (None, Some((start, stop, count)), None),
            Spacing::Logarithmic { start, stop, count } => {
                (Some(WrittenSpacing::Log), Some((start, stop, count)), None)
            }
            Spacing::Listed(values) => (None, None, Some(values)),
        };
        Self {
            parameter: axis.coordinate,
            spacing,
            start: ends.map(|(start, ..)| start),
            stop: ends.map(|(_, stop, _)| stop),
            count: ends.map(|(.., count)| count),
            values,
        }
    }
}

impl Axis {
    /// The most values an axis may have.
    pub const MAX_COUNT: usize = MOST_VALUES;

    /// `count` values at equal distances from `start` to `stop`, both included, of a coordinate or its name.
    ///
    /// # Errors
    /// If there is no coordinate of that name, an end is out of its range or infinite, the ends are equal, or the count is below 2 or
    /// above [`Axis::MAX_COUNT`].
    pub fn even<C>(coordinate: C, start: f64, stop: f64, count: usize) -> Result<Self, AxisError>
    where
        C: TryInto<Coordinate>,
        AxisError: From<C::Error>,
    {
        Self::of(coordinate.try_into()?, Spacing::Even { start, stop, count })
    }

    /// `count` values at equal ratios from `start` to `stop`, both included, of a coordinate or its name.
    ///
    /// # Errors
    /// As [`Axis::even`]; and if an end is not above 0.
    pub fn logarithmic<C>(coordinate: C, start: f64, stop: f64, count: usize) -> Result<Self, AxisError>
    where
        C: TryInto<Coordinate>,
        AxisError: From<C::Error>,
    {
        Self::of(coordinate.try_into()?, Spacing::Logarithmic { start, stop, count })
    }

    /// The given values, in their order, of a coordinate or its name.
    ///
    /// # Errors
    /// If there is no coordinate of that name, if a value is out of its range, infinite or repeated, or if there are fewer than 2
    /// or more than [`Axis::MAX_COUNT`] values.
    pub fn listed<C>(coordinate: C, values: impl Into<Vec<f64>>) -> Result<Self, AxisError>
    where
        C: TryInto<Coordinate>,
        AxisError: From<C::Error>,
    {
        Self::of(coordinate.try_into()?, Spacing::Listed(values.into()))
    }

    fn of(coordinate: Coordinate, spacing: Spacing) -> Result<Self, AxisError> {
        let axis = Self { coordinate, spacing };
        let (name, count) = (coordinate.name(), axis.count());
        if !(2..=Self::MAX_COUNT).contains(&count) {
            return Err(AxisError::Count { name, count });
        }
        for value in axis.given() {
            coordinate.check(value)?;
            if !value.is_finite() {
                return Err(AxisError::Infinite { name });
            }
        }
        match &axis.spacing {
            Spacing::Even { start, stop, .. } | Spacing::Logarithmic { start, stop, .. } if start == stop => {
                return Err(AxisError::Empty { name, value: *start });
            }
            Spacing::Logarithmic { start, stop, .. } => {
                if let Some(value) = [*start, *stop].into_iter().find(|&end| end <= 0.0) {
                    return Err(AxisError::NotPositive { name, value });
                }
            }
            Spacing::Even { .. } => {}
            Spacing::Listed(values) => {
                let mut sorted = values.clone();
                sorted.sort_by(f64::total_cmp);
                if let Some(pair) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
                    return Err(AxisError::Twice { name, value: pair[0] });
                }
            }
        }
        Ok(axis)
    }

    /// Reads an axis as it is typed: `NAME=START:STOP:COUNT`, `NAME=log:START:STOP:COUNT`, or `NAME=V1,V2,...`.
    ///
    /// # Errors
    /// If the text has another form, or as [`Axis::even`], [`Axis::logarithmic`] and [`Axis::listed`].
    pub fn parse(text: &str) -> Result<Self, AxisError> {
        let malformed = || AxisError::Malformed { text: text.to_owned() };
        let (name, values) = text.split_once('=').ok_or_else(malformed)?;
        let coordinate = Coordinate::from_name(name.trim())?;
        let values = values.trim();
        let number = |text: &str| text.trim().parse::<f64>().map_err(|_| malformed());
        if values.is_empty() {
            return Err(AxisError::Count {
                name: coordinate.name(),
                count: 0,
            });
        }
        if !values.contains(':') {
            let values: Vec<f64> = values.split(',').map(number).collect::<Result<_, _>>()?;
            return Self::listed(coordinate, values);
        }
        let (range, is_logarithmic) = match values.strip_prefix("log:") {
            Some(range) => (range, true),
            None => (values, false),
        };
        let fields: Vec<&str> = range.split(':').collect();
        let [start, stop, count] = fields[..] else {
            return Err(malformed());
        };
        let (start, stop) = (number(start)?, number(stop)?);
        let count = count.trim().parse().map_err(|_| malformed())?;
        if is_logarithmic {
            Self::logarithmic(coordinate, start, stop, count)
        } else {
            Self::even(coordinate, start, stop, count)
        }
    }

    /// The spacing of the values, as it was requested.
    pub fn spacing(&self) -> &Spacing {
        &self.spacing
    }

    /// Number of values.
    pub fn count(&self) -> usize {
        match &self.spacing {
            Spacing::Even { count, .. } | Spacing::Logarithmic { count, .. } => *count,
            Spacing::Listed(values) => values.len(),
        }
    }

    /// The ends, or all values of a list.
    fn given(&self) -> Vec<f64> {
        match &self.spacing {
            Spacing::Even { start, stop, .. } | Spacing::Logarithmic { start, stop, .. } => vec![*start, *stop],
            Spacing::Listed(values) => values.clone(),
        }
    }

    /// The first value.
    pub fn first(&self) -> f64 {
        self.value(0)
    }

    /// The last value.
    pub fn last(&self) -> f64 {
        self.value(self.count() - 1)
    }

    /// Least and greatest value.
    pub fn ends(&self) -> [f64; 2] {
        let given = self.given();
        let least = given.iter().copied().fold(f64::INFINITY, f64::min);
        let greatest = given.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        [least, greatest]
    }

    /// Values at equal distances, derived from another axis. They are not checked, and a single value is allowed.
    pub(crate) fn fine(coordinate: Coordinate, start: f64, stop: f64, count: usize) -> Self {
        Self {
            coordinate,
            spacing: Spacing::Even { start, stop, count },
        }
    }

    /// The axis reduced to its two ends.
    pub(super) fn between_ends(&self) -> Self {
        Self {
            coordinate: self.coordinate,
            spacing: Spacing::Listed(self.ends().to_vec()),
        }
    }

    /// The value at `index` in `0..count`; the ends are exact. A value that is a short decimal is bit for bit the number that
    /// one gets by typing it. One can therefore find it by its value.
    pub fn value(&self, index: usize) -> f64 {
        let part = |count: usize| index as f64 / (count - 1) as f64;
        match &self.spacing {
            Spacing::Even { start, stop, count } | Spacing::Logarithmic { start, stop, count }
                if index == 0 || index + 1 == *count =>
            {
                if index == 0 {
                    *start
                } else {
                    *stop
                }
            }
            Spacing::Even { start, stop, count } => {
                let t = part(*count);
                // the sum has a rounding error of a few spacings of f64 at the larger end
                as_typed(start * (1.0 - t) + stop * t, start.abs().max(stop.abs()), 4.0)
            }
            Spacing::Logarithmic { start, stop, count } => {
                let t = part(*count);
                let value = (start.ln() * (1.0 - t) + stop.ln() * t).exp();
                // the relative error of the value is the rounding error of the logarithm, which is proportional to its size
                as_typed(value, value, 4.0 * (2.0 + value.ln().abs()))
            }
            Spacing::Listed(values) => values[index],
        }
    }

    /// All values, in their order.
    pub fn values(&self) -> Vec<f64> {
        (0..self.count()).map(|index| self.value(index)).collect()
    }

    /// The position of a value among the rising values: 0 is the least one, `count - 1` the greatest. Between neighbours the
    /// position is linear in the value, or in its logarithm on a logarithmic axis; beyond the ends it is extrapolated.
    pub fn place(&self, value: f64) -> f64 {
        let between = |low: f64, high: f64, part: f64| (part - low) / (high - low);
        match &self.spacing {
            Spacing::Even { start, stop, count } => {
                let step = (stop - start) / (count - 1) as f64;
                (value - start.min(*stop)) / step.abs()
            }
            Spacing::Logarithmic { start, stop, count } => {
                let [low, high] = [start.min(*stop), start.max(*stop)].map(f64::ln);
                (count - 1) as f64 * between(low, high, value.ln())
            }
            Spacing::Listed(values) => {
                let mut sorted = values.clone();
                sorted.sort_by(f64::total_cmp);
                let above = sorted
                    .partition_point(|&other| other < value)
                    .clamp(1, sorted.len() - 1);
                (above - 1) as f64 + between(sorted[above - 1], sorted[above], value)
            }
        }
    }

    /// The axis with `count` values between the same ends: at equal ratios if this axis is logarithmic, else at equal distances.
    #[must_use]
    pub fn resampled(&self, count: usize) -> Self {
        let mut axis = self.clone();
        match &mut axis.spacing {
            Spacing::Even { count: own, .. } | Spacing::Logarithmic { count: own, .. } => *own = count,
            Spacing::Listed(_) => {
                let [start, stop] = self.ends();
                axis.spacing = Spacing::Even { start, stop, count };
            }
        }
        axis
    }

    /// Indices in the order in which the values rise.
    pub fn rising(&self) -> Vec<usize> {
        let values = self.values();
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
        order
    }
}

/// Significant digits of a short decimal, counted from the first digit of the scale.
const DIGITS: f64 = 13.0;

/// The short decimal next to `value`, if they differ by at most `spacings` spacings of f64 at `scale`; else `value` itself.
fn as_typed(value: f64, scale: f64, spacings: f64) -> f64 {
    if !scale.is_normal() {
        return value;
    }
    let decimals = (DIGITS - 1.0 - scale.log10().floor()).max(0.0) as usize;
    let decimal: f64 = format!("{value:.decimals$}").parse().expect("it was a number");
    if (decimal - value).abs() <= spacings * f64::EPSILON * scale {
        decimal
    } else {
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_that_is_a_short_decimal_is_what_typing_it_gives() {
        // start, stop, count, and the values as whole multiples of a power of ten
        for (text, first, step, decimals) in [
            ("h1=0:1.5:301", 0, 5, 3),
            ("zeta_k=0:12:2401", 0, 5, 3),
            ("x0=-1:1:201", -100, 1, 2),
            ("h1=0.1:0.7:7", 1, 1, 1),
            ("zeta_k=5:3:201", 500, -1, 2),
            ("gamma=0:0.06:121", 0, 5, 4),
            ("zeta_k=3.5:4:5001", 35_000, 1, 4),
            ("epsilon_0=1e-9:1e-6:1000", 1, 1, 9),
            ("omega_tilde=100:1000:181", 100, 5, 0),
        ] {
            let axis = Axis::parse(text).unwrap();
            for (index, value) in axis.values().into_iter().enumerate() {
                let whole: i64 = first + step * index as i64;
                let typed: f64 = format!("{whole}e-{decimals}").parse().unwrap();
                assert_eq!(value.to_bits(), (typed + 0.0).to_bits(), "{text}: {typed} at {index}");
            }
        }
    }

    #[test]
    fn other_values_are_left_as_they_are_and_ends_are_met() {
        let axis = Axis::parse("zeta_k=3:5:600").unwrap();
        for (index, value) in axis.values().into_iter().enumerate() {
            assert!((value - (3.0 + 2.0 * index as f64 / 599.0)).abs() <= 5e-15, "{index}");
        }
        let axis = Axis::parse("h1=0.12345678901234567:1.0000000000000002:7").unwrap();
        assert_eq!(
            (axis.value(0), axis.value(6)),
            (0.123_456_789_012_345_67, 1.000_000_000_000_000_2)
        );
    }

    #[test]
    fn logarithmic_values_have_equal_ratios_and_are_the_decimals_that_they_are() {
        let axis = Axis::parse("gamma=log:1e-3:10:5").unwrap();
        assert_eq!(axis.values(), [0.001, 0.01, 0.1, 1.0, 10.0]);
        assert_eq!(axis.ends(), [0.001, 10.0]);
        let falling = Axis::parse("omega_0=log:10:0.01:201").unwrap();
        for (index, pair) in falling.values().windows(2).enumerate() {
            let ratio = pair[1] / pair[0];
            assert!((ratio / 1e-3f64.powf(1.0 / 200.0) - 1.0).abs() < 1e-14, "{index}");
        }
        assert_eq!((falling.first(), falling.last()), (10.0, 0.01));
        assert_eq!(falling.rising()[..2], [200, 199]);
    }

    #[test]
    fn listed_values_keep_their_order() {
        let axis = Axis::parse("gamma = 1, 0.1,0.3").unwrap();
        assert_eq!(axis.values(), [1.0, 0.1, 0.3]);
        assert_eq!((axis.ends(), axis.rising()), ([0.1, 1.0], vec![1, 2, 0]));
    }

    #[test]
    fn places_are_the_ranks_of_values_whatever_the_spacing() {
        for text in ["h1=2:0:5", "gamma=log:1e-3:10:5", "gamma=3,1,0.2,7"] {
            let axis = Axis::parse(text).unwrap();
            for (rank, index) in axis.rising().into_iter().enumerate() {
                assert!((axis.place(axis.value(index)) - rank as f64).abs() < 1e-12, "{text}");
            }
        }
        let place = |text: &str, value| Axis::parse(text).unwrap().place(value);
        assert!((place("gamma=log:0.01:1:3", 0.1f64.sqrt()) - 1.5).abs() < 1e-12);
        assert!((place("gamma=3,1,0.2,7", 5.0) - 2.5).abs() < 1e-12);
        assert!((place("gamma=1,2,4", 5.0) - 2.5).abs() < 1e-12);
    }

    #[test]
    fn the_form_in_files_is_read_back() {
        for text in [
            "gamma=0:1:11",
            "gamma=log:0.01:1:3",
            "gamma=1,0.5",
            "interference=1e-9:2e-9:3",
        ] {
            let axis = Axis::parse(text).unwrap();
            let written = toml::to_string(&axis).unwrap();
            assert_eq!(toml::from_str::<Axis>(&written).unwrap(), axis, "{written}");
        }
        for (written, reason) in [
            ("parameter = 'h1'\nstart = 0\nstop = 1", "needs start, stop and count"),
            (
                "parameter = 'h1'\nstart = 0\nvalues = [0, 1]",
                "needs start, stop and count",
            ),
            (
                "parameter = 'h1'\nspacing = 'log'\nvalues = [1, 2]",
                "needs start, stop and count",
            ),
            (
                "parameter = 'gamma'\nspacing = 'log'\nstart = 0\nstop = 1\ncount = 3",
                "an end at 0",
            ),
            ("parameter = 'gamma'\nvalues = []", "has 0 values"),
        ] {
            let message = toml::from_str::<Axis>(written).unwrap_err().to_string();
            assert!(message.contains(reason), "{written}: {message}");
        }
    }

    #[test]
    fn bad_axes_are_refused_with_a_reason() {
        for (text, reason) in [
            ("zeta_k", "NAME=START:STOP:COUNT"),
            ("zeta_k=0:1", "NAME=START:STOP:COUNT"),
            ("zeta_k=0:1:x", "NAME=START:STOP:COUNT"),
            ("zeta_k=0:1:-3", "NAME=START:STOP:COUNT"),
            ("zeta_k=1:1:5", "two different ends"),
            ("zeta_k=0:1:1", "needs 2"),
            ("zeta_k=0:NaN:5", "out of range"),
            ("zeta_k=0:inf:5", "out of range"),
            ("ramp_rate=1:inf:5", "runs to infinity"),
            ("epsilon_0=0:1:5", "out of range"),
            ("zetta_k=0:1:5", "did you mean"),
            ("gamma=", "has 0 values"),
            ("gamma=1", "has 1 values"),
            ("gamma=1,2,1", "the value 1 twice"),
            ("gamma=1,x", "NAME=V1,V2"),
            ("gamma=1,inf", "out of range"),
            ("gamma=log:0:1:5", "an end at 0"),
            ("omega_k=log:-1:1:5", "an end at -1"),
            ("gamma=log:1:1:5", "two different ends"),
            ("gamma=log:1:2", "NAME=log:START:STOP:COUNT"),
            ("gamma=lin:1:2:3", "NAME=START:STOP:COUNT"),
            ("intereference=0:1:5", "did you mean `interference`"),
            (
                "interference=-1e-9:1e-9:5",
                "interference = -0.000000001 m is out of range",
            ),
        ] {
            let message = Axis::parse(text).unwrap_err().to_string();
            assert!(message.contains(reason), "{text}: {message}");
        }
    }
}
