//! What a scene calls for beyond its objects, one file each. Entered only where the scene declares
//! the effect ([`crate::scene::Effects`]) and the frame does not switch it off.

pub mod haze;
pub mod motion;
pub mod occlusion;
pub mod terrain;
