//! The one integration test binary: a module per subject.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test that panics is a test that fails, and a skipped one says so"
)]

/// Broken `CityJSON` and `GeoJSON`: what is said of it and where, and that nothing panics.
mod import_broken_json;
/// `CityJSON`: what each fixture and each real city comes to.
mod import_cityjson;
/// `GeoJSON`: the same, and that memory does not follow the file.
mod import_geojson;
/// Files that a test writes, damages and imports.
mod written;
