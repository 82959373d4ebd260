//! Opening a pyramid, with or without reading it through.

use std::path::{Path, PathBuf};

use super::error::PyramidError;
use super::file::{ALIGNMENT, Header, Section, TableEntry, Tiling};
use super::head::{Sections, parse};
use crate::file::{MapError, Mapped};

/// An open `.terrain` file.
#[derive(Debug)]
pub struct Pyramid {
    pub(super) path: PathBuf,
    pub(super) map: Mapped,
    pub(super) tiling: Tiling,
    crs: Option<String>,
    pub(super) sections: Sections,
}

/// Where the ground of a city lies: beside it, under the same name with the ending `.terrain`.
///
/// Not in the city's own file, which stays small and can be read without it. A city that has ground
/// names it by its checksum.
pub fn beside(city: &Path) -> PathBuf {
    city.with_extension("terrain")
}

impl Pyramid {
    /// Maps a file without reading it through: constant time, whatever its size. Header, section
    /// table and reference system are checked, tiles and blocks when they are read; see
    /// [`Pyramid::open_verified`].
    ///
    /// The file must not be changed in place while it is mapped. [`write()`](super::write())
    /// replaces files whole, so writing over an open one is safe.
    ///
    /// # Errors
    /// [`PyramidError`] when the file cannot be read, is none of ours, or is cut off.
    pub fn open(path: &Path) -> Result<Self, PyramidError> {
        let map = Mapped::open(path).map_err(|error| {
            let path = path.to_owned();
            match error {
                MapError::Empty => PyramidError::Empty { path },
                MapError::Io { action, source } => PyramidError::Io {
                    path,
                    action,
                    source,
                },
            }
        })?;
        let (tiling, sections) = parse(path, &map)?;
        check(path, &map, &sections, Section::Crs)?;
        let crs = std::str::from_utf8(&map[sections[Section::Crs as usize].clone()]);
        let crs = crs.map_err(|e| PyramidError::damaged(path, Section::Crs, &e.to_string()))?;
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
        for section in [Section::Records, Section::Sums] {
            check(path, &pyramid.map, &pyramid.sections, section)?;
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

    /// Whether the file was written into since it was opened: then tiles may be wrong, and where
    /// it became shorter, reading on may end the process. False where the file cannot tell.
    pub fn is_written_into(&self) -> bool {
        self.map.is_written_into()
    }

    /// Length of the file.
    pub fn byte_len(&self) -> usize {
        self.map.len()
    }
}

/// Checks a section against its checksum in the section table; tiles have one each instead.
fn check(
    path: &Path,
    bytes: &[u8],
    sections: &Sections,
    section: Section,
) -> Result<(), PyramidError> {
    let range = &sections[section as usize];
    let end = range.end.next_multiple_of(ALIGNMENT as usize);
    let at = size_of::<Header>() + section as usize * size_of::<TableEntry>();
    let entry: TableEntry = bytemuck::pod_read_unaligned(&bytes[at..][..size_of::<TableEntry>()]);
    if crc32fast::hash(&bytes[range.start..end]) == entry.checksum {
        return Ok(());
    }
    Err(PyramidError::damaged(
        path,
        section,
        "its checksum does not match",
    ))
}
