//! What covers the ground, and what stands on it.

use crate::geom::Aabb;

/// `CityJSON` types of what lies on the ground: the box of such an object is as high as the ground
/// rises in it, and says little of how it looks.
const COVERS: [&str; 8] = [
    "LandUse",
    "PlantCover",
    "Road",
    "Railway",
    "TransportSquare",
    "WaterBody",
    "Waterway",
    "TINRelief",
];

/// What has no class of its own counts as lying where it is so many times wider than high.
const BROAD: f64 = 3.0;

/// Whether an object lies on the ground rather than stands on it, by its class: land, water and
/// traffic, and what is of no class of its own where it is broad.
pub fn is_cover(class: &str, bounds: &Aabb) -> bool {
    let class = class.trim_start_matches('+');
    let size = bounds.size();
    let is_broad = || size.x.max(size.y) > BROAD * size.z;
    COVERS.contains(&class) || (class == "GenericCityObject" && is_broad())
}

/// Whether a class is one of buildings and their parts.
pub fn is_building(class: &str) -> bool {
    class.trim_start_matches('+').starts_with("Building")
}
