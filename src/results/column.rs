//! The values of one quantity, in the type that the quantity deserves.
//!
//! Owns the passage between these types and f64, in which values are computed and read.

use crate::measure::Values;

/// Stands for no code where a value is not computed, or does not apply.
pub const NO_CODE: u8 = u8::MAX;

/// Values of one quantity, one for each point. What is not computed, or does not apply, is NaN, and [`NO_CODE`] among codes.
#[derive(Clone, Debug)]
pub enum Column {
    /// Numbers whose small differences count.
    F64(Vec<f64>),
    /// Numbers of seven digits.
    F32(Vec<f32>),
    /// Indices into names.
    Code(Vec<u8>),
}

impl Column {
    /// A column of which nothing is computed.
    pub fn new(values: Values, points: usize) -> Self {
        match values {
            Values::F64 => Self::F64(vec![f64::NAN; points]),
            Values::F32 => Self::F32(vec![f32::NAN; points]),
            Values::Code(_) => Self::Code(vec![NO_CODE; points]),
        }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        match self {
            Self::F64(values) => values.len(),
            Self::F32(values) => values.len(),
            Self::Code(codes) => codes.len(),
        }
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The value of a point; NaN where it is not computed, or does not apply.
    ///
    /// # Panics
    /// If there is no such point.
    pub fn value(&self, index: usize) -> f64 {
        match self {
            Self::F64(values) => values[index],
            Self::F32(values) => values[index].into(),
            Self::Code(codes) if codes[index] == NO_CODE => f64::NAN,
            Self::Code(codes) => codes[index].into(),
        }
    }

    /// Sets the value of a point, rounded to the column's type.
    ///
    /// # Panics
    /// If there is no such point.
    pub fn set(&mut self, index: usize, value: f64) {
        match self {
            Self::F64(values) => values[index] = value,
            Self::F32(values) => values[index] = value as f32,
            Self::Code(codes) => codes[index] = if value.is_nan() { NO_CODE } else { value as u8 },
        }
    }

    /// All values, in the order of the points.
    pub fn values(&self) -> impl ExactSizeIterator<Item = f64> + Clone + '_ {
        (0..self.len()).map(|index| self.value(index))
    }

    /// Puts the values of another column of the same type in place of those from `first` on.
    ///
    /// # Panics
    /// If the types differ, or the other column reaches beyond the end.
    pub fn replace(&mut self, first: usize, other: &Self) {
        let places = first..first + other.len();
        match (self, other) {
            (Self::F64(values), Self::F64(others)) => values[places].copy_from_slice(others),
            (Self::F32(values), Self::F32(others)) => values[places].copy_from_slice(others),
            (Self::Code(codes), Self::Code(others)) => codes[places].copy_from_slice(others),
            _ => panic!("columns of one quantity have one type"),
        }
    }
}
