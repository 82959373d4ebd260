//! The ground: its quadtree, its meshes and what they promise.

/// What a mesh must be, in whole numbers, sharing no code with what made it.
mod examine;
/// Holes, single posts, cliffs, far coordinates, an eye under the ground.
mod hard_ground;
/// Heights between posts.
mod heights;
/// The nearest known ground against a look at every post.
mod nearest;
/// Patches drawn from tiles against meshes; the bound of the error on the screen.
pub mod patches;
/// Real and made-up ground, and eyes about it.
mod places;
/// Records of nodes against brute force over posts.
mod records;
/// Over a thousand random views with each criterion: no cracks, all covered, errors as certified.
mod views;
