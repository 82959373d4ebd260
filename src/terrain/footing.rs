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

/// How a box stands on a field in the same coordinates, with `tolerance_m` up and down. Ground is
/// looked at below the corners of the box, its middle, and at every post between them.
pub fn footing(field: &HeightField, bounds: &Aabb, tolerance_m: f64) -> Footing {
    if bounds.is_empty() {
        return Footing::NoGround;
    }
    let (min, max, middle) = (bounds.min(), bounds.max(), bounds.center());
    let mut range: Option<(f64, f64)> = None;
    let mut look = |height: f64| {
        let (low, high) = range.unwrap_or((height, height));
        range = Some((low.min(height), high.max(height)));
    };
    for (x, y) in [
        (min.x, min.y),
        (max.x, min.y),
        (min.x, max.y),
        (max.x, max.y),
        (middle.x, middle.y),
    ] {
        field
            .height_at(x, y, Interpolation::Bilinear)
            .into_iter()
            .for_each(&mut look);
    }
    let grid = field.grid();
    let posts = |from: f64, to: f64, axis: usize, count: u32| {
        let at = |c: f64| (c - grid.origin()[axis]) / grid.spacing()[axis];
        let end = at(to).floor() + 1.0;
        at(from).ceil().max(0.0) as u32..end.clamp(0.0, f64::from(count)) as u32
    };
    for row in posts(min.y, max.y, 1, grid.rows()) {
        for column in posts(min.x, max.x, 0, grid.columns()) {
            let height = field.height(column, row);
            if !height.is_nan() {
                look(height.into());
            }
        }
    }
    match range {
        None => Footing::NoGround,
        Some((_, high)) if min.z > high + tolerance_m => Footing::Above(min.z - high),
        Some((low, _)) if min.z < low - tolerance_m => Footing::Below(low - min.z),
        Some(_) => Footing::Meets,
    }
}
