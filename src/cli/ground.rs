//! The ground of a city: elevation into the pyramid beside it, and what is said of it.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use serde_json::json;

use super::args::{ImportArgs, citylod_name};
use super::effects::declared;
use super::numbers::system;
use super::say::say;
use super::{progress, text};
use crate::effects::terrain::{Land, LandError};
use crate::file::finish_both;
use crate::index::LodTree;
use crate::scene::{Effects, Terrain};
use crate::terrain::pyramid::{Pyramid, Tiling, beside, prepared};
use crate::terrain::read::{Encoding, Options, read};
use crate::terrain::{Footing, HeightField, footing};

/// Up to this far above the highest or below the lowest ground under it, an object stands on it:
/// what elevation of 10 to 30 m posts leaves open.
const TOLERANCE_M: f64 = 2.0;

/// What concerns elevation.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub(super) struct GroundArgs {
    /// City to lay the ground of: written beside it, with the ending .terrain, and declared in it
    #[arg(long, value_name = "CITY", value_parser = citylod_name,
          conflicts_with_all = ["output", "up", "lod", "height"])]
    pub into: Option<PathBuf>,
    /// Coordinate system of the elevation, such as EPSG:25832; goes before what the file says
    #[arg(long, conflicts_with = "output", value_parser = system)]
    pub crs: Option<String>,
    /// How a PNG codes heights [default: told by its reds]
    #[arg(long, conflicts_with = "output")]
    pub encoding: Option<EncodingArg>,
    /// Outer edges of a PNG: west,south,east,north
    #[arg(long, conflicts_with = "output", allow_hyphen_values = true, value_parser = bounds)]
    pub bounds: Option<[f64; 4]>,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub(super) enum EncodingArg {
    TerrainRgb,
    Terrarium,
}

fn bounds(text: &str) -> Result<[f64; 4], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    let four = numbers.ok().and_then(|numbers| numbers.try_into().ok());
    four.ok_or_else(|| "expected west,south,east,north, such as 500,900,1500,1900".into())
}

/// Reads elevation, brings it into the city's system and writes it beside the city.
pub(super) fn import(args: &ImportArgs, city: &Path) -> Result<()> {
    let [file] = args.files.as_slice() else {
        bail!(
            "--into takes one elevation file; join several first, for example with gdalbuildvrt and gdal_translate"
        );
    };
    let tree = LodTree::open_verified(city)?;
    let options = Options {
        crs: args.ground.crs.clone(),
        encoding: args.ground.encoding.map(|encoding| match encoding {
            EncodingArg::TerrainRgb => Encoding::TerrainRgb,
            EncodingArg::Terrarium => Encoding::Terrarium,
        }),
        bounds: args.ground.bounds,
    };
    let spinner = progress::spinner();
    spinner.set_message("reading elevation");
    let raster = read(file, &options)?.to_metres(file, tree.crs())?;
    let output = beside(city);
    let field = &raster.field;
    spinner.set_message("looking what stands on it");
    let standing = Standing::of(&tree, field, args.warnings);
    if standing.without == u64::from(tree.object_count()) && standing.without > 0 {
        bail!(
            "{}: lies under nothing of the city: it reaches from {} to {}, the city from {} to {}; {} is left as it was",
            file.display(),
            corner(field, false),
            corner(field, true),
            text::point(tree.bounds().min(), " "),
            text::point(tree.bounds().max(), " "),
            output.display()
        );
    }
    let laid = prepared(
        &output,
        &Tiling::new(*field.grid()),
        raster.crs.as_deref(),
        |column, row| field.height(column, row),
        &|done, blocks| spinner.set_message(format!("writing block {done} of {blocks}")),
    )?;
    let pyramid = Pyramid::open(laid.path())?;
    let before = match &args.effects {
        Some(file) => declared(Some(file))?,
        None => *tree.effects(),
    };
    let declaring = declare(&tree, before, &pyramid).prepared(city);
    declaring
        .and_then(|declaring| finish_both(laid, declaring))
        .with_context(|| format!("{}: cannot lay its ground", city.display()))?;
    spinner.finish_and_clear();
    match (tree.crs(), &raster.crs) {
        (None, Some(crs)) => {
            say!(
                "warning: the ground lies in {crs}, the city names no system; they are taken for the same"
            );
        }
        (Some(crs), None) => {
            say!(
                "warning: the city lies in {crs}, the elevation names no system; they are taken for the same"
            );
        }
        _ => {}
    }
    for line in standing.lines(&tree, field) {
        say!("{line}");
    }
    say!("{}: {}", output.display(), line(&pyramid));
    say!(
        "{}: declares terrain: query, render and serve draw this ground; --without terrain leaves it out",
        city.display()
    );
    Ok(())
}

/// The city with these effects and this ground declared.
fn declare(tree: &LodTree, declared: Effects, pyramid: &Pyramid) -> LodTree {
    tree.declaring(Effects {
        terrain: Some(Terrain {
            ground: Some(pyramid.checksum()),
            ..declared.terrain.unwrap_or_default()
        }),
        ..declared
    })
}

