use anyhow::Result;

use super::args::ImportArgs;
use super::progress;
use crate::import::{Options, import};
use crate::index;

pub(super) fn run(args: &ImportArgs) -> Result<()> {
    let options = Options {
        up: args.up.map(Into::into),
        lod: args.lod.clone(),
        height: args.height.clone(),
    };
    let bar = progress::bytes();
    bar.set_message("importing");
    let imported = import(&args.files, &options, &|read, total| {
        bar.set_length(total);
        bar.set_position(read);
    });
    bar.finish_and_clear();
    let imported = imported?;

    for warning in imported.warnings.iter().take(args.warnings) {
        eprintln!("warning: {warning}");
    }
    let hidden = imported.warnings.len().saturating_sub(args.warnings);
    if hidden > 0 {
        eprintln!(
            "and {hidden} more warnings; see them with --warnings {}",
            imported.warnings.len()
        );
    }
    let spinner = progress::spinner();
    spinner.set_message("building the index");
    let tree = index::build(&imported.scene, args.promote.into())?;
    spinner.set_message("writing");
    tree.save(&args.output)?;
    spinner.finish_and_clear();
    eprintln!(
        "{}: {} objects, {} levels, {} bytes{}",
        args.output.display(),
        tree.object_count(),
        tree.level_count(),
        tree.byte_len(),
        tree.crs().map(|crs| format!(", {crs}")).unwrap_or_default(),
    );
    Ok(())
}
