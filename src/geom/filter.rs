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
//! carries 1 u and 3 u, and one sum more where both forms are asked for. Together at most 10 u of
//! Σ|nᵢ|·Xᵢ + |w|; [`SLACK`] is 16 u. The slack is part of w, so the sign alone answers; 0 means
//! that the exact value is beyond 0 by what is left of the slack. The planes' own uncertainty
//! ([`Frustum`]) and an absolute term for underflow are added; normals are about 1, so that none
//! of their components that matter is denormal in f32. Where plane tests could overflow, every one
//! of them is left open.

use wide::f32x8;

use super::simd::Floats;
use super::{Aabb, DVec3, Frustum};

/// Relative slack of plane tests.
const SLACK: f64 = 16.0 / (1 << 24) as f64;
/// Relative slack of distances: 2 u a difference, 1 u a square, 2 u the sums, halved by the root.
pub(super) const DISTANCE_SLACK: f64 = 8.0 / (1 << 24) as f64;
/// Coordinates beyond this would overflow when squared; everything is then left open.
const LARGEST: f64 = 1e18;
/// Terms of a plane beyond this could overflow when summed.
const LARGEST_TERM: f64 = 1e36;

/// Lanes of eight boxes: min x, y, z, max x, y, z.
pub type Eight = [f32x8; 6];

/// A set of eight boxes, bit i for box i; no other bits.
pub type Lanes = u32;

/// All eight.
pub const ALL_LANES: Lanes = 0xff;

/// A set of planes of a frustum, bit i for plane i.
pub type PlaneSet = u32;

/// Where a corner's coordinate lies in [`Eight`].
#[derive(Debug, Clone, Copy, Default)]
#[repr(usize)]
enum Lane {
    #[default]
    MinX,
    MinY,
    MinZ,
    MaxX,
    MaxY,
    MaxZ,
}

#[derive(Debug, Clone, Copy, Default)]
struct FilterPlane {
    normal: [f32x8; 3],
    /// Offset plus slack: sums from here are negative only for points certainly outside.
    outer: f32x8,
    /// Offset less slack: sums from here are negative unless a point is certainly inside.
    inner: f32x8,
    /// From the one to the other.
    band: f32x8,
    /// The corner farthest along the normal, and the opposite one.
    farthest: [Lane; 3],
    nearest: [Lane; 3],
}

impl FilterPlane {
    /// Negative for boxes certainly outside: `outer` and the farthest corners along the normal.
    #[inline(always)]
    fn farthest<F: Floats>(&self, boxes: &Eight) -> F {
        self.sum(&self.outer, boxes, self.farthest)
    }

    /// Negative for boxes not certainly inside: `inner` and the opposite corners.
    #[inline(always)]
    fn nearest<F: Floats>(&self, boxes: &Eight) -> F {
        self.sum(&self.inner, boxes, self.nearest)
    }

    #[inline(always)]
    fn sum<F: Floats>(&self, offset: &f32x8, boxes: &Eight, corner: [Lane; 3]) -> F {
        let term = |axis: usize| F::of(&boxes[corner[axis] as usize]) * F::of(&self.normal[axis]);
        F::of(offset) + term(0) + term(1) + term(2)
    }
}

/// A frustum and an eye as seen by the boxes of one tree.
#[derive(Debug, Clone)]
pub struct Filter {
    planes: [FilterPlane; Frustum::MAX_PLANES],
    count: usize,
    /// Whether no plane test of a box in the extent overflows.
    bounded: bool,
    eye: [f32; 3],
    pub(super) distance_error: f64,
}

/// How eight boxes lie to some planes of a frustum.
#[derive(Debug, Clone, Copy)]
pub struct EightRelations {
    /// Certainly outside.
    pub outside: Lanes,
    /// Certainly inside all the planes looked at.
    pub inside: Lanes,
    /// For each box, one byte: the planes it is not known to be inside of.
    open: u64,
}

impl EightRelations {
    #[cold]
    fn unknown(set: PlaneSet) -> Self {
        Self {
            outside: 0,
            inside: if set == 0 { ALL_LANES } else { 0 },
            open: u64::from(set) * 0x0101_0101_0101_0101,
        }
    }

    /// The planes that box `lane` is not known to be inside of.
    #[inline]
    pub fn open_planes(&self, lane: u32) -> PlaneSet {
        (self.open >> (8 * lane)) as PlaneSet & 0xff
    }
}

/// Squared distances from the eye to a point of each of eight boxes, m².
#[derive(Debug, Clone, Copy)]
pub struct EightDistances<F = f32x8> {
    pub(super) squared: F,
}

