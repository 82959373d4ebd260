//! Blocks put together, whether all of them are in memory or not.

use std::sync::Arc;

use rayon::prelude::*;

use super::block::{Block, NodeRecord};
use super::field::HeightField;
use super::layout::Layout;
use super::quadtree::Node;
use super::triangle::Post;
use crate::geom::{Aabb, DVec3};

/// The ground as a forest of blocks. A block that is not in memory is not drawn, and its
/// neighbours are drawn as if the ground ended there.
#[derive(Debug, Clone)]
pub struct Ground {
    layout: Layout,
    blocks: Vec<Option<Arc<Block>>>,
}

/// Why blocks are no ground.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GroundError {
    /// Not one place for each block of the layout.
    #[error("{given} blocks for a layout of {expected}")]
    Count {
        /// Blocks given, missing ones included.
        given: usize,
        /// Blocks of the layout.
        expected: usize,
    },
    /// A block of another layout.
    #[error("block {number} has depth {levels}, the layout {expected}")]
    Depth {
        /// Which block.
        number: usize,
        /// Its depth.
        levels: u32,
        /// That of the layout.
        expected: u32,
    },
}

impl Ground {
    /// Cuts a height field into blocks and measures them, in parallel. The same whatever the
    /// number of threads.
    pub fn cut(field: &HeightField, layout: &Layout) -> Self {
        let blocks = (0..layout.block_count()).into_par_iter().map(|number| {
            let block = Block::cut(field, layout, layout.block(number));
            Some(Arc::new(block))
        });
        Self {
            layout: *layout,
            blocks: blocks.collect(),
        }
    }

    /// Ground of the blocks that are in memory, in the order of their numbers.
    ///
    /// # Errors
    /// [`GroundError`] when they do not belong to the layout.
    pub fn new(layout: Layout, blocks: Vec<Option<Arc<Block>>>) -> Result<Self, GroundError> {
        let (given, expected) = (blocks.len(), layout.block_count());
        if given != expected {
            return Err(GroundError::Count { given, expected });
        }
        let depth = |block: &Option<Arc<Block>>| block.as_ref().map(|b| b.levels());
        let foreign = |block| depth(block).is_some_and(|levels| levels != layout.levels());
        if let Some(number) = blocks.iter().position(foreign) {
            return Err(GroundError::Depth {
                number,
                levels: depth(&blocks[number]).unwrap_or_default(),
                expected: layout.levels(),
            });
        }
        Ok(Self { layout, blocks })
    }

    /// How the raster is cut.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// A block by its number; `None` where it is not in memory.
    pub fn block(&self, number: usize) -> Option<&Arc<Block>> {
        self.blocks.get(number)?.as_ref()
    }

    /// The block that a node is in; `None` beyond the ground and where it is not in memory.
    pub fn block_of(&self, node: Node) -> Option<&Block> {
        Some(self.block(self.layout.block_of(node)?)?.as_ref())
    }

    /// What is known of a node. Cells have no record but are told from their posts: their errors
    /// are 0. Beyond the ground it is [`NodeRecord::NOTHING`].
    pub fn record(&self, node: Node) -> NodeRecord {
        let Some(block) = self.block_of(node) else {
            return NodeRecord::NOTHING;
        };
        if node.level < self.layout.levels() {
            return block.records()[node.index()];
        }
        let posts = self.layout.posts(node);
        let mut record = NodeRecord::NOTHING;
        if posts.is_flat() {
            return record;
        }
        let root = self.root(node);
        let heights = posts.corners().map(|post| block.height(root, post));
        if heights.iter().any(|z| z.is_nan()) {
            record.holes = 1;
        } else {
            record.low = heights.into_iter().fold(record.low, f32::min);
            record.high = heights.into_iter().fold(record.high, f32::max);
        }
        record
    }

    /// The block that a node is in, as a node.
    pub fn root(&self, node: Node) -> Node {
        let block = |at: u32| at.checked_shr(node.level).unwrap_or(0);
        Node {
            level: 0,
            x: block(node.x),
            y: block(node.y),
        }
    }

    /// Height of a post of a node, m; NaN where unknown or not in memory.
    pub fn height(&self, node: Node, post: Post) -> f32 {
        let block = self.block_of(node);
        block.map_or(f32::NAN, |block| block.height(self.root(node), post))
    }

    /// Height of a post by column and row of the raster, m; beyond the last one that of the last
    /// one. NaN where unknown or not in memory.
    pub fn post(&self, column: u32, row: u32) -> f32 {
        let ([across, up], levels) = (self.layout.blocks(), self.layout.levels());
        let block = Node {
            level: 0,
            x: (column >> levels).min(across.saturating_sub(1)),
            y: (row >> levels).min(up.saturating_sub(1)),
        };
        self.height(block, [column, row])
    }

    /// Box around the posts of a node and around every surface that may be drawn in it;
    /// [`Aabb::EMPTY`] where it has no ground.
    pub fn bounds(&self, node: Node, record: &NodeRecord) -> Aabb {
        if !record.has_ground() {
            return Aabb::EMPTY;
        }
        let (posts, grid) = (self.layout.posts(node), self.layout.grid());
        let margin = f64::from(record.margin);
        let corner = |[column, row]: Post, z: f64| DVec3::new(grid.x(column), grid.y(row), z);
        Aabb::around([
            corner(posts.first, f64::from(record.low) - margin),
            corner(posts.last, f64::from(record.high) + margin),
        ])
    }
}
