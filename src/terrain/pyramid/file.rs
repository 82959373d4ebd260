//! The `.terrain` format: what lies where in a file, and how it is checked.
//!
//! Little endian. Sections start on multiples of 64 bytes; gaps are zero.
//!
//! | offset | size | field |
//! |---|---|---|
//! | 0 | 8 | magic `89 43 54 45 52 0D 0A 1A` |
//! | 8 | 4 | format version |
//! | 12 | 4 | CRC-32 of the rest of the header and of the section table |
//! | 16 | 8 | length of the file |
//! | 24 | 8 | posts from west to east, from south to north, 2 u32 |
//! | 32 | 16 | south-west post, 2 f64, m |
//! | 48 | 16 | from post to post, 2 f64, m |
//! | 64 | 4 | depth of a block, h: 2^h + 1 posts a side |
//! | 68 | 4 | depth of a tile, n ≤ h: 2^n + 1 posts a side |
//! | 72 | 4 | number of sections |
//! | 76 | 20 | zero |
//! | 96 | 32 each | section table: tag (8 bytes), offset u64, length u64, CRC-32 u32, zero u32 |
//!
//! The raster is cut into square blocks, row by row from the south-west
//! ([`Layout`](crate::terrain::Layout)). The nodes of a block's levels 0 to h − n have a tile each:
//! a node of level L is drawn with 2^n + 1 posts a side, 2^(h−n−L) posts of the raster apart.
//! Nodes are numbered row by row within each level ([`Node`]), so that child (dr, dc) of node N on
//! level L is 2N + dc + (⌊N/2^L⌋ + dr)·2^(L+1) (A, equation 1), and a tile is found by arithmetic.
//!
//! A section's checksum covers it up to the start of the next one, gap included. Tiles have one
//! each instead, and the records of a block one more, so that one tile or block is checked without
//! reading the others.

use bytemuck::{Pod, Zeroable};

use crate::terrain::{Layout, Node, NodeRecord, level_start};

/// First bytes: not text, and damaged by anything that changes line ends.
pub(super) const MAGIC: [u8; 8] = *b"\x89CTER\r\n\x1a";
/// Raised with every change that older programs would misread.
pub(super) const VERSION: u32 = 2;
pub(super) const ALIGNMENT: u64 = 64;

/// What a file holds, in the order it lies there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(usize)]
pub(super) enum Section {
    /// UTF-8: coordinate reference system, as `AUTHORITY:CODE`; empty where none was named.
    Crs,
    /// [`NodeRecord`] (11 f32 and 1 u32: low, high, margin, error, whole, skipped × 4, vertex error,
    /// deviation, holes) for the nodes of levels 0 to h − 1 of each block, block after block.
    Records,
    /// u32 a tile: CRC-32 of its bytes, padding included; then u32 a block: CRC-32 of its records.
    Sums,
    /// The tiles, coarsest level first, in a level block after block, in a block in the order of
    /// their numbers. f32 heights row by row from the south-west, NaN where unknown, those beyond
    /// the raster repeated from its last column and row; zeros up to a multiple of 64 bytes.
    Tiles,
}

impl Section {
    pub(super) const ALL: [Self; 4] = [Self::Crs, Self::Records, Self::Sums, Self::Tiles];

    pub(super) const fn tag(self) -> [u8; 8] {
        *match self {
            Self::Crs => b"crs     ",
            Self::Records => b"records ",
            Self::Sums => b"sums    ",
            Self::Tiles => b"tiles   ",
        }
    }

    /// The tag as people read it.
    pub(super) fn name(self) -> String {
        String::from_utf8_lossy(&self.tag()).trim_end().to_owned()
    }
}

#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Header {
    pub magic: [u8; 8],
    pub version: u32,
    pub checksum: u32,
    pub length: u64,
    pub posts: [u32; 2],
    pub origin: [f64; 2],
    pub spacing: [f64; 2],
    pub block_levels: u32,
    pub tile_levels: u32,
    pub sections: u32,
    pub zero: [u32; 5],
}

#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct TableEntry {
    pub tag: [u8; 8],
    pub offset: u64,
    pub length: u64,
    pub checksum: u32,
    pub zero: u32,
}

/// Bytes of header and section table.
pub(super) const TABLE_END: usize =
    size_of::<Header>() + Section::ALL.len() * size_of::<TableEntry>();
/// Bytes before the first section.
pub(super) const HEAD: u64 = (TABLE_END as u64).next_multiple_of(ALIGNMENT);

