use std::fmt;
use std::path::{Path, PathBuf};

use crate::terrain::FieldError;

/// Where in an elevation file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// Line, from 1.
    Line(u64),
    /// A TIFF tag, by its name.
    Tag(&'static str),
    /// A strip or tile of a TIFF, from 0.
    Chunk(u32),
    /// Column and row of a sample, from the north-west, from 0.
    Sample(u32, u32),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line(line) => write!(f, "line {line}: "),
            Self::Tag(name) => write!(f, "tag {name}: "),
            Self::Chunk(chunk) => write!(f, "strip or tile {chunk}: "),
            Self::Sample(column, row) => write!(f, "column {column}, row {row}: "),
        }
    }
}

/// Why an elevation file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The operating system refused.
    #[error("{}: cannot read", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The name is of no known format.
    #[error(
        "{}: not an elevation format known here; expected .tif, .tiff, .asc, .hgt or .png; cities are imported with -o instead of --into",
        path.display()
    )]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// The name says that it is packed.
    #[error(
        "{}: is packed, and elevation is read unpacked only; unpack it first with {tool} {}",
        path.display(),
        path.display()
    )]
    Packed {
        /// The file.
        path: PathBuf,
        /// What unpacks it.
        tool: &'static str,
    },
    /// The content breaks the rules of its format.
    #[error("{}: {place}{reason}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Where in it.
        place: Place,
        /// What is wrong, and what was expected.
        reason: String,
    },
    /// The format is known, something in the file is not.
    #[error("{}: has {feature}, which is not supported; {way_out}", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// What it has.
        feature: String,
        /// What the user can do.
        way_out: &'static str,
    },
    /// More posts than are read at once.
    #[error(
        "{}: {columns} x {rows} posts are more than are read at once ({most}); cut the raster or make it coarser",
        path.display()
    )]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Posts from west to east.
        columns: u64,
        /// Posts from south to north.
        rows: u64,
        /// The most there may be.
        most: u64,
    },
    /// No memory for it.
    #[error(
        "{}: takes {bytes} bytes of memory, more than there are; cut the raster or make it coarser",
        path.display()
    )]
    Memory {
        /// The file.
        path: PathBuf,
        /// What its posts take.
        bytes: u64,
    },
    /// The raster lies in another system than it is asked for.
    #[error(
        "{}: lies in {found}, not in {wanted}, and there is no way from one to the other here; reproject it, for example with gdalwarp -t_srs '{target}'",
        path.display()
    )]
    CrsMismatch {
        /// The file.
        path: PathBuf,
        /// Its system.
        found: String,
        /// The system it is needed in.
        wanted: String,
        /// What to call the plane of that system elsewhere.
        target: String,
    },
    /// The raster is said to lie on a plane, but has degrees.
    #[error(
        "{}: has coordinates that are degrees or look like it ({:.4} {:.4} to {:.4} {:.4}), but is said to lie in {crs}, which is in metres; leave the system out, as degrees of WGS 84 are brought into the city's system anyway, or name that of the degrees, such as EPSG:4326",
        path.display(), from[0], from[1], to[0], to[1]
    )]
    Degrees {
        /// The file.
        path: PathBuf,
        /// Its south-west post.
        from: [f64; 2],
        /// Its north-east post.
        to: [f64; 2],
        /// The system that the caller named.
        crs: String,
    },
    /// The raster has degrees, and of the system that the caller named nothing is known.
    #[error(
        "{}: has coordinates that are degrees or look like it ({:.4} {:.4} to {:.4} {:.4}), and {crs} is not known to have any; name the system of the degrees, such as EPSG:4326, or leave it out",
        path.display(), from[0], from[1], to[0], to[1]
    )]
    UnknownSystem {
        /// The file.
        path: PathBuf,
        /// Its south-west post.
        from: [f64; 2],
        /// Its north-east post.
        to: [f64; 2],
        /// The system that the caller named.
        crs: String,
    },
    /// The raster is said to have degrees, but lies on a plane.
    #[error(
        "{}: is said to lie in {crs}, whose coordinates are degrees, but reaches from {} {} to {} {}, which are no longitudes and latitudes; leave the system out, or name the one in metres that it lies in, such as EPSG:25832",
        path.display(), from[0], from[1], to[0], to[1]
    )]
    NoDegrees {
        /// The file.
        path: PathBuf,
        /// Its south-west post.
        from: [f64; 2],
        /// Its north-east post.
        to: [f64; 2],
        /// The system that the caller named.
        crs: String,
    },
    /// The raster is far away from where the system that it is asked for is good.
    #[error(
        "{}: lies at longitudes {west:.2} to {east:.2}, too far from where {system}, the city's system, is good; take elevation of the city's surroundings, or cut this to them, for example with gdalwarp -te",
        path.display()
    )]
    Beyond {
        /// The file.
        path: PathBuf,
        /// Its westernmost longitude, degrees.
        west: f64,
        /// Its easternmost.
        east: f64,
        /// The system.
        system: String,
    },
    /// The numbers make no height field.
    #[error("{}: {source}", path.display())]
    Field {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: FieldError,
    },
}

impl ReadError {
    pub(super) fn malformed(path: &Path, place: Place, reason: impl Into<String>) -> Self {
        Self::Malformed {
            path: path.to_owned(),
            place,
            reason: reason.into(),
        }
    }

    pub(super) fn io(path: &Path, source: std::io::Error) -> Self {
        Self::Io {
            path: path.to_owned(),
            source,
        }
    }
}
