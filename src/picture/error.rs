//! What can be wrong with a picture.

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages tell what each is")]
pub enum PictureError {
    #[error(
        "a map of {columns} x {rows} points is too large for a picture (at most {most} points along an axis and \
         {most_pixels} pixels): draw a map with fewer points; the store can hold this one"
    )]
    TooLarge {
        columns: usize,
        rows: usize,
        most: usize,
        most_pixels: u64,
    },
    #[error("the colour limits {low} and {high} are no range: give two numbers, the lower one first")]
    Limits { low: f64, high: f64 },
    #[error("the figure cannot be drawn: {0}")]
    Drawing(String),
}