/// How tiles are counted: all that the header decides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tiling {
    layout: Layout,
    tile_levels: u32,
}

impl Tiling {
    /// Depth of a tile where nothing else is asked for: 33 posts a side, 2048 triangles. All
    /// triangle counts of A's table 1 are multiples of 2048.
    pub const TILE_LEVELS: u32 = 5;

    /// Tiles of [`Tiling::TILE_LEVELS`] in blocks of the smallest depth whose side covers the
    /// raster, or of the largest there may be.
    pub fn new(grid: crate::terrain::Grid) -> Self {
        let longest = grid.columns().max(grid.rows()) - 1;
        let most = Layout::MOST_LEVELS;
        let levels = (Self::TILE_LEVELS..most)
            .find(|n| longest <= 1 << n)
            .unwrap_or(most);
        Self::with_levels(Layout::with_levels(grid, levels), Self::TILE_LEVELS)
    }

    /// Tiles of 2^`tile_levels` + 1 posts a side, no larger than the blocks.
    pub fn with_levels(layout: Layout, tile_levels: u32) -> Self {
        Self {
            layout,
            tile_levels: tile_levels.clamp(1, layout.levels()),
        }
    }

    /// How the raster is cut into blocks.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// n: a tile has 2^n + 1 posts a side.
    pub fn tile_levels(&self) -> u32 {
        self.tile_levels
    }

    /// The level whose tiles hold every post; tiles have levels 0 to this.
    pub fn finest(&self) -> u32 {
        self.layout.levels() - self.tile_levels
    }

    /// Posts a side of a tile.
    pub fn tile_side(&self) -> usize {
        (1 << self.tile_levels) + 1
    }

    /// Posts of a tile.
    pub fn tile_posts(&self) -> usize {
        self.tile_side() * self.tile_side()
    }

    /// Posts of the raster from post to post of a tile.
    pub fn stride(&self, level: u32) -> u32 {
        1 << (self.finest() - level)
    }

    /// How many tiles there are.
    pub fn tile_count(&self) -> u64 {
        self.layout.block_count() as u64 * level_start(self.finest() + 1) as u64
    }

    /// Tiles of one level, in the order they lie in the file.
    pub fn tiles(&self, level: u32) -> impl Iterator<Item = Node> + use<> {
        let layout = self.layout;
        (0..layout.block_count()).flat_map(move |number| {
            let root = layout.block(number);
            (0..1_u32 << (2 * level)).map(move |number| root.numbered(level, number))
        })
    }

    /// Place of a tile in the file; `None` for a node that has none.
    pub fn tile_index(&self, node: Node) -> Option<u64> {
        if node.level > self.finest() {
            return None;
        }
        let blocks = self.layout.block_count() as u64;
        let block = self.layout.block_of(node)? as u64;
        let before = blocks * level_start(node.level) as u64 + (block << (2 * node.level));
        Some(before + u64::from(node.number()))
    }

    /// Bytes from tile to tile.
    pub(super) fn tile_stride(&self) -> u64 {
        (self.tile_posts() as u64 * 4).next_multiple_of(ALIGNMENT)
    }

    /// Place of the checksum of a block's records among all checksums.
    pub(super) fn records_sum(&self, block: usize) -> usize {
        self.tile_count() as usize + block
    }

    /// Records of one block.
    pub(super) fn block_records(&self) -> usize {
        level_start(self.layout.levels())
    }

    /// Where the sections lie, for a system with a name of `crs` bytes; the last number is the
    /// length of the file. `None` where it is beyond 64 bits.
    pub(super) fn sections(&self, crs: u64) -> Option<([(u64, u64); Section::ALL.len()], u64)> {
        let blocks = self.layout.block_count() as u64;
        let record = size_of::<NodeRecord>() as u64;
        let mut end = HEAD;
        let mut sections = [(0, 0); Section::ALL.len()];
        for (section, place) in Section::ALL.into_iter().zip(&mut sections) {
            let length = match section {
                Section::Crs => crs,
                Section::Records => blocks.checked_mul(self.block_records() as u64 * record)?,
                Section::Sums => (self.tile_count().checked_add(blocks)?).checked_mul(4)?,
                Section::Tiles => self.tile_count().checked_mul(self.tile_stride())?,
            };
            *place = (end, length);
            end = end
                .checked_add(length)?
                .checked_next_multiple_of(ALIGNMENT)?;
        }
        Some((sections, end))
    }
}
