//! A deterministic software rasteriser: which object is seen at which pixel, and how far away.
//!
//! view → [`Projector`] → [`IdBuffer`] of boxes and meshes → [`paint`]: sun, sky and ground. It
//! measures accuracy, decides occlusion and draws pictures.
//!
//! Written here rather than taken from `euc` 0.5, the best fit among the crates there are: that
//! one works in f32, does not clip what reaches behind the eye, gives pixels on a shared edge to
//! both triangles, and took 1.5 to 4 times as long for the same 20,000 boxes, of whose pixels 99.5
//! to 100 % agreed.
//!
//! Knows nothing of LOD or HTTP.

mod clip;
mod coverage;
mod id_buffer;
mod light;
mod palette;
mod picture;
mod projector;
mod relief;
mod shadow;

pub use id_buffer::{IdBuffer, NONE};
pub use palette::LEVEL_COLOURS;
pub use picture::{Picture, Solid, paint, paint_on};
pub use projector::{LONGEST_SIDE, Projector, Ray};
pub use relief::Relief;
