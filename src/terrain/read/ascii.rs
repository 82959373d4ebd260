//! ESRI ASCII grid: a header of names and numbers, then heights from the north-west.
//!
//! Says nothing of its coordinate system: without [`Options::crs`] it is taken for degrees where
//! it lies on the globe with posts less than 0.1 apart, else for metres.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use super::Options;
use super::error::{Place, ReadError};
use super::raster::{Raster, assumed, count, field, grid, reserved};
use crate::terrain::Grid;

/// What the format says where the header does not.
const USUAL_NODATA: f64 = -9999.0;
/// No number is longer, and nobody reads more of what is none.
const LONGEST_WORD: usize = 64;
/// A height takes a digit and a separator.
const FEWEST_BYTES_A_POST: u64 = 2;

/// The words of a file one by one, in bounded memory however long its lines are.
struct Words<'a, R> {
    path: &'a Path,
    reader: R,
    line: u64,
    word: String,
}

impl<R: BufRead> Words<'_, R> {
    /// The next word, empty at the end of the file; and its line.
    fn next(&mut self) -> Result<(&str, u64), ReadError> {
        self.word.clear();
        let mut line = self.line;
        loop {
            let bytes = self.reader.fill_buf();
            let bytes = bytes.map_err(|e| ReadError::io(self.path, e))?;
            if bytes.is_empty() {
                break;
            }
            let mut used = 0;
            let mut ended = false;
            for &byte in bytes {
                used += 1;
                if byte == b'\n' {
                    self.line += 1;
                }
                if !byte.is_ascii_whitespace() && byte != 0 {
                    if self.word.is_empty() {
                        line = self.line;
                    }
                    if self.word.len() == LONGEST_WORD || !byte.is_ascii_graphic() {
                        let reason = "expected a number; the file is no ASCII grid";
                        return Err(ReadError::malformed(self.path, Place::Line(line), reason));
                    }
                    self.word.push(char::from(byte));
                } else if !self.word.is_empty() {
                    ended = true;
                    break;
                }
            }
            self.reader.consume(used);
            if ended {
                break;
            }
        }
        Ok((&self.word, line))
    }
}

#[derive(Default)]
struct Header {
    columns: Option<u64>,
    rows: Option<u64>,
    /// Position of the south-west cell, and whether of its centre rather than its corner.
    x: Option<(f64, bool)>,
    y: Option<(f64, bool)>,
    spacing: [Option<f64>; 2],
    nodata: Option<f64>,
}

impl Header {
    /// Takes one entry; `false` where its name is none of a header's.
    fn take(&mut self, name: &str, value: f64) -> bool {
        let whole = || (value.fract() == 0.0 && value >= 0.0).then_some(value as u64);
        match name {
            "ncols" => self.columns = whole(),
            "nrows" => self.rows = whole(),
            "xllcorner" => self.x = Some((value, false)),
            "xllcenter" => self.x = Some((value, true)),
            "yllcorner" => self.y = Some((value, false)),
            "yllcenter" => self.y = Some((value, true)),
            "cellsize" => self.spacing = [Some(value); 2],
            "dx" => self.spacing[0] = Some(value),
            "dy" => self.spacing[1] = Some(value),
            "nodata_value" | "nodata" => self.nodata = Some(value),
            _ => return false,
        }
        true
    }

    fn cells(&self, path: &Path) -> Result<(Grid, usize), ReadError> {
        let missing = |name: &str| {
            let reason = format!("the header has no usable {name}");
            ReadError::malformed(path, Place::File, reason)
        };
        let columns = self.columns.ok_or_else(|| missing("ncols"))?;
        let rows = self.rows.ok_or_else(|| missing("nrows"))?;
        let usable = |spacing: Option<f64>| spacing.filter(|s| s.is_finite() && *s > 0.0);
        let dx = usable(self.spacing[0]).ok_or_else(|| missing("cellsize"))?;
        let dy = usable(self.spacing[1]).ok_or_else(|| missing("cellsize"))?;
        let (x, x_is_centre) = self.x.ok_or_else(|| missing("xllcorner or xllcenter"))?;
        let (y, y_is_centre) = self.y.ok_or_else(|| missing("yllcorner or yllcenter"))?;
        let post = |at: f64, is_centre: bool, d: f64| if is_centre { at } else { at + d / 2.0 };
        let posts = count(path, columns, rows)?;
        let south_west = [post(x, x_is_centre, dx), post(y, y_is_centre, dy)];
        let grid = grid(path, [columns as u32, rows as u32], south_west, [dx, dy])?;
        Ok((grid, posts))
    }
}

pub(super) fn read(path: &Path, options: &Options) -> Result<Raster, ReadError> {
    let file = File::open(path).map_err(|e| ReadError::io(path, e))?;
    let bytes = file.metadata().map_err(|e| ReadError::io(path, e))?.len();
    let mut words = Words {
        path,
        reader: BufReader::with_capacity(1 << 16, file),
        line: 1,
        word: String::new(),
    };
    let mut header = Header::default();
    // The header ends with the first word that is a number.
    let (first, first_line) = loop {
        let (word, line) = words.next()?;
        if word.is_empty() || number(word).is_some() {
            break (number(word), line);
        }
        let name = word.to_lowercase();
        let (word, line) = words.next()?;
        let value = number(word);
        let known = value.is_some_and(|value| header.take(&name, value));
        if !known {
            let reason = match value {
                Some(_) => format!("{name:?} is no entry of a header"),
                None => format!("expected a number after {name:?}, found {word:?}"),
            };
            return Err(ReadError::malformed(path, Place::Line(line), reason));
        }
    };
    let (grid, posts) = header.cells(path)?;
    let room = bytes.div_ceil(FEWEST_BYTES_A_POST);
    if posts as u64 > room {
        let reason = format!("the header asks for {posts} heights, the file has room for {room}");
        return Err(ReadError::malformed(path, Place::File, reason));
    }
    let nodata = header.nodata.unwrap_or(USUAL_NODATA);
    let height = |value: f64| {
        if value == nodata {
            f32::NAN
        } else {
            value as f32
        }
    };
    let mut heights = reserved(path, posts)?;
    heights.extend(first.map(height));
    let mut last_line = first_line;
    while heights.len() < posts {
        let (word, line) = words.next()?;
        if word.is_empty() {
            let reason = format!("ends after {} of {posts} heights", heights.len());
            return Err(ReadError::malformed(path, Place::Line(last_line), reason));
        }
        let Some(value) = number(word) else {
            let reason = format!("expected a height, found {word:?}");
            return Err(ReadError::malformed(path, Place::Line(line), reason));
        };
        heights.push(height(value));
        last_line = line;
    }
    let (word, line) = words.next()?;
    if !word.is_empty() {
        let reason = format!("more than the {posts} heights that the header asks for");
        return Err(ReadError::malformed(path, Place::Line(line), reason));
    }
    let (units, crs) = assumed(options.crs.as_deref(), &grid);
    Ok(Raster {
        field: field(path, grid, heights)?,
        crs,
        units,
    })
}

/// A word as a number; NaN counts as one, infinity does not.
fn number(word: &str) -> Option<f64> {
    word.parse().ok().filter(|v: &f64| !v.is_infinite())
}
