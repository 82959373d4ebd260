//! GeoTIFF: one band of heights in strips or tiles; whole numbers of 8 to 32 bits or floats.
//!
//! Uncompressed, deflate, LZW and PackBits, with predictors; classic and BigTIFF, either byte
//! order. Strips and tiles that a sparse file leaves out are no data.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use tiff::decoder::{ChunkType, Decoder, DecodingResult, Limits};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError};

use super::Options;
use super::error::{Place, ReadError};
use super::geokeys::{self, Georeference};
use super::raster::{Raster, count, field, reserved, turn_rows};

/// No compression known here packs more: LZW reaches 2,700 times, deflate 1,032 times.
const MOST_PACKED: u64 = 4096;

pub(super) fn read(path: &Path, options: &Options) -> Result<Raster, ReadError> {
    let file = File::open(path).map_err(|e| ReadError::io(path, e))?;
    let length = file.metadata().map_err(|e| ReadError::io(path, e))?.len();
    let whole = |e| refused(path, Place::File, e);
    let mut decoder = Decoder::new(BufReader::new(file)).map_err(whole)?;
    let (columns, rows) = decoder.dimensions().map_err(whole)?;
    let posts = count(path, columns.into(), rows.into())?;
    let bits = match decoder.colortype().map_err(whole)? {
        ColorType::Gray(bits @ (8 | 16 | 32 | 64)) => u64::from(bits),
        other => {
            return Err(ReadError::Unsupported {
                path: path.to_owned(),
                feature: format!("{other:?} samples"),
                way_out: "take one band of whole bytes, for example with gdal_translate -b 1",
            });
        }
    };
    let chunks = Chunks::of(path, &mut decoder, columns, rows)?;
    // Chunks reach beyond the raster; a file that leaves some out holds fewer samples than it has.
    let (wide, high) = decoder.chunk_dimensions();
    let in_chunks = u64::from(chunks.present()) * u64::from(wide) * u64::from(high.min(rows));
    let held = in_chunks.max(posts as u64);
    if held.saturating_mul(bits / 8) > length.saturating_mul(MOST_PACKED) {
        let reason =
            format!("{columns} x {rows} samples of {bits} bits do not fit into {length} bytes");
        return Err(ReadError::malformed(path, Place::File, reason));
    }
    let mut decoder = decoder.with_limits(limits(posts, bits, length));
    let wanted = options.crs.as_deref();
    let place = geokeys::read(path, &mut decoder, columns, rows, wanted)?;
    let mut heights = reserved(path, posts)?;
    heights.resize(posts, f32::NAN);
    for chunk in (0..chunks.count).filter(|&chunk| chunks.bytes[chunk as usize] > 0) {
        let at_chunk = |e| refused(path, Place::Chunk(chunk), e);
        let (width, height) = decoder.chunk_data_dimensions(chunk);
        let (width, height) = (width as usize, height as usize);
        let samples = decoder.read_chunk(chunk).map_err(at_chunk)?;
        let (across, down) = (chunk % chunks.across, chunk / chunks.across);
        let (left, top) = (
            across as usize * wide as usize,
            down as usize * high as usize,
        );
        let columns = columns as usize;
        if left + width > columns || top + height > rows as usize {
            let reason = "reaches beyond the raster";
            return Err(ReadError::malformed(path, Place::Chunk(chunk), reason));
        }
        let given = each(samples, |at, sample| {
            let (row, column) = (at / width.max(1), at % width.max(1));
            if row < height {
                heights[(top + row) * columns + left + column] = height_of(sample, &place);
            }
        });
        if given < width * height {
            let reason = "holds fewer samples than it should";
            return Err(ReadError::malformed(path, Place::Chunk(chunk), reason));
        }
    }
    if place.from_south {
        // The field turns rows from the north around, so these are turned twice.
        turn_rows(&mut heights, columns as usize);
    }
    Ok(Raster {
        field: field(path, place.grid, heights)?,
        crs: place.crs,
        units: place.units,
    })
}

fn height_of(sample: f64, place: &Georeference) -> f32 {
    // No data of a float raster is written in decimals: it is the same number as f32.
    let is_nodata = |nodata: f64| sample == nodata || sample as f32 == nodata as f32;
    if place.nodata.is_some_and(is_nodata) || !sample.is_finite() {
        f32::NAN
    } else {
        sample as f32
    }
}