/// How the objects of a city stand on ground.
#[derive(Debug, Default)]
struct Standing {
    /// Of those whose base does not meet it, the first ones.
    named: Vec<String>,
    above: u64,
    below: u64,
    without: u64,
}

impl Standing {
    fn of(tree: &LodTree, field: &HeightField, most: usize) -> Self {
        let mut standing = Self::default();
        for object in (0..tree.object_count()).filter_map(|number| tree.object(number)) {
            let gap = match footing(field, &object.bounds, TOLERANCE_M) {
                Footing::Meets => continue,
                Footing::NoGround => {
                    standing.without += 1;
                    continue;
                }
                Footing::Above(gap) => {
                    standing.above += 1;
                    format!("{} m above", text::metres(gap))
                }
                Footing::Below(gap) => {
                    standing.below += 1;
                    format!("{} m below", text::metres(gap))
                }
            };
            if standing.named.len() < most {
                standing.named.push(format!(
                    "warning: {}: its base is {gap} the ground under it",
                    object.id
                ));
            }
        }
        standing
    }

    /// A warning for each that is named, and what they come to.
    fn lines(self, tree: &LodTree, field: &HeightField) -> Vec<String> {
        let Self {
            named: mut lines,
            above,
            below,
            without,
        } = self;
        let hidden = above + below - lines.len() as u64;
        if hidden > 0 {
            let all = above + below;
            let more = text::counted(hidden, "more object");
            lines.push(format!("and {more}; see them with --warnings {all}"));
        }
        let of = text::counted(tree.object_count().into(), "object");
        if above + below > 0 {
            lines.push(format!(
                "warning: of {of}, {} stand more than {TOLERANCE_M} m above the ground under them and {} more than that below; ground and city may count heights from different levels",
                text::grouped(above),
                text::grouped(below)
            ));
        }
        if without > 0 {
            lines.push(format!(
                "warning: of {of}, {} have no ground under them; the ground reaches from {} to {}",
                text::grouped(without),
                corner(field, false),
                corner(field, true)
            ));
        }
        lines
    }
}

/// The south-west or north-east post.
fn corner(field: &HeightField, far: bool) -> String {
    let grid = field.grid();
    let (column, row) = if far {
        (grid.columns() - 1, grid.rows() - 1)
    } else {
        (0, 0)
    };
    format!(
        "{} {}",
        text::metres(grid.x(column)),
        text::metres(grid.y(row))
    )
}

/// The ground of a city that declares terrain.
pub(super) fn land(city: &Path, tree: &LodTree) -> Result<Option<Land>, LandError> {
    let declared = tree.effects().terrain.as_ref();
    declared
        .map(|terrain| Land::of_city(city, terrain))
        .transpose()
}

/// A warning where a city is put beside ground that was laid under another.
pub(super) fn warn_of_other(city: &Path) {
    let ground = beside(city);
    if ground.exists() {
        let (ground, city) = (ground.display(), city.display());
        say!(
            "warning: {ground}: was laid under what {city} was before, and is not used: lay the ground anew with citylod import ELEVATION --into {city}, or remove it"
        );
    }
}

/// What is beside a city, where it declares terrain and its ground was laid.
pub(super) fn of_city(city: &Path, tree: &LodTree) -> Result<Option<Pyramid>, LandError> {
    let declared = tree.effects().terrain.as_ref();
    let laid = declared.filter(|terrain| terrain.ground.is_some());
    laid.map(|terrain| Land::open(city, terrain)).transpose()
}

/// What a pyramid holds, in one line.
pub(super) fn line(pyramid: &Pyramid) -> String {
    let tiling = pyramid.tiling();
    let grid = tiling.layout().grid();
    let heights = pyramid.height_range().map_or_else(
        || "no height known".to_owned(),
        |[low, high]| {
            format!(
                "{} to {} m high",
                text::metres(low.into()),
                text::metres(high.into())
            )
        },
    );
    format!(
        "{} x {} posts {} x {} m apart, {heights}, {} on {}{}",
        text::grouped(grid.columns().into()),
        text::grouped(grid.rows().into()),
        text::metres(grid.spacing().x),
        text::metres(grid.spacing().y),
        text::counted(tiling.tile_count(), "tile"),
        text::counted((tiling.finest() + 1).into(), "level"),
        pyramid
            .crs()
            .map(|crs| format!(", {crs}"))
            .unwrap_or_default(),
    )
}

/// The same for programs.
pub(super) fn summary(pyramid: &Pyramid) -> serde_json::Value {
    let tiling = pyramid.tiling();
    let grid = tiling.layout().grid();
    json!({
        "bytes": pyramid.byte_len(),
        "crs": pyramid.crs(),
        "posts": [grid.columns(), grid.rows()],
        "origin_m": grid.origin().to_array(),
        "spacing_m": grid.spacing().to_array(),
        "heights_m": pyramid.height_range(),
        "tiles": tiling.tile_count(),
        "tile_levels": tiling.finest() + 1,
    })
}
