use serde::{Deserialize, Serialize};

use crate::geom::Aabb;
use crate::scene::SceneObject;

/// Which object of a child stands for it in its parent (Gong, section 2.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Promotion {
    /// The one with the largest extent along z: keeps skylines.
    #[default]
    Tallest,
    /// The one with the largest footprint on the ground: keeps plans.
    Footprint,
    /// The one with the largest half diagonal: makes the error bound tightest.
    Largest,
}

impl Promotion {
    /// What is compared: the higher, the better.
    pub fn score(self, object: &SceneObject) -> f64 {
        self.score_of(&object.bounds, object.footprint_area)
    }

    pub(super) fn score_of(self, bounds: &Aabb, footprint_area: f64) -> f64 {
        match self {
            Self::Tallest => bounds.size().z,
            Self::Footprint => footprint_area,
            Self::Largest => bounds.radius(),
        }
    }
}
