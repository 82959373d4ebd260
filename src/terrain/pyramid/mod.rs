//! The ground on disk: a pyramid of tiles, each found by arithmetic and read by itself.
//!
//! [`write()`] cuts a raster of any size with one block in memory; [`Pyramid`] opens the file in
//! constant time and reads tiles, records and blocks out of it. The format is in `file.rs`.
//!
//! Source: A, section 1.1 (pyramid of tiles, linear quadtree); C, section 2.1 (square blocks).

mod error;
mod file;
mod identity;
mod write;

use std::fs::File;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use memmap2::Mmap;
use rayon::prelude::*;

pub use error::PyramidError;
pub use file::Tiling;
pub use write::write;

use crate::geom::DVec2;
use crate::terrain::{Block, Grid, Ground, Layout, Node, NodeRecord};
use file::{ALIGNMENT, HEAD, Header, MAGIC, Section, TABLE_END, TableEntry, VERSION};

/// An open `.terrain` file.
#[derive(Debug)]
pub struct Pyramid {
    path: PathBuf,
    map: Mmap,
    tiling: Tiling,
    crs: Option<String>,
    sections: [Range<usize>; Section::ALL.len()],
}

/// Heights of one node, as far apart as its level says.
#[derive(Debug, Clone, PartialEq)]
pub struct Tile {
    /// [`Tiling::tile_posts`] heights row by row from the south-west, m; NaN where unknown. Beyond
    /// the raster those of its last column and row again.
    pub heights: Vec<f32>,
}

/// Where the ground of a city lies: beside it, under the same name with the ending `.terrain`.
///
/// Not in the city's own file: either is replaced without the other, and a city without ground is
/// what it was before there was any.
pub fn beside(city: &Path) -> PathBuf {
    city.with_extension("terrain")
}

/// Everything of the head but the magic, the version and the checksum itself.
fn head_checksum(head: &[u8]) -> u32 {
    let covered = std::mem::offset_of!(Header, length)..HEAD as usize;
    crc32fast::hash(&head[covered])
}

impl Pyramid {
    /// Maps a file without reading it through: constant time, whatever its size. Header and
    /// section table are checked, and every tile when it is read; see [`Pyramid::open_verified`].
    ///
    /// The file must not be changed in place while it is mapped. [`write()`] replaces files
    /// whole, so writing over an open one is safe.
    ///
    /// # Errors
    /// [`PyramidError`] when the file cannot be read, is none of ours, or is cut off.
    pub fn open(path: &Path) -> Result<Self, PyramidError> {
        let io = |action| {
            move |source| PyramidError::Io {
                path: path.to_owned(),
                action,
                source,
            }
        };
        let file = File::open(path).map_err(io("cannot open"))?;
        if file.metadata().map_err(io("cannot open"))?.len() == 0 {
            return Err(PyramidError::Foreign {
                path: path.to_owned(),
            });
        }
        #[allow(
            unsafe_code,
            reason = "mapping a file is the one thing that needs it; the caller's duty is in the docs"
        )]
        // SAFETY: the map is only read, through slices that live no longer than it, and every
        // bit pattern is valid for the types it is read as. The caller keeps the file unchanged.
        let map = unsafe { Mmap::map(&file) }.map_err(io("cannot map"))?;
        let (tiling, sections) = parse(path, &map)?;
        let crs = std::str::from_utf8(&map[sections[Section::Crs as usize].clone()]);
        let crs = crs.map_err(|e| damaged(path, Section::Crs, &e.to_string()))?;
        Ok(Self {
            path: path.to_owned(),
            tiling,
            crs: (!crs.is_empty()).then(|| crs.to_owned()),
            sections,
            map,
        })
    }

    /// Opens a file and checks every byte of it against its checksums.
    ///
    /// # Errors
    /// [`PyramidError`], naming the damaged section.
    pub fn open_verified(path: &Path) -> Result<Self, PyramidError> {
        let pyramid = Self::open(path)?;
        let table = &pyramid.map[size_of::<Header>()..TABLE_END];
        let entries = table.chunks_exact(size_of::<TableEntry>());
        for (section, entry) in Section::ALL.into_iter().zip(entries) {
            if section == Section::Tiles {
                continue;
            }
            let entry: TableEntry = bytemuck::pod_read_unaligned(entry);
            let range = &pyramid.sections[section as usize];
            let end = range.end.next_multiple_of(ALIGNMENT as usize);
            if crc32fast::hash(&pyramid.map[range.start..end]) != entry.checksum {
                return Err(damaged(path, section, "its checksum does not match"));
            }
        }
        for level in 0..=pyramid.tiling.finest() {
            for node in pyramid.tiling.tiles(level) {
                pyramid.checked_bytes(node)?;
            }
        }
        Ok(pyramid)
    }

    /// How the raster is cut.
    pub fn tiling(&self) -> &Tiling {
        &self.tiling
    }

    /// Coordinate reference system, where the source named one.
    pub fn crs(&self) -> Option<&str> {
        self.crs.as_deref()
    }

    /// Length of the file.
    pub fn byte_len(&self) -> usize {
        self.map.len()
    }

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

    /// What is known of a node that has a tile or lies in one of the finest, cells excepted;
    /// [`NodeRecord::NOTHING`] beyond the ground.
    pub fn record(&self, node: Node) -> NodeRecord {
        let block = self.tiling.layout().block_of(node);
        let record = block.and_then(|block| self.records(block).get(node.index()));
        record.copied().unwrap_or(NodeRecord::NOTHING)
    }

    /// The records of a block, coarse levels first.
    pub fn records(&self, block: usize) -> &[NodeRecord] {
        let records = &self.map[self.sections[Section::Records as usize].clone()];
        let records = bytemuck::try_cast_slice(records).unwrap_or_default();
        let count = self.tiling.block_records();
        records
            .get(block * count..)
            .and_then(|r| r.get(..count))
            .unwrap_or_default()
    }

    /// Lowest and highest post, m; `None` where nothing is known.
    pub fn height_range(&self) -> Option<[f32; 2]> {
        let roots = (0..self.tiling.layout().block_count())
            .filter_map(|block| self.records(block).first())
            .filter(|record| record.has_ground());
        roots.fold(None, |range: Option<[f32; 2]>, record| {
            let [low, high] = range.unwrap_or([record.low, record.high]);
            Some([low.min(record.low), high.max(record.high)])
        })
    }

    /// Reads a block with all its posts.
    ///
    /// # Errors
    /// [`PyramidError`] for damaged tiles and for numbers that no cut writes.
    pub fn block(&self, number: usize) -> Result<Block, PyramidError> {
        let layout = self.tiling.layout();
        let (root, level) = (layout.block(number), self.tiling.finest());
        let (side, tile_side) = (layout.side() as usize, self.tiling.tile_side());
        let mut heights = vec![f32::NAN; side * side];
        for tile in 0..1_u32 << (2 * level) {
            let (x, y) = (tile % (1 << level), tile / (1 << level));
            let node = Node {
                level,
                x: (root.x << level) + x,
                y: (root.y << level) + y,
            };
            let (left, bottom) = (x as usize * (tile_side - 1), y as usize * (tile_side - 1));
            let posts = self.tile(node)?.heights;
            for (row, posts) in posts.chunks_exact(tile_side).enumerate() {
                heights[(bottom + row) * side + left..][..tile_side].copy_from_slice(posts);
            }
        }
        let records = self.records(number).to_vec();
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
        ground.map_err(|e| damaged(&self.path, Section::Tiles, &e.to_string()))
    }

    fn checked_bytes(&self, node: Node) -> Result<&[u8], PyramidError> {
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
        let sums = &self.map[self.sections[Section::Sums as usize].clone()];
        if bytemuck::pod_read_unaligned::<u32>(&sums[index * 4..][..4]) == crc32fast::hash(bytes) {
            return Ok(bytes);
        }
        let Node { level, x, y } = node;
        let reason = format!("the checksum of tile {x}, {y} of level {level} does not match");
        Err(damaged(&self.path, Section::Tiles, &reason))
    }
}

