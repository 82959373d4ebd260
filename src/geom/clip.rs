//! Where a view puts a point in its picture.

use std::ops::Mul;

use super::DVec3;
use super::frustum::Plane;

/// A linear form of a point relative to the eye: `normal · (p − eye) + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Form {
    /// Its gradient.
    pub normal: DVec3,
    /// Its value at the eye.
    pub offset: f64,
}

impl Form {
    /// 1 everywhere: as a half-space, all of space.
    const EVERYWHERE: Self = Self {
        normal: DVec3::ZERO,
        offset: 1.0,
    };

    /// Half of `a + sign · b`.
    fn halved(a: &Plane, b: &Plane, sign: f64) -> Self {
        Self {
            normal: a.normal * 0.5 + b.normal * (0.5 * sign),
            offset: a.offset * 0.5 + b.offset * (0.5 * sign),
        }
    }

    fn magnitude(&self) -> f64 {
        self.normal.abs().max_element().max(self.offset.abs())
    }
}

impl Mul<f64> for Form {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self {
            normal: self.normal * factor,
            offset: self.offset * factor,
        }
    }
}

impl From<Plane> for Form {
    fn from(plane: Plane) -> Self {
        let Plane { normal, offset, .. } = plane;
        Self { normal, offset }
    }
}

/// Homogeneous coordinates of a view's picture. A point is shown where −w ≤ x ≤ w, −w ≤ y ≤ w,
/// near ≥ 0 and far ≥ 0: at x/w from left (−1) to right (1), at y/w from bottom (−1) to top (1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClipSpace {
    /// Rightward.
    pub x: Form,
    /// Upward.
    pub y: Form,
    /// Depth in perspective, constant in parallel projections.
    pub w: Form,
    /// The near side's half-space; of a matrix, that of −w ≤ z.
    pub near: Form,
    /// The far side's, all of space where there is none; of a matrix, that of z ≤ w.
    pub far: Form,
}

impl ClipSpace {
    /// From half-spaces in the order near, far if there is one, left, right, bottom, top; left and
    /// right in one scale, bottom and top in one scale.
    pub(super) fn of_planes(planes: &[Plane]) -> Self {
        let sides = planes.len() - 4;
        let [left, right, bottom, top] = [0, 1, 2, 3].map(|side| &planes[sides + side]);
        let w = Form::halved(left, right, 1.0);
        // Left and right add up to 2w in their scale, bottom and top in theirs.
        let scale = w.magnitude() / Form::halved(bottom, top, 1.0).magnitude();
        Self {
            x: Form::halved(left, right, -1.0),
            y: Form::halved(bottom, top, -1.0) * scale,
            w,
            near: planes[0].into(),
            far: match planes[1..sides] {
                [far] => far.into(),
                _ => Form::EVERYWHERE,
            },
        }
    }
}
