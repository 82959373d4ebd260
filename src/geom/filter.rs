//! Eight boxes at a time, in f32: answers "certainly", "certainly not", or leaves it open.
//!
//! Boxes are given as f32 lanes relative to an f64 origin, rounded outward. What is left open is
//! decided by the caller on the exact box in f64, so that the outcome does not depend on f32 at
//! all. Portable SIMD without fused operations: the same bits with and without AVX.
//!
//! # Error bound
//! u = 2⁻²⁴. With X the largest coordinate of any box relative to the origin, a term n·x carries
//! 1 u from rounding n, 4 u from rounding x outward (an ulp is 2 u, both of the subtraction from
//! the origin and of the conversion), 1 u from the product and at most 3 u from the sums; w
//! carries 1 u and 3 u. Together at most 9 u of Σ|nᵢ|·Xᵢ + |w|; [`SLACK`] is 16 u. The absolute
//! term covers underflow. Where anything overflows, comparisons come out false and the question
//! stays open.

use wide::{f32x8, i32x8};

use super::{Aabb, DVec3, Frustum};

/// Relative slack of plane tests.
const SLACK: f64 = 16.0 / (1 << 24) as f64;
/// Relative slack of distances: 2 u a difference, 1 u a square, 2 u the sums, halved by the root.
const DISTANCE_SLACK: f64 = 8.0 / (1 << 24) as f64;
/// Coordinates beyond this would overflow when squared; everything is then left open.
const LARGEST: f64 = 1e18;

/// Lanes of eight boxes: min x, y, z, max x, y, z.
pub type Eight<'a> = [&'a [f32; 8]; 6];

/// A set of eight boxes, bit i for box i.
pub type Lanes = u8;

/// A set of planes of a frustum, bit i for plane i.
pub type PlaneSet = u8;

#[derive(Debug, Clone, Copy)]
struct FilterPlane {
    normal: [f32; 3],
    offset: f32,
    slack: f32,
}

/// A frustum and an eye as seen by the boxes of one tree.
#[derive(Debug, Clone)]
pub struct Filter {
    planes: [FilterPlane; Frustum::MAX_PLANES],
    count: usize,
    eye: [f32; 3],
    distance_error: f64,
}

/// How eight boxes lie to a frustum.
#[derive(Debug, Clone, Copy)]
pub struct EightRelations {
    /// Certainly outside.
    pub outside: Lanes,
    /// Certainly not outside.
    pub touching: Lanes,
    /// Certainly inside all planes that were looked at.
    pub inside: Lanes,
    /// Certainly inside each plane.
    inside_plane: [Lanes; Frustum::MAX_PLANES],
    looked_at: PlaneSet,
}

impl EightRelations {
    /// The planes that box `lane` is not known to be inside of.
    pub fn open_planes(&self, lane: u32) -> PlaneSet {
        let mut open = 0;
        for plane in 0..Frustum::MAX_PLANES {
            open |= (!self.inside_plane[plane] >> lane & 1) << plane;
        }
        open & self.looked_at
    }
}

/// Squared distances from the eye to eight boxes, m².
#[derive(Debug, Clone, Copy)]
pub struct EightDistances {
    /// To the nearest point, 0 inside.
    nearest: f32x8,
}

/// A distance that boxes are compared with, in both certain forms.
#[derive(Debug, Clone, Copy)]
pub struct Threshold {
    /// The distance itself, m; may be infinite.
    pub distance: f64,
    /// Squared distances below are certainly nearer.
    below: f32,
    /// Squared distances above are certainly not nearer.
    above: f32,
}

impl Filter {
    /// For boxes within `extent` (scene coordinates), given relative to `origin`.
    pub fn new(frustum: &Frustum, origin: DVec3, extent: &Aabb) -> Self {
        let reach = (extent.max() - origin)
            .abs()
            .max((extent.min() - origin).abs());
        let eye = frustum.eye() - origin;
        let mut planes = [FilterPlane {
            normal: [0.0; 3],
            offset: 0.0,
            slack: 0.0,
        }; Frustum::MAX_PLANES];
        for (filter, plane) in planes.iter_mut().zip(frustum.planes()) {
            let offset = plane.offset - plane.normal.dot(eye);
            let cancelled = plane.normal.abs().dot(eye.abs()) + plane.offset.abs();
            let magnitude = plane.normal.abs().dot(reach) + offset.abs();
            let slack = SLACK * magnitude
                + 8.0 * f64::EPSILON * cancelled
                + plane.offset_error
                + f64::from(f32::MIN_POSITIVE);
            *filter = FilterPlane {
                normal: plane.normal.as_vec3().to_array(),
                offset: offset as f32,
                slack: (slack as f32).next_up(),
            };
        }
        let largest = reach.max(eye.abs()).max_element();
        let distance_error = if largest < LARGEST {
            // Outward rounding of the box, rounding of the eye, and underflow; √3 < 2.
            let per_axis = SLACK * largest + f64::from(f32::MIN_POSITIVE);
            2.0 * per_axis
        } else {
            f64::INFINITY
        };
        Self {
            planes,
            count: frustum.planes().len(),
            eye: eye.as_vec3().to_array(),
            distance_error,
        }
    }

    /// All planes of the frustum.
    pub fn all_planes(&self) -> PlaneSet {
        ((1_u16 << self.count) - 1) as PlaneSet
    }

