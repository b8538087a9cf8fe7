//! Chunks of one array as files.
//!
//! Owns the passage of columns to the bytes of a chunk and back; the codecs are zarrs'.

use std::borrow::Cow;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use zarrs::array::{
    Array, ArrayError, ArrayToBytesCodecTraits, CodecOptions, Element, ElementOwned, FromArrayBytes, IntoArrayBytes,
};
use zarrs::filesystem::FilesystemStore;

use super::checksum::checksum;
use super::sync;
use crate::results::{Column, NO_CODE};

/// The file of a chunk.
pub fn path(store: &Path, array: &Array<FilesystemStore>, chunk: &[u64]) -> PathBuf {
    store.join(array.chunk_key(chunk).as_str())
}

/// The bytes of a chunk that holds these values first, and fill values behind them.
pub fn encode(array: &Array<FilesystemStore>, chunk: &[u64], values: &Column) -> Result<Vec<u8>, ArrayError> {
    match values {
        Column::F64(values) => encoded(array, chunk, values, f64::NAN),
        Column::F32(values) => encoded(array, chunk, values, f32::NAN),
        Column::Code(codes) => encoded(array, chunk, codes, NO_CODE),
    }
}

fn encoded<T>(array: &Array<FilesystemStore>, chunk: &[u64], values: &[T], fill: T) -> Result<Vec<u8>, ArrayError>
where
    T: Element + Copy,
    Vec<T>: IntoArrayBytes<'static>,
{
    let shape = array.chunk_shape(chunk)?;
    let mut whole = values.to_vec();
    whole.resize(shape.iter().map(|count| count.get() as usize).product(), fill);
    let bytes = whole.into_array_bytes(array.data_type())?;
    let options = CodecOptions::default();
    let encoded = array
        .codecs()
        .encode(bytes, &shape, array.data_type(), array.fill_value(), &options)?;
    Ok(encoded.into_owned())
}

/// The first `points` values of a chunk of these bytes.
///
/// # Errors
/// If the bytes are not those of a chunk: their checksum is wrong, or their number.
pub fn decode(
    array: &Array<FilesystemStore>,
    chunk: &[u64],
    bytes: Vec<u8>,
    points: usize,
) -> Result<Column, ArrayError> {
    // by the size of a value, since this program writes three types only
    Ok(match array.data_type().fixed_size() {
        Some(8) => Column::F64(decoded(array, chunk, bytes, points)?),
        Some(4) => Column::F32(decoded(array, chunk, bytes, points)?),
        _ => Column::Code(decoded(array, chunk, bytes, points)?),
    })
}

fn decoded<T>(
    array: &Array<FilesystemStore>,
    chunk: &[u64],
    bytes: Vec<u8>,
    points: usize,
) -> Result<Vec<T>, ArrayError>
where
    T: ElementOwned,
    Vec<T>: FromArrayBytes,
{
    let shape = array.chunk_shape(chunk)?;
    let options = CodecOptions::default();
    let bytes = array.codecs().decode(
        Cow::Owned(bytes),
        &shape,
        array.data_type(),
        array.fill_value(),
        &options,
    )?;
    let counts: Vec<u64> = shape.iter().map(|count| count.get()).collect();
    let mut values = Vec::<T>::from_array_bytes(bytes.into_owned(), &counts, array.data_type())?;
    values.truncate(points);
    Ok(values)
}

/// Writes the bytes of a chunk, and returns their checksum. The folder of the array must be there: a store that
/// was removed is not created again.
///
/// # Errors
/// If they cannot be written.
pub fn write(store: &Path, array: &Array<FilesystemStore>, chunk: &[u64], bytes: &[u8]) -> io::Result<String> {
    let file = path(store, array, chunk);
    let top = store.join(array.path().as_str().trim_start_matches('/'));
    let mut missing: Vec<&Path> = file
        .ancestors()
        .skip(1)
        .take_while(|folder| *folder != top && !folder.is_dir())
        .collect();
    while let Some(folder) = missing.pop() {
        match fs::create_dir(folder) {
            // by another process
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            made => made?,
        }
        sync::folder(folder.parent().unwrap_or(&top))?;
    }
    sync::write(&file, bytes)?;
    sync::folder(file.parent().unwrap_or(&top))?;
    Ok(checksum(bytes))
}
