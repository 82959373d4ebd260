//! A raster becomes a file, one block in memory at a time.

use std::fs::File;
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;

use super::error::PyramidError;
use super::file::{
    ALIGNMENT, HEAD, Header, MAGIC, Section, TABLE_END, TableEntry, Tiling, VERSION,
};
use super::head;
use crate::file::Replacement;
use crate::geom::DVec2;
use crate::terrain::{Block, Grid, HeightField, Layout, Node};

/// Writes the pyramid of a raster to a file, whole or not at all: under a temporary name beside
/// it, synced, renamed.
///
/// `height` gives the height of a post by column and row, m, NaN where unknown; it is asked block
/// by block. Memory is that of one block, however large the raster. `progress` is called with the
/// blocks done and their number.
///
/// # Errors
/// [`PyramidError::Io`], [`PyramidError::NoArea`], and [`PyramidError::Field`] where `height` is
/// infinite; what was at `path` before is then still there.
pub fn write(
    path: &Path,
    tiling: &Tiling,
    crs: Option<&str>,
    height: impl FnMut(u32, u32) -> f32,
    progress: &dyn Fn(usize, usize),
) -> Result<(), PyramidError> {
    let written = prepared(path, tiling, crs, height, progress)?;
    written.finish().map_err(|source| PyramidError::Io {
        path: path.to_owned(),
        action: "cannot write",
        source,
    })
}

/// The file that [`write()`] writes, but for its name.
pub(crate) fn prepared(
    path: &Path,
    tiling: &Tiling,
    crs: Option<&str>,
    mut height: impl FnMut(u32, u32) -> f32,
    progress: &dyn Fn(usize, usize),
) -> Result<Replacement, PyramidError> {
    let io = |source| PyramidError::Io {
        path: path.to_owned(),
        action: "cannot write",
        source,
    };
    let layout = tiling.layout();
    if layout.block_count() == 0 {
        return Err(PyramidError::NoArea {
            columns: layout.grid().columns(),
            rows: layout.grid().rows(),
        });
    }
    let crs = crs.unwrap_or_default();
    let too_long = || io(io::ErrorKind::FileTooLarge.into());
    let (sections, length) = tiling.sections(crs.len() as u64).ok_or_else(too_long)?;
    let mut replacement = Replacement::of(path).map_err(io)?;
    let file = replacement.file();
    file.set_len(length).map_err(io)?;
    put(file, sections[Section::Crs as usize].0, crs.as_bytes()).map_err(io)?;
    let blocks = layout.block_count();
    for number in 0..blocks {
        let block = cut(layout, layout.block(number), &mut height)?;
        let records = bytemuck::cast_slice(block.records());
        let at = sections[Section::Records as usize].0 + (number * records.len()) as u64;
        put(file, at, records).map_err(io)?;
        let sum = tiling.records_sum(number) as u64;
        let at = sections[Section::Sums as usize].0 + sum * 4;
        put(file, at, &crc32fast::hash(records).to_le_bytes()).map_err(io)?;
        for level in 0..=tiling.finest() {
            write_tiles(file, tiling, &block, layout.block(number), level, &sections)
                .map_err(io)?;
        }
        progress(number + 1, blocks);
    }
    finish(file, tiling, &sections, length).map_err(io)?;
    Ok(replacement)
}

/// Measures one block. Blocks reach beyond the raster; only the posts within it are asked for.
fn cut(
    layout: &Layout,
    root: Node,
    height: &mut impl FnMut(u32, u32) -> f32,
) -> Result<Block, PyramidError> {
    let posts = layout.posts(root);
    let ([west, south], [east, north]) = (posts.first, posts.last);
    let grid = layout.grid();
    let origin = DVec2::new(grid.x(west), grid.y(south));
    let window = Grid::new(east - west + 1, north - south + 1, origin, grid.spacing())?;
    let heights = (south..=north).flat_map(|row| (west..=east).map(move |column| (column, row)));
    let heights = heights.map(|(column, row)| height(column, row)).collect();
    let field = HeightField::new(window, heights)?;
    let alone = Layout::with_levels(window, layout.levels());
    Ok(Block::cut(&field, &alone, alone.block(0)))
}

