//! The 3D R-tree with representatives in its nodes, packed for querying, saving and mapping.
//!
//! objects → rows → hierarchy ([`build`] for a whole city, [`CityTree`] after edits) → [`LodTree`]
//! → `.citylod` file. [`validate`] states every invariant.
//!
//! Knows nothing of views or HTTP.

mod arrays;
mod blocks;
mod bulk;
mod columns;
mod edit;
mod envelope;
mod error;
mod file;
mod hierarchy;
mod image;
mod lifts;
mod meta;
mod outward;
mod pack;
mod plan;
mod promotion;
mod radii;
mod rows;
mod texts;
mod tree;
mod unpack;
mod validate;

pub use arrays::Arrays;
pub use edit::CityTree;
pub use envelope::{Candidate, LodEnvelope};
pub use error::{BuildError, FileError};
pub use promotion::Promotion;
pub use tree::{LodTree, Object};
pub use validate::{Violation, validate};

use crate::scene::Scene;

/// Fewest children of a node made by insertion: Gong's m.
pub const MIN_FAN_OUT: usize = 4;
/// Most children of a node: Gong's M. With both, √4 < `dist_factor` < √9 keeps the object count
/// per view stable (Gong, section 2.1).
pub const MAX_FAN_OUT: usize = 9;

/// Builds the packed tree of a scene.
///
/// The objects may come in any order; the result is the same to the bit.
///
/// # Errors
/// [`BuildError`] when ids repeat ([`Scene::canonicalize`] makes them unique) or there are more
/// objects than 32 bits count.
pub fn build(scene: &Scene, promotion: Promotion) -> Result<LodTree, BuildError> {
    let objects = hierarchy::canonical_order(scene)?;
    let meta = meta::Meta::of(scene).with_classes(&objects);
    let rows = rows::Rows::new(&objects, &meta);
    let hierarchy = bulk::load(&rows, promotion);
    Ok(pack::pack(&rows, &hierarchy, promotion, meta))
}
