//! The ground on disk: a pyramid of tiles, each found by arithmetic and read by itself.
//!
//! [`write()`] cuts a raster of any size with one block in memory; [`Pyramid`] opens the file in
//! constant time and reads tiles, records and blocks out of it. The format is in `file.rs`.
//!
//! Source: A, section 1.1 (pyramid of tiles, linear quadtree); C, section 2.1 (square blocks).

mod contents;
mod error;
mod file;
mod head;
mod identity;
mod open;
mod write;

pub use contents::Tile;
pub use error::PyramidError;
pub use file::Tiling;
pub use open::{Pyramid, beside};
pub(crate) use write::prepared;
pub use write::write;
