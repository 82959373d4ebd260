//! What a city is: objects with bounds, and the effects it declares.
//!
//! Knows nothing of file formats, trees or cameras.

mod canonical;
mod cover;
mod effects;
mod generate;
mod object;

pub use canonical::Renamed;
pub use cover::{is_building, is_cover};
pub use effects::{Criterion, Effects, EffectsError, Haze, Motion, Occlusion, Terrain};
pub use generate::{CityParams, generate};
pub use object::{Scene, SceneObject};
