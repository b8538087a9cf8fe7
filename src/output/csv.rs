//! The threshold of chaos as a table of comma-separated values.
//!
//! Owns the columns and their notes; finds no threshold itself.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::{PROGRAM, write_whole};
use crate::map::{OnsetKind, ParameterMap, threshold};

/// Writes, for every row of the map, where chaos first sets in.
///
/// # Errors
/// [`CsvError`] if the file cannot be written.
pub fn write_threshold(path: &Path, map: &ParameterMap) -> Result<(), CsvError> {
    let (x, y) = (map.x_axis().coordinate, map.y_axis().coordinate);
    let units = [x, y].map(|coordinate| match map.experiment.grid.fixed.unit(coordinate) {
        "1" => "dimensionless".to_owned(),
        unit => format!("in {unit}"),
    });
    let (x_name, y_name) = (x.name(), y.name());
    write_whole(path, |file| {
        writeln!(
            file,
            "# {PROGRAM}: onset of chaos, the first change to chaos as {x_name} rises, for each {y_name}"
        )?;
        writeln!(
            file,
            "# {x_name}: {}, {}; {y_name}: {}, {}",
            x.meaning(),
            units[0],
            y.meaning(),
            units[1]
        )?;
        writeln!(
            file,
            "# half_width: chaos sets in between {x_name}_onset - half_width and {x_name}_onset + \
             half_width"
        )?;
        writeln!(
            file,
            "# note: none = no chaos in the row, chaotic_from_start = chaotic at the row's first decided point, \
             incomplete = not computed"
        )?;
        writeln!(file, "{y_name},{x_name}_onset,half_width,note")?;
        for onset in threshold(map) {
            write!(file, "{},", onset.y)?;
            match onset.kind {
                OnsetKind::At { x, half_width } => writeln!(file, "{x},{half_width},")?,
                OnsetKind::BeforeFirst => writeln!(file, ",,chaotic_from_start")?,
                OnsetKind::Never => writeln!(file, ",,none")?,
                OnsetKind::Incomplete => writeln!(file, ",,incomplete")?,
            }
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

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::output::samples;

    #[test]
    fn every_row_has_its_onset_or_a_note() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("threshold.csv");
        #[rustfmt::skip]
        let exponents = [
            -1.0, -1.0, 1.0, 1.0,
            1.0, -1.0, 1.0, 1.0,
            -1.0, -1.0, -1.0, f64::NAN,
            -1.0,
        ];
        write_threshold(&path, &samples::map("zeta_k=0:1:4", "h1=0:0.3:4", &exponents)).unwrap();
        let text = fs::read_to_string(&path).unwrap();
        let (comments, rows): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with('#'));
        assert!(comments[0].contains(PROGRAM) && comments.len() == 4);
        assert_eq!(rows[0], "h1,zeta_k_onset,half_width,note");
        let fields: Vec<&str> = rows[1].split(',').collect();
        assert!((fields[1].parse::<f64>().unwrap() - 0.5).abs() < 1e-15);
        assert_eq!(
            fields[2].parse::<f64>().unwrap(),
            0.5 * (2.0 / 3.0 - 1.0 / 3.0),
            "all digits are kept"
        );
        assert_eq!((fields[0], fields[3]), ("0", ""));
        assert!(rows[2].ends_with(",,,chaotic_from_start") && rows[3].ends_with(",,,none"));
        assert_eq!(rows[4], "0.3,,,incomplete");
        assert_eq!(rows.len(), 5);
    }
}
