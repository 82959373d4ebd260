//! Header and section table, read with suspicion.

use std::ops::Range;
use std::path::Path;

use super::error::PyramidError;
use super::file::{HEAD, Header, MAGIC, Section, TABLE_END, TableEntry, Tiling, VERSION};
use crate::geom::DVec2;
use crate::terrain::{Grid, Layout};

/// Where the sections lie.
pub(super) type Sections = [Range<usize>; Section::ALL.len()];

/// Everything of the head but the magic, the version and the checksum itself.
pub(super) fn checksum(head: &[u8]) -> u32 {
    let covered = std::mem::offset_of!(Header, length)..HEAD as usize;
    crc32fast::hash(&head[covered])
}

/// What the head says, as far as it holds together: afterwards every tile, record and sum lies
/// within the file.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<(Tiling, Sections), PyramidError> {
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
    if checksum(bytes) != header.checksum {
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
            return Err(PyramidError::damaged(
                path,
                section,
                "not where the raster's size has it",
            ));
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
