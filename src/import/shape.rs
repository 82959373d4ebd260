//! From the vertices of one object to what is kept of it.

use compact_str::CompactString;
use geo::convex_hull::quick_hull;
use geo::{Area, Coord, Polygon};
use serde_json::value::RawValue;

use crate::geom::{Aabb, DVec3};
use crate::scene::SceneObject;

/// Collects the vertices of one object; cleared and used again for the next.
#[derive(Debug, Default)]
pub(super) struct Shape {
    vertices: Vec<DVec3>,
    triangles: u64,
    not_finite: usize,
    base_unknown: bool,
    lift_m: f64,
    /// Room for the vertices seen from above.
    ground: Vec<Coord>,
}

impl Shape {
    pub(super) fn clear(&mut self) {
        self.vertices.clear();
        self.triangles = 0;
        self.not_finite = 0;
        self.base_unknown = false;
        self.lift_m = 0.0;
    }

    /// Nothing says how high it stands.
    pub(super) fn base_is_unknown(&mut self) {
        self.base_unknown = true;
    }

    /// It begins so far above its ground, m.
    pub(super) fn begins_above(&mut self, lift_m: f64) {
        self.lift_m = lift_m;
    }

    /// Adds a vertex in scene coordinates. One that is not finite is counted and left out.
    pub(super) fn vertex(&mut self, vertex: DVec3) {
        if vertex.is_finite() {
            self.vertices.push(vertex);
        } else {
            self.not_finite += 1;
        }
    }

    pub(super) fn triangles(&mut self, count: u64) {
        self.triangles = self.triangles.saturating_add(count);
    }

    /// How many vertices were left out because they are not finite.
    pub(super) fn not_finite(&self) -> usize {
        self.not_finite
    }

    /// The object with this geometry; `None` when there is not one finite vertex.
    pub(super) fn object(
        &mut self,
        id: CompactString,
        class: CompactString,
        attributes: Option<Box<RawValue>>,
    ) -> Option<SceneObject> {
        let bounds = Aabb::around(self.vertices.iter().copied());
        (!bounds.is_empty()).then(|| SceneObject {
            id,
            class,
            bounds,
            footprint_area: self.footprint_area(bounds.min()),
            triangles: u32::try_from(self.triangles).unwrap_or(u32::MAX),
            base_known: !self.base_unknown,
            lift_m: self.lift_m,
            attributes,
        })
    }

    /// Area of the convex hull on the ground, m². Taken relative to a corner of the bounds, so
    /// that large coordinates lose no digits.
    fn footprint_area(&mut self, corner: DVec3) -> f64 {
        self.ground.clear();
        self.ground.extend(self.vertices.iter().map(|v| Coord {
            x: v.x - corner.x,
            y: v.y - corner.y,
        }));
        // A wall has its lower and upper corners above each other: half the points are repeats,
        // and the hull costs more per point than sorting does.
        self.ground
            .sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        self.ground.dedup();
        Polygon::new(quick_hull(&mut self.ground), Vec::new()).unsigned_area()
    }
}
