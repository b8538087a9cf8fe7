//! Lists of points.
//!
//! Owns that every value of a list is one that its coordinate may take; knows nothing of files.

use serde::{Deserialize, Serialize};

use super::{Coordinate, first_twice};

/// Points one by one: a value of each coordinate for every point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub struct Points {
    coordinates: Vec<Coordinate>,
    /// Row by row, a row for each point.
    values: Vec<f64>,
}

/// The form of a list in files.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    columns: Vec<Coordinate>,
    rows: Vec<Vec<f64>>,
}

impl TryFrom<Written> for Points {
    type Error = PointsError;
    fn try_from(written: Written) -> Result<Self, PointsError> {
        Self::new(written.columns, &written.rows)
    }
}

impl From<Points> for Written {
    fn from(points: Points) -> Self {
        let rows = (0..points.len()).map(|index| points.row(index).to_vec()).collect();
        Self {
            columns: points.coordinates,
            rows,
        }
    }
}

impl Points {
    /// The points whose values of `coordinates` are the rows.
    ///
    /// # Errors
    /// All that is wrong with them, row by row: see [`PointsError`].
    pub fn new<Row: AsRef<[f64]>>(coordinates: Vec<Coordinate>, rows: &[Row]) -> Result<Self, PointsError> {
        let columns = coordinates.len();
        if columns == 0 || rows.is_empty() {
            return Err(PointsError::Empty);
        }
        if let Some(twice) = first_twice(&coordinates) {
            return Err(PointsError::ColumnTwice { name: twice.name() });
        }
        let mut faults = Vec::new();
        for (index, row) in rows.iter().enumerate() {
            let (number, row) = (index + 1, row.as_ref());
            if row.len() != columns {
                faults.push(format!("row {number} has {} values for {columns} columns", row.len()));
                continue;
            }
            for (coordinate, &value) in coordinates.iter().zip(row) {
                if let Err(error) = coordinate.check(value) {
                    faults.push(format!("row {number}, column {coordinate}: {error}"));
                }
            }
        }
        if !faults.is_empty() {
            return Err(PointsError::Values { faults });
        }
        Ok(Self {
            coordinates,
            values: rows.iter().flat_map(|row| row.as_ref().iter().copied()).collect(),
        })
    }

    /// What the values of a row are of, in their order.
    pub fn coordinates(&self) -> &[Coordinate] {
        &self.coordinates
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.values.len() / self.coordinates.len()
    }

    /// Whether there is no point; never the case.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The values of a point, in the order of the coordinates.
    pub fn row(&self, index: usize) -> &[f64] {
        let columns = self.coordinates.len();
        &self.values[index * columns..][..columns]
    }

    /// Least and greatest value of each coordinate.
    pub fn ends(&self) -> Vec<[f64; 2]> {
        let empty = vec![[f64::INFINITY, f64::NEG_INFINITY]; self.coordinates.len()];
        (0..self.len()).fold(empty, |mut ends, index| {
            for (ends, &value) in ends.iter_mut().zip(self.row(index)) {
                *ends = [ends[0].min(value), ends[1].max(value)];
            }
            ends
        })
    }
}

/// Why something is no list of points.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages tell what each is")]
pub enum PointsError {
    #[error("the list of points is empty: give it at least one column and one row")]
    Empty,
    #[error("the list of points has the column {name} twice: leave one out")]
    ColumnTwice { name: &'static str },
    #[error("the list of points has {} faulty values:\n{}", faults.len(), shown(faults))]
    Values {
        /// One for each, naming row, column, value and limit.
        faults: Vec<String>,
    },
}

/// Faults that a message names one by one.
const SHOWN: usize = 20;

fn shown(faults: &[String]) -> String {
    let mut lines: Vec<String> = faults.iter().take(SHOWN).map(|fault| format!("  {fault}")).collect();
    if faults.len() > SHOWN {
        lines.push(format!("  and {} more", faults.len() - SHOWN));
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Parameter::{H1, ZetaK};

    fn points(rows: &[&[f64]]) -> Result<Points, PointsError> {
        Points::new(vec![ZetaK.into(), H1.into()], rows)
    }

    #[test]
    fn a_list_keeps_its_rows_and_is_read_back() {
        let list = points(&[&[3.0, 0.5], &[4.0, -0.25], &[3.5, 0.1]]).unwrap();
        assert_eq!((list.len(), list.row(1)), (3, &[4.0, -0.25][..]));
        assert_eq!(list.ends(), [[3.0, 4.0], [-0.25, 0.5]]);
        let written = toml::to_string(&list).unwrap();
        assert_eq!(toml::from_str::<Points>(&written).unwrap(), list, "{written}");
    }

    #[test]
    fn every_fault_is_named_with_its_place() {
        let error = points(&[&[3.0, 0.5], &[-4.0, f64::NAN], &[1.0]])
            .unwrap_err()
            .to_string();
        for part in [
            "3 faulty values",
            "row 2, column zeta_k: zeta_k = -4 is out of range",
            "row 2, column h1: h1 = NaN is out of range",
            "row 3 has 1 values for 2 columns",
        ] {
            assert!(error.contains(part), "{error}");
        }
        assert_eq!(points(&[]), Err(PointsError::Empty));
        let twice = Points::new(vec![H1.into(), H1.into()], &[[1.0, 1.0]]);
        assert_eq!(twice, Err(PointsError::ColumnTwice { name: "h1" }));
    }
}
