//! Refinement of a lattice along the border of a region.
//!
//! Owns which points are looked at next; does not know what they stand for.
//!
//! The lattice fills a square or a cube. It begins with equal cells, which are divided in halves along every side, again and again, down to
//! the finest level. Two rules say which:
//!
//! 1. a cell whose corners are not all of one kind;
//! 2. all neighbours of a divided cell in which the kind alternates: somewhere, along a line of three points, the middle one is of
//!    another kind than both ends, or than one of them where the other has none. One smooth border through a cell seldom does this;
//!    folds, strips and islands do.
//!
//! By the second rule the found border is closed: it cannot leave a finest cell through the side of a cell that was not divided.

use std::collections::{BTreeSet, HashMap, HashSet};

/// A point of the lattice: its place along each side, in sides of finest cells. A square has 0 in the third place.
pub type Node = [u32; 3];

/// Whether a point lies within the region; None where that has no meaning.
pub type Inside = Option<bool>;

/// A cell. At level 0 are the cells with which the lattice begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
struct Cell {
    level: u32,
    /// The corner nearest to the origin.
    corner: Node,
}

/// The shape of a lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// 2 for a square, 3 for a cube.
    pub sides: usize,
    /// Cells along a side at level 0.
    pub first: u32,
    /// The finest level.
    pub levels: u32,
}

impl Shape {
    /// Cells along a side at a level.
    pub fn cells(&self, level: u32) -> u32 {
        self.first << level
    }

    /// Points of the whole lattice at the finest level.
    pub fn points(&self) -> f64 {
        f64::from(self.cells(self.levels) + 1).powi(self.sides as i32)
    }

    /// The side of a cell of a level, in sides of finest cells.
    fn side(&self, level: u32) -> u32 {
        1 << (self.levels - level)
    }

    /// All ways to choose one of `steps` numbers from 0 on along each side.
    fn offsets(&self, steps: u32) -> Vec<Node> {
        let third = if self.sides == 3 { steps } else { 1 };
        let mut offsets = Vec::new();
        for z in 0..third {
            for y in 0..steps {
                for x in 0..steps {
                    offsets.push([x, y, z]);
                }
            }
        }
        offsets
    }

    fn corners(&self, cell: Cell) -> Vec<Node> {
        let side = self.side(cell.level);
        self.offsets(2)
            .into_iter()
            .map(|offset| moved(cell.corner, offset, side))
            .collect()
    }

    /// The points of a divided cell: three along every side.
    fn block(&self, cell: Cell) -> Vec<Node> {
        let half = self.side(cell.level) / 2;
        self.offsets(3)
            .into_iter()
            .map(|offset| moved(cell.corner, offset, half))
            .collect()
    }

    /// The cells into which a cell is divided.
    fn children(&self, cell: Cell) -> Vec<Cell> {
        let half = self.side(cell.level) / 2;
        let child = |offset| Cell {
            level: cell.level + 1,
            corner: moved(cell.corner, offset, half),
        };
        self.offsets(2).into_iter().map(child).collect()
    }

    /// The cell of a lower level that a cell lies in.
    fn ancestor(&self, cell: Cell, level: u32) -> Cell {
        let side = self.side(level);
        Cell {
            level,
            corner: cell.corner.map(|place| place / side * side),
        }
    }

    /// The cells of the same level that touch a cell, and the cell itself.
    fn around(&self, cell: Cell) -> Vec<Cell> {
        let side = self.side(cell.level);
        let end = self.cells(self.levels);
        let mut around = Vec::new();
        for offset in self.offsets(3) {
            let mut corner = cell.corner;
            let is_there = (0..self.sides).all(|axis| {
                let place = (corner[axis] + offset[axis] * side).checked_sub(side);
                place.is_some_and(|place| {
                    corner[axis] = place;
                    place < end
                })
            });
            if is_there {
                around.push(Cell { corner, ..cell });
            }
        }
        around
    }
}

