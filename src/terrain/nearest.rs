//! The nearest ground that is known, for what stands where none is.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::field::HeightField;
use crate::geom::Aabb;

/// Where the heights of a field are known: squares of posts, each level twice as wide as the one
/// below, down to single posts, which the field tells itself.
#[derive(Debug)]
pub struct NearestGround<'a> {
    field: &'a HeightField,
    /// Finest first: squares of 2, 4, 8, … posts.
    levels: Vec<Squares>,
}

#[derive(Debug)]
struct Squares {
    columns: u32,
    rows: u32,
    /// Whether the height of any post is known, row by row from the south.
    known: Vec<bool>,
}

/// A square by its level (0 for a post), row and column.
type Square = (u32, u32, u32);

impl<'a> NearestGround<'a> {
    /// Looks through a field once.
    pub fn of(field: &'a HeightField) -> Self {
        let mut nearest = Self {
            field,
            levels: Vec::new(),
        };
        let (mut columns, mut rows) = (field.grid().columns(), field.grid().rows());
        while columns > 1 || rows > 1 || nearest.levels.is_empty() {
            let below = nearest.levels.len() as u32;
            (columns, rows) = (columns.div_ceil(2), rows.div_ceil(2));
            let squares = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
            let known = squares
                .map(|(row, column)| quarters(below + 1, row, column).any(|q| nearest.is_known(q)))
                .collect();
            nearest.levels.push(Squares {
                columns,
                rows,
                known,
            });
        }
        nearest
    }

    /// The height of the post with one that is nearest to a box in the same coordinates, as seen
    /// on the map, m; of several as near always the same. `None` where no post has any.
    pub fn height(&self, bounds: &Aabb) -> Option<f64> {
        let mut waiting = BinaryHeap::new();
        let top = (self.levels.len() as u32, 0, 0);
        if self.is_known(top) {
            waiting.push(Reverse((0, top)));
        }
        while let Some(Reverse((_, (level, row, column)))) = waiting.pop() {
            if level == 0 {
                return Some(self.field.height(column, row).into());
            }
            for quarter in quarters(level, row, column).filter(|&q| self.is_known(q)) {
                // Numbers of 0 and more are in the order of their bits.
                let apart = self.squared_distance(quarter, bounds).to_bits();
                waiting.push(Reverse((apart, quarter)));
            }
        }
        None
    }

    fn is_known(&self, (level, row, column): Square) -> bool {
        let Some(at) = level.checked_sub(1) else {
            let grid = self.field.grid();
            let is_post = column < grid.columns() && row < grid.rows();
            return is_post && !self.field.height(column, row).is_nan();
        };
        let squares = &self.levels[at as usize];
        let is_square = column < squares.columns && row < squares.rows;
        is_square && squares.known[row as usize * squares.columns as usize + column as usize]
    }

    /// From a box to the rectangle that the posts of a square span, m².
    fn squared_distance(&self, (level, row, column): Square, bounds: &Aabb) -> f64 {
        let grid = self.field.grid();
        let last = |at: u32, count: u32| ((((at + 1) << level) - 1).min(count - 1), at << level);
        let (east, west) = last(column, grid.columns());
        let (north, south) = last(row, grid.rows());
        let (min, max) = (bounds.min(), bounds.max());
        let x = (min.x - grid.x(east)).max(grid.x(west) - max.x).max(0.0);
        let y = (min.y - grid.y(north)).max(grid.y(south) - max.y).max(0.0);
        x * x + y * y
    }
}

/// The four squares of the level below, some of which may lie beyond the field.
fn quarters(level: u32, row: u32, column: u32) -> impl Iterator<Item = Square> {
    let at = [(0, 0), (0, 1), (1, 0), (1, 1)].into_iter();
    at.map(move |(up, right)| (level - 1, 2 * row + up, 2 * column + right))
}
