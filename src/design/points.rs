//! Lists of points.
//!
//! Owns the check that every value of a list is allowed for its coordinate; knows nothing of files.

use serde::{Deserialize, Serialize};

use super::{AxisError, Coordinate, Sample, SampleError, first_twice};

/// Points one by one: a value of each coordinate for every point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub struct Points {
    coordinates: Vec<Coordinate>,
    /// Row by row, a row for each point.
    values: Vec<f64>,
    /// The sample that they are, if they are one: it stands for them in files.
    sample: Option<Sample>,
}

/// The form of a list in files: columns and rows, or a sample.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    columns: Option<Vec<Coordinate>>,
    /// Instead of the rows, if these are kept elsewhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    count: Option<usize>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    rows: Option<Vec<Vec<f64>>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sample: Option<Sample>,
}

impl TryFrom<Written> for Points {
    type Error = PointsError;
    fn try_from(written: Written) -> Result<Self, PointsError> {
        match (written.columns, written.count, written.rows, written.sample) {
            (Some(columns), None, Some(rows), None) => Self::new(columns, &rows),
            (Some(_), Some(count), None, None) => Err(PointsError::Elsewhere { count }),
            (None, None, None, Some(sample)) => {
                sample.check()?;
                Ok(Self::from(sample))
            }
            _ => Err(PointsError::Incomplete),
        }
    }
}

impl From<Points> for Written {
    fn from(points: Points) -> Self {
        if points.sample.is_some() {
            return Self {
                columns: None,
                count: None,
                rows: None,
                sample: points.sample,
            };
        }
        let rows = (0..points.len()).map(|index| points.row(index).to_vec()).collect();
        Self {
            columns: Some(points.coordinates),
            count: None,
            rows: Some(rows),
            sample: None,
        }
    }
}

impl From<Sample> for Points {
    fn from(sample: Sample) -> Self {
        Self {
            coordinates: sample.coordinates(),
            values: sample.values(),
            sample: Some(sample),
        }
    }
}

impl Points {
    /// The points whose values of `coordinates` are the rows.
    ///
    /// # Errors
    /// [`PointsError`], which names all faults of the rows.
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
            sample: None,
        })
    }

    /// Reads a table of comma-separated values: names of coordinates in the first line, a point in each other one. Lines that begin
    /// with `#` are comments; a byte order mark is passed over.
    ///
    /// # Errors
    /// If the text is not UTF-8, a name is unknown, or as [`Points::new`], with all faults of the table at once.
    pub fn from_csv(text: &[u8]) -> Result<Self, PointsError> {
        let text = text.strip_prefix("\u{feff}".as_bytes()).unwrap_or(text);
        let text = std::str::from_utf8(text).map_err(|error| PointsError::Encoding {
            line: 1 + String::from_utf8_lossy(&text[..error.valid_up_to()])
                .matches('\n')
                .count(),
        })?;
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let header = reader.headers().map_err(|error| PointsError::Table {
            reason: error.to_string(),
        })?;
        let coordinates = header
            .iter()
            .map(Coordinate::from_name)
            .collect::<Result<Vec<_>, _>>()
            .map_err(AxisError::from)?;
        let (mut rows, mut faults) = (Vec::new(), Vec::new());
        for (index, record) in reader.records().enumerate() {
            let record = record.map_err(|error| PointsError::Table {
                reason: error.to_string(),
            })?;
            let mut row = Vec::with_capacity(record.len());
            for (column, field) in record.iter().enumerate() {
                row.push(field.parse().unwrap_or_else(|_| {
                    let name = coordinates
                        .get(column)
                        .map_or("beyond the last", |coordinate| coordinate.name());
                    faults.push(format!("row {}, column {name}: `{field}` is no number", index + 1));
                    0.0
                }));
            }
            rows.push(row);
        }
        match (Self::new(coordinates, &rows), faults.is_empty()) {
            (points, true) => points,
            (Err(PointsError::Values { faults: others }), false) => {
                faults.extend(others);
                Err(PointsError::Values { faults })
            }
            (_, false) => Err(PointsError::Values { faults }),
        }
    }

    /// What stands for a list in a file that holds its values as data; None for a sample, which is short.
    pub(crate) fn outline(&self) -> Option<impl Serialize + use<>> {
        self.sample.is_none().then(|| Written {
            columns: Some(self.coordinates.clone()),
            count: Some(self.len()),
            rows: None,
            sample: None,
        })
    }

    /// Takes the outline of a list out of the file of an experiment; returns its columns, or none if there is no outline.
    ///
    /// # Errors
    /// If the list has another form.
    pub(crate) fn take_outline(experiment: &mut toml::Table) -> Result<Vec<Coordinate>, toml::de::Error> {
        let points = experiment.get("points").and_then(toml::Value::as_table);
        if points.is_none_or(|points| !points.contains_key("count")) {
            return Ok(Vec::new());
        }
        let points = experiment.remove("points").expect("it was found");
        let written: Written = points.try_into()?;
        Ok(written.columns.unwrap_or_default())
    }

    /// The coordinates of the values in a row, in their order.
    pub fn coordinates(&self) -> &[Coordinate] {
        &self.coordinates
    }

    /// Whether a column was sampled so that equal ratios are equally likely.
    pub fn is_logarithmic(&self, column: usize) -> bool {
        self.sample.as_ref().is_some_and(|sample| sample.is_logarithmic(column))
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.values.len() / self.coordinates.len()
    }

    /// Whether there is no point; always false.
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

