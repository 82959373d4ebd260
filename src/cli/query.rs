use std::borrow::Cow;
use std::ffi::OsStr;
use std::io::{self, BufWriter, Write};
use std::time::Duration;

use serde::Serialize;

use super::args::{EffectArg, QueryArgs, misuse};
use super::say::say;
use super::select::{Selected, require, select};
use super::text;
use crate::effects::terrain::Drawn;
use crate::frame::Effects;
use crate::service::{Lists, Tail};

pub(super) fn run(args: &QueryArgs) -> anyhow::Result<()> {
    for (asked, effect, reason) in [
        (
            args.visible_pixels,
            EffectArg::Occlusion,
            "--visible-pixels: is of occlusion, which --without switches off",
        ),
        (
            args.patches,
            EffectArg::Terrain,
            "--patches: is of terrain, which --without switches off",
        ),
    ] {
        if asked && args.select.without.contains(&effect) {
            return Err(misuse("query", reason).into());
        }
    }
    let selected = select(&args.select, "query", args.repeat)?;
    let hint = selected.hint();
    let Selected { tree, frame, .. } = selected;
    if args.visible_pixels {
        let declared = tree.effects().occlusion.is_some();
        require(declared, &args.select, "occlusion", "--visible-pixels")?;
    }
    if args.patches {
        let declared = tree.effects().terrain.is_some();
        require(declared, &args.select, "terrain", "--patches")?;
    }
    let selection = frame.selection();
    let mut out = BufWriter::new(io::stdout().lock());
    if args.json {
        let lists = Lists {
            pixels: args.visible_pixels,
            patches: args.patches,
        };
        let answer = Answer {
            scene: args.select.file.file_stem().map(OsStr::to_string_lossy),
            revision: tree.revision(),
            count: selection.count(),
            ids: selection.objects().filter_map(|o| tree.id(o)).collect(),
            tail: Tail::of(&frame, lists),
        };
        serde_json::to_writer(&mut out, &answer).map_err(io::Error::from)?;
        writeln!(out)?;
    } else {
        for id in selection.objects().filter_map(|object| tree.id(object)) {
            writeln!(out, "{id}")?;
        }
    }
    out.flush()?;
    if !args.json {
        say!(
            "{} of {}, retrieved in {:.0} us; {}{}",
            text::grouped(selection.count().into()),
            text::counted(tree.object_count().into(), "object"),
            frame.retrieval().as_secs_f64() * 1e6,
            bound(selection.error_px()),
            effects(frame.effects())
        );
    }
    if let Some(hint) = hint {
        say!("{hint}");
    }
    Ok(())
}

/// What may be missing, for people.
fn bound(error_px: f64) -> String {
    if error_px == f64::INFINITY {
        return "something around the eye may be left out for its distance or size".into();
    }
    let px = text::pixels(error_px);
    format!("nothing left out for its distance or size is larger than {px} pixels")
}

/// What the effects of the city did, for people.
fn effects(ran: &Effects) -> String {
    let took = |took: Duration| took.as_secs_f64() * 1e6;
    let motion = ran.motion.map(|ran| {
        let slowdown = ran.result;
        format!("; motion left {slowdown:.1} times less detail")
    });
    let haze = ran.haze.map(|ran| {
        format!(
            "; haze cut off what lies beyond it in {:.0} us",
            took(ran.took)
        )
    });
    let occlusion = ran.occlusion.map(|ran| {
        let (hidden, us) = (text::grouped(ran.result.into()), took(ran.took));
        format!("; occlusion hid {hidden} in {us:.0} us")
    });
    let terrain = ran.terrain.map(|ran| {
        let Drawn {
            patches,
            triangles,
            error_px,
        } = ran.result;
        let within = if error_px == f64::INFINITY {
            "without a bound around the eye".to_owned()
        } else {
            format!("within {error_px:.1} pixels")
        };
        format!(
            "; terrain draws {} between posts of {}, {within}, in {:.0} us",
            text::counted(triangles as u64, "triangle"),
            text::counted(patches.into(), "tile"),
            took(ran.took)
        )
    });
    [motion, haze, occlusion, terrain]
        .into_iter()
        .flatten()
        .collect()
}

/// The answer of the HTTP service, in its order.
#[derive(Serialize)]
struct Answer<'a> {
    scene: Option<Cow<'a, str>>,
    revision: String,
    count: u32,
    ids: Vec<Cow<'a, str>>,
    #[serde(flatten)]
    tail: Tail<'a>,
}
