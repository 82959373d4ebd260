//! Memory of the queue as the ground grows 50 times (D, table 3).

use std::path::Path;

use super::store::SHARE;
use super::supply::{Drawn, Supply, Way};
use crate::experiment::{Progress, ReportError};
use crate::geom::{DVec2, DVec3, DepthRange, Orientation, Projection, View};
use crate::terrain::pyramid::{Pyramid, Tiling, write};
use crate::terrain::{Criterion, Grid, Layout};

/// Blocks a side, from 400 of the finest tiles, more than the queue holds, to 51.8 times as many.
const BLOCKS: [u32; 5] = [5, 14, 20, 28, 36];
const SPACING_M: f64 = 10.0;
/// Depth of the blocks that are written one at a time.
const BLOCK_LEVELS: u32 = 7;
/// The eye is as fast over a large ground as over a small one.
const FRAMES_A_BLOCK: u32 = 20;
/// D's view range: what a frame draws must not grow with the ground either.
const VIEW_RANGE_M: f64 = 2_500.0;

/// One ground.
pub(super) struct Row {
    pub growth: f64,
    pub bytes: usize,
    pub tiles: u64,
    /// The most tiles held at once.
    pub held: usize,
    /// What these take.
    pub held_bytes: usize,
    /// Memory of the process that no file stands behind, at its most while the file was written
    /// and during the flight; `None` where the system does not tell.
    pub write_bytes: Option<u64>,
    pub flight_bytes: Option<u64>,
    /// The part of the file that is in memory after the flight: the system takes it back when it
    /// likes.
    pub mapped_bytes: Option<u64>,
}

pub(super) fn rows(folder: &Path, most: u32, progress: &Progress) -> Result<Vec<Row>, ReportError> {
    let path = folder.join("growing.terrain");
    let mut rows: Vec<Row> = Vec::new();
    let allowed = u64::from(most).isqrt() as u32 >> BLOCK_LEVELS;
    // The first is done twice: an allocator keeps what it was once given, whatever the ground.
    for blocks in [BLOCKS[0]].into_iter().chain(BLOCKS) {
        let blocks = blocks.min(allowed).max(1);
        progress(&format!("ground of {blocks} x {blocks} blocks"));
        rows.push(row(&path, blocks)?);
    }
    rows.remove(0);
    let least = rows[0].tiles as f64;
    for row in &mut rows {
        row.growth = row.tiles as f64 / least;
    }
    Ok(rows)
}

fn row(path: &Path, blocks: u32) -> Result<Row, ReportError> {
    let side = (blocks << BLOCK_LEVELS) + 1;
    let grid = Grid::new(side, side, DVec2::ZERO, DVec2::splat(SPACING_M))?;
    let layout = Layout::with_levels(grid, BLOCK_LEVELS);
    let tiling = Tiling::with_levels(layout, Tiling::TILE_LEVELS);
    let mut writing = Most::default();
    let writing_seen = std::cell::RefCell::new(&mut writing);
    write(path, &tiling, None, hill, &|_, _| {
        writing_seen.borrow_mut().look();
    })?;
    let pyramid = Pyramid::open(path)?;
    let mut supply = Supply::new(Way::Queue, &pyramid, path).reaching(3.0);
    let knobs = Criterion::Roughness.share(&Criterion::Roughness.knobs(), SHARE);
    let mut flying = Most::default();
    let frames = blocks * FRAMES_A_BLOCK;
    for frame in 0..frames {
        let flown = f64::from(frame) / f64::from(frames);
        supply.frame(&view(&grid, flown)?, &knobs)?;
        flying.look();
    }
    let held = supply.counts().most;
    Ok(Row {
        growth: 1.0,
        bytes: pyramid.byte_len(),
        tiles: tiling.tile_count(),
        held,
        held_bytes: held * (size_of::<Drawn>() + tiling.tile_posts() * size_of::<[f32; 3]>()),
        write_bytes: writing.bytes,
        flight_bytes: flying.bytes,
        mapped_bytes: resident("RssFile:"),
    })
}

/// Rolling hills, the same wherever one looks.
fn hill(column: u32, row: u32) -> f32 {
    let (x, y) = (f64::from(column), f64::from(row));
    let waves = [(97.0, 120.0), (31.0, 25.0), (7.0, 4.0), (2.3, 0.6)];
    let heights = waves.map(|(length, height)| height * (x / length).sin() * (y / length).cos());
    heights.into_iter().sum::<f64>() as f32
}

/// Across the ground from one corner to the other, so far on the way, 0 to 1.
fn view(grid: &Grid, flown: f64) -> Result<View, ReportError> {
    let far = DVec2::new(grid.x(grid.columns() - 1), grid.y(grid.rows() - 1));
    let eye = far * (0.1 + 0.8 * flown);
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

/// The most memory that no file stood behind.
#[derive(Default)]
struct Most {
    bytes: Option<u64>,
}

impl Most {
    fn look(&mut self) {
        self.bytes = self.bytes.max(resident("RssAnon:"));
    }
}

/// Memory of this process of one kind, bytes.
fn resident(kind: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(kind))?;
    let kilobytes: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(kilobytes * 1024)
}