    /// How the boxes lie to the planes in `set`.
    #[inline]
    pub fn relations(&self, boxes: &Eight, set: PlaneSet) -> EightRelations {
        let mut outside = 0;
        let mut touching = Lanes::MAX;
        let mut inside = Lanes::MAX;
        let mut inside_plane = [Lanes::MAX; Frustum::MAX_PLANES];
        let mut rest = set;
        while rest != 0 {
            let index = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let plane = &self.planes[index];
            let slack = f32x8::splat(plane.slack);
            let offset = f32x8::splat(plane.offset);
            let mut farthest = offset;
            let mut nearest = offset;
            for axis in 0..3 {
                let n = f32x8::splat(plane.normal[axis]);
                let low = f32x8::from(*boxes[axis]) * n;
                let high = f32x8::from(*boxes[axis + 3]) * n;
                // The corner farther along the normal, whichever way it points.
                let positive = plane.normal[axis] >= 0.0;
                farthest += if positive { high } else { low };
                nearest += if positive { low } else { high };
            }
            outside |= lanes(farthest.simd_lt(-slack));
            touching &= lanes(farthest.simd_gt(slack));
            inside_plane[index] = lanes(nearest.simd_gt(slack));
            inside &= inside_plane[index];
        }
        EightRelations {
            outside,
            touching,
            inside,
            inside_plane,
            looked_at: set,
        }
    }

    /// Distances to the nearest points of the boxes.
    #[inline]
    pub fn distances(&self, boxes: &Eight) -> EightDistances {
        let mut nearest = f32x8::ZERO;
        for axis in 0..3 {
            let eye = f32x8::splat(self.eye[axis]);
            let low = f32x8::from(*boxes[axis]) - eye;
            let high = eye - f32x8::from(*boxes[axis + 3]);
            let near = low.fast_max(high).fast_max(f32x8::ZERO);
            nearest += near * near;
        }
        EightDistances { nearest }
    }

    /// The boxes of which every point is certainly nearer than `threshold`.
    #[inline]
    pub fn wholly_nearer(&self, boxes: &Eight, threshold: &Threshold) -> Lanes {
        if threshold.distance == f64::INFINITY {
            return Lanes::MAX;
        }
        let mut farthest = f32x8::ZERO;
        for axis in 0..3 {
            let eye = f32x8::splat(self.eye[axis]);
            let low = eye - f32x8::from(*boxes[axis]);
            let high = f32x8::from(*boxes[axis + 3]) - eye;
            let far = low.fast_max(high);
            farthest += far * far;
        }
        lanes(farthest.simd_lt(f32x8::splat(threshold.below)))
    }

    /// A distance to compare with, m ≥ 0.
    pub fn threshold(&self, distance: f64) -> Threshold {
        let near = (distance - self.distance_error) * (1.0 - DISTANCE_SLACK);
        let far = (distance + self.distance_error) * (1.0 + DISTANCE_SLACK);
        Threshold {
            distance,
            below: if near > 0.0 {
                ((near * near) as f32).next_down()
            } else {
                -1.0
            },
            above: ((far * far) as f32).next_up(),
        }
    }

    /// For each box in `set`, at least radius/distance, infinite around the eye; 0 for the rest.
    #[inline]
    pub fn largest_angles(
        &self,
        radii: &[f32; 8],
        distances: &EightDistances,
        set: Lanes,
    ) -> f32x8 {
        let distance = distances.nearest.sqrt() * f32x8::splat(1.0 - 2.0 * DISTANCE_SLACK as f32)
            - f32x8::splat(self.distance_error as f32);
        let angle = Self::of_set(radii, set) / distance.max(f32x8::ZERO);
        // 0 / 0 is NaN and gives way to 0: nothing hidden, however near.
        (angle * f32x8::splat(1.0 + 4.0 * f32::EPSILON)).max(f32x8::ZERO)
    }

    /// The values of the boxes in `set`, 0 elsewhere.
    #[inline]
    pub fn of_set(values: &[f32; 8], set: Lanes) -> f32x8 {
        const BITS: [i32; 8] = [1, 2, 4, 8, 16, 32, 64, 128];
        let bits = i32x8::from(BITS);
        let mask = (i32x8::splat(i32::from(set)) & bits).simd_eq(bits);
        bytemuck::cast::<i32x8, f32x8>(mask) & f32x8::from(*values)
    }

    /// At least half the diagonal of each box.
    pub fn radii(boxes: &Eight) -> [f32; 8] {
        let mut squared = f32x8::ZERO;
        for axis in 0..3 {
            let size = f32x8::from(*boxes[axis + 3]) - f32x8::from(*boxes[axis]);
            squared += size * size;
        }
        (squared.sqrt() * f32x8::splat(0.5 * (1.0 + 8.0 * f32::EPSILON))).to_array()
    }
}

impl EightDistances {
    /// Boxes certainly nearer than the threshold.
    #[inline]
    pub fn nearer(&self, threshold: &Threshold) -> Lanes {
        lanes(self.nearest.simd_lt(f32x8::splat(threshold.below)))
    }

    /// Boxes certainly not nearer than the threshold.
    #[inline]
    pub fn not_nearer(&self, threshold: &Threshold) -> Lanes {
        lanes(self.nearest.simd_gt(f32x8::splat(threshold.above)))
    }
}

#[inline]
fn lanes(mask: f32x8) -> Lanes {
    mask.to_bitmask() as Lanes
}
