//! The ground under the city: one height field, one quadtree, the LOD criteria of four papers.
//!
//! Metres, z up, heights over a regular grid. Knows nothing of scenes, objects or trees.
//!
//! Sources: A: Lü et al., landslide-oriented terrain rendering. B: Wang and Zhu, dynamic LOD
//! quadtree. C: static LOD for transmission-line corridors. D: Wang and Luo, parallel terrain LOD.

mod block;
mod bound;
mod criterion;
mod cut;
mod fan;
mod field;
mod footing;
mod ground;
mod interpolate;
mod judge;
mod layout;
mod measure;
mod mesh;
mod nearest;
mod patch;
pub mod pyramid;
mod quadtree;
pub mod read;
mod refine;
mod select;
mod spare;
mod stitch;
mod store;
mod triangle;

pub use block::{Block, BlockError, NodeRecord};
pub use criterion::{Criterion, KnobError, Knobs, REST_MPS, Seen};
pub use cut::{Cut, State};
pub use fan::Facet;
pub use field::{FieldError, Grid, HeightField};
pub use footing::{Footing, footing, ground_under};
pub use ground::{Ground, GroundError};
pub use interpolate::Interpolation;
pub use layout::{Layout, Posts};
pub use mesh::Mesh;
pub use nearest::NearestGround;
pub use patch::Patch;
pub use quadtree::{Node, QUARTERS, Quarter, child_number, level_start};
pub use refine::Workers;
pub use select::{Detail, Selection, refine, select, select_within};
pub use store::{Keep, Reach, StoreCounts, TileStore};
pub use triangle::{Post, doubled_area, height_between, height_on};
