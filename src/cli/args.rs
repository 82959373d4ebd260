//! The command line, as typed and checked.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand, ValueEnum};

use super::ground::GroundArgs;
use super::numbers::{angle, metres};
use super::serve::ServeArgs;
use crate::experiment::Experiment;
use crate::geom::DVec3;
use crate::import::Up;
use crate::index::Promotion;

/// Which objects of a 3D city to draw for a camera, and at what detail.
#[derive(Debug, Parser)]
#[command(name = "citylod", version, about, propagate_version = true)]
pub(super) struct Args {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Turn city files (glTF, GLB, OBJ, CityJSON, CityJSONSeq, GeoJSON; also gzipped) into a
    /// .citylod, or elevation (GeoTIFF, ASCII grid, HGT, PNG) into the ground of one
    Import(ImportArgs),
    /// Make a city up: streets, blocks, a downtown, suburbs, parks with trees
    Generate(GenerateArgs),
    /// Tell what a .citylod holds
    Info(InfoArgs),
    /// Find the objects a camera calls for
    Query(QueryArgs),
    /// Answer over HTTP; without a file, for the built-in demo city
    Serve(ServeArgs),
    /// Draw a picture of the objects a camera calls for
    Render(RenderArgs),
    /// Measure, plot and picture
    Experiment(ExperimentArgs),
}

#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub(super) struct ImportArgs {
    /// Files of one city; formats may differ. With --into, one elevation file
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Where to write the city: a name that ends in .citylod
    #[arg(short, long, value_parser = citylod_name, required_unless_present = "into")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub ground: GroundArgs,
    /// Axis that points up [default: y for glTF, z for OBJ]
    #[arg(long)]
    pub up: Option<UpArg>,
    /// What makes an object stand for its neighbours
    #[arg(long, default_value = "tallest")]
    pub promote: PromoteArg,
    /// CityJSON level of detail to take, such as 1.2 [default: the highest of each object]
    #[arg(long)]
    pub lod: Option<String>,
    /// GeoJSON property with the height in metres [default: height, measuredHeight, …]
    #[arg(long)]
    pub height: Option<String>,
    /// Take only objects of this class, such as Building; may be given more than once
    #[arg(long, value_name = "NAME", conflicts_with = "except_class")]
    pub class: Vec<String>,
    /// Leave out objects of this class, such as Road; may be given more than once
    #[arg(long, value_name = "NAME")]
    pub except_class: Vec<String>,
    /// JSON file that declares what a frame of the city calls for: motion, haze, occlusion, and
    /// with --into, in place of what it declared, terrain too
    #[arg(long, value_name = "FILE")]
    pub effects: Option<PathBuf>,
    /// Warnings to show; the rest are counted
    #[arg(long, default_value_t = 20)]
    pub warnings: usize,
}

#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub(super) struct GenerateArgs {
    /// How many objects
    #[arg(long, default_value_t = 23_951, value_parser = clap::value_parser!(u32).range(..=100_000_000))]
    pub objects: u32,
    /// The same seed gives the same city
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Where to write it: .citylod or .glb
    #[arg(short, long, value_parser = citylod_or_glb_name)]
    pub output: PathBuf,
    /// What makes an object stand for its neighbours; .citylod only [default: tallest]
    #[arg(long)]
    pub promote: Option<PromoteArg>,
    /// JSON file that declares motion, haze, occlusion; .citylod only
    #[arg(long, value_name = "FILE")]
    pub effects: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
#[allow(
    clippy::struct_excessive_bools,
    reason = "each is a flag of the command line"
)]
pub(super) struct InfoArgs {
    /// The city
    pub file: PathBuf,
    /// As JSON
    #[arg(long)]
    pub json: bool,
    /// Check every invariant of the tree; fails when one is broken
    #[arg(long)]
    pub check: bool,
    /// One JSON object a line for each object
    #[arg(long, conflicts_with_all = ["nodes", "json"])]
    pub objects: bool,
    /// One JSON object a line for each node
    #[arg(long, conflicts_with = "json")]
    pub nodes: bool,
}

#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub(super) struct SelectArgs {
    /// The city
    pub file: PathBuf,
    /// Where the camera stands: x,y,z
    #[arg(long, allow_hyphen_values = true)]
    pub eye: PointArg,
    /// Where it looks at: x,y,z
    #[arg(long, allow_hyphen_values = true)]
    pub target: PointArg,
    /// Full vertical angle of view, degrees
    #[arg(long, default_value_t = 60.0, value_parser = angle)]
    pub fov: f64,
    /// Picture size, pixels
    #[arg(long, default_value = "1920x1080")]
    pub size: SizeArg,
    /// Farthest distance of the finest level, m; `inf` for everything in view
    #[arg(long, default_value_t = 500.0, value_parser = metres)]
    pub far_dist: f64,
    /// Ratio of the far distances of neighbouring levels
    #[arg(long, default_value_t = 2.5)]
    pub dist_factor: f64,
    /// Levels that have a range
    #[arg(long, default_value_t = 4)]
    pub levels: u32,
    /// Past the last level: show or hide
    #[arg(long, default_value = "show")]
    pub beyond: BeyondArg,
    /// Instead of by distance: all objects of at least this size on the screen, pixels
    #[arg(long, conflicts_with_all = ["far_dist", "dist_factor", "levels", "beyond", "max_objects"])]
    pub max_error_px: Option<f64>,
    /// Instead of by distance: so many objects, the largest on the screen
    #[arg(long, conflicts_with_all = ["far_dist", "dist_factor", "levels", "beyond"])]
    pub max_objects: Option<u32>,
    /// How objects at the border of the view are culled: by its planes, or exactly
    #[arg(long, default_value = "fast")]
    pub culling: CullingArg,
    /// Speed of the camera, m/s, where the city declares motion
    #[arg(long)]
    pub speed: Option<f64>,
    /// Switch off an effect, should the city declare it; may be given more than once
    #[arg(long, value_name = "EFFECT")]
    pub without: Vec<EffectArg>,
}

