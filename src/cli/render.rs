use std::io::{BufWriter, Write as _};

use anyhow::{Context, Result};

use super::args::{RenderArgs, TintArg, misuse};
use super::select::{Selected, select};
use super::text;
use crate::index::replace_file;
use crate::raster::{Solid, paint};

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
    let Selected { tree, view, frame } = selected;
    let selection = frame.selection();
    let objects = selection.objects().filter_map(|number| tree.object(number));
    let solids: Vec<Solid> = objects
        .map(|object| match args.tint {
            TintArg::Class => Solid::by_class(object.bounds, object.class, &object.id),
            TintArg::Level => Solid::by_level(object.bounds, object.class, object.level),
        })
        .collect();
    let ground_z = tree.bounds().min().z;
    let picture = paint(&view, size, &solids, ground_z);
    replace_file(&args.output, |file| {
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
    if let Some(hint) = hint {
        eprintln!("{hint}");
    }
    Ok(())
}
