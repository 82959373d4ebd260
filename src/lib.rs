//! Which objects of a 3D city should be drawn for this camera, at what detail, and how wrong is
//! the answer?
//!
//! `citylod` carries out the R-tree LOD method of Gong et al., "An adaptive control method of LODs
//! for 3D scene based on R-tree index": all objects lie in the leaves of a 3D R-tree, every inner
//! node holds one representative of each child, and a view is answered by nodes near it in full
//! and by representatives far from it.
//!
//! # From a file to an answer
//!
//! ```
//! use citylod::geom::{DVec3, DepthRange, Orientation, Projection, View};
//! use citylod::index::{self, Promotion};
//! use citylod::lod::{RangeLod, Selection, retrieve};
//! use citylod::scene::{CityParams, generate};
//!
//! // Once: a scene from import::import or scene::generate, and its tree.
//! let scene = generate(&CityParams { objects: 2_000, seed: 1 });
//! let tree = index::build(&scene, Promotion::Tallest)?;
//!
//! // Each frame: a view, the knobs, and a selection whose memory is used again.
//! let view = View::new(
//!     DVec3::new(0.0, -400.0, 120.0),
//!     Orientation::LookAt { target: DVec3::ZERO, up: DVec3::Z },
//!     Projection::Perspective { fov_y_deg: 60.0 },
//!     DepthRange { near: 0.1, far: None },
//!     [1920, 1080],
//! )?;
//! let mut selection = Selection::default();
//! retrieve(&tree, &view, &RangeLod::default(), &mut selection);
//! for object in selection.objects() {
//!     let _ = (tree.id(object), tree.bounds_of(object));
//! }
//! assert!(selection.count() > 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Layers
//!
//! One direction: a module uses only modules above it, and only those in its row. A test walks the
//! sources and enforces the table.
//!
//! | module | is | may use | knows nothing of |
//! |---|---|---|---|
//! | [`geom`] | boxes, views, frusta, distances; the numeric contract | – | ids, files, LOD |
//! | [`file`](mod@file) | files are replaced whole or not at all | – | what is in them |
//! | [`scene`] | what a city is; a generator | geom | formats, trees, cameras |
//! | [`import`] | files → scene + warnings | geom, scene | trees, LOD, HTTP |
//! | [`index`] | tree with representatives, packed; its file | geom, file, scene | views, HTTP |
//! | [`terrain`] | height field, quadtree, criteria, meshes without cracks | geom, file | scene, index |
//! | [`control`] | `far_dist` from frame times: a pure step | – | trees, views, clocks |
//! | [`lod`] | the seven-step retrieval, error and budget modes | geom, index | files, HTTP |
//! | [`raster`] | id-buffer of boxes and meshes; pictures | geom, scene | LOD, HTTP |
//! | [`effects`] | motion, haze, occlusion, terrain: entered only where the scene declares them | geom, scene, lod, raster, terrain | trees, HTTP |
//! | [`frame`] | one frame: view and knobs → what to draw | all above | clocks, files, HTTP |
//! | [`experiment`] | the paper's questions → records | all above | the service |
//! | [`service`] | HTTP | all above but experiment | the command line |
//! | [`cli`] | what was typed → one call | all | – |
//!
//! # Laws
//!
//! - Nothing visible is lost: culling errs only towards drawing ([`geom::Frustum`]).
//! - The outcome does not depend on f32, on SIMD, on threads or on the order of the objects: f32
//!   only decides what it decides for certain ([`geom::Filter`]).
//! - No node is nearer to the eye than its parent, in floating point too, so an answer holds no
//!   object twice and leaves no hole ([`lod::retrieve`]).
//! - Ground is drawn once everywhere, without cracks, and no post is farther from where it is drawn
//!   than the answer says ([`terrain::select`]).
//! - Retrieval cannot fail, and reading a damaged file cannot break memory or loop for ever
//!   ([`index::LodTree`]).

pub mod cli;
pub mod control;
pub mod effects;
pub mod experiment;
pub mod file;
pub mod frame;
pub mod geom;
pub mod import;
pub mod index;
pub mod lod;
pub mod raster;
pub mod scene;
pub mod service;
pub mod terrain;