/// Writes the tiles of one level of a block, and their checksums. In a file they are neighbours.
fn write_tiles(
    file: &mut File,
    tiling: &Tiling,
    block: &Block,
    root: Node,
    level: u32,
    sections: &[(u64, u64); Section::ALL.len()],
) -> io::Result<()> {
    let (n, side) = (tiling.tile_levels(), 1_usize << level);
    let stride = tiling.stride(level) as usize;
    let row_posts = tiling.layout().side() as usize;
    let first = Node {
        level,
        x: root.x << level,
        y: root.y << level,
    };
    let index = tiling.tile_index(first).unwrap_or_default();
    let at = sections[Section::Tiles as usize].0 + index * tiling.tile_stride();
    file.seek(SeekFrom::Start(at))?;
    let mut out = BufWriter::with_capacity(1 << 16, &mut *file);
    let mut sums = Vec::with_capacity(side * side);
    let mut bytes = Vec::with_capacity(tiling.tile_stride() as usize);
    for number in 0..side * side {
        let (x, y) = ((number % side) << n, (number / side) << n);
        bytes.clear();
        for row in (y..).take(tiling.tile_side()) {
            let posts = &block.heights()[row * stride * row_posts..][..row_posts];
            let columns = (x..).take(tiling.tile_side());
            bytes.extend(columns.flat_map(|column| posts[column * stride].to_le_bytes()));
        }
        bytes.resize(tiling.tile_stride() as usize, 0);
        sums.push(crc32fast::hash(&bytes));
        out.write_all(&bytes)?;
    }
    out.flush()?;
    drop(out);
    let at = sections[Section::Sums as usize].0 + index * 4;
    put(file, at, bytemuck::cast_slice(&sums))
}

/// Adds section table, header and their checksums.
fn finish(
    file: &mut File,
    tiling: &Tiling,
    sections: &[(u64, u64); Section::ALL.len()],
    length: u64,
) -> io::Result<()> {
    let mut head = vec![0; HEAD as usize];
    let table = &mut head[size_of::<Header>()..TABLE_END];
    let entries = table.chunks_exact_mut(size_of::<TableEntry>());
    for ((section, &(offset, bytes)), entry) in Section::ALL.into_iter().zip(sections).zip(entries)
    {
        let end = (offset + bytes).next_multiple_of(ALIGNMENT);
        let checksum = match section {
            Section::Tiles => 0,
            _ => hash(file, offset, end - offset)?,
        };
        entry.copy_from_slice(bytemuck::bytes_of(&TableEntry {
            tag: section.tag(),
            offset,
            length: bytes,
            checksum,
            zero: 0,
        }));
    }
    let grid = tiling.layout().grid();
    let mut header = Header {
        magic: MAGIC,
        version: VERSION,
        checksum: 0,
        length,
        posts: [grid.columns(), grid.rows()],
        origin: grid.origin().to_array(),
        spacing: grid.spacing().to_array(),
        block_levels: tiling.layout().levels(),
        tile_levels: tiling.tile_levels(),
        sections: Section::ALL.len() as u32,
        zero: [0; 5],
    };
    head[..size_of::<Header>()].copy_from_slice(bytemuck::bytes_of(&header));
    header.checksum = head::checksum(&head);
    head[..size_of::<Header>()].copy_from_slice(bytemuck::bytes_of(&header));
    put(file, 0, &head)
}

fn put(file: &mut File, at: u64, bytes: &[u8]) -> io::Result<()> {
    file.seek(SeekFrom::Start(at))?;
    file.write_all(bytes)
}

/// CRC-32 of what was written, read back piece by piece.
fn hash(file: &mut File, from: u64, length: u64) -> io::Result<u32> {
    file.seek(SeekFrom::Start(from))?;
    let mut hasher = crc32fast::Hasher::new();
    let mut piece = [0; 1 << 14];
    let mut left = length;
    while left > 0 {
        let wanted = left.min(piece.len() as u64) as usize;
        file.read_exact(&mut piece[..wanted])?;
        hasher.update(&piece[..wanted]);
        left -= wanted as u64;
    }
    Ok(hasher.finalize())
}
