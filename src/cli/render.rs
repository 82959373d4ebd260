use std::io::{BufWriter, Write as _};

use anyhow::{Context, Result};

use super::args::{RenderArgs, TintArg, misuse};
use super::select::{Selected, select};
use super::text;
use crate::file;
use crate::raster::{Relief, Solid, paint, paint_on};

/// Longest side of a picture, pixels: one of 4096 x 4096 takes 0.8 GB to paint.
const LONGEST_SIDE: u32 = 4096;

pub(super) fn run(args: &RenderArgs) -> Result<()> {
    let size = args.select.size.0;
    if size.iter().any(|&side| side > LONGEST_SIDE) {
        let reason = format!("--size: pictures have at most {LONGEST_SIDE} pixels a side");
        return Err(misuse("render", reason).into());
    }
    let Selected {
        tree,
        land,
        view,
        frame,
    } = select(&args.select, "render", 1)?;
    let selection = frame.selection();
    let objects = selection.objects().filter_map(|number| tree.object(number));
    let solids: Vec<Solid> = objects
        .map(|object| match args.tint {
            TintArg::Class => Solid::by_class(object.bounds, object.class, &object.id),
            TintArg::Level => Solid::by_level(object.bounds, object.class, object.level),
        })
        .collect();
    let picture = match (frame.surface(), &land) {
        (Some(surface), Some(land)) => {
            let (corners, triangles) = surface.mesh(land);
            paint_on(&view, size, &solids, &Relief::new(corners, triangles))
        }
        _ => paint(&view, size, &solids, tree.bounds().min().z),
    };
    file::replace(&args.output, |file| {
        let mut out = BufWriter::new(file);
        picture.write_png(&mut out)?;
        out.flush()
    })
    .with_context(|| format!("{}: cannot write", args.output.display()))?;
    eprintln!(
        "{}: {} of {}",
        args.output.display(),
        text::grouped(selection.count().into()),
        text::counted(tree.object_count().into(), "object"),
    );
    Ok(())
}
