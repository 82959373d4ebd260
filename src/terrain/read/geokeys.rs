//! The georeference of a TIFF: where its cells lie, in which system, and what is no data.
//!
//! Source: OGC GeoTIFF 1.1, sections 7.1 to 7.5; the tag of no data is GDAL's.

use std::io::{Read, Seek};
use std::path::Path;

use tiff::decoder::Decoder;
use tiff::tags::Tag;

use super::error::{Place, ReadError};
use super::raster::{Units, assumed, grid};
use crate::terrain::Grid;

const MODEL_TYPE: u16 = 1024;
const RASTER_TYPE: u16 = 1025;
const GEOGRAPHIC_CRS: u16 = 2048;
const PROJECTED_CRS: u16 = 3072;
const PROJECTED_UNITS: u16 = 3076;
const VERTICAL_UNITS: u16 = 4099;

const MODEL_PROJECTED: u16 = 1;
const MODEL_GEOGRAPHIC: u16 = 2;
const PIXEL_IS_POINT: u16 = 2;
const METRE: u16 = 9001;
/// The code's place is taken, but by none of EPSG's.
const USER_DEFINED: u16 = 32767;

/// What the tags say.
pub(super) struct Georeference {
    pub grid: Grid,
    /// Whether the first row is the southernmost, which only a matrix can say.
    pub from_south: bool,
    pub crs: Option<String>,
    pub units: Units,
    pub nodata: Option<f64>,
}

/// Values of the short keys, which is all that is needed of them.
struct Keys(Vec<[u16; 4]>);

impl Keys {
    fn get(&self, key: u16) -> Option<u16> {
        let of_key = |entry: &&[u16; 4]| entry[0] == key && entry[1] == 0;
        self.0.iter().find(of_key).map(|entry| entry[3])
    }
}

pub(super) fn read<R: Read + Seek>(
    path: &Path,
    decoder: &mut Decoder<R>,
    columns: u32,
    rows: u32,
    wanted_crs: Option<&str>,
) -> Result<Georeference, ReadError> {
    let keys = keys(path, decoder)?;
    let unsupported = |feature: String, way_out| ReadError::Unsupported {
        path: path.to_owned(),
        feature,
        way_out,
    };
    let (crs, model) = match keys.get(MODEL_TYPE) {
        Some(MODEL_PROJECTED) => (keys.get(PROJECTED_CRS), Some(Units::Metres)),
        Some(MODEL_GEOGRAPHIC) => (keys.get(GEOGRAPHIC_CRS), Some(Units::Degrees)),
        None => (None, None),
        Some(model) => {
            let way_out = "project it onto a plane, for example with gdalwarp -t_srs";
            return Err(unsupported(format!("model type {model}"), way_out));
        }
    };
    for (key, what) in [(PROJECTED_UNITS, "positions"), (VERTICAL_UNITS, "heights")] {
        let unit = keys.get(key).filter(|&unit| unit != METRE);
        if let Some(unit) = unit {
            let way_out = "convert it to metres, for example with gdalwarp";
            return Err(unsupported(format!("{what} in unit EPSG:{unit}"), way_out));
        }
    }
    let named = crs.filter(|&code| code != USER_DEFINED && code != 0);
    let crs = wanted_crs
        .map(str::to_owned)
        .or_else(|| named.map(|code| format!("EPSG:{code}")));
    let (corner, [dx, dy]) = cells(path, decoder)?;
    // A tie point ties a corner of a cell, or its centre where the raster says so.
    let half = if keys.get(RASTER_TYPE) == Some(PIXEL_IS_POINT) {
        0.0
    } else {
        0.5
    };
    let (first_x, first_y) = (corner[0] + half * dx, corner[1] - half * dy);
    let from_south = dy < 0.0;
    let last_y = first_y - dy * f64::from(rows - 1);
    let south_west = [first_x, if from_south { first_y } else { last_y }];
    let grid = grid(path, [columns, rows], south_west, [dx, dy.abs()])?;
    let (assumed, _) = assumed(crs.as_deref(), &grid);
    // What the caller says names the system; what numbers are, the file knows better.
    let units = model.unwrap_or(assumed);
    Ok(Georeference {
        grid,
        from_south,
        crs,
        units,
        nodata: nodata(path, decoder)?,
    })
}

