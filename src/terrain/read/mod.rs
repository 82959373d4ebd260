//! Elevation files → [`Raster`]: GeoTIFF, ESRI ASCII grid, SRTM HGT, PNG with coded heights.
//!
//! Each format is one module of the same shape: `read(path, options)`. A cell of a raster becomes
//! one post at the cell's centre; what the file calls no data becomes NaN. Memory is bounded by
//! what the file is long enough to hold: sizes are believed only after that check.
//!
//! [`Raster::to_metres`] turns longitudes and latitudes into metres, and one plane into another.

mod ascii;
mod error;
mod geokeys;
mod geotiff;
mod hgt;
mod metres;
mod png;
mod raster;
mod system;

use std::path::Path;

use metres::reach;
use system::{System, has_degrees};

pub use error::{Place, ReadError};
pub use png::Encoding;
pub use raster::{Raster, Units};

/// What names of elevation files end in.
const EXTENSIONS: [&str; 5] = ["tif", "tiff", "asc", "hgt", "png"];

/// What the caller may say of a file that does not say it itself.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Coordinate reference system, e.g. `EPSG:25832`; goes before what the file says.
    pub crs: Option<String>,
    /// How a PNG codes heights; default: told by its reds, see [`Encoding`].
    pub encoding: Option<Encoding>,
    /// Outer edges of a PNG: west, south, east, north; default: from its world file.
    pub bounds: Option<[f64; 4]>,
}

/// Reads one elevation file; its format is what its name ends in.
///
/// # Errors
/// [`ReadError`], naming the file and the place in it.
pub fn read(path: &Path, options: &Options) -> Result<Raster, ReadError> {
    let extension = extension(path);
    let raster = match extension.as_deref() {
        Some("tif" | "tiff") => geotiff::read(path, options),
        Some("asc") => ascii::read(path, options),
        Some("hgt") => hgt::read(path, options),
        Some("png") => png::read(path, options),
        Some("gz") if !is_other(&path.with_extension("")) => Err(packed(path, "gunzip")),
        Some("zip") => Err(packed(path, "unzip")),
        _ => Err(ReadError::UnknownFormat {
            path: path.to_owned(),
        }),
    }?;
    let Some(crs) = &options.crs else {
        return Ok(raster);
    };
    let [from, to] = reach(&raster.field);
    let (path, crs) = (path.to_owned(), crs.clone());
    match raster.units {
        Units::Degrees if System::named(&crs).is_some() => Err(ReadError::Degrees {
            path,
            from,
            to,
            crs,
        }),
        Units::Degrees if !has_degrees(&crs) => Err(ReadError::UnknownSystem {
            path,
            from,
            to,
            crs,
        }),
        Units::Metres if has_degrees(&crs) => Err(ReadError::NoDegrees {
            path,
            from,
            to,
            crs,
        }),
        _ => Ok(raster),
    }
}

/// What a name ends in, in small letters.
fn extension(path: &Path) -> Option<String> {
    path.extension().map(|e| e.to_string_lossy().to_lowercase())
}

/// Whether a name says that the file holds something else.
fn is_other(path: &Path) -> bool {
    extension(path).is_some_and(|e| !EXTENSIONS.contains(&e.as_str()))
}

fn packed(path: &Path, tool: &'static str) -> ReadError {
    ReadError::Packed {
        path: path.to_owned(),
        tool,
    }
}