#[derive(Debug, clap::Args)]
pub(super) struct QueryArgs {
    #[command(flatten)]
    pub select: SelectArgs,
    /// Work it out so many times in the same memory, and time the last
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub repeat: u32,
    /// As JSON, like the HTTP service
    #[arg(long)]
    pub json: bool,
    /// With the pixels of each object, where the city declares occlusion
    #[arg(long, requires = "json")]
    pub visible_pixels: bool,
    /// With the patches of the ground, where the city declares terrain
    #[arg(long, requires = "json")]
    pub patches: bool,
}

#[derive(Debug, clap::Args)]
pub(super) struct RenderArgs {
    #[command(flatten)]
    pub select: SelectArgs,
    /// Where to write the picture: a name that ends in .png
    #[arg(short, long, value_parser = png_name)]
    pub output: PathBuf,
    /// What colours tell: the class of an object or its level
    #[arg(long, default_value = "class")]
    pub tint: TintArg,
}

/// The kind of file that the name says.
pub(super) fn extension(path: &Path) -> &str {
    path.extension()
        .and_then(|e| e.to_str())
        .unwrap_or_default()
}

pub(super) fn citylod_name(text: &str) -> Result<PathBuf, String> {
    match extension(Path::new(text)) {
        "citylod" => Ok(text.into()),
        _ => Err("the name must end in .citylod".into()),
    }
}

fn citylod_or_glb_name(text: &str) -> Result<PathBuf, String> {
    match extension(Path::new(text)) {
        "citylod" | "glb" => Ok(text.into()),
        _ => Err("the name must end in .citylod or .glb".into()),
    }
}

fn png_name(text: &str) -> Result<PathBuf, String> {
    match extension(Path::new(text)) {
        "png" => Ok(text.into()),
        _ => Err("the name must end in .png".into()),
    }
}

/// A fault in what was typed that shows only after parsing; the run ends with 2.
pub(super) fn misuse(verb: &str, reason: impl std::fmt::Display) -> clap::Error {
    let mut command = Args::command();
    command.build();
    match command.find_subcommand_mut(verb) {
        Some(verb) => verb.error(ErrorKind::ValueValidation, reason),
        None => command.error(ErrorKind::ValueValidation, reason),
    }
}

#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub(super) struct ExperimentArgs {
    /// Which one
    #[arg(value_parser = experiment_names())]
    pub name: String,
    /// Also write csv, json, plots and pictures into this folder
    #[arg(long)]
    pub out: Option<PathBuf>,
    /// One JSON object instead of a table
    #[arg(long)]
    pub json: bool,
    /// A city to look at beside the generated ones; may be given more than once
    #[arg(long)]
    pub city: Vec<PathBuf>,
    /// Largest generated city, objects; of ground, posts [default: 10000000]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1_000..=100_000_000))]
    pub largest: Option<u32>,
}

/// The experiments with what they ask, and all of them.
fn experiment_names() -> PossibleValuesParser {
    let each = Experiment::ALL.map(|e| PossibleValue::new(e.name()).help(e.question()));
    let all = PossibleValue::new("all").help("One after another, and a page that shows them");
    each.into_iter().chain([all]).into()
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum UpArg {
    Y,
    Z,
}

impl From<UpArg> for Up {
    fn from(arg: UpArg) -> Self {
        match arg {
            UpArg::Y => Self::Y,
            UpArg::Z => Self::Z,
        }
    }
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum CullingArg {
    Fast,
    Exact,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum EffectArg {
    Motion,
    Haze,
    Occlusion,
    Terrain,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum BeyondArg {
    Show,
    Hide,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum TintArg {
    Class,
    Level,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum PromoteArg {
    Tallest,
    Footprint,
    Largest,
}

impl From<PromoteArg> for Promotion {
    fn from(arg: PromoteArg) -> Self {
        match arg {
            PromoteArg::Tallest => Self::Tallest,
            PromoteArg::Footprint => Self::Footprint,
            PromoteArg::Largest => Self::Largest,
        }
    }
}

/// Nothing on earth lies farther from the origin of any system.
const FARTHEST_M: f64 = 1e9;

/// `x,y,z`
#[derive(Debug, Clone, Copy)]
pub(super) struct PointArg(pub DVec3);

impl FromStr for PointArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Result<Vec<f64>, _> = text.split(',').map(|n| n.trim().parse()).collect();
        let Ok([x, y, z]) = numbers.as_deref() else {
            return Err("expected three numbers with commas, such as 120,-35.5,1.7".into());
        };
        let point = DVec3::new(*x, *y, *z);
        if point.abs().cmple(DVec3::splat(FARTHEST_M)).all() {
            Ok(Self(point))
        } else {
            Err("must lie within a million kilometres of the origin, in metres".into())
        }
    }
}

/// `WIDTHxHEIGHT`
#[derive(Debug, Clone, Copy)]
pub(super) struct SizeArg(pub [u32; 2]);

impl FromStr for SizeArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        text.split_once(['x', 'X'])
            .and_then(|(w, h)| Some(Self([w.parse().ok()?, h.parse().ok()?])))
            .ok_or_else(|| "expected width x height in pixels, such as 1920x1080".into())
    }
}
