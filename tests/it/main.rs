//! The one integration test binary: a module per subject.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test fails by panicking and says on its output what it skipped"
)]
#![allow(missing_docs, reason = "tests are not an interface")]

/// The command line as a user meets it: what it writes, prints, refuses and exits with.
mod command;
/// The controller keeps what it promises, over a thousand seeds a promise, and any numbers.
mod control;
/// A folder to run the command in, and what a run came to.
mod desk;
/// What one answer has that another has not, against sets.
mod difference;
/// A city that is edited keeps its laws and gives the same answers.
mod edit;
/// Motion, haze and occlusion: declared, switched off, and what they leave.
mod effects;
/// Elevation files that a test writes.
mod elevation_files;
/// The experiments print, write and state what was asked for.
mod experiment;
/// The experiments on the ground state what they measure.
mod experiment_terrain;
/// Broken `CityJSON` and `GeoJSON`: what is said of it and where, and that nothing panics.
mod import_broken_json;
/// `CityJSON`: what each fixture and each real city comes to.
mod import_cityjson;
/// Classes of objects that are chosen or left out.
mod import_classes;
/// The system of a city: told by the caller, known by its code, of no use, contradicted.
mod import_crs;
/// `GeoJSON`: the same, and that memory does not follow the file.
mod import_geojson;
/// `GeoJSON`: where a file lies that does not say so, or says so late.
mod import_geojson_place;
/// glTF and GLB become the objects, bounds and attributes that the file states.
mod import_gltf;
/// A broken glTF file is refused with the place at fault, whatever the bytes, and never panics.
mod import_gltf_malformed;
/// OBJ becomes the objects and bounds that the file states; broken files name line and column.
mod import_obj;
/// Cities whose sizes and places cannot be: degrees taken as metres, strays, houses of kilometres.
mod import_sense;
/// Several files at once: whether they can be one city, and what is told once and not of each object.
mod import_several;
/// What goes into a tree comes back out of its file, whatever it is.
mod index_content;
/// `.citylod` files: the same bytes every time, whole or not at all, and safe when damaged.
mod index_file;
/// A ridge with houses on either side.
mod land;
/// Error mode and budget mode against brute force, and the bound in every mode.
mod modes;
/// Views and boxes at the edge of what f32 and f64 can tell.
mod numerics;
/// One city at the origin, in a national grid and earth-centred gives the same ids.
mod offsets;
/// The paper's seven steps, transcribed set by set.
mod oracle;
/// Answers over HTTP against a program in another language.
mod other_language;
/// Pictures: what `render` writes, refuses, and shows where.
mod picture;
/// The id-buffer: its laws, and every pixel against a ray cast through its centre.
mod raster;
/// Real cities, from import to answer.
mod real_cities;
/// Retrieval against the transcription and against brute force.
mod retrieval;
/// `serve` reads its files again, starts again after a kill, and logs what it refuses.
mod serve_again;
/// Limits given to `serve` as flags.
mod serve_limits;
/// `serve` as a process.
mod served;
/// The HTTP service: answers, refusals, limits, description.
mod service;
/// Culling, "inside" and distances against exact arithmetic, and the oracle against what is plain.
mod stability;
/// The view that `info` suggests shows what a person wants to see, in awkward cities too.
mod suggested;
/// Random scenes and cameras.
mod support;
/// The ground: blocks, criteria, meshes without cracks, heights between posts.
mod terrain;
/// Broken elevation files: what is said of them and where, and that nothing panics.
mod terrain_broken;
/// Elevation laid under a city, as a user meets it.
mod terrain_import;
/// The pyramid of tiles: what goes into the file comes back out of it, or is refused.
mod terrain_pyramid;
/// Elevation files: every format against rasterio, and what is said of broken ones.
mod terrain_read;
/// Elevation that cannot be laid, or not as it is asked for: the right reason, and the way out.
mod terrain_reasons;
/// Objects whose base is not known, or all, set on the ground that is laid.
mod terrain_set_down;
/// Stores of tiles against plain lists.
mod terrain_store;
/// Ground in use: declared when it is laid, drawn, refused when it is another's.
mod terrain_use;
/// The sources keep the layer table and the house rules.
mod tidy;
/// What the command says of numbers, files, pipes and effects that cannot be.
mod usage;
/// Files that a test writes, damages and imports.
mod written;
