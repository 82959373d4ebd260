use std::io::{self, BufWriter, Write};

use anyhow::{Result, bail};
use serde_json::json;

use super::args::InfoArgs;
use super::failure::told;
use super::ground;
use super::say::say;
use super::text::{self, grouped};
use crate::frame::Overview;
use crate::geom::Aabb;
use crate::index::LodTree;
use crate::lod::RangeLod;
use crate::terrain::pyramid::Pyramid;

pub(super) fn run(args: &InfoArgs) -> Result<()> {
    let tree = LodTree::open_verified(&args.file)?;
    let ground = Ground::of_city(args, &tree);
    let mut out = BufWriter::new(io::stdout().lock());
    if args.objects {
        objects(&tree, &mut out)?;
    } else if args.nodes {
        nodes(&tree, &mut out)?;
    } else if args.json {
        writeln!(out, "{:#}", summary(args, &tree, &ground))?;
    } else {
        table(args, &tree, &ground, &mut out)?;
    }
    out.flush()?;
    if args.check {
        check(args, &tree, &ground)?;
    }
    Ok(())
}

/// What there is of the ground of a city.
enum Ground {
    /// It declares none.
    None,
    /// It declares terrain, which is yet to be laid.
    Unlaid,
    Laid(Box<Pyramid>),
    /// It was laid, but is missing, damaged or another's.
    Unusable(String),
}

impl Ground {
    fn of_city(args: &InfoArgs, tree: &LodTree) -> Self {
        match ground::of_city(&args.file, tree) {
            Ok(Some(pyramid)) => Self::Laid(Box::new(pyramid)),
            Ok(None) if tree.effects().terrain.is_some() => Self::Unlaid,
            Ok(None) => Self::None,
            Err(error) => Self::Unusable(told(&error.into())),
        }
    }

    fn is_laid(&self) -> bool {
        matches!(self, Self::Laid(_) | Self::Unusable(_))
    }
}

fn check(args: &InfoArgs, tree: &LodTree, ground: &Ground) -> Result<()> {
    let violations = tree.validate();
    for violation in &violations {
        say!("{}: {violation}", args.file.display());
    }
    if !violations.is_empty() {
        bail!(
            "{}: the tree is not sound; import the city again",
            args.file.display()
        );
    }
    if let Ground::Unusable(why) = ground {
        bail!("{why}; the city itself is sound");
    }
    say!("{}: checked, sound", args.file.display());
    Ok(())
}

fn summary(args: &InfoArgs, tree: &LodTree, ground: &Ground) -> serde_json::Value {
    let (terrain, problem) = match ground {
        Ground::Laid(pyramid) => (Some(ground::summary(pyramid)), None),
        Ground::Unusable(why) => (None, Some(why)),
        Ground::None | Ground::Unlaid => (None, None),
    };
    json!({
        "file": args.file.display().to_string(),
        "bytes": tree.byte_len(),
        "revision": tree.revision(),
        "crs": tree.crs(),
        "objects": tree.object_count(),
        "nodes": tree.node_count(),
        "levels": tree.level_count(),
        "base_unknown": tree.base_unknown_count(),
        "promotion": tree.promotion(),
        "bounds": bounds_json(&tree.bounds()),
        "origin": tree.origin().to_array(),
        "classes": class_counts(tree).into_iter().collect::<serde_json::Map<_, _>>(),
        "effects": tree.effects(),
        "terrain": terrain,
        "terrain_problem": problem,
    })
}

/// Of how many objects it is not known how high they stand, and what becomes of them.
fn bases(args: &InfoArgs, tree: &LodTree, is_laid: bool) -> String {
    let objects = text::counted(tree.base_unknown_count().into(), "object");
    let fate = if is_laid {
        "set on the ground; as high as the nearest where there is none under them".to_owned()
    } else {
        let city = text::word(&args.file.to_string_lossy());
        format!("at 0 until ground is laid: citylod import ELEVATION --into {city}")
    };
    format!("not known of {objects}; {fate}")
}

fn bounds_json(bounds: &Aabb) -> serde_json::Value {
    if bounds.is_empty() {
        serde_json::Value::Null
    } else {
        json!(bounds.to_array())
    }
}

fn class_counts(tree: &LodTree) -> Vec<(String, serde_json::Value)> {
    let mut counts = vec![0_u64; tree.classes().len()];
    for object in 0..tree.object_count() {
        if let Some(class) = tree.class_number(object) {
            counts[class] += 1;
        }
    }
    let names = tree.classes().iter().map(ToString::to_string);
    names.zip(counts.into_iter().map(Into::into)).collect()
}

