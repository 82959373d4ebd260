//! The ground that the experiments look at, and where from.

use std::path::Path;

use crate::experiment::city::SEED;
use crate::experiment::{Options, ReportError};
use crate::geom::{DVec2, DVec3, DepthRange, Orientation, Projection, View};
use crate::terrain::read::{Options as ReadOptions, read};
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

/// Elevation files of the folder that `CITYLOD_DATA` names, and the edges of those that do not say
/// where they lie.
const REAL: [(&str, Option<[f64; 4]>); 3] = [
    ("dem/SRTMGL3_colorado_240x144.asc", None),
    ("dem/pre_runout_DEM.asc", None),
    ("dem/terrarium_256.png", Some([0.0, 0.0, 7680.0, 7680.0])),
];

/// Real ground, where there is any: of each file the largest square of 2^k + 1 posts about its
/// middle, unless there is a hole in it.
pub(super) fn real() -> Result<Vec<(String, HeightField)>, ReportError> {
    let mut found = Vec::new();
    let Some(folder) = std::env::var_os("CITYLOD_DATA") else {
        return Ok(found);
    };
    for (name, bounds) in REAL {
        let path = Path::new(&folder).join(name);
        if !path.is_file() {
            continue;
        }
        let options = ReadOptions {
            bounds,
            ..ReadOptions::default()
        };
        let raster = read(&path, &options)?.to_metres(&path, None)?;
        let square = square(&raster.field)?;
        if square.heights().iter().all(|z| !z.is_nan()) {
            let stem = path.file_stem().unwrap_or_default();
            found.push((stem.to_string_lossy().into_owned(), square));
        }
    }
    Ok(found)
}

/// The largest square of 2^k + 1 posts about the middle of a field.
fn square(field: &HeightField) -> Result<HeightField, ReportError> {
    let grid = field.grid();
    let size = [grid.columns(), grid.rows()];
    let side = (1 << (size[0].min(size[1]) - 1).max(1).ilog2()) + 1;
    let [column, row] = size.map(|posts| posts.saturating_sub(side) / 2);
    let origin = DVec2::new(grid.x(column), grid.y(row));
    let rows = (row..).take(side as usize);
    let heights = rows.flat_map(|row| {
        let columns = (column..).take(side as usize);
        columns.map(move |column| field.height(column, row))
    });
    let square = Grid::new(side, side, origin, grid.spacing())?;
    Ok(HeightField::new(square, heights.collect())?)
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
        looking(eye, orientation, 60.0, [1920, 1080])
    };
    (0..views).map(view).collect()
}

/// The whole field from above and aside, everything in view.
pub(super) fn overview(field: &HeightField) -> Result<View, ReportError> {
    let grid = field.grid();
    let far = DVec2::new(grid.x(grid.columns() - 1), grid.y(grid.rows() - 1));
    let middle = grid.origin().midpoint(far);
    let known = field.heights().iter().filter(|z| !z.is_nan());
    let highest = known.fold(0.0_f32, |highest, z| highest.max(*z));
    let eye = middle.extend(f64::from(highest) + 0.7 * grid.origin().distance(far));
    let orientation = Orientation::LookAt {
        target: middle.extend(0.0),
        up: DVec3::Y,
    };
    looking(eye, orientation, 120.0, [1920, 1920])
}

fn looking(
    eye: DVec3,
    orientation: Orientation,
    fov_y_deg: f64,
    viewport: [u32; 2],
) -> Result<View, ReportError> {
    let projection = Projection::Perspective { fov_y_deg };
    let depth = DepthRange {
        near: 1.0,
        far: None,
    };
    Ok(View::new(eye, orientation, projection, depth, viewport)?)
}
