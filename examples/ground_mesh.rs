//! The ground as triangles, wrong by no more than so many metres: `tests/compare` asks for it.
//!
//! `cargo run --release --example ground_mesh -- HEIGHTS.f32 SIDE ERROR_M...` reads SIDE × SIDE
//! heights, f32 little endian, and prints one JSON object a line for each error: `posts`, column
//! and row of each vertex, and `triangles`, three vertices each.

use std::error::Error;
use std::io::Write as _;

use citylod::geom::{DVec2, DVec3, DepthRange, Orientation, Projection, View};
use citylod::terrain::{
    Criterion, Detail, Grid, Ground, HeightField, Knobs, Layout, Workers, select,
};

/// So far up that every post is equally far away: B's criterion then asks for metres.
const UP_M: f64 = 1e12;
/// Errors are known as f32, rounded up.
const ROUNDING: f64 = 1.0 + 1e-6;

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let usage = "usage: ground_mesh HEIGHTS.f32 SIDE ERROR_M...";
    let bytes = std::fs::read(args.next().ok_or(usage)?)?;
    let side: u32 = args.next().ok_or(usage)?.parse()?;
    let heights = bytes.as_chunks().0.iter().map(|&z| f32::from_le_bytes(z));
    let grid = Grid::new(side, side, DVec2::ZERO, DVec2::ONE)?;
    let field = HeightField::new(grid, heights.collect())?;
    let ground = Ground::cut(&field, &Layout::with_levels(grid, Layout::MOST_LEVELS));
    let middle = DVec2::splat(f64::from(side - 1) / 2.0);
    let view = View::new(
        middle.extend(UP_M),
        Orientation::LookAt {
            target: middle.extend(0.0),
            up: DVec3::Y,
        },
        Projection::Orthographic {
            height_m: 2.0 * f64::from(side),
        },
        DepthRange {
            near: 1.0,
            far: None,
        },
        [1000, 1000],
    )?;
    for error_m in args {
        let error_m: f64 = error_m.parse()?;
        let detail = Detail {
            knobs: Knobs {
                c1: UP_M * 1e3,
                // What is drawn whole errs by no more than L / C2.
                c2: (UP_M / (error_m * ROUNDING)).min(f64::MAX),
                ..Criterion::Error.knobs()
            },
            ..Detail::of(Criterion::Error)
        };
        let mesh = select(&ground, &view, &detail, Workers::Pool)?.mesh(&ground);
        let line = serde_json::json!({
            "posts": mesh.posts.as_flattened(),
            "triangles": mesh.triangles.as_flattened(),
        });
        writeln!(std::io::stdout(), "{line}")?;
    }
    Ok(())
}