fn moved(node: Node, steps: Node, step: u32) -> Node {
    std::array::from_fn(|axis| node[axis] + steps[axis] * step)
}

/// A lattice that is being refined.
pub struct Lattice {
    shape: Shape,
    kinds: HashMap<Node, Inside>,
    divided: HashSet<Cell>,
    /// Cells whose corners are still to be compared.
    new: BTreeSet<Cell>,
    /// Divided cells in which the kind may alternate.
    blocks: BTreeSet<Cell>,
    /// Cells of the finest level whose corners are of both kinds.
    border: BTreeSet<Cell>,
    /// The level that is looked at.
    level: u32,
}

impl Lattice {
    pub fn new(shape: Shape) -> Self {
        let side = shape.side(0);
        let cells = shape.offsets(shape.first).into_iter();
        let cells = cells.map(|offset| Cell {
            level: 0,
            corner: moved([0; 3], offset, side),
        });
        Self {
            shape,
            kinds: HashMap::new(),
            divided: HashSet::new(),
            new: cells.collect(),
            blocks: BTreeSet::new(),
            border: BTreeSet::new(),
            level: 0,
        }
    }

    /// Number of points whose kind is known.
    pub fn known(&self) -> usize {
        self.kinds.len()
    }

    /// The kind of a point; None if it is not known, or has none.
    pub fn kind(&self, node: Node) -> Inside {
        self.kinds.get(&node).copied().flatten()
    }

    /// Takes the kinds of points, and returns the points that are looked at next, in a fixed order. None are left once the border is found.
    /// A level is begun when all cells of the levels before it are done, so that a lattice with more levels begins with the same
    /// points.
    pub fn refine(&mut self, found: impl IntoIterator<Item = (Node, Inside)>) -> Vec<Node> {
        self.kinds.extend(found);
        while self.level <= self.shape.levels {
            let is_due = |level| level <= self.level;
            let cells = self.new.iter().filter(|cell| is_due(cell.level));
            let blocks = self.blocks.iter().filter(|cell| is_due(cell.level + 1));
            let (cells, blocks): (Vec<Cell>, Vec<Cell>) = (cells.copied().collect(), blocks.copied().collect());
            if cells.is_empty() && blocks.is_empty() {
                self.level += 1;
                continue;
            }
            let mut missing = BTreeSet::new();
            for cell in cells {
                if self.are_known(self.shape.corners(cell), &mut missing) {
                    self.new.remove(&cell);
                    self.compare_corners(cell);
                }
            }
            for cell in blocks {
                if self.are_known(self.shape.block(cell), &mut missing) {
                    self.blocks.remove(&cell);
                    self.look_into(cell);
                }
            }
            if !missing.is_empty() {
                // row by row
                let mut missing: Vec<Node> = missing.into_iter().collect();
                missing.sort_unstable_by_key(|&[x, y, z]| [z, y, x]);
                return missing;
            }
        }
        Vec::new()
    }

    /// Whether the kinds of all these points are known; adds those that are missing.
    fn are_known(&self, nodes: Vec<Node>, missing: &mut BTreeSet<Node>) -> bool {
        let unknown: Vec<Node> = nodes
            .into_iter()
            .filter(|node| !self.kinds.contains_key(node))
            .collect();
        missing.extend(&unknown);
        unknown.is_empty()
    }

    /// The first rule.
    fn compare_corners(&mut self, cell: Cell) {
        let corners = self.shape.corners(cell);
        let has = |kind: bool| corners.iter().any(|&node| self.kind(node) == Some(kind));
        if !(has(true) && has(false)) {
            return;
        }
        if cell.level == self.shape.levels {
            self.border.insert(cell);
        } else {
            self.divide(cell);
        }
    }

    /// The second rule.
    fn look_into(&mut self, cell: Cell) {
        if self.alternates(cell) {
            for neighbour in self.shape.around(cell) {
                self.divide(neighbour);
            }
        }
    }