/// The north-west corner of the first cell, and the size of cells; the height of a cell is
/// negative where rows run to the north.
fn cells<R: Read + Seek>(
    path: &Path,
    decoder: &mut Decoder<R>,
) -> Result<([f64; 2], [f64; 2]), ReadError> {
    let scale = numbers(path, decoder, Tag::ModelPixelScaleTag, "ModelPixelScale")?;
    let tie = numbers(path, decoder, Tag::ModelTiepointTag, "ModelTiepoint")?;
    let matrix = numbers(
        path,
        decoder,
        Tag::ModelTransformationTag,
        "ModelTransformation",
    )?;
    match (scale.as_deref(), tie.as_deref(), matrix.as_deref()) {
        (Some(&[dx, dy, ..]), Some(&[column, row, _, x, y, _]), _) => {
            Ok(([x - column * dx, y + row * dy], [dx, dy]))
        }
        (_, _, Some(&[dx, 0.0, _, x, 0.0, dy, _, y, ..])) => Ok(([x, y], [dx, -dy])),
        (_, _, Some(_)) => Err(ReadError::Unsupported {
            path: path.to_owned(),
            feature: "a rotated or sheared raster".into(),
            way_out: "turn it north up, for example with gdalwarp",
        }),
        (_, Some(_), _) => Err(ReadError::Unsupported {
            path: path.to_owned(),
            feature: "tie points without a pixel scale".into(),
            way_out: "turn it north up, for example with gdalwarp",
        }),
        _ => {
            let reason = "the file does not say where it lies; add a georeference, for example with gdal_translate -a_ullr";
            Err(ReadError::malformed(
                path,
                Place::Tag("ModelTiepoint"),
                reason,
            ))
        }
    }
}

fn numbers<R: Read + Seek>(
    path: &Path,
    decoder: &mut Decoder<R>,
    tag: Tag,
    name: &'static str,
) -> Result<Option<Vec<f64>>, ReadError> {
    let value = decoder.find_tag(tag);
    let value = value.and_then(|v| v.map(tiff::decoder::ifd::Value::into_f64_vec).transpose());
    value.map_err(|e| ReadError::malformed(path, Place::Tag(name), e.to_string()))
}

fn keys<R: Read + Seek>(path: &Path, decoder: &mut Decoder<R>) -> Result<Keys, ReadError> {
    let malformed =
        |reason: String| ReadError::malformed(path, Place::Tag("GeoKeyDirectory"), reason);
    let words = decoder
        .find_tag_unsigned_vec::<u16>(Tag::GeoKeyDirectoryTag)
        .map_err(|e| malformed(e.to_string()))?
        .unwrap_or_default();
    let Some((head, entries)) = words.split_first_chunk::<4>() else {
        return Ok(Keys(vec![]));
    };
    let count = usize::from(head[3]);
    if head[0] != 1 || entries.len() < count * 4 {
        let reason = format!(
            "{} numbers are no version 1 directory of {count} keys",
            words.len()
        );
        return Err(malformed(reason));
    }
    let (entries, _) = entries.as_chunks::<4>();
    Ok(Keys(entries[..count].to_vec()))
}

/// GDAL writes the number as text.
fn nodata<R: Read + Seek>(path: &Path, decoder: &mut Decoder<R>) -> Result<Option<f64>, ReadError> {
    let malformed = |reason: String| ReadError::malformed(path, Place::Tag("GDAL_NODATA"), reason);
    let value = decoder.find_tag(Tag::GdalNodata);
    let Some(value) = value.map_err(|e| malformed(e.to_string()))? else {
        return Ok(None);
    };
    let text = value.into_string().map_err(|e| malformed(e.to_string()))?;
    let text = text.trim_matches(['\0', ' ']);
    match text.parse() {
        Ok(number) => Ok(Some(number)),
        Err(_) if text.is_empty() => Ok(None),
        Err(_) => Err(malformed(format!("{text:?} is no number"))),
    }
}
