//! A block of the ground: its posts, and for every node what a criterion asks.

use bytemuck::{Pod, Zeroable};

use super::field::HeightField;
use super::layout::Layout;
use super::measure;
use super::quadtree::{Node, level_start};

/// What is known of a node, whatever the view. Rounded outward.
///
/// Law: going down, `low` never falls, and `high`, `margin`, `error`, `vertex_error`, `deviation`
/// and `holes` never rise. `whole` and `skipped` are never above the `error` of the node, nor is
/// that above its `margin`.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct NodeRecord {
    /// Lowest post of the ground in the node, m. Above `high` where there is no ground.
    pub low: f32,
    /// Highest post, m.
    pub high: f32,
    /// How far above `high` or below `low` any surface may lie, m, that is drawn over the node,
    /// be it in a fan of its parent.
    pub margin: f32,
    /// Largest vertical distance, m, between a post and what is drawn of the node, whole or in
    /// parts, that splitting it or what is below can mend. B's ε.
    pub error: f32,
    /// The same for the node as two triangles of its parent's fan, and nothing else.
    pub whole: f32,
    /// The same for the two quarters along a side, south, east, north and west, where the node's
    /// own fan skips the side's midpoint.
    pub skipped: [f32; 4],
    /// Largest vertical distance, m, of a midpoint of a side or diagonal from that side or
    /// diagonal, over the node and all below: the Δh of A's equation (2), and D's vertex error.
    pub vertex_error: f32,
    /// Largest standard deviation of heights, m, of the node and of any below: C's D(z).
    pub deviation: f32,
    /// Cells without ground: at least one of their four posts is unknown.
    pub holes: u32,
}

/// 2^n + 1 posts a side and the records of its nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    levels: u32,
    records: Vec<NodeRecord>,
    heights: Vec<f32>,
}

/// Why arrays are no block.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BlockError {
    /// An array has not the length that the depth asks for.
    #[error("a block of depth {levels} has {expected} {what}, not {given}; write the file again")]
    Length {
        /// n.
        levels: u32,
        /// Which array.
        what: &'static str,
        /// As the depth asks.
        expected: usize,
        /// As given.
        given: usize,
    },
    /// A number that no cut writes.
    #[error("{what} {index} of a block holds a number that cannot be; write the file again")]
    Number {
        /// Which array.
        what: &'static str,
        /// Place in the array.
        index: usize,
    },
}

impl NodeRecord {
    /// Neither ground nor hole: beyond the raster, or nothing but holes.
    pub const NOTHING: Self = Self {
        low: f32::INFINITY,
        high: f32::NEG_INFINITY,
        margin: 0.0,
        error: 0.0,
        whole: 0.0,
        skipped: [0.0; 4],
        vertex_error: 0.0,
        deviation: 0.0,
        holes: 0,
    };

    /// Whether there is any ground.
    pub fn has_ground(&self) -> bool {
        self.low <= self.high
    }

    /// Whether there is ground and a hole. Such a node is drawn in parts or not at all.
    pub fn is_mixed(&self) -> bool {
        self.has_ground() && self.holes > 0
    }

    fn is_sound(&self) -> bool {
        let [south, east, north, west] = self.skipped;
        let lengths = [
            self.margin,
            self.error,
            self.whole,
            south,
            east,
            north,
            west,
            self.vertex_error,
            self.deviation,
        ];
        let range = [self.low, self.high];
        lengths.iter().all(|l| l.is_finite() && *l >= 0.0)
            && (range.iter().all(|z| z.is_finite()) && self.has_ground()
                || range == [Self::NOTHING.low, Self::NOTHING.high])
    }
}

impl Block {
    /// Cuts a block out of a height field and measures its nodes. `block` is a level-0 node of
    /// the layout.
    pub fn cut(field: &HeightField, layout: &Layout, block: Node) -> Self {
        let cells = 1 << layout.levels();
        let posts = |at: u32| (0..=cells).map(move |k| at * cells + k);
        let heights = posts(block.y)
            .flat_map(|row| posts(block.x).map(move |column| field.height(column, row)))
            .collect();
        let mut cut = Self {
            levels: layout.levels(),
            records: vec![NodeRecord::NOTHING; level_start(layout.levels())],
            heights,
        };
        cut.records = measure::records(layout, &cut, block);
        cut
    }

    /// A block from its arrays, as [`Block::records`] and [`Block::heights`] gave them.
    ///
    /// # Errors
    /// [`BlockError`] for arrays of the wrong length and for numbers that no cut writes. Numbers
    /// that are merely wrong are not found out: they make a wrong picture, never a crash.
    pub fn from_arrays(
        levels: u32,
        records: Vec<NodeRecord>,
        heights: Vec<f32>,
    ) -> Result<Self, BlockError> {
        let levels = levels.clamp(1, Layout::MOST_LEVELS);
        let side = (1 << levels) + 1;
        let lengths = [
            ("records", level_start(levels), records.len()),
            ("heights", side * side, heights.len()),
        ];
        for (what, expected, given) in lengths {
            if expected != given {
                return Err(BlockError::Length {
                    levels,
                    what,
                    expected,
                    given,
                });
            }
        }
        let number = |what, at: Option<usize>| {
            at.map_or(Ok(()), |index| Err(BlockError::Number { what, index }))
        };
        number("record", records.iter().position(|r| !r.is_sound()))?;
        number(
            "height",
            heights
                .iter()
                .position(|z| z.abs() > HeightField::HIGHEST_M),
        )?;
        Ok(Self {
            levels,
            records,
            heights,
        })
    }

    /// n: the nodes of level n are its cells and have no record.
    pub fn levels(&self) -> u32 {
        self.levels
    }

    /// Records of the nodes of levels 0 to n − 1, coarse first, each level row by row from the
    /// south-west ([`Node::index`]).
    pub fn records(&self) -> &[NodeRecord] {
        &self.records
    }

    /// Heights row by row from the south-west, NaN where unknown; beyond the raster those of its
    /// last column and row again.
    pub fn heights(&self) -> &[f32] {
        &self.heights
    }

    /// The height of a post of the block, by column and row of the whole raster.
    ///
    /// Posts of other blocks have no meaning here; the answer is that of some post of the block.
    pub fn height(&self, block: Node, [column, row]: [u32; 2]) -> f32 {
        let cells = 1_u32 << self.levels;
        let within = |post: u32, block: u32| post.saturating_sub(block << self.levels).min(cells);
        let (column, row) = (within(column, block.x), within(row, block.y));
        self.heights[row as usize * (cells as usize + 1) + column as usize]
    }
}
