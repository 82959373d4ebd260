//! Ground that is not level, as it is painted.

use std::collections::BTreeMap;

use crate::geom::DVec3;

/// Triangles that face up, with the slope of the surface at each corner: shading is smooth across
/// them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Relief {
    pub(super) corners: Vec<DVec3>,
    pub(super) triangles: Vec<[u32; 3]>,
    normals: Vec<DVec3>,
}

impl Relief {
    /// Triangles between corners, m, each with the numbers of its three. Corners at one place need
    /// not be one.
    pub fn new(corners: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Self {
        let place = |corner: DVec3| [corner.x.to_bits(), corner.y.to_bits()];
        let mut sums: BTreeMap<[u64; 2], DVec3> = BTreeMap::new();
        for triangle in &triangles {
            let [a, b, c] = triangle.map(|corner| corners[corner as usize]);
            // Twice the area long: large triangles count for more.
            let across = (b - a).cross(c - a);
            for corner in [a, b, c] {
                *sums.entry(place(corner)).or_default() += across;
            }
        }
        let normal = |corner: &DVec3| {
            let sum = sums.get(&place(*corner)).copied().unwrap_or_default();
            sum.normalize_or(DVec3::Z)
        };
        Self {
            normals: corners.iter().map(normal).collect(),
            corners,
            triangles,
        }
    }

    /// The direction that a triangle faces at a point of it: between those of its corners.
    pub(super) fn normal(&self, triangle: usize, point: DVec3) -> DVec3 {
        let numbers = self.triangles[triangle].map(|corner| corner as usize);
        let [a, b, c] = numbers.map(|corner| self.corners[corner].truncate());
        let p = point.truncate();
        let area = (b - a).perp_dot(c - a);
        let weights = [
            (b - p).perp_dot(c - p),
            (c - p).perp_dot(a - p),
            (a - p).perp_dot(b - p),
        ];
        let sum: DVec3 = numbers
            .iter()
            .zip(weights)
            .map(|(&corner, weight)| self.normals[corner] * (weight / area))
            .sum();
        sum.normalize_or(DVec3::Z)
    }
}
