//! The ground under the city: one height field, one quadtree, the LOD criteria of four papers.
//!
//! Metres, z up, heights over a regular grid. Knows nothing of scenes, objects or trees.
//!
//! Sources: A: Lü et al., landslide-oriented terrain rendering. B: Wang and Zhu, dynamic LOD
//! quadtree. C: static LOD for transmission-line corridors. D: Wang and Luo, parallel terrain LOD.

mod field;
pub mod read;

pub use field::{FieldError, Grid, HeightField};