fn table(args: &InfoArgs, tree: &LodTree, ground: &Ground, out: &mut impl Write) -> io::Result<()> {
    let bounds = tree.bounds();
    writeln!(out, "file       {}", args.file.display())?;
    writeln!(
        out,
        "size       {}",
        text::counted(tree.byte_len() as u64, "byte")
    )?;
    writeln!(out, "revision   {}", tree.revision())?;
    writeln!(out, "crs        {}", tree.crs().unwrap_or("not stated"))?;
    writeln!(out, "objects    {}", grouped(tree.object_count().into()))?;
    for (class, count) in class_counts(tree) {
        let count = grouped(count.as_u64().unwrap_or_default());
        writeln!(out, "           {count:>11} {class}")?;
    }
    if tree.base_unknown_count() > 0 {
        writeln!(out, "bases      {}", bases(args, tree, ground.is_laid()))?;
    }
    writeln!(out, "nodes      {}", grouped(tree.node_count().into()))?;
    let a = tree.arrays();
    for level in (0..tree.level_count() as usize).rev() {
        let at = tree.level_count() as usize - 1 - level;
        writeln!(
            out,
            "  level {level:<2} {:>11} nodes {:>11} objects",
            grouped((a.level_nodes[at + 1] - a.level_nodes[at]).into()),
            grouped((a.level_objects[at + 1] - a.level_objects[at]).into())
        )?;
    }
    let promotion = format!("{:?}", tree.promotion()).to_lowercase();
    writeln!(out, "promotion  {promotion}")?;
    let effects = serde_json::to_string(tree.effects()).unwrap_or_default();
    writeln!(out, "effects    {effects}")?;
    match ground {
        Ground::Laid(pyramid) => writeln!(out, "ground     {}", ground::line(pyramid))?,
        Ground::Unusable(why) => writeln!(out, "ground     cannot be used: {why}")?,
        Ground::Unlaid => writeln!(
            out,
            "ground     none yet: citylod import ELEVATION --into {}",
            args.file.display()
        )?,
        Ground::None => {}
    }
    if !bounds.is_empty() {
        writeln!(
            out,
            "bounds     {} to {}",
            text::point(bounds.min(), " "),
            text::point(bounds.max(), " ")
        )?;
        writeln!(out, "extent     {} m", text::point(bounds.size(), " x "))?;
    }
    let height = |x: f64, y: f64| match ground {
        Ground::Laid(pyramid) => pyramid.height_near(x, y),
        Ground::None | Ground::Unlaid | Ground::Unusable(_) => None,
    };
    if let Some(overview) = Overview::on(tree, &height) {
        writeln!(out, "try        {}", example(args, &overview))?;
    }
    Ok(())
}

/// A query that shows some thousand objects.
fn example(args: &InfoArgs, overview: &Overview) -> String {
    let far_dist = if overview.far_dist == RangeLod::default().far_dist() {
        String::new()
    } else {
        format!(" --far-dist {}", overview.far_dist)
    };
    format!(
        "citylod query {} --eye {} --target {}{far_dist}",
        text::word(&args.file.to_string_lossy()),
        text::point(overview.eye, ","),
        text::point(overview.target, ",")
    )
}

fn objects(tree: &LodTree, out: &mut impl Write) -> Result<()> {
    for index in 0..tree.object_count() {
        let Some(object) = tree.object(index) else {
            bail!("object {index} cannot be read");
        };
        let line = json!({
            "index": index,
            "id": object.id,
            "class": object.class,
            "level": object.level,
            "bounds": object.bounds.to_array(),
        });
        writeln!(out, "{line}")?;
    }
    Ok(())
}

fn nodes(tree: &LodTree, out: &mut impl Write) -> io::Result<()> {
    let a = tree.arrays();
    let inner = a.children.len().saturating_sub(1);
    for level in 0..tree.level_count() as usize {
        for node in a.level_nodes[level]..a.level_nodes[level + 1] {
            let at = node as usize;
            let children = if at < inner {
                a.children[at]..a.children[at + 1]
            } else {
                0..0
            };
            let line = json!({
                "node": node,
                "level": tree.level_count() as usize - 1 - level,
                "bounds": a.node_boxes[at],
                "objects": (a.own[at]..a.own[at + 1]).collect::<Vec<_>>(),
                "children": children.collect::<Vec<_>>(),
            });
            writeln!(out, "{line}")?;
        }
    }
    Ok(())
}
