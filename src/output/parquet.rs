//! Tables as Parquet, the columnar form that data frames read.
//!
//! Owns the passage of columns to Parquet; computes nothing.

use std::io;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, FloatType};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;

use super::PROGRAM;
use super::whole::{WriteError, write_whole};
use crate::measure::Values;
use crate::results::Column;

/// The name of a column, and the type of its values.
pub type Heading<'a> = (&'a str, Values);

/// Writes a table. `next` gives it in pieces of rows, each with all columns in the order of the headings, and None at the end. Codes are
/// written as their names; a value that is not finite, or a code of nothing, is null. `experiment` is held in the file's metadata.
///
/// # Errors
/// [`WriteError`] if the file cannot be written, or if `next` fails.
///
/// # Panics
/// If a piece does not have the columns of the headings.
pub fn write(
    path: &Path,
    experiment: &str,
    headings: &[Heading<'_>],
    next: &mut dyn FnMut() -> io::Result<Option<Vec<Column>>>,
) -> Result<(), WriteError> {
    write_whole(path, |file| {
        let key = |key: &str, value: &str| KeyValue::new(key.to_owned(), value.to_owned());
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by(PROGRAM.to_owned())
            .set_key_value_metadata(Some(vec![key("experiment", experiment)]))
            .build();
        let schema = schema(headings).map_err(io::Error::other)?;
        let mut writer = SerializedFileWriter::new(file, schema, Arc::new(properties)).map_err(io::Error::other)?;
        while let Some(columns) = next()? {
            assert_eq!(columns.len(), headings.len(), "a piece has all columns");
            let mut rows = writer.next_row_group().map_err(io::Error::other)?;
            for (column, (_, values)) in columns.iter().zip(headings) {
                let place = rows.next_column().map_err(io::Error::other)?;
                let place = place.expect("there is a column for each heading");
                write_column(place, column, *values).map_err(io::Error::other)?;
            }
            rows.close().map_err(io::Error::other)?;
        }
        writer.close().map_err(io::Error::other)?;
        Ok(())
    })
}

fn schema(headings: &[Heading<'_>]) -> Result<Arc<Type>, ParquetError> {
    let field = |&(name, values): &Heading<'_>| {
        let (physical, logical) = match values {
            Values::F64 => (Physical::DOUBLE, None),
            Values::F32 => (Physical::FLOAT, None),
            Values::Code(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let field = Type::primitive_type_builder(name, physical)
            .with_repetition(Repetition::OPTIONAL)
            .with_logical_type(logical);
        field.build().map(Arc::new)
    };
    let fields = headings.iter().map(field).collect::<Result<_, _>>()?;
    Type::group_type_builder("table")
        .with_fields(fields)
        .build()
        .map(Arc::new)
}

fn write_column(place: SerializedColumnWriter<'_>, column: &Column, values: Values) -> Result<(), ParquetError> {
    match values {
        Values::F64 => write_values::<DoubleType>(place, column, |value| value),
        Values::F32 => write_values::<FloatType>(place, column, |value| value as f32),
        Values::Code(names) => {
            write_values::<ByteArrayType>(place, column, |code| ByteArray::from(names[code as usize]))
        }
    }
}

fn write_values<T: DataType>(
    mut place: SerializedColumnWriter<'_>,
    column: &Column,
    convert: impl Fn(f64) -> T::T,
) -> Result<(), ParquetError> {
    // 1 where there is a value, 0 where there is none
    let levels: Vec<i16> = column.values().map(|value| i16::from(value.is_finite())).collect();
    let values: Vec<T::T> = column.values().filter(|value| value.is_finite()).map(convert).collect();
    place.typed::<T>().write_batch(&values, Some(&levels), None)?;
    place.close()
}

#[cfg(test)]
mod tests {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::RowAccessor;

    use super::*;
    use crate::results::NO_CODE;

    #[test]
    fn tables_are_read_back_with_their_gaps() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/table.parquet");
        let names: &[&str] = &["chaotic", "regular"];
        let headings = [
            ("x", Values::F64),
            ("lyapunov", Values::F32),
            ("class", Values::Code(names)),
        ];
        let mut pieces = vec![
            vec![
                Column::F64(vec![1.0 / 3.0, 2.0]),
                Column::F32(vec![0.1, f32::NAN]),
                Column::Code(vec![1, NO_CODE]),
            ],
            vec![Column::F64(vec![3.0]), Column::F32(vec![-2.5]), Column::Code(vec![0])],
        ];
        pieces.reverse();
        write(&path, "a = 1\n", &headings, &mut || Ok(pieces.pop())).unwrap();
        let reader = SerializedFileReader::new(std::fs::File::open(&path).unwrap()).unwrap();
        let metadata = reader.metadata().file_metadata();
        assert_eq!((metadata.num_rows(), metadata.created_by()), (3, Some(PROGRAM)));
        let held = metadata.key_value_metadata().unwrap();
        assert!(
            held.iter()
                .any(|held| held.key == "experiment" && held.value.as_deref() == Some("a = 1\n"))
        );
        let rows: Vec<_> = reader.get_row_iter(None).unwrap().map(Result::unwrap).collect();
        assert_eq!(
            (rows[0].get_double(0).unwrap(), rows[0].get_float(1).unwrap()),
            (1.0 / 3.0, 0.1)
        );
        assert_eq!(rows[0].get_string(2).unwrap(), "regular");
        assert!(rows[1].get_float(1).is_err() && rows[1].get_string(2).is_err());
        assert_eq!(
            (rows[2].get_float(1).unwrap(), rows[2].get_string(2).unwrap().as_str()),
            (-2.5, "chaotic")
        );
        let failing = write(&path, "", &headings, &mut || Err(io::Error::other("no more"))).unwrap_err();
        assert!(failing.to_string().contains("no more"));
    }
}
