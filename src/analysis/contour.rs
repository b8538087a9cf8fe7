//! The border of a region on a grid of points: marching squares.
//!
//! Owns which edges of the grid the border crosses, and in which order; where on an edge it does, the caller finds.

use std::collections::BTreeMap;

/// An edge of the grid, from a point to a neighbour with a greater index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Edge {
    pub from: usize,
    pub to: usize,
}

/// The border as lines. Each line is the list of edges that it crosses from one end to the other; a closed line ends with its
/// first edge. `inside` tells for each point whether it lies within the region, in rows of `columns` points. No line passes where
/// it is None.
pub fn lines(inside: &[Option<bool>], columns: usize) -> Vec<Vec<Edge>> {
    let cells = (0..inside.len().saturating_sub(columns)).filter(|cell| cell % columns < columns - 1);
    lines_through(
        cells.map(|cell| [cell, cell + 1, cell + columns + 1, cell + columns]),
        |point| inside[point],
    )
}

/// As [`lines`], through some cells of a grid. Each is given by its corners, in the order of a walk around it.
pub fn lines_through(
    cells: impl Iterator<Item = [usize; 4]>,
    inside: impl Fn(usize) -> Option<bool>,
) -> Vec<Vec<Edge>> {
    let mut links: BTreeMap<Edge, Vec<Edge>> = BTreeMap::new();
    for corners in cells {
        for [a, b] in crossed(corners, corners.map(&inside)) {
            links.entry(a).or_default().push(b);
            links.entry(b).or_default().push(a);
        }
    }
    // ends first: when the open lines have been followed, only closed ones are left
    let (ends, others): (Vec<_>, Vec<_>) = links.keys().copied().partition(|edge| links[edge].len() == 1);
    let mut lines = Vec::new();
    for start in ends.into_iter().chain(others) {
        let mut line = vec![start];
        let mut here = start;
        while let Some(next) = links.get_mut(&here).and_then(Vec::pop) {
            links
                .get_mut(&next)
                .expect("links are mutual")
                .retain(|edge| *edge != here);
            line.push(next);
            here = next;
        }
        // otherwise the start already belongs to a line
        if line.len() > 1 {
            lines.push(line);
        }
    }
    lines
}

/// The strokes of the border through a cell, each from one edge of the cell to another.
fn crossed(corners: [usize; 4], inside: [Option<bool>; 4]) -> Vec<[Edge; 2]> {
    let edge = |side: usize| {
        let ends = [corners[side], corners[(side + 1) % 4]];
        Edge {
            from: ends[0].min(ends[1]),
            to: ends[0].max(ends[1]),
        }
    };
    let [Some(a), Some(b), Some(c), Some(d)] = inside else {
        return Vec::new();
    };
    let sides: Vec<usize> = (0..4).filter(|&side| [a != b, b != c, c != d, d != a][side]).collect();
    match sides[..] {
        [] => Vec::new(),
        [one, other] => vec![[edge(one), edge(other)]],
        // a saddle: its two corners inside count as two regions, not as one region with a narrow connection
        _ if a => vec![[edge(3), edge(0)], [edge(1), edge(2)]],
        _ => vec![[edge(0), edge(1)], [edge(2), edge(3)]],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(picture: &[&str]) -> Vec<Vec<Edge>> {
        let points = picture.iter().flat_map(|row| row.chars()).map(|point| match point {
            '#' => Some(true),
            '.' => Some(false),
            _ => None,
        });
        lines(&points.collect::<Vec<_>>(), picture[0].len())
    }

    #[test]
    fn a_border_from_edge_to_edge_is_one_line() {
        let lines = of(&["..##", ".###", "..##"]);
        let pairs: Vec<(usize, usize)> = lines[0].iter().map(|edge| (edge.from, edge.to)).collect();
        assert_eq!(lines.len(), 1);
        assert_eq!(pairs, [(1, 2), (1, 5), (4, 5), (5, 9), (9, 10)]);
    }

    #[test]
    fn an_island_has_a_closed_border_and_a_saddle_two() {
        let island = of(&["....", ".##.", "...."]);
        assert_eq!((island.len(), island[0].len()), (1, 7));
        assert_eq!(island[0].first(), island[0].last());
        let saddle = of(&["....", ".#..", "..#.", "...."]);
        assert_eq!(saddle.iter().map(Vec::len).collect::<Vec<_>>(), [5, 5]);
    }

    #[test]
    fn no_line_passes_where_nothing_is_known_and_none_is_where_all_is_one() {
        assert_eq!(of(&["?#.", "?#.", "?#."]).len(), 1);
        assert!(of(&["?#", ".?"]).is_empty());
        assert!(of(&["##", "##"]).is_empty() && of(&["..", ".."]).is_empty());
    }
}
