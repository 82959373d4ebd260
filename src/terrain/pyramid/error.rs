use std::path::{Path, PathBuf};

use super::file::Section;
use crate::terrain::{BlockError, FieldError};

/// Why a `.terrain` file cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum PyramidError {
    /// The operating system refused.
    #[error("{}: {action}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
    /// Nothing is in it.
    #[error("{}: is empty; import the elevation again", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// Not a `.terrain` file.
    #[error("{}: not a .terrain file; make one with citylod import", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
    },
    /// Written by another version.
    #[error(
        "{}: has format version {found}, this program reads {expected}; import the elevation again",
        path.display()
    )]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: u32,
        /// The version known here.
        expected: u32,
    },
    /// Cut off or altered.
    #[error("{}: section {section}: {reason}; import the elevation again", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Where in it.
        section: String,
        /// What is wrong.
        reason: String,
    },
    /// No such tile.
    #[error("{}: has no tile of level {level} at {x}, {y}", path.display())]
    NoTile {
        /// The file.
        path: PathBuf,
        /// Level asked for.
        level: u32,
        /// Column of tiles.
        x: u32,
        /// Row of tiles.
        y: u32,
    },
    /// A raster of one column or row has no area to cut into tiles.
    #[error("a raster of {columns} x {rows} posts has no area; at least 2 x 2 are needed")]
    NoArea {
        /// Posts from west to east.
        columns: u32,
        /// Posts from south to north.
        rows: u32,
    },
    /// Heights that are none.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// Numbers in a file that no cut writes.
    #[error("{}: block {block}: {source}", path.display())]
    Block {
        /// The file.
        path: PathBuf,
        /// Which block.
        block: usize,
        /// What is wrong with it.
        source: BlockError,
    },
}

impl PyramidError {
    pub(super) fn damaged(path: &Path, section: Section, reason: &str) -> Self {
        Self::Damaged {
            path: path.to_owned(),
            section: section.name(),
            reason: reason.to_owned(),
        }
    }
}
