use std::borrow::Cow;
use std::ffi::OsStr;
use std::io::{self, BufWriter, Write};
use std::time::Instant;

use serde::Serialize;

use super::args::{BeyondArg, QueryArgs, misuse};
use super::text;
use crate::geom::{DVec3, DepthRange, Orientation, Projection, View};
use crate::index::LodTree;
use crate::lod::{Beyond, BudgetLod, ErrorLod, Lod, LodError, RangeLod, Selection, select};

pub(super) fn run(args: &QueryArgs) -> anyhow::Result<()> {
    let lod = lod(args).map_err(|e| misuse("query", format!("{}: {}", flag(e.field), e.reason)))?;
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
    .map_err(|e| misuse("query", format!("{}: {}", flag(e.field), e.reason)))?;
    let tree = LodTree::open_verified(&args.file)?;
    let mut selection = Selection::default();
    let start = Instant::now();
    select(&tree, &view, &lod, &mut selection);
    let retrieve_us = start.elapsed().as_secs_f64() * 1e6;
    let mut out = BufWriter::new(io::stdout().lock());
    if args.json {
        let answer = answer(args, &tree, &lod, &selection, retrieve_us);
        serde_json::to_writer(&mut out, &answer).map_err(io::Error::from)?;
        writeln!(out)?;
    } else {
        for id in selection.objects().filter_map(|object| tree.id(object)) {
            writeln!(out, "{id}")?;
        }
    }
    out.flush()?;
    if !args.json {
        eprintln!(
            "{} of {} in {retrieve_us:.0} us; nothing left out is larger than {:.1} pixels",
            text::grouped(selection.count().into()),
            text::counted(tree.object_count().into(), "object"),
            selection.error_px()
        );
    }
    Ok(())
}

fn lod(args: &QueryArgs) -> Result<Lod, LodError> {
    if let Some(px) = args.max_error_px {
        return ErrorLod::new(px).map(Lod::Error);
    }
    if let Some(most) = args.max_objects {
        return Ok(Lod::Budget(BudgetLod::new(most)));
    }
    let beyond = match args.beyond {
        BeyondArg::Show => Beyond::Show,
        BeyondArg::Hide => Beyond::Hide,
    };
    RangeLod::new(args.far_dist, args.dist_factor, args.levels, beyond).map(Lod::Range)
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

/// The flag that sets a field of the engine.
fn flag(field: &'static str) -> &'static str {
    match field {
        "eye" => "--eye",
        "target" | "up" => "--target",
        "fov_y_deg" => "--fov",
        "viewport" => "--size",
        "far_dist_m" => "--far-dist",
        "dist_factor" => "--dist-factor",
        "levels" => "--levels",
        "max_error_px" => "--max-error-px",
        other => other,
    }
}

/// The answer of the HTTP service, in its order.
#[derive(Serialize)]
struct Answer<'a> {
    scene: Option<Cow<'a, str>>,
    revision: String,
    count: u32,
    ids: Vec<Cow<'a, str>>,
    lod: LodAnswer,
    effects: NoEffects,
    stats: Stats,
}

/// JSON has no infinity: null.
#[derive(Serialize)]
#[serde(tag = "mode", rename_all = "lowercase")]
enum LodAnswer {
    Range {
        far_dist_m: Option<f64>,
        dist_factor: f64,
        levels: u32,
        error_px: Option<f64>,
    },
    Error {
        max_error_px: f64,
        error_px: Option<f64>,
    },
    Budget {
        max_objects: u32,
        error_px: Option<f64>,
    },
}

#[derive(Serialize)]
struct NoEffects {}

#[derive(Serialize)]
struct Stats {
    nodes_visited: u32,
    objects_tested: u32,
    retrieve_us: f64,
}

fn answer<'a>(
    args: &'a QueryArgs,
    tree: &'a LodTree,
    lod: &Lod,
    selection: &Selection,
    retrieve_us: f64,
) -> Answer<'a> {
    let finite = |number: f64| number.is_finite().then_some(number);
    let error_px = finite(selection.error_px());
    Answer {
        scene: args.file.file_stem().map(OsStr::to_string_lossy),
        revision: tree.revision(),
        count: selection.count(),
        ids: selection.objects().filter_map(|o| tree.id(o)).collect(),
        lod: match lod {
            Lod::Range(lod) => LodAnswer::Range {
                far_dist_m: finite(lod.far_dist()),
                dist_factor: lod.dist_factor(),
                levels: lod.level_count(),
                error_px,
            },
            Lod::Error(lod) => LodAnswer::Error {
                max_error_px: lod.max_error_px(),
                error_px,
            },
            Lod::Budget(lod) => LodAnswer::Budget {
                max_objects: lod.max_objects(),
                error_px,
            },
        },
        effects: NoEffects {},
        stats: Stats {
            nodes_visited: selection.stats().nodes_visited,
            objects_tested: selection.stats().objects_tested,
            retrieve_us,
        },
    }
}
