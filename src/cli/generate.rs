use std::io::BufWriter;

use anyhow::{Context, Result, bail};

use super::args::GenerateArgs;
use super::{glb, progress};
use crate::index;
use crate::scene::{CityParams, Scene, generate};

pub(super) fn run(args: &GenerateArgs) -> Result<()> {
    let extension = args.output.extension().and_then(|e| e.to_str());
    let write: fn(&GenerateArgs, &Scene) -> Result<()> = match extension {
        Some("citylod") => write_citylod,
        Some("glb") => write_glb,
        _ => bail!(
            "{}: the name must end in .citylod or .glb",
            args.output.display()
        ),
    };
    let spinner = progress::spinner();
    spinner.set_message("generating");
    let scene = generate(&CityParams {
        objects: args.objects,
        seed: args.seed,
    });
    spinner.set_message("writing");
    write(args, &scene)?;
    spinner.finish_and_clear();
    eprintln!("{}: {} objects", args.output.display(), args.objects);
    Ok(())
}

fn write_citylod(args: &GenerateArgs, scene: &Scene) -> Result<()> {
    Ok(index::build(scene, args.promote.into())?.save(&args.output)?)
}

fn write_glb(args: &GenerateArgs, scene: &Scene) -> Result<()> {
    let path = args.output.display();
    crate::index::replace_file(&args.output, |file| {
        let mut out = BufWriter::new(file);
        glb::write_glb(scene, &mut out)?;
        std::io::Write::flush(&mut out)
    })
    .with_context(|| format!("{path}: cannot write"))
}
