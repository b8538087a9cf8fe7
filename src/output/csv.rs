//! Tables of comma-separated values, with comments that describe their content; among them the table of the border of chaos.
//!
//! Owns their form; computes nothing, and finds no border itself.

use std::io::Write;
use std::path::Path;

use super::PROGRAM;
use super::whole::{WriteError, write_whole};
use crate::design::Coordinate;
use crate::map::{ParameterMap, border};

/// The comment above the lines of an experiment in a table.
const HEADING: &str = "experiment:";

/// Comments that hold an experiment in TOML.
pub fn experiment_comments(toml: &str) -> impl Iterator<Item = String> + '_ {
    let lines = toml.lines().filter(|line| !line.is_empty()).map(str::to_owned);
    std::iter::once(HEADING.to_owned()).chain(lines)
}

/// The experiment in the comments of a table, if there is one.
pub fn experiment_in(table: &str) -> Option<String> {
    let comments = table.lines().map_while(|line| line.strip_prefix("# "));
    let mut toml = comments.skip_while(|&comment| comment != HEADING);
    toml.next()?;
    Some(toml.flat_map(|line| [line, "\n"]).collect())
}

/// Writes a table: comments, the names of the columns, and rows of values. A value that is not finite is left empty.
///
/// # Errors
/// [`WriteError`] if the file cannot be written.
pub fn write_table<const N: usize>(
    path: &Path,
    comments: &[String],
    columns: [&str; N],
    rows: impl Iterator<Item = [f64; N]>,
) -> Result<(), WriteError> {
    write_rows(path, comments, &columns, rows)
}

/// As [`write_table`], with a number of columns that is known at run time only.
///
/// # Errors
/// [`WriteError`] if the file cannot be written.
pub fn write_rows(
    path: &Path,
    comments: &[String],
    columns: &[impl AsRef<str>],
    rows: impl Iterator<Item = impl AsRef<[f64]>>,
) -> Result<(), WriteError> {
    write_whole(path, |file| {
        writeln!(file, "# {PROGRAM}")?;
        for comment in comments {
            writeln!(file, "# {comment}")?;
        }
        let names: Vec<&str> = columns.iter().map(AsRef::as_ref).collect();
        writeln!(file, "{}", names.join(","))?;
        for row in rows {
            for (index, value) in row.as_ref().iter().enumerate() {
                if index > 0 {
                    write!(file, ",")?;
                }
                if value.is_finite() {
                    write!(file, "{value}")?;
                }
            }
            writeln!(file)?;
        }
        Ok(())
    })
}

/// Writes the changes between chaos and regular or quasi-periodic motion along every row and every column of the map, one
/// change per line, in the units of the axes.
///
/// # Errors
/// [`WriteError`] if the file cannot be written.
pub fn write_border(path: &Path, map: &ParameterMap) -> Result<(), WriteError> {
    let coordinates = [map.x_axis().coordinate, map.y_axis().coordinate];
    let [x, y] = coordinates.map(Coordinate::name);
    let [x_words, y_words] = coordinates.map(|coordinate| {
        let unit = match map.experiment.design.fixed.unit(coordinate) {
            "1" => "dimensionless".to_owned(),
            unit => format!("in {unit}"),
        };
        format!("{coordinate}: {}, {unit}", coordinate.meaning())
    });
    write_whole(path, |file| {
        writeln!(
            file,
            "# {PROGRAM}: border of chaos, all changes between chaotic and regular or quasi-periodic points along {x} and along {y}"
        )?;
        writeln!(file, "# {x_words}; {y_words}")?;
        writeln!(
            file,
            "# half_width: along the axis named first, the change lies between the middle given - half_width and + half_width; \
             points in between are undecided, unstable, under-resolved, or ran away"
        )?;
        writeln!(file, "# chaos: begins or ends as the axis named first rises")?;
        for line in experiment_comments(&map.experiment.to_toml()) {
            writeln!(file, "# {line}")?;
        }
        writeln!(file, "along,{x},{y},half_width,chaos")?;
        for change in border(map) {
            let along = [x, y][change.along];
            let [x, y] = change.place;
            let chaos = if change.begins { "begins" } else { "ends" };
            writeln!(file, "{along},{x},{y},{},{chaos}", change.half_width)?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::samples;
    use super::*;

    #[test]
    fn all_digits_are_kept_and_gaps_are_empty() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/table.csv");
        let rows = [[1.0 / 3.0, f64::NAN], [-2.0, 1e-3]];
        write_table(&path, &["a comment".to_owned()], ["x", "y"], rows.into_iter()).unwrap();
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.ends_with("x,y\n0.3333333333333333,\n-2,0.001\n"));
        assert!(text.starts_with(&format!("# {PROGRAM}\n# a comment\n")));
    }
    #[test]
    fn changes_of_rows_and_columns_are_listed_with_all_digits() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("border.csv");
        #[rustfmt::skip]
        let exponents = [
            -1.0, 1.0, 1.0, -1.0,
            -1.0, -1.0, 1.0, f64::NAN,
        ];
        write_border(&path, &samples::map("zeta_k=0:1:4", "h1=0:0.3:2", &exponents)).unwrap();
        let text = fs::read_to_string(&path).unwrap();
        let (comments, rows): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with('#'));
        assert!(comments[0].contains(PROGRAM));
        let map = samples::map("zeta_k=0:1:4", "h1=0:0.3:2", &exponents);
        assert_eq!(
            experiment_in(&text).unwrap().replace('\n', ""),
            map.experiment.to_toml().replace('\n', "")
        );
        let (third, two_thirds) = (1.0 / 3.0, 2.0 / 3.0);
        let expected = [
            "along,zeta_k,h1,half_width,chaos".to_owned(),
            format!("zeta_k,{},0,{},begins", 0.5 * third, 0.5 * third),
            format!(
                "zeta_k,{},0,{},ends",
                0.5 * (two_thirds + 1.0),
                0.5 * (1.0 - two_thirds)
            ),
            format!("zeta_k,0.5,0.3,{},begins", 0.5 * (two_thirds - third)),
            format!("h1,{third},0.15,0.15,ends"),
        ];
        assert_eq!(rows, expected);
    }
}
