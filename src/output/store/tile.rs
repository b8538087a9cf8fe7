//! Tiles: the rectangles of grid points that are computed and written at once.
//!
//! Owns the order of points in a tile; knows no files.

/// A rectangle of grid points that is written at once, in rows and columns of the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    pub row0: usize,
    pub rows: usize,
    pub col0: usize,
    pub cols: usize,
}

impl Tile {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.rows * self.cols
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The tile's grid points, x fastest, as indices into a grid whose rows have `columns` points.
    pub fn indices(self, columns: usize) -> impl Iterator<Item = usize> {
        (self.row0..self.row0 + self.rows)
            .flat_map(move |row| (self.col0..self.col0 + self.cols).map(move |col| row * columns + col))
    }
}
