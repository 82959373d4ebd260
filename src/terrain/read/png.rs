//! PNG with heights coded in red, green and blue, as map tiles carry them.
//!
//! Pixels without opacity are no data. Where the picture lies is not in it: it comes from
//! [`Options::bounds`] or from a world file beside it (`NAME.pgw` or `NAME.wld`: six lines, of
//! which the 2nd and 3rd, rotation, must be 0). Units and system are as for ASCII grids.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use ::png::{BitDepth, ColorType, Decoder, Transformations};

use super::Options;
use super::error::{Place, ReadError};
use super::raster::{Raster, assumed, count, field, grid, reserved};
use crate::terrain::Grid;

/// How heights are coded. Heights of the Earth tell the two apart by red: up to 2 in the one,
/// 80 to 163 in the other (−11,000 m to 9,000 m).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// −10,000 m + (65,536 r + 256 g + b) · 0.1 m.
    TerrainRgb,
    /// 256 r + g + b/256 − 32,768 m.
    Terrarium,
}

impl Encoding {
    /// What it is called.
    fn name(self) -> &'static str {
        match self {
            Self::TerrainRgb => "terrain-rgb",
            Self::Terrarium => "terrarium",
        }
    }

    fn height(self, [r, g, b]: [u8; 3]) -> f32 {
        let (r, g, b) = (f64::from(r), f64::from(g), f64::from(b));
        (match self {
            Self::TerrainRgb => (r * 65536.0 + g * 256.0 + b) * 0.1 - 10_000.0,
            Self::Terrarium => r * 256.0 + g + b / 256.0 - 32_768.0,
        }) as f32
    }

    /// The one that makes every height one of the Earth.
    fn told_by(reds: impl Iterator<Item = u8>) -> Option<Self> {
        let (low, high) = reds.fold((u8::MAX, 0), |(low, high), red| {
            (low.min(red), high.max(red))
        });
        if high <= 2 {
            Some(Self::TerrainRgb)
        } else if low >= 80 && high <= 163 {
            Some(Self::Terrarium)
        } else {
            None
        }
    }
}

pub(super) fn read(path: &Path, options: &Options) -> Result<Raster, ReadError> {
    let malformed = |reason: String| ReadError::malformed(path, Place::File, reason);
    let file = File::open(path).map_err(|e| ReadError::io(path, e))?;
    let length = file.metadata().map_err(|e| ReadError::io(path, e))?.len();
    let mut decoder = Decoder::new(BufReader::new(file));
    decoder.set_transformations(Transformations::IDENTITY);
    let mut reader = decoder.read_info().map_err(|e| malformed(e.to_string()))?;
    let info = reader.info();
    let (columns, rows) = (info.width, info.height);
    let channels = match (info.color_type, info.bit_depth) {
        (ColorType::Rgb, BitDepth::Eight) => 3,
        (ColorType::Rgba, BitDepth::Eight) => 4,
        (color, depth) => {
            return Err(ReadError::Unsupported {
                path: path.to_owned(),
                feature: format!("{color:?} samples of {} bits", depth as u8),
                way_out: "heights are coded in 8-bit RGB or RGBA; convert a grey picture to GeoTIFF",
            });
        }
    };
    let posts = count(path, columns.into(), rows.into())?;
    // Deflate packs at most 1032 times.
    if (posts * channels) as u64 > length.saturating_mul(1032) {
        let reason = format!("{columns} x {rows} pixels do not fit into {length} bytes");
        return Err(malformed(reason));
    }
    let bytes = reader.output_buffer_size().unwrap_or(posts * channels);
    let mut pixels = reserved(path, bytes)?;
    pixels.resize(bytes, 0);
    reader
        .next_frame(&mut pixels)
        .map_err(|e| malformed(e.to_string()))?;
    let pixels = &pixels[..pixels.len().min(posts * channels)];
    let opaque = |pixel: &&[u8]| pixel.get(3) != Some(&0);
    let reds = pixels
        .chunks_exact(channels)
        .filter(opaque)
        .map(|pixel| pixel[0]);
    let told = Encoding::told_by(reds);
    if let (Some(said), Some(told)) = (options.encoding, told)
        && said != told
    {
        let (said, told) = (said.name(), told.name());
        return Err(malformed(format!(
            "its reds are those of {told}; as {said} its heights would be none of the Earth; leave --encoding out, or give --encoding {told}"
        )));
    }
    let encoding = options.encoding.or(told).ok_or_else(|| {
        malformed("its reds are those of neither coding of the Earth's heights; give --encoding terrain-rgb or terrarium".into())
    })?;
    let mut heights = reserved(path, posts)?;
    heights.extend(pixels.chunks_exact(channels).map(|pixel| {
        if opaque(&pixel) {
            encoding.height([pixel[0], pixel[1], pixel[2]])
        } else {
            f32::NAN
        }
    }));
    let grid = place(path, options, columns, rows)?;
    let (units, crs) = assumed(options.crs.as_deref(), &grid);
    Ok(Raster {
        field: field(path, grid, heights)?,
        crs,
        units,
    })
}

/// Where the posts lie, which are the centres of the pixels.
fn place(path: &Path, options: &Options, columns: u32, rows: u32) -> Result<Grid, ReadError> {
    let malformed = |reason: &str| ReadError::malformed(path, Place::File, reason);
    let [west, north, dx, dy] = if let Some([west, south, east, north]) = options.bounds {
        let (dx, dy) = (
            (east - west) / f64::from(columns),
            (north - south) / f64::from(rows),
        );
        [west + dx / 2.0, north - dy / 2.0, dx, dy]
    } else {
        let beside = ["pgw", "wld"].map(|e| path.with_extension(e));
        let Some(world) = beside.iter().find_map(|p| std::fs::read_to_string(p).ok()) else {
            return Err(malformed(
                "does not say where it lies; give --bounds west,south,east,north, or put a world file (.pgw) beside it",
            ));
        };
        let numbers: Option<Vec<f64>> = world.split_whitespace().map(|w| w.parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[dx, 0.0, 0.0, dy, west, north]) => [west, north, dx, -dy],
            _ => {
                return Err(malformed(
                    "its world file is not six numbers, the 2nd and 3rd of them 0",
                ));
            }
        }
    };
    let usable = |v: f64| v.is_finite() && v > 0.0;
    if !(west.is_finite() && north.is_finite() && usable(dx) && usable(dy)) {
        return Err(malformed("its bounds leave no room for pixels"));
    }
    let south_west = [west, north - dy * f64::from(rows - 1)];
    grid(path, [columns, rows], south_west, [dx, dy])
}