/// Why a list of points is not valid.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages tell what each is")]
pub enum PointsError {
    #[error("the list of points is empty: give it at least one column and one row")]
    Empty,
    #[error("a list of points has `columns` and `rows`, or a `sample`")]
    Incomplete,
    #[error(
        "the values of its {count} points are not in this text, but in the columns of the table or the coordinates of the store that it \
         comes from: give the store, or a table of these columns alone as --points"
    )]
    Elsewhere { count: usize },
    #[error(transparent)]
    Sample(#[from] SampleError),
    #[error(transparent)]
    Coordinate(#[from] AxisError),
    #[error("line {line} is not UTF-8: save the table in this encoding")]
    Encoding { line: usize },
    #[error("the table cannot be read: {reason}")]
    Table { reason: String },
    #[error("the list of points has the column {name} twice: leave one out")]
    ColumnTwice { name: &'static str },
    #[error("the list of points has {} faulty values:\n{}", faults.len(), shown(faults))]
    Values {
        /// A text for each fault, with row, column, value and limit.
        faults: Vec<String>,
    },
}

/// The most faults that a message names one by one.
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
    fn tables_are_read_with_comments_and_a_byte_order_mark() {
        let read = |text: &str| Points::from_csv(text.as_bytes());
        let list = points(&[&[3.0, 0.5], &[4.0, -0.25]]).unwrap();
        assert_eq!(read("zeta_k,h1\n3,0.5\n4,-0.25\n"), Ok(list.clone()));
        assert_eq!(
            read("\u{feff}# a note\r\nzeta_k, h1\r\n3.0,5e-1\r\n# more\r\n4, -0.25"),
            Ok(list)
        );
        let faults = read("zeta_k,h1\n3,\nabc,0.1\nNaN,0.2\n1,2,3\n")
            .unwrap_err()
            .to_string();
        for part in [
            "row 1, column h1: `` is no number",
            "row 2, column zeta_k: `abc` is no number",
            "row 3, column zeta_k: zeta_k = NaN is out of range",
            "row 4 has 3 values for 2 columns",
        ] {
            assert!(faults.contains(part), "{faults}");
        }
        assert_eq!(read("h1,h1\n1,2\n"), Err(PointsError::ColumnTwice { name: "h1" }));
        assert_eq!(read("zeta_k,h1\n"), Err(PointsError::Empty));
        assert!(read("zeta,h1\n1,2\n").unwrap_err().to_string().contains("zeta_k"));
        let latin = b"zeta_k,h1\n3,1\n# K\xfchler\n4,1\n";
        assert_eq!(Points::from_csv(latin), Err(PointsError::Encoding { line: 3 }));
    }

    #[test]
    fn a_sample_is_written_as_one() {
        let side = crate::design::Side::parse("zeta_k=3:5").unwrap();
        let points = Points::from(Sample::new("sobol:64".parse().unwrap(), vec![side]).unwrap());
        let written = toml::to_string(&points).unwrap();
        assert!(written.len() < 150, "{written}");
        assert_eq!(toml::from_str::<Points>(&written).unwrap(), points, "{written}");
        assert!(toml::from_str::<Points>(&written.replace("64", "0")).is_err());
        assert!(toml::from_str::<Points>("columns = [\"h1\"]").is_err());
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
