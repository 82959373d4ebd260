use std::io::{self, BufWriter, Write};
use std::time::Instant;

use anyhow::{Context, Result};
use serde_json::json;

use super::args::{BeyondArg, QueryArgs};
use crate::geom::{DVec3, DepthRange, Orientation, Projection, View};
use crate::index::LodTree;
use crate::lod::{Beyond, RangeLod, Selection, retrieve};

pub(super) fn run(args: &QueryArgs) -> Result<()> {
    let beyond = match args.beyond {
        BeyondArg::Show => Beyond::Show,
        BeyondArg::Hide => Beyond::Hide,
    };
    let lod = RangeLod::new(args.far_dist, args.dist_factor, args.levels, beyond)
        .context("level of detail")?;
    let view = View::new(
        args.eye.0,
        Orientation::LookAt {
            target: args.target.0,
            up: upright(args),
        },
        Projection::Perspective {
            fov_y_deg: args.fov,
        },
        DepthRange {
            near: 0.1,
            far: None,
        },
        args.size.0,
    )
    .context("camera")?;
    let tree = LodTree::open_verified(&args.file)?;
    let mut selection = Selection::default();
    let start = Instant::now();
    retrieve(&tree, &view, &lod, &mut selection);
    let retrieve_us = start.elapsed().as_secs_f64() * 1e6;
    let mut out = BufWriter::new(io::stdout().lock());
    if args.json {
        writeln!(
            out,
            "{}",
            answer(args, &tree, &lod, &selection, retrieve_us)
        )?;
    } else {
        for id in selection.objects().filter_map(|object| tree.id(object)) {
            writeln!(out, "{id}")?;
        }
    }
    out.flush()?;
    if !args.json {
        eprintln!(
            "{} of {} objects in {retrieve_us:.0} us; nothing left out is larger than {:.1} pixels",
            selection.count(),
            tree.object_count(),
            selection.error_px()
        );
    }
    Ok(())
}

/// Up, or north where the camera looks straight up or down.
fn upright(args: &QueryArgs) -> DVec3 {
    let sight = args.target.0 - args.eye.0;
    if sight.x == 0.0 && sight.y == 0.0 {
        DVec3::Y
    } else {
        DVec3::Z
    }
}

fn answer(
    args: &QueryArgs,
    tree: &LodTree,
    lod: &RangeLod,
    selection: &Selection,
    retrieve_us: f64,
) -> serde_json::Value {
    let ids: Vec<_> = selection.objects().filter_map(|o| tree.id(o)).collect();
    json!({
        "scene": args.file.file_stem().map(|s| s.to_string_lossy()),
        "revision": tree.revision(),
        "count": selection.count(),
        "ids": ids,
        "lod": {
            "mode": "range",
            "far_dist_m": lod.far_dist(), // JSON has no infinity: null
            "dist_factor": lod.dist_factor(),
            "levels": lod.level_count(),
            "beyond": lod.beyond(),
            "error_px": selection.error_px(),
        },
        "effects": {},
        "stats": {
            "nodes_visited": selection.stats().nodes_visited,
            "objects_tested": selection.stats().objects_tested,
            "retrieve_us": retrieve_us,
        },
    })
}
