use compact_str::CompactString;
use serde_json::value::RawValue;

use super::Effects;
use crate::geom::Aabb;

/// One thing of the city that is drawn or left out as a whole: a building, a tree, a bridge.
#[derive(Debug, Clone)]
pub struct SceneObject {
    /// Name, unique in its scene once imported; any script, any length.
    pub id: CompactString,
    /// Kind of thing, e.g. `Building`; the `CityJSON` type where the source has one.
    pub class: CompactString,
    /// Bounds in scene coordinates.
    pub bounds: Aabb,
    /// Area of the convex hull of its vertices on the ground, m².
    pub footprint_area: f64,
    /// Triangles it takes to draw.
    pub triangles: u32,
    /// Whether the source says how high it stands. A footprint without a height of its ground
    /// does not: it stands at 0 until ground is laid under it.
    pub base_known: bool,
    /// How far above its ground it begins, m, as the source says of parts such as a roof; else 0,
    /// which is also what a city keeps of anything else but a length.
    pub lift_m: f64,
    /// What else the source says of it: a JSON object.
    pub attributes: Option<Box<RawValue>>,
}

impl SceneObject {
    /// Extent along z, m.
    pub fn height(&self) -> f64 {
        self.bounds.size().z
    }
}

/// A city as imported or generated: what an index is built from.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// Coordinate reference system as the source names it, e.g. `EPSG:6677`.
    pub crs: Option<String>,
    /// What a frame of it calls for beyond its objects.
    pub effects: Effects,
    /// The objects, in any order; their order does not matter to what is built from them.
    pub objects: Vec<SceneObject>,
}
