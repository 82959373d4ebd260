//! City files → one [`Scene`] and the warnings that came up on the way.
//!
//! Each format is one module of the same shape: `read(&Source, &Options, &mut Collector)`. It hands
//! over objects one by one and never sees another file's. An unusable file is an
//! [`ImportError`]; bad geometry in a usable file is a [`Warning`] that names the object.
//!
//! Knows nothing of trees, levels of detail or HTTP.

mod cityjson;
mod classes;
mod collector;
mod crs;
mod error;
mod extents;
mod geojson;
mod globe;
mod gltf;
mod json;
mod named_height;
mod obj;
mod placing;
mod sense;
mod shape;
mod source;
mod tally;
mod tilt;
mod utm;

use std::path::PathBuf;

use crate::scene::Scene;

pub use classes::Classes;
pub use collector::Warning;
pub use error::{ImportError, Place};
pub use tally::{Fate, Tally};

use collector::Collector;
use source::{Format, Source};

/// Which axis of a format that does not say so points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Up {
    /// Computer graphics habit: (x, y, z) becomes (x, −z, y).
    Y,
    /// GIS habit: taken as it is.
    Z,
}

/// What the caller may choose about an import.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Up axis of OBJ (default z) and glTF (default y, as its specification says).
    pub up: Option<Up>,
    /// `CityJSON` level of detail to take, e.g. `1.2`; default: the highest each object has.
    pub lod: Option<String>,
    /// `GeoJSON` property that holds the height in metres; default: the usual names.
    pub height: Option<String>,
    /// Which classes of objects are taken over; default: all.
    pub classes: Classes,
    /// System of the files that do not state one, e.g. `EPSG:28992`; degrees are projected to UTM.
    pub crs: Option<String>,
}

/// Called with the bytes read so far (as they lie on disk) and their total.
pub type Progress<'a> = dyn Fn(u64, u64) + 'a;

/// A scene and what could not be taken over as it was.
#[derive(Debug)]
pub struct Imported {
    /// Everything that has geometry and is of a class that was asked for, in file order. Where ids repeat they are made unique, each
    /// with a warning, and the objects put in the order of their ids.
    pub scene: Scene,
    /// One for each object or feature that was changed or left out, in file order.
    pub warnings: Vec<Warning>,
    /// How many were left out or kept flat, by the reason; the warnings name most of them.
    pub tallies: Vec<Tally>,
    /// Options that were given and apply to none of the files.
    pub unused: Vec<Unused>,
}

/// An option that applies to none of the files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unused {
    /// [`Options::up`] without glTF and OBJ.
    Up,
    /// [`Options::lod`] without `CityJSON`.
    Lod,
    /// [`Options::height`] without `GeoJSON`.
    Height,
}

impl Options {
    /// Those given that apply to none of these formats.
    fn unused(&self, formats: &[Format]) -> Vec<Unused> {
        let has = |format| formats.contains(&format);
        let solid = has(Format::Gltf) || has(Format::Obj);
        [
            (self.up.is_some() && !solid, Unused::Up),
            (self.lod.is_some() && !has(Format::CityJson), Unused::Lod),
            (
                self.height.is_some() && !has(Format::GeoJson),
                Unused::Height,
            ),
        ]
        .into_iter()
        .filter_map(|(is_unused, option)| is_unused.then_some(option))
        .collect()
    }
}

/// Reads all `files` into one scene.
///
/// # Errors
/// [`ImportError`], naming the file and the place in it, when a file cannot be read at all or the
/// files do not share a coordinate reference system, or cannot, or state another than the caller
/// does, or where there is no object of a
/// class, or no feature with a height, that is named. No partial scene is returned.
pub fn import(
    files: &[PathBuf],
    options: &Options,
    progress: &Progress,
) -> Result<Imported, ImportError> {
    let mut collector = Collector::new(options);
    let total = files
        .iter()
        .map(|f| f.metadata().map_or(0, |m| m.len()))
        .sum();
    let mut done = 0;
    let mut formats = Vec::new();
    for path in files {
        let source = Source::open(path)?;
        let size = source.size_on_disk();
        let report = |read: u64| progress(done + read.min(size), total);
        collector.begin(&source)?;
        formats.push(source.format());
        match source.format() {
            Format::Gltf => gltf::read(&source, options, &mut collector, &report),
            Format::Obj => obj::read(&source, options, &mut collector, &report),
            Format::CityJson => cityjson::read(&source, options, &mut collector, &report),
            Format::GeoJson => geojson::read(&source, options, &mut collector, &report),
        }?;
        done += size;
        progress(done, total);
    }
    collector.named_height.check(options.height.as_deref())?;
    let mut imported = collector.finish()?;
    imported.unused = options.unused(&formats);
    Ok(imported)
}
