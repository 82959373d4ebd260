use std::io::BufWriter;

use anyhow::{Context, Result};

use super::args::{GenerateArgs, extension, misuse};
use super::effects::declared_anew;
use super::say::say;
use super::{glb, ground, progress, text};
use crate::index;
use crate::scene::{CityParams, Scene, generate};

pub(super) fn run(args: &GenerateArgs) -> Result<()> {
    let is_glb = extension(&args.output) == "glb";
    if is_glb && args.promote.is_some() {
        return Err(misuse("generate", "--promote does not apply to a .glb").into());
    }
    if is_glb && args.effects.is_some() {
        return Err(misuse("generate", "--effects does not apply to a .glb").into());
    }
    let effects = declared_anew(args.effects.as_deref())?;
    let spinner = progress::spinner();
    spinner.set_message("generating");
    let mut scene = generate(&CityParams {
        objects: args.objects,
        seed: args.seed,
    });
    scene.effects = effects;
    spinner.set_message("writing");
    let summary = if is_glb {
        write_glb(args, &scene)?;
        text::counted(args.objects.into(), "object")
    } else {
        let promotion = args.promote.map(Into::into).unwrap_or_default();
        let tree = index::build(&scene, promotion)?;
        tree.save(&args.output)?;
        ground::warn_of_other(&args.output);
        text::summary(&tree)
    };
    spinner.finish_and_clear();
    say!("{}: {summary}", args.output.display());
    Ok(())
}

fn write_glb(args: &GenerateArgs, scene: &Scene) -> Result<()> {
    let path = args.output.display();
    crate::file::replace(&args.output, |file| {
        let mut out = BufWriter::new(file);
        glb::write_glb(scene, &mut out)?;
        std::io::Write::flush(&mut out)
    })
    .with_context(|| format!("{path}: cannot write"))
}
