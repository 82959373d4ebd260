use citylod::geom::{DVec2, DVec3, DepthRange, Orientation, Projection, View};
use citylod::terrain::{Grid, HeightField};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::written::real;

pub fn rng(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed)
}

pub fn between(rng: &mut Pcg64Mcg, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.random::<f64>()
}

/// A field from a function of column and row.
pub fn field(
    [columns, rows]: [u32; 2],
    origin: DVec2,
    spacing: DVec2,
    height: impl Fn(u32, u32) -> f32,
) -> HeightField {
    let grid = Grid::new(columns, rows, origin, spacing).unwrap();
    let posts = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
    let heights = posts.map(|(column, row)| height(column, row)).collect();
    HeightField::new(grid, heights).unwrap()
}

pub fn flat(size: [u32; 2]) -> HeightField {
    field(size, DVec2::ZERO, DVec2::splat(10.0), |_, _| 123.4)
}

/// Values in [0, 1) that neighbouring posts do not share.
fn hash(column: u32, row: u32, seed: u32) -> f32 {
    let mut h = column.wrapping_mul(0x9e37_79b1) ^ row.wrapping_mul(0x85eb_ca77) ^ seed;
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    ((h ^ (h >> 15)) >> 8) as f32 / 16_777_216.0
}

/// Ground of one of many kinds and sizes, with holes now and then.
pub fn made_up(rng: &mut Pcg64Mcg) -> HeightField {
    let sides = [2, 3, 9, 16, 17, 18, 33, 34, 50, 65, 66, 80];
    let size = [0, 1].map(|_| sides[rng.random_range(0..sides.len())]);
    let origin = match rng.random_range(0..4) {
        0 => DVec2::new(486_000.25, 5_512_000.5),
        1 => DVec2::new(-6_000_000.0, -6_000_000.0),
        _ => DVec2::ZERO,
    };
    let spacing = match rng.random_range(0..4) {
        0 => DVec2::splat(1.0),
        1 => DVec2::new(25.0, 10.0),
        2 => DVec2::splat(0.1),
        _ => DVec2::splat(10.0),
    };
    let (kind, seed) = (rng.random_range(0..7), rng.random::<u32>());
    let relief = spacing.x as f32 * [0.1, 1.0, 5.0][rng.random_range(0..3)];
    let waves = between(rng, 0.02, 0.6) as f32;
    let holes = rng.random_range(0..5);
    let hole = [rng.random_range(0..size[0]), rng.random_range(0..size[1])];
    let radius = rng.random_range(0..=size[0].max(size[1]) / 2);
    field(size, origin, spacing, |column, row| {
        let (x, y) = (column as f32, row as f32);
        let unknown = match holes {
            0 => column.abs_diff(hole[0]).max(row.abs_diff(hole[1])) <= radius / 2,
            1 => column.abs_diff(hole[0]) + row.abs_diff(hole[1]) > radius + 3,
            2 => hash(column, row, !seed) < 0.03,
            _ => false,
        };
        if unknown {
            return f32::NAN;
        }
        match kind {
            0 => 77.7,
            1 => x * relief * 0.1 - y * relief * 0.05,
            2 => ((x * waves).sin() + (y * waves * 0.7).cos()) * relief * 4.0,
            3 => hash(column, row, seed) * relief,
            4 => {
                if column * 3 > row * 2 {
                    relief * 40.0
                } else {
                    0.0
                }
            }
            5 => (hash(column / 7, row / 5, seed) - 0.5) * 2e6,
            _ => {
                if hash(column, row, seed) < 0.01 {
                    relief * 10.0
                } else {
                    (x * waves).sin()
                }
            }
        }
    })
}

