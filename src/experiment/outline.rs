//! The written form of an experiment without the values of a list of points, for files that hold these values as data.
//!
//! Owns what stands for the list; does not know where the values are.

use super::{Experiment, ExperimentError, Request};
use crate::design::{Coordinate, Points, Varied};

/// An experiment as it is read from such a text.
#[derive(Clone, Debug)]
pub struct Outline {
    request: Request,
    columns: Vec<Coordinate>,
}

impl Experiment {
    /// The experiment as TOML, as [`Experiment::to_toml`] gives it, but without the values of a list of points: it holds only the
    /// names of their columns and their number.
    #[expect(clippy::missing_panics_doc, reason = "names and numbers have a TOML form")]
    pub fn outline(&self) -> String {
        let Varied::Points(points) = &self.design.varied else {
            return self.to_toml();
        };
        let Some(outline) = points.outline() else {
            return self.to_toml();
        };
        let mut request = self.request();
        request.points = None;
        let outline = toml::to_string(&outline).expect("an outline has a TOML form");
        format!("{}\n[points]\n{outline}", request.result_toml())
    }
}

impl Outline {
    /// Reads the text of [`Experiment::outline`].
    ///
    /// # Errors
    /// As [`Request::from_toml`].
    pub fn from_toml(text: &str) -> Result<Self, ExperimentError> {
        let mut table: toml::Table = text.parse()?;
        let columns = Points::take_outline(&mut table)?;
        let request = if columns.is_empty() {
            Request::from_toml(text)?
        } else {
            table.try_into()?
        };
        Ok(Self { request, columns })
    }

    /// The columns whose values the text does not hold; none if it holds the whole experiment.
    pub fn columns(&self) -> &[Coordinate] {
        &self.columns
    }

    /// The whole experiment, given the values of each column.
    ///
    /// # Errors
    /// If a value is not allowed, or as [`Request::resolve`].
    pub fn complete(self, values: &[Vec<f64>]) -> Result<Experiment, ExperimentError> {
        let mut request = self.request;
        if !self.columns.is_empty() {
            let rows = values.iter().map(Vec::len).min().unwrap_or(0);
            let rows: Vec<Vec<f64>> = (0..rows)
                .map(|row| values.iter().map(|column| column[row]).collect())
                .collect();
            request.points = Some(Points::new(self.columns, &rows)?);
        }
        request.resolve()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::{Plan, Sample, Side};
    use crate::parameters::Parameter::{H1, ZetaK};

    #[test]
    fn a_list_is_outlined_by_its_columns_and_read_back_with_its_values() {
        let rows = [[3.0, 0.5], [4.0, 0.25], [3.5, 1.0 / 3.0]];
        let request = Request {
            points: Some(Points::new(vec![ZetaK.into(), H1.into()], &rows).unwrap()),
            ..Request::default()
        };
        let experiment = request.resolve().unwrap();
        let text = experiment.outline();
        assert!(text.contains("count = 3") && !text.contains("0.333"), "{text}");
        let outline = Outline::from_toml(&text).unwrap();
        assert_eq!(outline.columns(), [ZetaK.into(), H1.into()]);
        let columns = [0, 1].map(|column| rows.iter().map(|row| row[column]).collect());
        assert_eq!(outline.complete(&columns).unwrap(), experiment);
        let message = Request::from_toml(&text).unwrap_err().to_string();
        assert!(message.contains("--points"), "{message}");
    }

    #[test]
    fn what_is_short_is_written_whole() {
        let side = Side::parse("zeta_k=3:5").unwrap();
        let sample = Sample::new("sobol:64".parse::<Plan>().unwrap(), vec![side]).unwrap();
        for request in [
            Request::default(),
            Request {
                points: Some(Points::from(sample)),
                ..Request::default()
            },
        ] {
            let experiment = request.resolve().unwrap();
            let outline = Outline::from_toml(&experiment.outline()).unwrap();
            assert!(outline.columns().is_empty());
            assert_eq!(outline.complete(&[]).unwrap(), experiment);
        }
    }
}
