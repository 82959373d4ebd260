//! What a pyramid holds: tiles, records, blocks, and all of it as a ground.

use std::sync::Arc;

use rayon::prelude::*;

use super::error::PyramidError;
use super::file::Section;
use super::open::Pyramid;
use crate::terrain::{Block, Ground, Node, NodeRecord};

/// Heights of one node, as far apart as its level says.
#[derive(Debug, Clone, PartialEq)]
pub struct Tile {
    /// [`Tiling::tile_posts`](super::Tiling::tile_posts) heights row by row from the south-west, m; NaN where unknown. Beyond
    /// the raster those of its last column and row again.
    pub heights: Vec<f32>,
}

impl Pyramid {
    /// Reads a tile and checks it.
    ///
    /// # Errors
    /// [`PyramidError::NoTile`], and [`PyramidError::Damaged`] where its checksum does not match.
    pub fn tile(&self, node: Node) -> Result<Tile, PyramidError> {
        let bytes = self.checked_bytes(node)?;
        let heights = &bytes[..self.tiling.tile_posts() * size_of::<f32>()];
        let heights = heights.as_chunks().0.iter().map(|&b| f32::from_le_bytes(b));
        Ok(Tile {
            heights: heights.collect(),
        })
    }

    /// The height of the post that is nearest to a place, m; `None` beyond the raster, where it is
    /// unknown and where its tile is damaged. Reads one tile.
    pub fn height_near(&self, x: f64, y: f64) -> Option<f64> {
        let (tiling, grid) = (&self.tiling, self.tiling.layout().grid());
        let post = |at: f64, count: u32| {
            let at = at.round();
            (at >= 0.0 && at < f64::from(count)).then_some(at as u32)
        };
        let column = post((x - grid.origin().x) / grid.spacing().x, grid.columns())?;
        let row = post((y - grid.origin().y) / grid.spacing().y, grid.rows())?;
        let levels = tiling.tile_levels();
        // The last post belongs to the tile before it.
        let tile = |at: u32| at.saturating_sub(1) >> levels;
        let (tile_x, tile_y) = (tile(column), tile(row));
        let node = Node {
            level: tiling.finest(),
            x: tile_x,
            y: tile_y,
        };
        let [across, up] = [column - (tile_x << levels), row - (tile_y << levels)];
        let heights = self.tile(node).ok()?.heights;
        let height = heights[up as usize * tiling.tile_side() + across as usize];
        (!height.is_nan()).then(|| height.into())
    }

    /// What is known of a node that has a tile or lies in one of the finest, cells excepted;
    /// [`NodeRecord::NOTHING`] beyond the ground. As it stands in the file: its checksum is that
    /// of the block ([`Pyramid::records`]).
    pub fn record(&self, node: Node) -> NodeRecord {
        let block = self.tiling.layout().block_of(node);
        let record = block.and_then(|block| self.unchecked_records(block).get(node.index()));
        record.copied().unwrap_or(NodeRecord::NOTHING)
    }

    /// The records of a block, coarse levels first, checked; none for a number beyond the last.
    ///
    /// # Errors
    /// [`PyramidError::Damaged`] where their checksum does not match.
    pub fn records(&self, block: usize) -> Result<&[NodeRecord], PyramidError> {
        let records = self.unchecked_records(block);
        let sum = crc32fast::hash(bytemuck::cast_slice(records));
        if records.is_empty() || self.sum(self.tiling.records_sum(block)) == sum {
            return Ok(records);
        }
        let reason = format!("the checksum of block {block} does not match");
        Err(PyramidError::damaged(&self.path, Section::Records, &reason))
    }

    fn unchecked_records(&self, block: usize) -> &[NodeRecord] {
        let records = &self.map[self.sections[Section::Records as usize].clone()];
        let records = bytemuck::try_cast_slice(records).unwrap_or_default();
        let count = self.tiling.block_records();
        let from = block.saturating_mul(count);
        let records = records.get(from..).and_then(|r| r.get(..count));
        records.unwrap_or_default()
    }

    /// Lowest and highest post, m; `None` where nothing is known. As it stands in the file, like
    /// [`Pyramid::record`].
    pub fn height_range(&self) -> Option<[f32; 2]> {
        let roots = (0..self.tiling.layout().block_count())
            .filter_map(|block| self.unchecked_records(block).first())
            .filter(|record| record.has_ground());
        roots.fold(None, |range: Option<[f32; 2]>, record| {
            let [low, high] = range.unwrap_or([record.low, record.high]);
            Some([low.min(record.low), high.max(record.high)])
        })
    }

    /// Reads a block with all its posts.
    ///
    /// # Errors
    /// [`PyramidError`] for damaged tiles or records and for numbers that no cut writes.
    pub fn block(&self, number: usize) -> Result<Block, PyramidError> {
        let layout = self.tiling.layout();
        let (root, level) = (layout.block(number), self.tiling.finest());
        let (side, tile_side) = (layout.side() as usize, self.tiling.tile_side());
        let mut heights = vec![f32::NAN; side * side];
        for number in 0..1_u32 << (2 * level) {
            let node = root.numbered(level, number);
            let (x, y) = (number % (1 << level), number / (1 << level));
            let (left, bottom) = (x as usize * (tile_side - 1), y as usize * (tile_side - 1));
            let posts = self.tile(node)?.heights;
            for (row, posts) in posts.chunks_exact(tile_side).enumerate() {
                heights[(bottom + row) * side + left..][..tile_side].copy_from_slice(posts);
            }
        }
        let records = self.records(number)?.to_vec();
        Block::from_arrays(layout.levels(), records, heights).map_err(|source| {
            PyramidError::Block {
                path: self.path.clone(),
                block: number,
                source,
            }
        })
    }

    /// Reads all blocks, in parallel.
    ///
    /// # Errors
    /// As [`Pyramid::block`].
    pub fn ground(&self) -> Result<Ground, PyramidError> {
        let layout = *self.tiling.layout();
        let blocks = (0..layout.block_count()).into_par_iter();
        let blocks: Result<Vec<_>, _> = blocks
            .map(|number| self.block(number).map(|block| Some(Arc::new(block))))
            .collect();
        let ground = Ground::new(layout, blocks?);
        ground.map_err(|e| PyramidError::damaged(&self.path, Section::Tiles, &e.to_string()))
    }

    pub(super) fn checked_bytes(&self, node: Node) -> Result<&[u8], PyramidError> {
        let index = self
            .tiling
            .tile_index(node)
            .ok_or_else(|| PyramidError::NoTile {
                path: self.path.clone(),
                level: node.level,
                x: node.x,
                y: node.y,
            })? as usize;
        let stride = self.tiling.tile_stride() as usize;
        let tiles = &self.map[self.sections[Section::Tiles as usize].clone()];
        let bytes = &tiles[index * stride..][..stride];
        if self.sum(index) == crc32fast::hash(bytes) {
            return Ok(bytes);
        }
        let Node { level, x, y } = node;
        let reason = format!("the checksum of tile {x}, {y} of level {level} does not match");
        Err(PyramidError::damaged(&self.path, Section::Tiles, &reason))
    }

    /// A number of the section of checksums.
    fn sum(&self, index: usize) -> u32 {
        let sums = &self.map[self.sections[Section::Sums as usize].clone()];
        bytemuck::pod_read_unaligned(&sums[index * 4..][..4])
    }
}