/// An ESRI ASCII grid of the real data, at most `most` posts a side from its north-west; `None`,
/// said aloud, where the data is not at hand.
pub fn ascii_grid(name: &str, most: usize) -> Option<HeightField> {
    let text = std::fs::read_to_string(real(name)?).unwrap();
    let mut lines = text.lines();
    let mut header = std::collections::BTreeMap::new();
    let body: Vec<f32> = loop {
        let line = lines.next().unwrap();
        let mut words = line.split_whitespace();
        let first = words.next().unwrap();
        if first.starts_with(|c: char| c.is_alphabetic()) {
            let value: f64 = words.next().unwrap().parse().unwrap();
            header.insert(first.to_lowercase(), value);
        } else {
            let rest = std::iter::once(line).chain(lines);
            break rest
                .flat_map(str::split_whitespace)
                .map(|word| word.parse().unwrap())
                .collect();
        }
    };
    let [all_columns, all_rows] = ["ncols", "nrows"].map(|key| header[key] as usize);
    assert_eq!(body.len(), all_columns * all_rows, "{name}");
    let nodata = header.get("nodata_value").copied();
    // Degrees as if they were 90 m.
    let spacing = if header["cellsize"] < 0.01 {
        90.0
    } else {
        header["cellsize"]
    };
    let (columns, rows) = (all_columns.min(most), all_rows.min(most));
    Some(field(
        [columns as u32, rows as u32],
        DVec2::new(header["xllcorner"], header["yllcorner"]),
        DVec2::splat(spacing),
        |column, row| {
            let z = body[(rows - 1 - row as usize) * all_columns + column as usize];
            if nodata == Some(f64::from(z)) {
                f32::NAN
            } else {
                z
            }
        },
    ))
}

/// All real grids, large ones in part.
pub fn real_grounds() -> Vec<(&'static str, HeightField)> {
    let names = [
        "dem/DEM_10m.asc",
        "dem/hugo_site.asc",
        "dem/pre_runout_DEM.asc",
        "dem/west_bijou_gully.asc",
        "dem/SRTMGL3_colorado_240x144.asc",
    ];
    let grounds = names.map(|name| Some((name, ascii_grid(name, 100)?)));
    grounds.into_iter().flatten().collect()
}

/// Where a field lies: its middle and half its diagonal.
pub fn extent(field: &HeightField) -> (DVec3, f64) {
    let grid = field.grid();
    let [x, y] = [grid.x(grid.columns() - 1), grid.y(grid.rows() - 1)];
    let known = || field.heights().iter().filter(|z| !z.is_nan()).copied();
    let low = f64::from(known().fold(f32::INFINITY, f32::min));
    let high = f64::from(known().fold(f32::NEG_INFINITY, f32::max));
    let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
    let min = grid.origin().extend(low);
    let max = DVec3::new(x, y, high);
    (min.midpoint(max), min.distance(max).max(1e-3) / 2.0)
}

/// A random view about a field: from above, beside, inside and below.
pub fn view(rng: &mut Pcg64Mcg, field: &HeightField) -> View {
    let (middle, reach) = extent(field);
    loop {
        let away = [0.1, 0.5, 1.0, 3.0, 40.0][rng.random_range(0..5)] * reach;
        let mut point = |scale: f64| {
            DVec3::new(
                between(rng, -1.0, 1.0),
                between(rng, -1.0, 1.0),
                between(rng, -1.0, 1.0),
            ) * scale
        };
        let (eye, target) = (middle + point(away), middle + point(reach * 0.7));
        let fov_y_deg = [20.0, 60.0, 60.0, 110.0][rng.random_range(0..4)];
        let projection = if rng.random_bool(0.1) {
            Projection::Orthographic {
                height_m: between(rng, 0.1, 2.0) * reach,
            }
        } else {
            Projection::Perspective { fov_y_deg }
        };
        let depth = DepthRange {
            near: 0.1,
            far: rng
                .random_bool(0.2)
                .then_some(0.2 + between(rng, 0.1, 3.0) * reach),
        };
        let orientation = Orientation::LookAt {
            target,
            up: DVec3::Z,
        };
        if let Ok(view) = View::new(eye, orientation, projection, depth, [1920, 1080]) {
            return view;
        }
    }
}

/// From straight above the middle, everything in view.
pub fn from_above(field: &HeightField, radii: f64) -> View {
    let (middle, reach) = extent(field);
    let eye = middle + DVec3::Z * reach * radii;
    let orientation = Orientation::LookAt {
        target: middle,
        up: DVec3::Y,
    };
    let projection = Projection::Perspective { fov_y_deg: 150.0 };
    let depth = DepthRange {
        near: reach * 1e-6,
        far: None,
    };
    View::new(eye, orientation, projection, depth, [1000, 1000]).unwrap()
}
