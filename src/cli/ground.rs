//! The ground of a city: elevation into the pyramid beside it, and what is said of it.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use serde_json::json;

use super::args::{ImportArgs, citylod_name, extension};
use super::effects::declared;
use super::numbers::system;
use super::say::say;
use super::standing::{Standing, no_ground, set_down};
use super::{progress, text};
use crate::effects::terrain::{Land, LandError};
use crate::file::{NotReplaced, finish_both};
use crate::index::LodTree;
use crate::scene::{Effects, Terrain};
use crate::terrain::pyramid::{Pyramid, Tiling, beside, prepared};
use crate::terrain::read::{Encoding, Options, read};

/// What concerns elevation.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub(super) struct GroundArgs {
    /// City to lay the ground of: written beside it, with the ending .terrain, and declared in it
    #[arg(long, value_name = "CITY", value_parser = citylod_name,
          conflicts_with_all = ["output", "up", "lod", "height", "promote", "class", "except_class"])]
    pub into: Option<PathBuf>,
    /// Set all objects on the ground, not only those whose source does not say how high they stand
    #[arg(long, conflicts_with = "output")]
    pub drape: bool,
    /// Coordinate system of files that state none, such as EPSG:28992; degrees, such as EPSG:4326,
    /// are projected to UTM. With --into, of the elevation: goes before what the file says
    #[arg(long, value_parser = system)]
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
    warn_of_unused(&args.ground, file);
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
    let mut done = set_down(&tree, field, args.ground.drape)?;
    let tree = done.city.take().unwrap_or(tree);
    let standing = Standing::of(&tree, field, args.warnings)?;
    if standing.without() == u64::from(tree.object_count()) && standing.without() > 0 {
        bail!(
            "{}: {}; {} is left as it was",
            file.display(),
            no_ground(&tree, field),
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
    let declaring = declaring.map_err(|source| NotReplaced {
        path: city.to_owned(),
        source,
    })?;
    finish_both(laid, declaring)?;
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
    if done.set > 0 {
        say!(
            "{}: {} set on the lowest ground under their boxes",
            city.display(),
            text::counted(done.set, "object")
        );
    }
    say!(
        "{}: declares terrain: query, render and serve draw this ground; --without terrain leaves it out",
        city.display()
    );
    Ok(())
}

/// A warning for each option of PNG that another format does not use.
fn warn_of_unused(args: &GroundArgs, file: &Path) {
    if extension(file).eq_ignore_ascii_case("png") {
        return;
    }
    for (is_given, option, what) in [
        (args.bounds.is_some(), "--bounds", "where it lies"),
        (args.encoding.is_some(), "--encoding", "its heights"),
    ] {
        if is_given {
            let file = file.display();
            say!(
                "warning: {file}: {option} is for PNG and not used; other formats tell {what} themselves"
            );
        }
    }
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
