//! A deterministic software rasteriser: which object is seen at which pixel, and how far away.
//!
//! view → [`Projector`] → [`IdBuffer`] of boxes and meshes → [`paint`]: sun, sky and ground. It
//! measures accuracy, decides occlusion and draws pictures.
//!
//! Knows nothing of LOD or HTTP.

mod clip;
mod coverage;
mod id_buffer;
mod light;
mod palette;
mod picture;
mod projector;
mod shadow;

pub use id_buffer::{IdBuffer, NONE};
pub use picture::{Picture, Solid, paint};
pub use projector::{LONGEST_SIDE, Projector, Ray};
