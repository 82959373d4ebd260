//! Boxes, views, frusta and distances, and the numeric contract they keep.
//!
//! Metres, z up, right-handed. Knows nothing of ids, files or levels of detail.

mod aabb;
mod clip;
mod filter;
mod frustum;
mod largest;
mod separating;
mod simd;
mod size;
mod view;
mod view_error;

pub use aabb::{Aabb, AabbError};
pub use clip::{ClipSpace, Form};
pub use filter::{
    ALL_LANES, Eight, EightDistances, EightRelations, Filter, Lanes, PlaneSet, Threshold,
};
pub use frustum::{Frustum, Plane, Relation};
pub use glam::{DMat4, DQuat, DVec2, DVec3};
pub use largest::LargestSize;
pub use separating::SeparatingAxes;
pub(crate) use simd::widest;
pub use simd::{Floats, Kernel, in_registers_of_four};
pub use size::SizeThreshold;
pub use view::{DepthRange, Orientation, PixelScale, Projection, View};
pub use view_error::ViewError;
