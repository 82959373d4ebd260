use std::io::{BufWriter, Write as _};

use anyhow::{Context, Result};

use super::args::{RenderArgs, TintArg, misuse};
use super::say::say;
use super::select::{Selected, select};
use super::text;
use crate::file;
use crate::index::LodTree;
use crate::lod::Selection;
use crate::raster::{LEVEL_COLOURS, Relief, Solid, paint, paint_on};

/// Longest side of a picture, pixels: one of 4096 x 4096 takes 0.8 GB to paint.
const LONGEST_SIDE: u32 = 4096;

pub(super) fn run(args: &RenderArgs) -> Result<()> {
    let size = args.select.size.0;
    if size.iter().any(|&side| side > LONGEST_SIDE) {
        let reason = format!("--size: pictures have at most {LONGEST_SIDE} pixels a side");
        return Err(misuse("render", reason).into());
    }
    let selected = select(&args.select, "render", 1)?;
    let hint = selected.hint();
    let Selected {
        tree,
        land,
        view,
        frame,
    } = selected;
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
    say!(
        "{}: {} of {}",
        args.output.display(),
        text::grouped(selection.count().into()),
        text::counted(tree.object_count().into(), "object"),
    );
    if let TintArg::Level = args.tint {
        legend(&tree, selection);
    }
    if let Some(hint) = hint {
        say!("{hint}");
    }
    Ok(())
}

/// What the colours of levels are, coarsest first.
fn legend(tree: &LodTree, selection: &Selection) {
    let mut counts = vec![0_u32; tree.level_count() as usize];
    for level in selection
        .objects()
        .filter_map(|o| Some(tree.object(o)?.level))
    {
        counts[level as usize] += 1;
    }
    for (level, &count) in counts
        .iter()
        .enumerate()
        .rev()
        .filter(|(_, count)| **count > 0)
    {
        let (name, hex) = LEVEL_COLOURS[level.min(LEVEL_COLOURS.len() - 1)];
        let count = text::grouped(count.into());
        say!("  level {level}  {name:<6} #{hex:06x} {count:>11}");
    }
}