/// A distance that boxes are compared with, in both certain forms.
#[derive(Debug, Clone, Copy)]
pub struct Threshold {
    /// The distance itself, m; may be infinite.
    pub distance: f64,
    /// Squared distances below are certainly nearer.
    below: f32x8,
    /// Squared distances above are certainly not nearer.
    above: f32x8,
}

impl Filter {
    /// For boxes within `extent` (scene coordinates), given relative to `origin`.
    pub fn new(frustum: &Frustum, origin: DVec3, extent: &Aabb) -> Self {
        let reach = (extent.max() - origin)
            .abs()
            .max((extent.min() - origin).abs());
        let eye = frustum.eye() - origin;
        let mut planes = [FilterPlane::default(); Frustum::MAX_PLANES];
        let mut bounded = true;
        for (filter, plane) in planes.iter_mut().zip(frustum.planes()) {
            let offset = plane.offset - plane.normal.dot(eye);
            let cancelled = plane.normal.abs().dot(eye.abs()) + plane.offset.abs();
            let magnitude = plane.normal.abs().dot(reach) + offset.abs();
            let uncertain = plane.normal.abs().max_element()
                * (reach.element_sum() + eye.abs().element_sum())
                + plane.offset.abs();
            let slack = SLACK * magnitude
                + frustum.slack() * uncertain
                + 8.0 * f64::EPSILON * cancelled
                + plane.offset_error
                + f64::from(f32::MIN_POSITIVE) * (1.0 + reach.element_sum());
            bounded &= magnitude + plane.normal.abs().max_element() + slack < LARGEST_TERM;
            let upper = plane.normal.cmpge(DVec3::ZERO);
            let corner = |upper: [bool; 3]| {
                let lane = |upper, max, min| if upper { max } else { min };
                [
                    lane(upper[0], Lane::MaxX, Lane::MinX),
                    lane(upper[1], Lane::MaxY, Lane::MinY),
                    lane(upper[2], Lane::MaxZ, Lane::MinZ),
                ]
            };
            let upper = [upper.test(0), upper.test(1), upper.test(2)];
            *filter = FilterPlane {
                normal: plane.normal.as_vec3().to_array().map(f32x8::splat),
                outer: f32x8::splat((offset + slack) as f32),
                inner: f32x8::splat((offset - slack) as f32),
                band: f32x8::splat(((2.0 * slack) as f32).next_up()),
                farthest: corner(upper),
                nearest: corner(upper.map(|upper| !upper)),
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
            bounded,
            eye: eye.as_vec3().to_array(),
            distance_error,
        }
    }

    /// All planes of the frustum.
    pub fn all_planes(&self) -> PlaneSet {
        (1 << self.count) - 1
    }

    /// How the boxes lie to the planes in `set`.
    #[inline]
    pub fn relations(&self, boxes: &Eight, set: PlaneSet) -> EightRelations {
        self.relations_in::<f32x8>(boxes, set)
    }

    /// The same in registers of this kind.
    #[inline(always)]
    pub(crate) fn relations_in<F: Floats>(
        &self,
        boxes: &Eight,
        mut set: PlaneSet,
    ) -> EightRelations {
        if !self.bounded {
            return EightRelations::unknown(set);
        }
        let mut outside = F::splat(0.0);
        let mut crossing = 0;
        let mut open = 0_u64;
        while let Some(plane) = self.planes.get(set.trailing_zeros() as usize) {
            outside = outside | plane.farthest(boxes);
            let not_inside = plane.nearest::<F>(boxes).negative();
            crossing |= not_inside;
            open |= u64::from(not_inside) << (8 * set.trailing_zeros());
            set &= set.wrapping_sub(1);
        }
        EightRelations {
            outside: outside.negative(),
            inside: crossing ^ ALL_LANES,
            open: if crossing == 0 { 0 } else { transposed(open) },
        }
    }

    /// Boxes certainly outside one of the planes in `set`, and boxes certainly not.
    #[inline]
    pub fn outside_or_touching(&self, boxes: &Eight, set: PlaneSet) -> (Lanes, Lanes) {
        self.outside_or_touching_in::<f32x8>(boxes, set)
    }

    /// The same in registers of this kind.
    #[inline(always)]
    pub(crate) fn outside_or_touching_in<F: Floats>(
        &self,
        boxes: &Eight,
        mut set: PlaneSet,
    ) -> (Lanes, Lanes) {
        if !self.bounded {
            return unknown();
        }
        let mut outside = F::splat(0.0);
        let mut open = F::splat(0.0);
        while let Some(plane) = self.planes.get(set.trailing_zeros() as usize) {
            let farthest: F = plane.farthest(boxes);
            outside = outside | farthest;
            open = open | (farthest - F::of(&plane.band));
            set &= set.wrapping_sub(1);
        }
        (outside.negative(), open.negative() ^ ALL_LANES)
    }

    /// Distances to the nearest points of the boxes.
    #[inline]
    pub fn distances(&self, boxes: &Eight) -> EightDistances {
        self.distances_in(boxes)
    }

    /// The same in registers of this kind.
    #[inline(always)]
    pub(crate) fn distances_in<F: Floats>(&self, boxes: &Eight) -> EightDistances<F> {
        let along = |axis: usize| {
            let eye = F::splat(self.eye[axis]);
            let low = F::of(&boxes[axis]) - eye;
            let high = eye - F::of(&boxes[axis + 3]);
            let near = low.larger(high).larger(F::splat(0.0));
            near * near
        };
        EightDistances {
            squared: along(0) + along(1) + along(2),
        }
    }

    /// Distances to the farthest corners of the boxes.
    #[inline]
    pub fn farthest(&self, boxes: &Eight) -> EightDistances {
        self.farthest_in(boxes)
    }

    /// The same in registers of this kind.
    #[inline(always)]
    pub(crate) fn farthest_in<F: Floats>(&self, boxes: &Eight) -> EightDistances<F> {
        let along = |axis: usize| {
            let eye = F::splat(self.eye[axis]);
            let low = eye - F::of(&boxes[axis]);
            let high = F::of(&boxes[axis + 3]) - eye;
            let far = low.larger(high);
            far * far
        };
        EightDistances {
            squared: along(0) + along(1) + along(2),
        }
    }

    /// A distance to compare with, m ≥ 0.
    pub fn threshold(&self, distance: f64) -> Threshold {
        let near = (distance - self.distance_error) * (1.0 - DISTANCE_SLACK);
        let far = (distance + self.distance_error) * (1.0 + DISTANCE_SLACK);
        Threshold {
            distance,
            below: f32x8::splat(if near > 0.0 {
                ((near * near) as f32).next_down()
            } else {
                -1.0
            }),
            above: f32x8::splat(((far * far) as f32).next_up()),
        }
    }

    /// At least half the diagonal of each box.
    pub fn radii(boxes: &Eight) -> f32x8 {
        let mut squared = f32x8::ZERO;
        for axis in 0..3 {
            let size = boxes[axis + 3] - boxes[axis];
            squared += size * size;
        }
        // Squares may underflow; what is lost is less than what is added.
        squared.sqrt() * f32x8::splat(0.5 * (1.0 + 8.0 * f32::EPSILON)) + f32x8::splat(1e-18)
    }
}

impl<F: Floats> EightDistances<F> {
    /// Their squares, m², within f32.
    #[inline(always)]
    pub fn squared(&self) -> F {
        self.squared
    }

