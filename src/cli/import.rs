use std::path::Path;

use anyhow::{Result, bail};

use super::args::ImportArgs;
use super::effects::declared_anew;
use super::say::say;
use super::{ground, progress, text};
use crate::import::{Classes, Fate, Options, Tally, Unused, import};
use crate::index;

pub(super) fn run(args: &ImportArgs) -> Result<()> {
    match (&args.output, &args.ground.into) {
        (_, Some(city)) => ground::import(args, city),
        (Some(output), None) => import_city(args, output),
        (None, None) => bail!("nowhere to write to; give -o or --into"),
    }
}

fn import_city(args: &ImportArgs, output: &Path) -> Result<()> {
    let effects = declared_anew(args.effects.as_deref())?;
    let options = Options {
        up: args.up.map(Into::into),
        lod: args.lod.clone(),
        height: args.height.clone(),
        classes: classes(args),
        crs: args.ground.crs.clone(),
    };
    let bar = progress::bytes();
    bar.set_message("importing");
    let imported = import(&args.files, &options, &|read, total| {
        bar.set_length(total);
        bar.set_position(read);
    });
    bar.finish_and_clear();
    let mut imported = imported?;
    imported.scene.effects = effects;

    for option in &imported.unused {
        say!("warning: {}", unused(*option));
    }
    // What concerns a whole file is not to be hidden by what concerns its objects.
    imported.warnings.sort_by_key(|w| w.object.is_some());
    for warning in imported.warnings.iter().take(args.warnings) {
        say!("warning: {warning}");
    }
    let hidden = imported.warnings.len().saturating_sub(args.warnings);
    if hidden > 0 {
        say!(
            "and {}; see them with --warnings {}",
            text::counted(hidden as u64, "more warning"),
            imported.warnings.len()
        );
    }
    sum_up(&imported.tallies);
    if imported.scene.objects.is_empty() {
        let none = match options.classes {
            Classes::All => "the files hold no object to import",
            _ => "no object is left of the classes asked for",
        };
        bail!("{none}; {} is left as it was", output.display());
    }
    let spinner = progress::spinner();
    spinner.set_message("building the index");
    let tree = index::build(&imported.scene, args.promote.into())?;
    spinner.set_message("writing");
    tree.save(output)?;
    spinner.finish_and_clear();
    ground::warn_of_other(output);
    say!("{}: {}", output.display(), text::summary(&tree));
    Ok(())
}

/// What was left out or kept flat, by the reason.
fn sum_up(tallies: &[Tally]) {
    for tally in tallies {
        let fate = match tally.fate {
            Fate::LeftOut => "left out",
            Fate::KeptFlat => "kept flat",
        };
        let these = text::counted(tally.count, tally.noun);
        say!("{these} {fate}: {}", tally.reason);
    }
}

fn classes(args: &ImportArgs) -> Classes {
    match (args.class.as_slice(), args.except_class.as_slice()) {
        ([], []) => Classes::All,
        ([], except) => Classes::Except(except.to_vec()),
        (only, _) => Classes::Only(only.to_vec()),
    }
}

fn unused(option: Unused) -> &'static str {
    match option {
        Unused::Up => "--up is for glTF and OBJ, of which there is no file",
        Unused::Lod => "--lod is for CityJSON, of which there is no file",
        Unused::Height => "--height is for GeoJSON, of which there is no file",
    }
}
