use std::borrow::Cow;
use std::ffi::OsStr;
use std::io::{self, BufWriter, Write};
use std::time::Duration;

use serde::Serialize;

use super::args::QueryArgs;
use super::select::{Selected, select};
use super::text;
use crate::frame::Effects;
use crate::service::Tail;

pub(super) fn run(args: &QueryArgs) -> anyhow::Result<()> {
    let selected = select(&args.select, "query", args.repeat)?;
    let hint = selected.hint();
    let Selected { tree, frame, .. } = selected;
    let selection = frame.selection();
    let mut out = BufWriter::new(io::stdout().lock());
    if args.json {
        let answer = Answer {
            scene: args.select.file.file_stem().map(OsStr::to_string_lossy),
            revision: tree.revision(),
            count: selection.count(),
            ids: selection.objects().filter_map(|o| tree.id(o)).collect(),
            tail: Tail::of(&frame, args.visible_pixels),
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
        eprintln!(
            "{} of {}, retrieved in {:.0} us; nothing left out for its distance or size is \
             larger than {:.1} pixels{}",
            text::grouped(selection.count().into()),
            text::counted(tree.object_count().into(), "object"),
            frame.retrieval().as_secs_f64() * 1e6,
            selection.error_px(),
            effects(frame.effects())
        );
    }
    if let Some(hint) = hint {
        eprintln!("{hint}");
    }
    Ok(())
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
    [motion, haze, occlusion].into_iter().flatten().collect()
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
