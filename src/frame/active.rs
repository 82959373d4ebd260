//! What a frame takes beside its knobs, and what its effects did.

use std::time::Duration;

use crate::scene;

/// How objects at the border of the frustum are told from those outside.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Culling {
    /// By the planes of the frustum: keeps some boxes near its corners that do not meet it.
    #[default]
    Fast,
    /// By separating axes too ([`SeparatingAxes`](crate::geom::SeparatingAxes)): keeps only boxes that meet it.
    Exact,
}

/// What one frame takes beside its knobs: of the effects that the scene declares, the ones not
/// switched off, and how it culls.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Active {
    /// How it culls.
    pub culling: Culling,
    /// Detail falls with the camera's speed, m/s.
    pub motion: Option<(scene::Motion, f64)>,
    /// Nothing beyond the visibility range.
    pub haze: Option<scene::Haze>,
    /// Nothing that is hidden.
    pub occlusion: Option<scene::Occlusion>,
}

impl Active {
    /// All that a scene declares, for a camera that moves at `speed_mps`, ≥ 0.
    pub fn all(declared: &scene::Effects, speed_mps: f64) -> Self {
        Self {
            motion: declared.motion.map(|motion| (motion, speed_mps)),
            haze: declared.haze,
            occlusion: declared.occlusion,
            ..Self::default()
        }
    }
}

/// What an effect did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ran<T> {
    /// What came of it.
    pub result: T,
    /// What it took.
    pub took: Duration,
}

/// What the effects of one frame did; `None` did not run.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Effects {
    /// How many times less detail there is.
    pub motion: Option<Ran<f64>>,
    /// How many selected objects it took out.
    pub haze: Option<Ran<u32>>,
    /// How many selected objects it took out.
    pub occlusion: Option<Ran<u32>>,
}