    /// The same as they lie in memory.
    #[inline(always)]
    pub(crate) fn in_memory(&self) -> EightDistances {
        EightDistances {
            squared: f32x8::from(self.squared.to_array()),
        }
    }

    /// Boxes certainly nearer than the threshold.
    #[inline(always)]
    pub fn nearer(&self, threshold: &Threshold) -> Lanes {
        self.squared.less(F::of(&threshold.below))
    }

    /// Boxes certainly not nearer than the threshold.
    #[inline(always)]
    pub fn not_nearer(&self, threshold: &Threshold) -> Lanes {
        F::of(&threshold.above).less(self.squared)
    }
}

#[cold]
fn unknown() -> (Lanes, Lanes) {
    (0, 0)
}

/// Bit i of byte k becomes bit k of byte i. Source: Warren, "Hacker's Delight", 7-3.
#[inline]
fn transposed(mut bits: u64) -> u64 {
    for (shift, swapped) in [
        (7, 0x00aa_00aa_00aa_00aa),
        (14, 0x0000_cccc_0000_cccc),
        (28, 0x0000_0000_f0f0_f0f0),
    ] {
        let moved = (bits ^ (bits >> shift)) & swapped;
        bits ^= moved ^ (moved << shift);
    }
    bits
}

#[cfg(test)]
mod tests {
    use super::transposed;

    #[test]
    fn every_bit_changes_row_and_column() {
        for row in 0..8 {
            for column in 0..8 {
                assert_eq!(transposed(1 << (8 * row + column)), 1 << (8 * column + row));
            }
        }
    }
}
