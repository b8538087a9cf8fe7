//! The border of chaos as a table of comma-separated values.
//!
//! Owns the columns and their notes; finds no border itself.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::table::experiment_comments;
use super::{PROGRAM, write_whole};
use crate::map::{ParameterMap, border};

/// Writes the changes between chaos and regular or quasi-periodic motion along every row and every column of the map, one a
/// line, in the units of the axes.
///
/// # Errors
/// [`CsvError`] if the file cannot be written.
pub fn write_border(path: &Path, map: &ParameterMap) -> Result<(), CsvError> {
    let coordinates = [map.x_axis().coordinate, map.y_axis().coordinate];
    let [x, y] = coordinates.map(|coordinate| coordinate.name());
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
    .map_err(|source| CsvError {
        path: path.to_owned(),
        source,
    })
}

#[derive(Debug, thiserror::Error)]
#[error("{} cannot be written: {source}; check the folder's permissions and the free space", path.display())]
pub struct CsvError {
    path: PathBuf,
    source: io::Error,
}

#[cfg(all(test, feature = "pictures"))]
mod tests {
    use std::fs;

    use super::*;
    use crate::output::{samples, table::experiment_in};

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
