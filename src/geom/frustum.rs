//! The part of space a view shows, as half-spaces, and the conservative test against it.

use super::{Aabb, DVec3};

/// The half-space `normal · (p − eye) + offset ≥ 0`. The normal need not be of unit length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Points into the visible side.
    pub normal: DVec3,
    /// Value at the eye.
    pub offset: f64,
    /// What the offset may be off by, absolutely, beyond the frustum's relative error.
    pub offset_error: f64,
}

/// How a box lies to a frustum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Relation {
    /// No point of the box is visible. Said only when it is true.
    Outside,
    /// Every point of the box is visible. Said only when it is true.
    Inside,
    /// Anything else, boxes that touch a plane from outside included.
    Crossing,
}

/// Intersection of at most [`Frustum::MAX_PLANES`] half-spaces, stated relative to the eye, so
/// that large coordinates cancel before they are multiplied.
#[derive(Debug, Clone, PartialEq)]
pub struct Frustum {
    eye: DVec3,
    planes: Vec<Plane>,
    slack: f64,
}

/// Shorter sums of plane normals point nowhere in particular.
const LEAST_OPENING: f64 = 1e-3;

/// Unit roundoff of f64.
const U: f64 = f64::EPSILON / 2.0;

impl Frustum {
    /// Left, right, bottom, top, near, far.
    pub const MAX_PLANES: usize = 6;

    /// `coefficient_error` bounds the rounding error of each normal component relative to the
    /// normal's largest one, and of each offset relative to itself, in units of roundoff.
    pub(super) fn new(eye: DVec3, planes: Vec<Plane>, coefficient_error: f64) -> Self {
        debug_assert!(planes.len() <= Self::MAX_PLANES);
        Self {
            eye,
            planes: planes.into_iter().map(Plane::rescaled).collect(),
            slack: (coefficient_error + EVALUATION_ERROR) * U,
        }
    }

    /// The same without what lies beyond `distance` (m) along the direction it opens to. A box with
    /// a visible point no farther than that from the eye is not outside. Where no plane is to
    /// spare, nothing is cut off.
    #[must_use]
    pub fn within(&self, distance: f64) -> Self {
        let unit = |plane: &Plane| plane.normal.normalize_or_zero();
        let opening: DVec3 = self.planes.iter().map(unit).sum();
        let mut within = self.clone();
        if self.planes.len() < Self::MAX_PLANES && opening.length() > LEAST_OPENING {
            // Any unit vector would do: along none is a point farther than its distance. That
            // of this one is off by its normalisation, which the slack has room for.
            let normal = -opening.normalize();
            let plane = Plane::exact(normal, distance * (1.0 + 8.0 * f64::EPSILON));
            within.planes.push(plane.rescaled());
        }
        within
    }

    /// Where the view is seen from; planes are relative to it.
    pub fn eye(&self) -> DVec3 {
        self.eye
    }

    /// What the value of a plane may be off by, relative to ‖n‖∞·Σ|pᵢ − eyeᵢ| + |offset|.
    pub(super) fn slack(&self) -> f64 {
        self.slack
    }

    /// The half-spaces; the largest component of each normal lies in [1, 2).
    pub fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// Whether the box lies beyond one of the planes. Conservative: a box that meets the frustum
    /// is never outside.
    pub fn is_outside(&self, b: &Aabb) -> bool {
        self.planes
            .iter()
            .any(|plane| plane.beyond(self.eye, b, self.slack))
    }

    /// The same for those planes only whose bit is in `set`.
    pub(crate) fn is_outside_of(&self, set: super::PlaneSet, b: &Aabb) -> bool {
        let planes = (0..).zip(&self.planes);
        planes
            .filter(|(bit, _)| set >> bit & 1 == 1)
            .any(|(_, plane)| plane.beyond(self.eye, b, self.slack))
    }

    /// How the box lies to the frustum.
    pub fn relation(&self, b: &Aabb) -> Relation {
        if self.is_outside(b) {
            return Relation::Outside;
        }
        // Inside the half-space is beyond its complement.
        let inside = self
            .planes
            .iter()
            .all(|plane| plane.complement().beyond(self.eye, b, self.slack));
        if inside {
            Relation::Inside
        } else {
            Relation::Crossing
        }
    }
}

/// Roundings on the way of one term through [`Plane::beyond`]: difference, product, three sums
/// make 5; the magnitude it is compared with loses as many again, and the comparison's product 1.
const EVALUATION_ERROR: f64 = 12.0;

/// More than the products and the magnitude lose where they are too small for f64: normals are
/// about 1 and there are fewer than eight.
const UNDERFLOW: f64 = 8.0 * f64::MIN_POSITIVE;

impl Plane {
    pub(super) fn exact(normal: DVec3, offset: f64) -> Self {
        Self {
            normal,
            offset,
            offset_error: 0.0,
        }
    }

    /// The same half-space, its numbers multiplied by a power of two, which rounds nothing.
    pub(super) fn rescaled(self) -> Self {
        let times = |plane: Self, factor: f64| Self {
            normal: plane.normal * factor,
            offset: plane.offset * factor,
            offset_error: plane.offset_error * factor,
        };
        let largest = |plane: &Self| plane.normal.abs().max_element();
        if self.normal == DVec3::ZERO {
            return self;
        }
        // Out of the reach of denormals first, whose exponents do not tell their size.
        let plane = match largest(&self) {
            tiny if tiny < f64::MIN_POSITIVE => times(self, f64::from_bits((1023 + 600) << 52)),
            _ => self,
        };
        let exponent = largest(&plane).to_bits() >> 52;
        match 2046_u64.checked_sub(exponent) {
            Some(opposite @ 1..) => times(plane, f64::from_bits(opposite << 52)),
            _ => plane,
        }
    }

    /// The other side.
    fn complement(self) -> Self {
        Self {
            normal: -self.normal,
            offset: -self.offset,
            ..self
        }
    }

    /// Whether every point of the box is certainly on the invisible side.
    ///
    /// The corner farthest along the normal decides: s = Σ nᵢ·(pᵢ − eyeᵢ) + offset. Computed in
    /// floating point it is off by at most `slack`·m with m = ‖n‖∞·Σ|pᵢ − eyeᵢ| + |offset|, so
    /// s < −`slack`·m proves that the exact value is negative. (Higham, "Accuracy and Stability
    /// of Numerical Algorithms", §3.1: a sum of k roundings is off by k·u of its magnitude, the
    /// terms in u² being covered by the roundings counted twice in [`EVALUATION_ERROR`].) Products
    /// that underflow are off by less than [`UNDERFLOW`].
    fn beyond(&self, eye: DVec3, b: &Aabb, slack: f64) -> bool {
        let corner = DVec3::select(self.normal.cmpge(DVec3::ZERO), b.max(), b.min());
        let to_corner = corner - eye;
        let s = self.normal.dot(to_corner) + self.offset;
        let magnitude =
            self.normal.abs().max_element() * to_corner.abs().element_sum() + self.offset.abs();
        s < -(slack * magnitude + self.offset_error + UNDERFLOW)
    }
}
