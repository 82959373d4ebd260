//! The one integration test binary: a module per subject.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test that panics is a test that fails, and a skipped one says so"
)]

/// `CityJSON`: what each fixture and each real city comes to, and what is said of broken ones.
mod import_cityjson;
/// `GeoJSON`: the same, and that memory does not follow the file.
mod import_geojson;
/// Files that a test writes, damages and imports.
mod written;
