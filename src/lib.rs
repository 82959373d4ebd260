//! Which objects of a 3D city should be drawn for this camera, at what detail, and how wrong is
//! the answer?

pub mod cli;
pub mod experiment;
pub mod geom;
pub mod import;
pub mod index;
pub mod lod;
pub mod scene;
pub mod service;
