//! How a raster of any size is cut into square blocks.

use super::field::Grid;
use super::quadtree::Node;

/// Any rectangle as several square blocks of 2^n + 1 posts that share their border posts. Blocks
/// reach beyond the last column and row; what lies there is folded onto it, so a node may be
/// narrower than it is tall, or have no area at all.
///
/// A raster of a single column or row has no area and no block.
///
/// Source: C, section 2.1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layout {
    grid: Grid,
    levels: u32,
    blocks: [u32; 2],
}

/// Posts of a node: first and last column and row, counted over the whole raster.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Posts {
    /// South-west.
    pub first: [u32; 2],
    /// The post in the middle, where its children meet.
    pub middle: [u32; 2],
    /// North-east.
    pub last: [u32; 2],
}

impl Layout {
    /// Depths of a block that C names.
    pub const LEVELS: std::ops::RangeInclusive<u32> = 4..=7;
    /// The deepest block there may be.
    pub const MOST_LEVELS: u32 = 10;

    /// Blocks of the smallest depth of C whose side covers the raster, or of the largest.
    pub fn new(grid: Grid) -> Self {
        let longest = grid.columns().max(grid.rows()) - 1;
        let (least, most) = Self::LEVELS.into_inner();
        let levels = (least..most).find(|n| longest <= 1 << n).unwrap_or(most);
        Self::with_levels(grid, levels)
    }

    /// Blocks of 2^`levels` + 1 posts a side; depths outside 1 to [`Layout::MOST_LEVELS`] are
    /// drawn into that range.
    pub fn with_levels(grid: Grid, levels: u32) -> Self {
        let levels = levels.clamp(1, Self::MOST_LEVELS);
        let blocks = |posts: u32| (posts - 1).div_ceil(1 << levels);
        Self {
            grid,
            levels,
            blocks: [blocks(grid.columns()), blocks(grid.rows())],
        }
    }

    /// Where the posts stand.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// n: nodes of this level are single cells between four posts.
    pub fn levels(&self) -> u32 {
        self.levels
    }

    /// Posts a side of a block, 2^n + 1.
    pub fn side(&self) -> u32 {
        (1 << self.levels) + 1
    }

    /// Blocks from west to east and from south to north.
    pub fn blocks(&self) -> [u32; 2] {
        self.blocks
    }

    /// How many blocks there are; they are numbered row by row from the south-west.
    pub fn block_count(&self) -> usize {
        let [across, up] = self.blocks();
        across as usize * up as usize
    }

    /// Level-0 node of a block.
    pub fn block(&self, number: usize) -> Node {
        let across = self.blocks()[0].max(1) as usize;
        Node {
            level: 0,
            x: (number % across) as u32,
            y: (number / across) as u32,
        }
    }

    /// Number of the block that a node is in; `None` beyond the last block, and below the cells.
    pub fn block_of(&self, node: Node) -> Option<usize> {
        if node.level > self.levels {
            return None;
        }
        let [across, up] = self.blocks();
        let (x, y) = (node.x >> node.level, node.y >> node.level);
        (x < across && y < up).then(|| y as usize * across as usize + x as usize)
    }

    /// The posts of a node, those beyond the raster folded onto its last column and row. There is
    /// nothing below the cells: what is asked for there is taken for a cell.
    pub fn posts(&self, node: Node) -> Posts {
        let side = self.cells(node.level);
        let last = [self.grid.columns() - 1, self.grid.rows() - 1];
        let at = |half_sides: u32| {
            let post = |at: u32, last: u32| {
                let unfolded = u64::from(at) * u64::from(side) + u64::from(half_sides * side / 2);
                unfolded.min(u64::from(last)) as u32
            };
            [post(node.x, last[0]), post(node.y, last[1])]
        };
        Posts {
            first: at(0),
            middle: at(1),
            last: at(2),
        }
    }

    /// Length of a node's longer side before folding, m: D in A and B; on level 0 r in C.
    pub fn side_m(&self, level: u32) -> f64 {
        self.grid.spacing().max_element() * f64::from(self.cells(level))
    }

    /// Cells a side of a node before folding, 1 below the cells too.
    pub fn cells(&self, level: u32) -> u32 {
        1 << self.levels.saturating_sub(level)
    }
}

impl Posts {
    /// South-west, south-east, north-east, north-west.
    pub fn corners(&self) -> [[u32; 2]; 4] {
        let ([x0, y0], [x1, y1]) = (self.first, self.last);
        [[x0, y0], [x1, y0], [x1, y1], [x0, y1]]
    }

    /// The middles of the south, east, north and west side.
    pub fn midpoints(&self) -> [[u32; 2]; 4] {
        let ([x0, y0], [x1, y1], [x, y]) = (self.first, self.last, self.middle);
        [[x, y0], [x1, y], [x, y1], [x0, y]]
    }

    /// Whether no area is left.
    pub fn is_flat(&self) -> bool {
        self.first[0] == self.last[0] || self.first[1] == self.last[1]
    }
}
