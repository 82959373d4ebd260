use std::borrow::Cow;
use std::ffi::OsStr;
use std::io::{self, BufWriter, Write};
use std::time::Instant;

use anyhow::Result;
use serde::Serialize;

use super::args::{BeyondArg, QueryArgs, SelectArgs, misuse};
use super::text;
use crate::geom::{DVec3, DepthRange, Orientation, Projection, View};
use crate::index::LodTree;
use crate::lod::{Beyond, RangeLod, Selection, retrieve};

pub(super) fn run(args: &QueryArgs) -> Result<()> {
    let lod = lod(&args.select, "query")?;
    let view = view(&args.select, "query")?;
    let tree = LodTree::open_verified(&args.select.file)?;
    let mut selection = Selection::default();
    let start = Instant::now();
    retrieve(&tree, &view, &lod, &mut selection);
    let retrieve_us = start.elapsed().as_secs_f64() * 1e6;
    let mut out = BufWriter::new(io::stdout().lock());
    if args.json {
        let answer = answer(&args.select, &tree, &lod, &selection, retrieve_us);
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

/// The knobs typed for `verb`.
pub(super) fn lod(args: &SelectArgs, verb: &str) -> Result<RangeLod> {
    let beyond = match args.beyond {
        BeyondArg::Show => Beyond::Show,
        BeyondArg::Hide => Beyond::Hide,
    };
    let lod = RangeLod::new(args.far_dist, args.dist_factor, args.levels, beyond)
        .map_err(|e| misuse(verb, format!("{}: {}", flag(e.field), e.reason)))?;
    Ok(lod)
}

/// The camera typed for `verb`.
pub(super) fn view(args: &SelectArgs, verb: &str) -> Result<View> {
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
    .map_err(|e| misuse(verb, format!("{}: {}", flag(e.field), e.reason)))?;
    Ok(view)
}

/// Up, or north where the camera looks straight up or down.
fn upright(args: &SelectArgs) -> DVec3 {
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
    lod: Lod,
    effects: NoEffects,
    stats: Stats,
}

#[derive(Serialize)]
struct Lod {
    mode: &'static str,
    /// JSON has no infinity: null.
    far_dist_m: Option<f64>,
    dist_factor: f64,
    levels: u32,
    error_px: Option<f64>,
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
    args: &'a SelectArgs,
    tree: &'a LodTree,
    lod: &RangeLod,
    selection: &Selection,
    retrieve_us: f64,
) -> Answer<'a> {
    let finite = |number: f64| number.is_finite().then_some(number);
    Answer {
        scene: args.file.file_stem().map(OsStr::to_string_lossy),
        revision: tree.revision(),
        count: selection.count(),
        ids: selection.objects().filter_map(|o| tree.id(o)).collect(),
        lod: Lod {
            mode: "range",
            far_dist_m: finite(lod.far_dist()),
            dist_factor: lod.dist_factor(),
            levels: lod.level_count(),
            error_px: finite(selection.error_px()),
        },
        effects: NoEffects {},
        stats: Stats {
            nodes_visited: selection.stats().nodes_visited,
            objects_tested: selection.stats().objects_tested,
            retrieve_us,
        },
    }
}
