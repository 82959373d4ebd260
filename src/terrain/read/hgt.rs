//! SRTM HGT: big-endian 16-bit heights from the north-west, nothing else. The name tells the
//! south-west corner (`N40W106.hgt`), the length of the file how many posts a degree has.
//!
//! The outermost posts lie on whole degrees. Sides of 1201 and 3601 posts are usual, any from 2 on
//! is read.

use std::path::Path;

use super::Options;
use super::error::{Place, ReadError};
use super::raster::{Raster, Units, count, field, grid};

const VOID: i16 = i16::MIN;

pub(super) fn read(path: &Path, options: &Options) -> Result<Raster, ReadError> {
    let malformed = |reason: String| ReadError::malformed(path, Place::File, reason);
    let corner = corner(path).ok_or_else(|| {
        malformed("the name does not tell the corner; expected one like N40W106.hgt".into())
    })?;
    let length = path.metadata().map_err(|e| ReadError::io(path, e))?.len();
    let posts = length / 2;
    let side = posts.isqrt();
    if !length.is_multiple_of(2) || side * side != posts || side < 2 {
        let reason = format!(
            "{length} bytes are no square of 16-bit heights; 1201 x 1201 take 2884802, 3601 x 3601 take 25934402"
        );
        return Err(malformed(reason));
    }
    count(path, side, side)?;
    let bytes = std::fs::read(path).map_err(|e| ReadError::io(path, e))?;
    let heights: Vec<f32> = bytes
        .chunks_exact(2)
        .map(|pair| match i16::from_be_bytes([pair[0], pair[1]]) {
            VOID => f32::NAN,
            height => f32::from(height),
        })
        .collect();
    if heights.len() as u64 != posts {
        return Err(malformed("changed while it was read; try again".into()));
    }
    let spacing = [1.0 / (side - 1) as f64; 2];
    let grid = grid(path, [side as u32; 2], corner, spacing)?;
    Ok(Raster {
        field: field(path, grid, heights)?,
        crs: Some(options.crs.clone().unwrap_or_else(|| "EPSG:4326".into())),
        units: Units::Degrees,
    })
}

/// Longitude and latitude of the south-west corner that a name such as `S12E034` tells.
fn corner(path: &Path) -> Option<[f64; 2]> {
    let name = path.file_stem()?.to_str()?.to_ascii_uppercase();
    let degrees = |range: std::ops::Range<usize>, signs: [char; 2], most: u16| {
        let text = name.get(range)?;
        let size: u16 = text.get(1..)?.parse().ok().filter(|d| *d <= most)?;
        let negative = match text.chars().next()? {
            c if c == signs[0] => false,
            c if c == signs[1] => true,
            _ => return None,
        };
        Some(if negative {
            -f64::from(size)
        } else {
            f64::from(size)
        })
    };
    let latitude = degrees(0..3, ['N', 'S'], 90)?;
    let longitude = degrees(3..7, ['E', 'W'], 180)?;
    (name.len() == 7).then_some([longitude, latitude])
}
