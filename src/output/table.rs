//! Tables of comma-separated values with comments that tell what they hold.
//!
//! Owns their form; computes nothing.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::{PROGRAM, write_whole};

/// What stands above the lines of an experiment in the comments of a table.
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
    Some(toml.map(|line| format!("{line}\n")).collect())
}

/// Writes a table: comments, the names of the columns, and rows of values. A value that is not finite is left empty.
///
/// # Errors
/// [`TableError`] if the file cannot be written.
pub fn write_table<const N: usize>(
    path: &Path,
    comments: &[String],
    columns: [&str; N],
    rows: impl Iterator<Item = [f64; N]>,
) -> Result<(), TableError> {
    write_rows(path, comments, &columns, rows)
}

/// As [`write_table`], with a number of columns that is known at run time only.
///
/// # Errors
/// [`TableError`] if the file cannot be written.
pub fn write_rows(
    path: &Path,
    comments: &[String],
    columns: &[impl AsRef<str>],
    rows: impl Iterator<Item = impl AsRef<[f64]>>,
) -> Result<(), TableError> {
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
    .map_err(|source| TableError {
        path: path.to_owned(),
        source,
    })
}

/// Writes a text file whole.
///
/// # Errors
/// [`TableError`] if the file cannot be written.
pub fn write_text(path: &Path, text: &str) -> Result<(), TableError> {
    write_whole(path, |file| file.write_all(text.as_bytes())).map_err(|source| TableError {
        path: path.to_owned(),
        source,
    })
}

#[derive(Debug, thiserror::Error)]
#[error("{} cannot be written: {source}; check the folder's permissions and the free space", path.display())]
pub struct TableError {
    path: PathBuf,
    source: io::Error,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_digits_are_kept_and_gaps_are_empty() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/table.csv");
        let rows = [[1.0 / 3.0, f64::NAN], [-2.0, 1e-3]];
        write_table(&path, &["a comment".to_owned()], ["x", "y"], rows.into_iter()).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.ends_with("x,y\n0.3333333333333333,\n-2,0.001\n"));
        assert!(text.starts_with(&format!("# {PROGRAM}\n# a comment\n")));
    }
}
