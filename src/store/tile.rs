//! Tiles: the rectangles of grid points that are computed and written at once.
//!
//! Owns the order of points in a tile; knows no files.

/// A rectangle of grid points that is written at once, in rows and columns of the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// First row: an index along the vertical axis.
    pub row0: usize,
    /// Number of rows.
    pub rows: usize,
    /// First column: an index along the horizontal axis.
    pub col0: usize,
    /// Number of columns.
    pub cols: usize,
}

impl Tile {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.rows * self.cols
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The tile's grid points, x fastest, as indices into a grid whose rows have `columns` points.
    pub fn indices(self, columns: usize) -> impl Iterator<Item = usize> {
        (self.row0..self.row0 + self.rows)
            .flat_map(move |row| (self.col0..self.col0 + self.cols).map(move |col| row * columns + col))
    }
}

/// Number of tiles of a map of `x` by `y` points, in tiles of so many rows and columns.
pub fn count([x, y]: [usize; 2], [rows, cols]: [usize; 2]) -> usize {
    y.div_ceil(rows) * x.div_ceil(cols)
}

/// The tile `index` of such a map, counted row by row.
pub fn tile([x, y]: [usize; 2], [rows, cols]: [usize; 2], index: usize) -> Tile {
    let in_a_row = x.div_ceil(cols);
    let (row0, col0) = (index / in_a_row * rows, index % in_a_row * cols);
    Tile {
        row0,
        rows: rows.min(y - row0),
        col0,
        cols: cols.min(x - col0),
    }
}

/// Rows and columns of the tiles of a map of `x` by `y` points, of about `points` points: whole rows if they hold no more, else parts of
/// one.
pub fn shape([x, y]: [usize; 2], points: usize) -> [usize; 2] {
    if points >= x {
        [(points / x).min(y), x]
    } else {
        [1, points]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_whole_rows_or_parts_of_one() {
        assert_eq!(shape([300, 201], 4096), [13, 300]);
        assert_eq!(shape([300, 201], 1 << 20), [201, 300]);
        assert_eq!(shape([300, 201], 299), [1, 299]);
    }

    #[test]
    fn tiles_cover_every_point_once() {
        let (map, shape) = ([7, 5], [2, 3]);
        let tiles = (0..count(map, shape)).map(|index| tile(map, shape, index));
        let mut all: Vec<usize> = tiles.flat_map(|tile| tile.indices(7)).collect();
        all.sort_unstable();
        assert_eq!(all, (0..35).collect::<Vec<_>>());
    }
}