    fn alternates(&self, cell: Cell) -> bool {
        let half = self.shape.side(cell.level) / 2;
        let lines = |axis: usize| {
            let starts = self
                .shape
                .offsets(3)
                .into_iter()
                .filter(move |offset| offset[axis] == 0);
            starts.map(move |start| {
                [0, 1, 2].map(|step| {
                    let mut offset = start;
                    offset[axis] = step;
                    moved(cell.corner, offset, half)
                })
            })
        };
        (0..self.shape.sides).flat_map(lines).any(|line| {
            let [first, middle, last] = line.map(|node| self.kind(node));
            let differs = |end: Inside| end.is_some() && middle.is_some() && end != middle;
            // a change that the two ends do not show
            (differs(first) && first == last)
                || (differs(first) && last.is_none())
                || (differs(last) && first.is_none())
        })
    }

    /// Divides a cell, and before it those that it lies in.
    fn divide(&mut self, cell: Cell) {
        if cell.level >= self.shape.levels || !self.divided.insert(cell) {
            return;
        }
        if cell.level > 0 {
            self.divide(self.shape.ancestor(cell, cell.level - 1));
        }
        self.new.extend(self.shape.children(cell));
        self.blocks.insert(cell);
    }

    /// How many cells of each level the border passes through, from level 0 on.
    pub fn boxes(&self) -> Vec<usize> {
        let at = |level| {
            let cells: HashSet<Cell> = self
                .border
                .iter()
                .map(|&cell| self.shape.ancestor(cell, level))
                .collect();
            cells.len()
        };
        (0..=self.shape.levels).map(at).collect()
    }

    /// The finest squares through which the border passes, by their corners in the order of a walk. In a cube these are the cells' sides
    /// that lie in planes of one third place, plane by plane.
    pub fn squares(&self) -> Vec<[Node; 4]> {
        let planes: u32 = if self.shape.sides == 3 { 2 } else { 1 };
        let lowest = self
            .border
            .iter()
            .flat_map(|cell| (0..planes).map(|up| moved(cell.corner, [0, 0, up], 1)));
        // two cells of a cube share a side
        let lowest: BTreeSet<[u32; 3]> = lowest.map(|[x, y, z]| [z, y, x]).collect();
        let squares = lowest
            .into_iter()
            .map(|[z, y, x]| [[x, y, z], [x + 1, y, z], [x + 1, y + 1, z], [x, y + 1, z]]);
        squares.collect()
    }

    /// For each point of level `level` in a plane of one third place, row by row, the nearest known point of the smallest cell that it lies
    /// in. A square has the plane 0 alone.
    pub fn nearest(&self, level: u32, plane: u32) -> Vec<Node> {
        let (step, count) = (self.shape.side(level), self.shape.cells(level) + 1);
        let last = self.shape.cells(self.shape.levels) - 1;
        let nearest = |node: Node| {
            // the last points lie in the last cells
            let within = node.map(|place| place.min(last));
            let mut cell = self.shape.ancestor(
                Cell {
                    level: self.shape.levels,
                    corner: within,
                },
                0,
            );
            while cell.level < level && self.divided.contains(&cell) {
                let finest = Cell {
                    level: self.shape.levels,
                    corner: within,
                };
                cell = self.shape.ancestor(finest, cell.level + 1);
            }
            let side = self.shape.side(cell.level);
            let to_corner = |axis: usize| {
                let beyond = node[axis] - cell.corner[axis];
                cell.corner[axis] + if 2 * beyond > side { side } else { 0 }
            };
            [0, 1, 2].map(|axis| if axis < self.shape.sides { to_corner(axis) } else { 0 })
        };
        (0..count)
            .flat_map(|y| (0..count).map(move |x| [x * step, y * step, plane]))
            .map(nearest)
            .collect()
    }
}
