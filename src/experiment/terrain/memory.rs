//! Memory of the queue as the ground grows 50 times (D, table 3).

use std::path::Path;

use super::store::SHARE;
use super::supply::{Drawn, Supply, Way};
use crate::experiment::{Progress, ReportError};
use crate::geom::{DVec2, DVec3, DepthRange, Orientation, Projection, View};
use crate::terrain::pyramid::{Pyramid, Tiling, write};
use crate::terrain::{Criterion, Grid, Layout};

/// How many times the least ground.
const GROWTH: [u32; 5] = [1, 8, 16, 30, 50];
/// Posts a side of the least: 361 of the finest tiles, more than the queue holds.
const LEAST_SIDE: f64 = 609.0;
const SPACING_M: f64 = 10.0;
/// Depth of the blocks that are written one at a time.
const BLOCK_LEVELS: u32 = 8;
const FRAMES: u32 = 100;
/// D's view range: what a frame draws must not grow with the ground either.
const VIEW_RANGE_M: f64 = 2_500.0;

/// One ground.
pub(super) struct Row {
    pub growth: u32,
    pub bytes: usize,
    pub tiles: u64,
    /// The most tiles held at once.
    pub held: usize,
    /// What these take.
    pub held_bytes: usize,
    /// Memory of the process that no file stands behind, at its most while the file was written,
    /// and after the flight; `None` where the system does not tell.
    pub write_bytes: Option<u64>,
    pub flight_bytes: Option<u64>,
}

pub(super) fn rows(folder: &Path, most: u32, progress: &Progress) -> Result<Vec<Row>, ReportError> {
    let path = folder.join("growing.terrain");
    let mut rows = Vec::new();
    for growth in GROWTH {
        progress(&format!("ground of {growth} times the size"));
        let allowed = f64::from(most).sqrt();
        let side = (LEAST_SIDE * f64::from(growth).sqrt())
            .min(allowed)
            .max(33.0) as u32;
        rows.push(row(&path, growth, side)?);
    }
    Ok(rows)
}

fn row(path: &Path, growth: u32, side: u32) -> Result<Row, ReportError> {
    let grid = Grid::new(side, side, DVec2::ZERO, DVec2::splat(SPACING_M))?;
    let layout = Layout::with_levels(grid, BLOCK_LEVELS);
    let tiling = Tiling::with_levels(layout, Tiling::TILE_LEVELS);
    let largest = std::cell::Cell::new(anonymous());
    write(path, &tiling, None, hill, &|_, _| {
        largest.set(largest.get().max(anonymous()));
    })?;
    let pyramid = Pyramid::open(path)?;
    let mut supply = Supply::new(Way::Queue, &pyramid, path).reaching(3.0);
    let knobs = Criterion::Roughness.share(&Criterion::Roughness.knobs(), SHARE);
    for frame in 0..FRAMES {
        supply.frame(&view(&grid, frame)?, &knobs)?;
    }
    let held = supply.counts().most;
    Ok(Row {
        growth,
        bytes: pyramid.byte_len(),
        tiles: tiling.tile_count(),
        held,
        held_bytes: held * (size_of::<Drawn>() + tiling.tile_posts() * size_of::<[f32; 3]>()),
        write_bytes: largest.get(),
        flight_bytes: anonymous(),
    })
}

/// Rolling hills, the same wherever one looks.
fn hill(column: u32, row: u32) -> f32 {
    let (x, y) = (f64::from(column), f64::from(row));
    let waves = [(97.0, 120.0), (31.0, 25.0), (7.0, 4.0), (2.3, 0.6)];
    let heights = waves.map(|(length, height)| height * (x / length).sin() * (y / length).cos());
    heights.into_iter().sum::<f64>() as f32
}

/// Across the ground from one corner to the other.
fn view(grid: &Grid, frame: u32) -> Result<View, ReportError> {
    let far = DVec2::new(grid.x(grid.columns() - 1), grid.y(grid.rows() - 1));
    let eye = far * (0.1 + 0.8 * f64::from(frame) / f64::from(FRAMES));
    let orientation = Orientation::LookAt {
        target: (eye + DVec2::splat(500.0)).extend(150.0),
        up: DVec3::Z,
    };
    let projection = Projection::Perspective { fov_y_deg: 60.0 };
    let depth = DepthRange {
        near: 1.0,
        far: Some(VIEW_RANGE_M),
    };
    Ok(View::new(
        eye.extend(250.0),
        orientation,
        projection,
        depth,
        [1920, 1080],
    )?)
}

/// Memory of this process that no file stands behind, bytes.
fn anonymous() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("RssAnon:"))?;
    let kilobytes: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(kilobytes * 1024)
}
