//! What every format comes to: posts from the north, and where they lie.

use std::path::Path;

use super::error::{Place, ReadError};
use super::system::has_degrees;
use crate::geom::DVec2;
use crate::terrain::{FieldError, Grid, HeightField};

/// Most posts that are read at once: 1 GiB of heights.
pub(super) const MOST_POSTS: u64 = 1 << 28;

/// What the horizontal coordinates of a raster are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Units {
    /// East and north, m.
    Metres,
    /// Longitude and latitude, degrees.
    Degrees,
}

/// A height field as it lies in its file.
#[derive(Debug, Clone)]
pub struct Raster {
    /// The posts; heights in metres, positions in `units`.
    pub field: HeightField,
    /// Coordinate reference system as `AUTHORITY:CODE`, where file or caller named one.
    pub crs: Option<String>,
    /// What the positions are.
    pub units: Units,
}

/// Number of posts, if so many may be read.
pub(super) fn count(path: &Path, columns: u64, rows: u64) -> Result<usize, ReadError> {
    if columns == 0 || rows == 0 {
        let reason = format!("{columns} x {rows} posts are no raster");
        return Err(ReadError::malformed(path, Place::File, reason));
    }
    let posts = columns.checked_mul(rows).filter(|&n| n <= MOST_POSTS);
    posts.map(|n| n as usize).ok_or(ReadError::TooLarge {
        path: path.to_owned(),
        columns,
        rows,
        most: MOST_POSTS,
    })
}

/// A grid of so many posts from its south-west one on.
pub(super) fn grid(
    path: &Path,
    [columns, rows]: [u32; 2],
    south_west: impl Into<DVec2>,
    spacing: impl Into<DVec2>,
) -> Result<Grid, ReadError> {
    let grid = Grid::new(columns, rows, south_west.into(), spacing.into());
    grid.map_err(|source| no_field(path, source))
}

/// An empty list with room for so many values, if there is.
pub(super) fn reserved<T>(path: &Path, count: usize) -> Result<Vec<T>, ReadError> {
    let mut values = Vec::new();
    match values.try_reserve_exact(count) {
        Ok(()) => Ok(values),
        Err(_full) => Err(ReadError::Memory {
            path: path.to_owned(),
            bytes: count as u64 * size_of::<T>() as u64,
        }),
    }
}

/// Turns rows from the north into a field, whose rows run from the south.
pub(super) fn field(
    path: &Path,
    grid: Grid,
    mut from_north: Vec<f32>,
) -> Result<HeightField, ReadError> {
    turn_rows(&mut from_north, grid.columns() as usize);
    HeightField::new(grid, from_north).map_err(|source| no_field(path, source))
}

/// Puts the last row first.
pub(super) fn turn_rows(heights: &mut [f32], columns: usize) {
    let rows = heights.len() / columns;
    for row in 0..rows / 2 {
        let (above, below) = heights.split_at_mut((rows - 1 - row) * columns);
        above[row * columns..(row + 1) * columns].swap_with_slice(&mut below[..columns]);
    }
}

fn no_field(path: &Path, source: FieldError) -> ReadError {
    ReadError::Field {
        path: path.to_owned(),
        source,
    }
}

/// What positions are and which system they lie in, where a file does not say so: degrees where
/// all of them are on the globe and the system has degrees or the posts are less than a tenth
/// apart, which metres hardly are.
pub(super) fn assumed(crs: Option<&str>, grid: &Grid) -> (Units, Option<String>) {
    let (west, east) = (grid.x(0), grid.x(grid.columns() - 1));
    let (south, north) = (grid.y(0), grid.y(grid.rows() - 1));
    let on_globe = west >= -180.0 && east <= 360.0 && south >= -90.0 && north <= 90.0;
    let spacing = grid.spacing().max_element();
    if on_globe && (crs.is_some_and(has_degrees) || spacing < 0.1) {
        (Units::Degrees, Some(crs.unwrap_or("EPSG:4326").to_owned()))
    } else {
        (Units::Metres, crs.map(str::to_owned))
    }
}
