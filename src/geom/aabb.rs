//! Axis-aligned boxes in metres, f64, z up.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A closed axis-aligned box. A flat, line or point box is a box like any other.
///
/// Made only from finite, ordered corners ([`Aabb::new`]) or as the union of such boxes, so every
/// value of this type is valid. The one exception is [`Aabb::EMPTY`], the neutral element of
/// [`Aabb::union`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Aabb {
    min: DVec3,
    max: DVec3,
}

/// Why two corners are no box.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum AabbError {
    /// A coordinate is NaN or infinite.
    #[error("a corner is not finite: min {min}, max {max}")]
    NotFinite {
        /// The lower corner given.
        min: DVec3,
        /// The upper corner given.
        max: DVec3,
    },
    /// A minimum lies above its maximum.
    #[error("the box is inverted: min {min}, max {max}")]
    Inverted {
        /// The lower corner given.
        min: DVec3,
        /// The upper corner given.
        max: DVec3,
    },
}

impl Aabb {
    /// Contains nothing; `EMPTY ∪ b = b`.
    pub const EMPTY: Self = Self {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };

    /// The box with these corners.
    ///
    /// # Errors
    /// [`AabbError`] when a coordinate is not finite or `min > max` on an axis.
    #[inline]
    pub fn new(min: DVec3, max: DVec3) -> Result<Self, AabbError> {
        if !min.is_finite() || !max.is_finite() {
            return Err(AabbError::NotFinite { min, max });
        }
        if min.cmpgt(max).any() {
            return Err(AabbError::Inverted { min, max });
        }
        // -0.0 becomes 0.0, so that equal boxes have equal bits.
        Ok(Self {
            min: min + DVec3::ZERO,
            max: max + DVec3::ZERO,
        })
    }

    /// The smallest box around the finite points; [`Aabb::EMPTY`] when there is none.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Self {
        points
            .into_iter()
            .filter(|p| p.is_finite())
            .fold(Self::EMPTY, |b, p| Self {
                min: b.min.min(p + DVec3::ZERO),
                max: b.max.max(p + DVec3::ZERO),
            })
    }

    /// Lower corner.
    pub fn min(&self) -> DVec3 {
        self.min
    }

    /// Upper corner.
    pub fn max(&self) -> DVec3 {
        self.max
    }

    /// Whether nothing is inside, i.e. this is [`Aabb::EMPTY`].
    pub fn is_empty(&self) -> bool {
        self.min.x > self.max.x
    }

    /// Extent along each axis, m. Infinite for boxes wider than `f64::MAX`.
    pub fn size(&self) -> DVec3 {
        self.max - self.min
    }

    /// Midpoint, without overflow.
    pub fn center(&self) -> DVec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// Half the diagonal, m: the radius of the sphere around the box.
    pub fn radius(&self) -> f64 {
        self.size().length() * 0.5
    }

    /// The smallest box around both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// Whether `other` lies inside, borders included.
    pub fn contains(&self, other: &Self) -> bool {
        self.min.cmple(other.min).all() && self.max.cmpge(other.max).all()
    }

    /// Squared distance from `point` to the nearest point of the box, m²; 0 inside.
    ///
    /// Law: never smaller for a box inside than for the box around it, in floating point too:
    /// each operation is monotone.
    pub fn distance_squared(&self, point: DVec3) -> f64 {
        (self.min - point)
            .max(point - self.max)
            .max(DVec3::ZERO)
            .length_squared()
    }

    /// Distance from `point` to the nearest point of the box, m; 0 inside. Monotone as
    /// [`Aabb::distance_squared`] is.
    pub fn distance(&self, point: DVec3) -> f64 {
        self.distance_squared(point).sqrt()
    }

    /// The box with the corners `[min x, min y, min z, max x, max y, max z]`.
    ///
    /// # Errors
    /// As [`Aabb::new`].
    #[inline]
    pub fn from_array([x0, y0, z0, x1, y1, z1]: [f64; 6]) -> Result<Self, AabbError> {
        Self::new(DVec3::new(x0, y0, z0), DVec3::new(x1, y1, z1))
    }

    /// Box number `at` of many; `None` past the last one and where the numbers are no box.
    pub fn nth(boxes: &[[f64; 6]], at: u32) -> Option<Self> {
        Self::from_array(*boxes.get(at as usize)?).ok()
    }

    /// `[min x, min y, min z, max x, max y, max z]`.
    pub fn to_array(self) -> [f64; 6] {
        [
            self.min.x, self.min.y, self.min.z, self.max.x, self.max.y, self.max.z,
        ]
    }
}