/// The strips or tiles of a file.
struct Chunks {
    count: u32,
    /// How many stand side by side.
    across: u32,
    /// Length of each in the file; 0 where it is left out.
    bytes: Vec<u64>,
}

impl Chunks {
    fn of(
        path: &Path,
        decoder: &mut Decoder<BufReader<File>>,
        columns: u32,
        rows: u32,
    ) -> Result<Self, ReadError> {
        let (tag, name) = match decoder.get_chunk_type() {
            ChunkType::Strip => (Tag::StripByteCounts, "StripByteCounts"),
            ChunkType::Tile => (Tag::TileByteCounts, "TileByteCounts"),
        };
        let malformed = |reason: String| ReadError::malformed(path, Place::Tag(name), reason);
        let (wide, high) = decoder.chunk_dimensions();
        if wide == 0 || high == 0 {
            return Err(malformed(format!(
                "{wide} x {high} samples are no strip or tile"
            )));
        }
        let (across, down) = (columns.div_ceil(wide), rows.div_ceil(high));
        let bytes = decoder.find_tag_unsigned_vec::<u64>(tag);
        let bytes = bytes
            .map_err(|e| malformed(e.to_string()))?
            .unwrap_or_default();
        let count = u64::from(across) * u64::from(down);
        if bytes.len() as u64 != count {
            let reason = format!(
                "lists {} strips or tiles where there are {count}",
                bytes.len()
            );
            return Err(malformed(reason));
        }
        Ok(Self {
            count: count as u32,
            across,
            bytes,
        })
    }

    fn present(&self) -> u32 {
        self.bytes.iter().filter(|&&bytes| bytes > 0).count() as u32
    }
}

/// What one strip or tile may take: no more than the whole raster or the whole file.
fn limits(posts: usize, bits: u64, length: u64) -> Limits {
    const LEAST: usize = 1 << 20;
    let mut limits = Limits::default();
    let length = usize::try_from(length).unwrap_or(usize::MAX);
    limits.decoding_buffer_size = (posts * bits as usize / 8).max(LEAST);
    limits.intermediate_buffer_size = length.max(LEAST);
    limits.ifd_value_size = length.max(LEAST);
    limits
}

/// Hands over samples one by one with their places, and returns how many there were.
fn each(chunk: DecodingResult, mut take: impl FnMut(usize, f64)) -> usize {
    fn hand<T>(
        samples: Vec<T>,
        wide: impl Fn(T) -> f64,
        take: &mut impl FnMut(usize, f64),
    ) -> usize {
        let count = samples.len();
        let samples = samples.into_iter().enumerate();
        samples.for_each(|(at, sample)| take(at, wide(sample)));
        count
    }
    let take = &mut take;
    match chunk {
        DecodingResult::U8(v) => hand(v, f64::from, take),
        DecodingResult::U16(v) => hand(v, f64::from, take),
        DecodingResult::U32(v) => hand(v, f64::from, take),
        DecodingResult::U64(v) => hand(v, |s| s as f64, take),
        DecodingResult::I8(v) => hand(v, f64::from, take),
        DecodingResult::I16(v) => hand(v, f64::from, take),
        DecodingResult::I32(v) => hand(v, f64::from, take),
        DecodingResult::I64(v) => hand(v, |s| s as f64, take),
        DecodingResult::F16(v) => hand(v, f64::from, take),
        DecodingResult::F32(v) => hand(v, f64::from, take),
        DecodingResult::F64(v) => hand(v, |s| s, take),
    }
}

fn refused(path: &Path, place: Place, error: TiffError) -> ReadError {
    match error {
        TiffError::UnsupportedError(what) => ReadError::Unsupported {
            path: path.to_owned(),
            feature: what.to_string(),
            way_out: "write it anew, for example with gdal_translate -co COMPRESS=DEFLATE",
        },
        TiffError::LimitsExceeded | TiffError::IntSizeError => ReadError::malformed(
            path,
            place,
            "asks for more memory than its raster or the file takes",
        ),
        TiffError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
            ReadError::malformed(path, place, "cut off")
        }
        other => {
            let other = other.to_string();
            let other = other.trim_start_matches("format error: ");
            let reason = match place {
                Place::File => format!("no readable TIFF: {other}; fetch or write it anew"),
                _ => other.to_owned(),
            };
            ReadError::malformed(path, place, reason)
        }
    }
}
