//! Terrain: the ground for the view, beside the objects.
//!
//! The criterion of a paper says which parts of the ground are drawn finer, tuned so that it splits
//! about what errs by the declared number of pixels; what errs by more for certain is split too, so
//! that the number holds until triangles run out ([`terrain::select_within`]). Pixels are counted as
//! for sizes: a length times the pixels per radian in the middle of the picture, by its distance.

use std::path::{Path, PathBuf};

use crate::geom::{DVec3, PixelScale, View};
use crate::scene;
use crate::terrain::pyramid::{Pyramid, PyramidError, beside};
use crate::terrain::{self, Criterion, Detail, Ground, Patch, Workers};

/// The ground of a city: its file, and all of it in memory.
#[derive(Debug)]
pub struct Land {
    pyramid: Pyramid,
    ground: Ground,
}

/// Why there is no ground to draw.
#[derive(Debug, thiserror::Error)]
pub enum LandError {
    /// It was never laid, or has gone.
    #[error(
        "{}: there is no such file, but the city declares terrain; lay its ground with citylod import ELEVATION --into {}",
        ground.display(),
        city.display()
    )]
    Missing {
        /// The city.
        city: PathBuf,
        /// Where its ground should be.
        ground: PathBuf,
    },
    /// It lies there, but under another city or of another time.
    #[error(
        "{}: is not the ground that was laid under {}; lay it again with citylod import ELEVATION --into {}",
        ground.display(),
        city.display(),
        city.display()
    )]
    Another {
        /// The city.
        city: PathBuf,
        /// The file beside it.
        ground: PathBuf,
    },
    /// It cannot be read.
    #[error(transparent)]
    Pyramid(#[from] PyramidError),
}

impl Land {
    /// Opens the ground beside a city that declares it, and checks every byte.
    ///
    /// # Errors
    /// [`LandError`] where it is missing, damaged, or not the one that was laid under this city.
    pub fn of_city(city: &Path, declared: &scene::Terrain) -> Result<Self, LandError> {
        Ok(Self::new(Self::open(city, declared)?)?)
    }

    /// The file of the ground beside a city, checked through but not read into memory.
    ///
    /// # Errors
    /// As [`Land::of_city`].
    pub fn open(city: &Path, declared: &scene::Terrain) -> Result<Pyramid, LandError> {
        let path = beside(city);
        let (of, ground) = (|| city.to_owned(), path.clone());
        if !path.exists() {
            return Err(LandError::Missing { city: of(), ground });
        }
        let pyramid = Pyramid::open_verified(&path)?;
        if declared.ground != Some(pyramid.checksum()) {
            return Err(LandError::Another { city: of(), ground });
        }
        Ok(pyramid)
    }

    /// All of a pyramid, read into memory.
    ///
    /// # Errors
    /// [`PyramidError`] for damaged tiles.
    pub fn new(pyramid: Pyramid) -> Result<Self, PyramidError> {
        let ground = pyramid.ground()?;
        Ok(Self { pyramid, ground })
    }

    /// Its file.
    pub fn pyramid(&self) -> &Pyramid {
        &self.pyramid
    }

    /// Its blocks.
    pub fn ground(&self) -> &Ground {
        &self.ground
    }
}

/// What is drawn of the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drawn {
    /// Tiles that it takes posts of.
    pub patches: u32,
    /// How many triangles.
    pub triangles: usize,
    /// No post of the ground is drawn farther above or below its place than this on the screen,
    /// pixels: an error e counts as e times the pixels per radian, by the distance to the nearest
    /// point of the box it is in, as sizes of objects do. Off the axis of a wide view, pixels are
    /// wider apart than that.
    pub error_px: f64,
}

/// The ground for one view after another.
#[derive(Debug, Default)]
pub struct Surface {
    selection: Option<terrain::Selection>,
    patches: Vec<Patch>,
}

impl Surface {
    /// Works out what to draw of the ground, `slowdown` ≥ 1 times coarser than declared.
    pub fn choose(
        &mut self,
        declared: &scene::Terrain,
        land: &Land,
        view: &View,
        slowdown: f64,
    ) -> Drawn {
        let max_error_px = declared.max_error_px * slowdown;
        let detail = detail(declared, view, max_error_px);
        let Land { pyramid, ground } = land;
        let chosen = terrain::select_within(ground, view, &detail, max_error_px, Workers::One);
        // Declared values that cannot be were refused where they came in.
        self.selection = chosen.ok();
        let selection = self.selection.as_ref();
        let tile_levels = pyramid.tiling().tile_levels();
        self.patches = selection.map_or_else(Vec::new, |s| s.patches(ground, tile_levels));
        Drawn {
            patches: self.patches.len() as u32,
            triangles: selection.map_or(0, terrain::Selection::triangles),
            error_px: selection.map_or(0.0, terrain::Selection::error_px),
        }
    }

    /// Whether all is drawn that was asked for: triangles did not run out, so that the bound
    /// that was asked for holds.
    pub fn is_whole(&self) -> bool {
        self.selection.as_ref().is_some_and(|s| s.share() >= 1.0)
    }

    /// The tiles to draw, and which triangles between their posts.
    pub fn patches(&self) -> &[Patch] {
        &self.patches
    }

    /// The triangles to draw, by corners, m.
    pub fn mesh(&self, land: &Land) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let Some(selection) = &self.selection else {
            return Default::default();
        };
        let mesh = selection.mesh(&land.ground);
        let corners = (0..mesh.posts.len() as u32).map(|v| mesh.position(&land.ground, v));
        (corners.collect(), mesh.triangles)
    }
}

/// The criterion, tuned to split what is larger than `max_error_px` on the screen.
fn detail(declared: &scene::Terrain, view: &View, max_error_px: f64) -> Detail {
    /// Of its distance, the knobs that criteria start from split what errs by more than the part
    /// that this is the whole of.
    const USUAL: f64 = 1024.0;
    /// Parallel projections know no distance: what errs decides alone.
    const LEAST: f64 = 1e-9;
    let criterion = match declared.criterion {
        scene::Criterion::Roughness => Criterion::Roughness,
        scene::Criterion::Error => Criterion::Error,
        scene::Criterion::Motion => Criterion::Motion,
        scene::Criterion::Vertex => Criterion::Vertex,
    };
    let share = match view.pixels() {
        PixelScale::PerRadian(px) => (px / max_error_px / USUAL).clamp(LEAST, LEAST.recip()),
        PixelScale::PerMetre(_) => LEAST,
    };
    let usual = Detail::of(criterion);
    Detail {
        knobs: criterion.share(&usual.knobs, share),
        max_triangles: Some(declared.max_triangles as usize),
        ..usual
    }
}
