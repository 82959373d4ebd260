//! What a city is: objects with bounds, and the effects it declares.
//!
//! Knows nothing of file formats, trees or cameras.

<<<<<<< HEAD
mod canonical;
mod object;

pub use canonical::Renamed;
=======
mod generate;
mod object;

pub use generate::{CityParams, generate};
>>>>>>> house
pub use object::{Scene, SceneObject};
