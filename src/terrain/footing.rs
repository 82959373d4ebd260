//! Whether what stands in a city stands on its ground.

use super::field::HeightField;
use super::interpolate::Interpolation;
use crate::geom::Aabb;

/// How the base of a box lies to the ground under it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Footing {
    /// Between the lowest and the highest ground under it, or no farther from that than is
    /// tolerated.
    Meets,
    /// So many metres above the highest ground under it.
    Above(f64),
    /// So many metres below the lowest.
    Below(f64),
    /// No height is known under it.
    NoGround,
}

/// How a box stands on a field in the same coordinates, with `tolerance_m` up and down.
pub fn footing(field: &HeightField, bounds: &Aabb, tolerance_m: f64) -> Footing {
    let base = bounds.min().z;
    match ground_under(field, bounds) {
        None => Footing::NoGround,
        Some([_, high]) if base > high + tolerance_m => Footing::Above(base - high),
        Some([low, _]) if base < low - tolerance_m => Footing::Below(low - base),
        Some(_) => Footing::Meets,
    }
}

/// The lowest and the highest ground under a box in the same coordinates, bilinear between posts,
/// m; `None` where no height is known under it.
///
/// Law: exact where all heights under the box are known. In a rectangle, what is bilinear is lowest
/// and highest at corners: of the box, of cells, and where the one's sides cross the other's.
pub fn ground_under(field: &HeightField, bounds: &Aabb) -> Option<[f64; 2]> {
    if bounds.is_empty() {
        return None;
    }
    let (min, max) = (bounds.min(), bounds.max());
    let mut range: Option<[f64; 2]> = None;
    let mut look = |height: f64| {
        let [low, high] = range.unwrap_or([height; 2]);
        range = Some([low.min(height), high.max(height)]);
    };
    let grid = field.grid();
    let posts = |axis: usize, count: u32| {
        let at = |c: f64| (c - grid.origin()[axis]) / grid.spacing()[axis];
        let end = at(max[axis]).floor() + 1.0;
        at(min[axis]).ceil().max(0.0) as u32..end.clamp(0.0, f64::from(count)) as u32
    };
    let (columns, rows) = (posts(0, grid.columns()), posts(1, grid.rows()));
    let sides = columns.clone().map(|column| grid.x(column));
    for x in sides.chain([min.x, max.x]) {
        for y in [min.y, max.y] {
            let height = field.height_at(x, y, Interpolation::Bilinear);
            height.into_iter().for_each(&mut look);
        }
    }
    for row in rows {
        for x in [min.x, max.x] {
            let height = field.height_at(x, grid.y(row), Interpolation::Bilinear);
            height.into_iter().for_each(&mut look);
        }
        for column in columns.clone() {
            let height = field.height(column, row);
            if !height.is_nan() {
                look(height.into());
            }
        }
    }
    range
}
