//! Compiles the crate again when the viewer was built, so that the binary has the latest.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // A folder that is missing would count as changed each time: then the one above it is watched.
    let built = std::path::Path::new("viewer/dist").exists();
    let watched = if built { "viewer/dist" } else { "viewer" };
    println!("cargo::rerun-if-changed={watched}");
}
