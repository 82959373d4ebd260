//! The ground that the experiments look at, and where from.

use crate::experiment::city::SEED;
use crate::experiment::{Options, ReportError};
use crate::geom::{DVec2, DVec3, DepthRange, Orientation, Projection, View};
use crate::terrain::{Grid, Ground, HeightField, Interpolation, Layout};

/// Posts a side unless [`Options::largest`] asks for less.
const SIDE: u32 = 1025;
/// From post to post, m.
const SPACING_M: f64 = 10.0;
/// Above the ground, m.
const FLYING_M: f64 = 60.0;
/// Positions of a flight.
pub(super) const POSITIONS: u32 = 10;

/// Height field and ground of mountains and a plain: 2^k + 1 posts a side, no more in all
/// than the options allow, but at least 33.
pub(super) fn mountains(options: &Options) -> Result<(HeightField, Ground), ReportError> {
    let allowed = options.largest.map_or(SIDE, u32::isqrt).clamp(33, SIDE) - 1;
    let field = landscape((1 << allowed.ilog2()) + 1)?;
    let ground = Ground::cut(&field, &Layout::new(*field.grid()));
    Ok((field, ground))
}

/// Mountains, rough at every scale, out of a plain with gentle swells and a lake.
fn landscape(side: u32) -> Result<HeightField, ReportError> {
    let grid = Grid::new(side, side, DVec2::ZERO, DVec2::splat(SPACING_M))?;
    let size = f64::from(side - 1);
    let height = |column: u32, row: u32| {
        let octave = |n: u64| {
            let cells = f64::from(1 << n) / size;
            noise(f64::from(column) * cells, f64::from(row) * cells, n)
        };
        let mountain = (octave(2) * 1.5 + octave(1) * 0.5).clamp(0.0, 1.0);
        let rough: f64 = (3..10)
            .map(|n| octave(n) / 1.9_f64.powi(n as i32 - 3))
            .sum();
        let plain = 0.1 * octave(1) + 0.02 * octave(4);
        let relief = plain + mountain * mountain * (1.0 + 0.6 * rough);
        (size * SPACING_M * 0.1 * relief.max(-0.05)) as f32
    };
    let rows = (0..side).flat_map(|row| (0..side).map(move |column| height(column, row)));
    Ok(HeightField::new(grid, rows.collect())?)
}

/// Smooth noise in −1 to 1 that passes through random values at whole coordinates.
fn noise(x: f64, y: f64, octave: u64) -> f64 {
    let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
    let value = |x: f64, y: f64| {
        let mut h = (x as u64) ^ (y as u64) << 20 ^ octave << 40 ^ SEED << 50;
        for _ in 0..2 {
            // SplitMix64.
            h = (h ^ h >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            h = (h ^ h >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        }
        (h >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let (x0, y0) = (x.floor(), y.floor());
    let (tx, ty) = (smooth(x - x0), smooth(y - y0));
    let along = |y: f64| value(x0, y) * (1.0 - tx) + value(x0 + 1.0, y) * tx;
    along(y0) * (1.0 - ty) + along(y0 + 1.0) * ty
}

/// Ten views on the way across a field, low above the ground, looking ahead.
pub(super) fn flight(field: &HeightField) -> Result<Vec<View>, ReportError> {
    flight_of(field, POSITIONS)
}

/// The same way in so many views.
pub(super) fn flight_of(field: &HeightField, views: u32) -> Result<Vec<View>, ReportError> {
    let grid = field.grid();
    let at = |part: f64| {
        let size = DVec2::new(
            grid.x(grid.columns() - 1) - grid.x(0),
            grid.y(grid.rows() - 1) - grid.y(0),
        );
        let xy = grid.origin() + size * DVec2::new(part, 0.3 + 0.4 * part);
        let ground = field.height_at(xy.x, xy.y, Interpolation::Bilinear);
        xy.extend(ground.unwrap_or(0.0) + FLYING_M)
    };
    let view = |n: u32| {
        let part = 0.05 + 0.8 * f64::from(n) / f64::from(views);
        let (eye, ahead) = (at(part), at(part + 0.1));
        let orientation = Orientation::LookAt {
            target: DVec3::new(ahead.x, ahead.y, eye.z - 0.1 * eye.distance(ahead)),
            up: DVec3::Z,
        };
        let projection = Projection::Perspective { fov_y_deg: 60.0 };
        let depth = DepthRange {
            near: 1.0,
            far: None,
        };
        Ok(View::new(
            eye,
            orientation,
            projection,
            depth,
            [1920, 1080],
        )?)
    };
    (0..views).map(view).collect()
}

/// The whole field from above and aside, everything in view.
pub(super) fn overview(field: &HeightField) -> Result<View, ReportError> {
    let grid = field.grid();
    let far = DVec2::new(grid.x(grid.columns() - 1), grid.y(grid.rows() - 1));
    let middle = grid.origin().midpoint(far);
    let eye = middle.extend(0.7 * grid.origin().distance(far));
    let orientation = Orientation::LookAt {
        target: middle.extend(0.0),
        up: DVec3::Y,
    };
    let projection = Projection::Perspective { fov_y_deg: 120.0 };
    let depth = DepthRange {
        near: 1.0,
        far: None,
    };
    Ok(View::new(
        eye,
        orientation,
        projection,
        depth,
        [1920, 1920],
    )?)
}
