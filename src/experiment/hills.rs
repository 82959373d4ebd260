//! Made-up ground under a made-up city.

use std::path::Path;

use super::ReportError;
use crate::geom::{Aabb, DVec2};
use crate::terrain::Grid;
use crate::terrain::pyramid::{Pyramid, Tiling, beside, write};

/// Posts a side.
const SIDE: u32 = 513;

/// Lays rolling ground beside a city, a quarter wider than the city on every side: waves of
/// several lengths, none of which rises above the lowest object.
pub(super) fn lay(city: &Path, bounds: &Aabb) -> Result<Pyramid, ReportError> {
    let size = bounds.size().truncate() * 1.5;
    let origin = bounds.min().truncate() - size / 6.0;
    let grid = Grid::new(SIDE, SIDE, origin, size / f64::from(SIDE - 1))?;
    let height = |column: u32, row: u32| {
        let at = DVec2::new(f64::from(column), f64::from(row));
        let waves = [(0.02, 12.0), (0.11, 3.0), (0.53, 0.6), (1.9, 0.15)]
            .map(|(pace, high)| high * ((at.x * pace).sin() * (at.y * pace * 1.3).cos() - 1.0));
        (bounds.min().z + waves.iter().sum::<f64>()) as f32
    };
    let path = beside(city);
    write(&path, &Tiling::new(grid), None, height, &|_, _| {})?;
    Ok(Pyramid::open(&path)?)
}
