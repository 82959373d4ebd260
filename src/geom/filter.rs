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
pub type Eight = [[f32; 8]; 6];

/// A set of eight boxes, bit i for box i.
pub type Lanes = u8;

/// A set of planes of a frustum, bit i for plane i.
pub type PlaneSet = u8;

#[derive(Debug, Clone, Copy, Default)]
struct FilterPlane {
    normal: [f32x8; 3],
    offset: f32x8,
    slack: f32x8,
    /// Whether the corner farthest along the normal is the upper one on each axis.
    upper: [bool; 3],
}

impl FilterPlane {
    /// Signed distances, scaled by the normal's length, of the farthest corners along the normal.
    #[inline]
    fn farthest(&self, boxes: &Eight) -> f32x8 {
        self.values(boxes, self.upper)
    }

    /// The same of the opposite corners.
    #[inline]
    fn nearest(&self, boxes: &Eight) -> f32x8 {
        self.values(boxes, self.upper.map(|upper| !upper))
    }

    #[inline]
    fn values(&self, boxes: &Eight, upper: [bool; 3]) -> f32x8 {
        (0..3).fold(self.offset, |sum, axis| {
            let corner = boxes[axis + 3 * usize::from(upper[axis])];
            sum + f32x8::from(corner) * self.normal[axis]
        })
    }
}

/// A frustum and an eye as seen by the boxes of one tree.
#[derive(Debug, Clone)]
pub struct Filter {
    planes: [FilterPlane; Frustum::MAX_PLANES],
    count: usize,
    eye: [f32; 3],
    distance_error: f64,
}

/// How eight boxes lie to some planes of a frustum.
#[derive(Debug, Clone, Copy)]
pub struct EightRelations {
    /// Certainly outside.
    pub outside: Lanes,
    /// Certainly inside all the planes looked at.
    pub inside: Lanes,
    /// Certainly inside each plane.
    inside_plane: [Lanes; Frustum::MAX_PLANES],
    looked_at: PlaneSet,
}

impl EightRelations {
    /// The planes that box `lane` is not known to be inside of.
    #[inline]
    pub fn open_planes(&self, lane: u32) -> PlaneSet {
        planes(self.looked_at).fold(0, |open, plane| {
            open | ((!self.inside_plane[plane] >> lane) & 1) << plane
        })
    }
}

/// Squared distances from the eye to a point of each of eight boxes, m².
#[derive(Debug, Clone, Copy)]
pub struct EightDistances {
    squared: f32x8,
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
        let mut planes = [FilterPlane::default(); Frustum::MAX_PLANES];
        for (filter, plane) in planes.iter_mut().zip(frustum.planes()) {
            let offset = plane.offset - plane.normal.dot(eye);
            let cancelled = plane.normal.abs().dot(eye.abs()) + plane.offset.abs();
            let magnitude = plane.normal.abs().dot(reach) + offset.abs();
            let slack = SLACK * magnitude
                + 8.0 * f64::EPSILON * cancelled
                + plane.offset_error
                + f64::from(f32::MIN_POSITIVE);
            let upper = plane.normal.cmpge(DVec3::ZERO);
            *filter = FilterPlane {
                normal: plane.normal.as_vec3().to_array().map(f32x8::splat),
                offset: f32x8::splat(offset as f32),
                slack: f32x8::splat((slack as f32).next_up()),
                upper: std::array::from_fn(|axis| upper.test(axis)),
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
        let mut inside = Lanes::MAX;
        let mut inside_plane = [Lanes::MAX; Frustum::MAX_PLANES];
        for index in planes(set) {
            let plane = &self.planes[index];
            outside |= lanes(plane.farthest(boxes).simd_lt(-plane.slack));
            inside_plane[index] = lanes(plane.nearest(boxes).simd_gt(plane.slack));
            inside &= inside_plane[index];
        }
        EightRelations {
            outside,
            inside,
            inside_plane,
            looked_at: set,
        }
    }

    /// Boxes certainly outside one of the planes in `set`, and boxes certainly not.
    #[inline]
    pub fn outside_or_touching(&self, boxes: &Eight, set: PlaneSet) -> (Lanes, Lanes) {
        let mut outside = f32x8::ZERO;
        let mut touching = f32x8::ZERO.simd_eq(f32x8::ZERO);
        for index in planes(set) {
            let plane = &self.planes[index];
            let farthest = plane.farthest(boxes);
            outside |= farthest.simd_lt(-plane.slack);
            touching &= farthest.simd_gt(plane.slack);
        }
        (lanes(outside), lanes(touching))
    }

    /// Distances to the nearest points of the boxes.
    #[inline]
    pub fn distances(&self, boxes: &Eight) -> EightDistances {
        let mut nearest = f32x8::ZERO;
        for axis in 0..3 {
            let eye = f32x8::splat(self.eye[axis]);
            let low = f32x8::from(boxes[axis]) - eye;
            let high = eye - f32x8::from(boxes[axis + 3]);
            let near = low.fast_max(high).fast_max(f32x8::ZERO);
            nearest += near * near;
        }
        EightDistances { squared: nearest }
    }

    /// Distances to the farthest corners of the boxes.
    #[inline]
    pub fn farthest(&self, boxes: &Eight) -> EightDistances {
        let mut farthest = f32x8::ZERO;
        for axis in 0..3 {
            let eye = f32x8::splat(self.eye[axis]);
            let low = eye - f32x8::from(boxes[axis]);
            let high = f32x8::from(boxes[axis + 3]) - eye;
            let far = low.fast_max(high);
            farthest += far * far;
        }
        EightDistances { squared: farthest }
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
        let distance = distances.squared.sqrt() * f32x8::splat(1.0 - 2.0 * DISTANCE_SLACK as f32)
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
            let size = f32x8::from(boxes[axis + 3]) - f32x8::from(boxes[axis]);
            squared += size * size;
        }
        (squared.sqrt() * f32x8::splat(0.5 * (1.0 + 8.0 * f32::EPSILON))).to_array()
    }
}

impl EightDistances {
    /// Boxes certainly nearer than the threshold.
    #[inline]
    pub fn nearer(&self, threshold: &Threshold) -> Lanes {
        lanes(self.squared.simd_lt(f32x8::splat(threshold.below)))
    }

    /// Boxes certainly not nearer than the threshold.
    #[inline]
    pub fn not_nearer(&self, threshold: &Threshold) -> Lanes {
        lanes(self.squared.simd_gt(f32x8::splat(threshold.above)))
    }
}

/// The planes of a set, by number.
#[inline]
fn planes(mut set: PlaneSet) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let plane = set.trailing_zeros() as usize;
        set &= set.wrapping_sub(1);
        (plane < Frustum::MAX_PLANES).then_some(plane)
    })
}

#[inline]
fn lanes(mask: f32x8) -> Lanes {
    mask.to_bitmask() as Lanes
}
