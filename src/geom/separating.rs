//! The exact test of a box against a frustum, for what the planes leave crossing.
//!
//! A box near a corner or an edge of the frustum may lie beyond none of the planes and yet not
//! meet it. Two convex polyhedra that do not meet are separated by a plane that is parallel to a
//! face of one of them or to an edge of each (separating axes). Each such plane that bounds the
//! frustum is a sum λᵢ·(half-space i) with λᵢ ≥ 0 of at most three of its half-spaces: one is a
//! face of the frustum itself, two whose sum has no part along an edge of the box are parallel to
//! that edge, and three whose sum has no part along two are parallel to a face of the box. (By
//! Helly's theorem half-spaces in space without a common point have four among them without one;
//! by Farkas' lemma a sum of these is a contradiction.) So all sums are made once for a view, and
//! a box is held against them as against the planes.
//!
//! # Error bound
//! A sum of half-spaces that contain the frustum contains it whatever the λ, so these count as
//! exact, however they were rounded. With M = Σ λᵢ·‖nᵢ‖∞ and E = Σ λᵢ·|dᵢ|, the planes' own
//! uncertainty and the evaluation ([`Frustum`]) make `slack`·(M·Σ|pⱼ − eyeⱼ| + E) + Σ λᵢ·eᵢ, eᵢ
//! their absolute errors, and the sums 3 u more (one product, two sums); M, E and what is
//! compared with are rounded themselves, for which 1 u more than covers. λ are at most 1 and one
//! of them is 1, so M ≥ 1 and what underflows is less than that last unit.

use super::{Aabb, DVec3, Frustum, Plane};

/// Half-spaces around a frustum that, with its planes, tell every box that does not meet it.
#[derive(Debug, Clone)]
pub struct SeparatingAxes {
    eye: DVec3,
    sums: Vec<Sum>,
}

/// normal · (p − eye) + offset ≥ 0 for all p in the frustum, but for the errors.
#[derive(Debug, Clone, Copy)]
struct Sum {
    normal: DVec3,
    offset: f64,
    /// What the value may be off by for each metre of Σ|pⱼ − eyeⱼ|.
    error_per_metre: f64,
    /// And beside it.
    error: f64,
}

/// Roundings of the sums, in units of roundoff.
const SUM_ERROR: f64 = 4.0;

/// Products of boxes with normals that are too small for f64.
const UNDERFLOW: f64 = 8.0 * f64::MIN_POSITIVE;

impl SeparatingAxes {
    /// All sums of the planes of a frustum.
    pub fn new(frustum: &Frustum) -> Self {
        let planes = frustum.planes();
        let slack = frustum.slack();
        let mut sums = Vec::new();
        for (i, a) in planes.iter().enumerate() {
            for b in &planes[i + 1..] {
                for axis in 0..3 {
                    let (along_a, along_b) = (a.normal[axis], b.normal[axis]);
                    if along_a * along_b < 0.0 {
                        let terms = [(along_b.abs(), a), (along_a.abs(), b)];
                        sums.extend(Sum::of(&terms, slack));
                    }
                }
            }
        }
        for axis in 0..3 {
            for direction in [1.0, -1.0] {
                sums.extend(tightest(planes, axis, direction, slack));
            }
        }
        Self {
            eye: frustum.eye(),
            sums,
        }
    }

    /// Whether the box, which is not outside one of the planes, does not meet the frustum.
    /// Conservative as [`Frustum::is_outside`]: a box that meets the frustum is never separated;
    /// one that does not is, but for those that touch it within rounding.
    pub fn separate(&self, b: &Aabb) -> bool {
        self.sums.iter().any(|sum| sum.beyond(self.eye, b))
    }

    /// How many half-spaces a box is held against.
    pub fn count(&self) -> usize {
        self.sums.len()
    }
}

/// The sum of three planes that says best how far the frustum reaches along an axis.
fn tightest(planes: &[Plane], axis: usize, direction: f64, slack: f64) -> Option<Sum> {
    let mut best: Option<(f64, Sum)> = None;
    for (i, a) in planes.iter().enumerate() {
        for (j, b) in planes.iter().enumerate().skip(i + 1) {
            for c in &planes[j + 1..] {
                // Cramer's rule for Σ λ·normal = ±axis.
                let [na, nb, nc] = [a, b, c].map(|plane| plane.normal);
                let sign = na.dot(nb.cross(nc)).signum() * direction;
                let factors = [nb.cross(nc), nc.cross(na), na.cross(nb)].map(|v| v[axis] * sign);
                if factors.iter().any(|factor| *factor < 0.0) {
                    continue;
                }
                let terms = [(factors[0], a), (factors[1], b), (factors[2], c)];
                let Some(sum) = Sum::of(&terms, slack) else {
                    continue;
                };
                let reach = sum.offset / sum.normal[axis].abs();
                if best.is_none_or(|(least, _)| reach < least) {
                    best = Some((reach, sum));
                }
            }
        }
    }
    best.map(|(_, sum)| sum)
}

impl Sum {
    /// Σ λᵢ·planeᵢ, λ scaled to 1 at most; `None` where nothing is left of the normals.
    fn of(terms: &[(f64, &Plane)], slack: f64) -> Option<Self> {
        let largest = terms
            .iter()
            .fold(0.0, |most: f64, (factor, _)| most.max(*factor));
        if largest < f64::MIN_POSITIVE {
            return None;
        }
        let (mut normal, mut offset) = (DVec3::ZERO, 0.0);
        let (mut normals, mut offsets, mut errors) = (0.0, 0.0, 0.0);
        for &(factor, plane) in terms {
            let factor = factor / largest;
            normal += plane.normal * factor;
            offset += plane.offset * factor;
            normals += plane.normal.abs().max_element() * factor;
            offsets += plane.offset.abs() * factor;
            errors += plane.offset_error * factor;
        }
        let relative = slack + SUM_ERROR * (f64::EPSILON / 2.0);
        let sum = Self {
            normal,
            offset,
            error_per_metre: relative * normals,
            error: relative * offsets + errors * (1.0 + 4.0 * f64::EPSILON) + UNDERFLOW,
        };
        (normal.abs().max_element() > sum.error_per_metre).then_some(sum)
    }

    /// Whether every point of the box is certainly on the far side.
    fn beyond(&self, eye: DVec3, b: &Aabb) -> bool {
        let corner = DVec3::select(self.normal.cmpge(DVec3::ZERO), b.max(), b.min());
        let to_corner = corner - eye;
        let value = self.normal.dot(to_corner) + self.offset;
        value < -(self.error_per_metre * to_corner.abs().element_sum() + self.error)
    }
}