fn damaged(path: &Path, section: Section, reason: &str) -> PyramidError {
    PyramidError::Damaged {
        path: path.to_owned(),
        section: section.name(),
        reason: reason.to_owned(),
    }
}

/// What the head says, as far as it holds together: afterwards every tile, record and sum lies
/// within the file.
fn parse(
    path: &Path,
    bytes: &[u8],
) -> Result<(Tiling, [Range<usize>; Section::ALL.len()]), PyramidError> {
    let damaged_head = |reason: String| PyramidError::Damaged {
        path: path.to_owned(),
        section: "header".into(),
        reason,
    };
    let known = bytes.len().min(MAGIC.len());
    if bytes[..known] != MAGIC[..known] {
        return Err(PyramidError::Foreign {
            path: path.to_owned(),
        });
    }
    if (bytes.len() as u64) < HEAD {
        return Err(damaged_head(format!(
            "cut off at {} of {HEAD} bytes",
            bytes.len()
        )));
    }
    let header: Header = bytemuck::pod_read_unaligned(&bytes[..size_of::<Header>()]);
    if header.version != VERSION {
        return Err(PyramidError::Version {
            path: path.to_owned(),
            found: header.version,
            expected: VERSION,
        });
    }
    if head_checksum(bytes) != header.checksum {
        return Err(damaged_head("its checksum does not match".into()));
    }
    let [columns, rows] = header.posts;
    let (origin, spacing) = (DVec2::from(header.origin), DVec2::from(header.spacing));
    let grid =
        Grid::new(columns, rows, origin, spacing).map_err(|e| damaged_head(e.to_string()))?;
    let layout = Layout::with_levels(grid, header.block_levels);
    let tiling = Tiling::with_levels(layout, header.tile_levels);
    let as_written = layout.levels() == header.block_levels
        && tiling.tile_levels() == header.tile_levels
        && header.sections as usize == Section::ALL.len();
    if !as_written {
        return Err(damaged_head("impossible depths or counts".into()));
    }
    let table = &bytes[size_of::<Header>()..TABLE_END];
    let entries = table.chunks_exact(size_of::<TableEntry>());
    let entries: Vec<TableEntry> = entries.map(bytemuck::pod_read_unaligned).collect();
    let placed = tiling.sections(entries[Section::Crs as usize].length);
    let (places, length) = placed.ok_or_else(|| damaged_head("impossible lengths".into()))?;
    for ((section, entry), place) in Section::ALL.into_iter().zip(&entries).zip(places) {
        if entry.tag != section.tag() || (entry.offset, entry.length) != place {
            return Err(damaged(path, section, "not where the raster's size has it"));
        }
    }
    if header.length != length || bytes.len() as u64 != length {
        let reason = format!("{} bytes long instead of {length}", bytes.len());
        return Err(damaged_head(reason));
    }
    // All lie within the file, whose length is a usize.
    Ok((
        tiling,
        places.map(|(offset, length)| offset as usize..(offset + length) as usize),
    ))
}
