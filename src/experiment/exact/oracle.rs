//! The frustum of one camera, and how boxes lie to it.

use std::cmp::Ordering;

use super::camera::{Camera, HalfSpace, Vector, vector};
use super::dyadic::Dyadic;
use super::interval::Interval;
use super::quick::{QuickPlane, Told};
use super::{camera, feasible, quick};
use crate::geom::{Aabb, DVec3};

/// Bits of irrational numbers, one step after another.
const BITS: [u32; 3] = [128, 512, LAST_BITS];
/// Here refinement ends: 2⁻²⁰⁴⁸ of a coordinate is less than any f64 tells apart.
pub const LAST_BITS: u32 = 2048;

/// What exact arithmetic says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Answer {
    /// It is so.
    Yes,
    /// It is not so.
    No,
    /// The box touches the frustum to within 2^−[`LAST_BITS`].
    Open,
}

impl From<bool> for Answer {
    fn from(so: bool) -> Self {
        if so { Self::Yes } else { Self::No }
    }
}

/// The frustum of one camera.
#[derive(Debug, Clone)]
pub struct Oracle {
    camera: Camera,
    eye: Vector,
    /// To the first number of bits.
    planes: Vec<HalfSpace>,
    quick: Vec<QuickPlane>,
}

/// Which of two frusta to take for one that lies between them.
#[derive(Debug, Clone, Copy)]
enum Bound {
    Containing,
    Contained,
}

impl Oracle {
    /// For the frustum that a valid camera stands for.
    pub fn new(camera: &Camera) -> Self {
        let planes = camera.half_spaces(BITS[0]);
        Self {
            camera: *camera,
            eye: vector(camera.eye()),
            quick: planes.iter().map(QuickPlane::of).collect(),
            planes,
        }
    }

    /// Whether the box and the frustum have a point in common, borders included.
    pub fn meets(&self, b: &Aabb) -> Answer {
        match self.quick(b).meets {
            Some(so) => so.into(),
            None => self.meets_exactly(b),
        }
    }

    /// Whether every point of the box lies in the frustum, borders included.
    pub fn contains(&self, b: &Aabb) -> Answer {
        match self.quick(b).inside {
            Some(so) => so.into(),
            None => self.contains_exactly(b),
        }
    }

    /// Both answers, [`Oracle::meets`] first.
    pub fn relation(&self, b: &Aabb) -> [Answer; 2] {
        let told = self.quick(b);
        let meets = told
            .meets
            .map_or_else(|| self.meets_exactly(b), Answer::from);
        let inside = match (meets, told.inside) {
            (Answer::No, _) => Answer::No,
            (_, Some(so)) => so.into(),
            (_, None) => self.contains_exactly(b),
        };
        [meets, inside]
    }

    /// As [`Oracle::meets`], in exact numbers only.
    pub fn meets_exactly(&self, b: &Aabb) -> Answer {
        self.refined(|planes, bound| meets(&relative(planes, bound, &self.eye, b)))
    }

    /// As [`Oracle::contains`], in exact numbers only.
    pub fn contains_exactly(&self, b: &Aabb) -> Answer {
        self.refined(|planes, bound| contains(&relative(planes, bound, &self.eye, b)))
    }

    fn quick(&self, b: &Aabb) -> Told {
        quick::ask(&self.quick, self.camera.eye(), b)
    }

    /// Asks for both frusta, closer and closer, until they agree.
    fn refined(&self, ask: impl Fn(&[HalfSpace], Bound) -> bool) -> Answer {
        for bits in BITS {
            let closer;
            let planes = if bits == BITS[0] {
                &self.planes
            } else {
                closer = self.camera.half_spaces(bits);
                &closer
            };
            if !ask(planes, Bound::Containing) {
                return Answer::No;
            }
            let exact = planes.iter().all(|plane| plane.factor.is_exact());
            if exact || ask(planes, Bound::Contained) {
                return Answer::Yes;
            }
        }
        Answer::Open
    }

    /// The value of half-space `plane` at a point, exact for the lower bounds of irrational
    /// numbers. Its sign alone means something; the scale is arbitrary.
    pub fn value_at(&self, plane: usize, point: DVec3) -> Option<(Dyadic, [Dyadic; 3])> {
        let plane = self.planes.get(plane)?;
        let [a, b, c, offset] = plane.at(&plane.factor.low);
        let normal = [a, b, c];
        let point = vector(point);
        let from_eye: Vector = std::array::from_fn(|k| &point[k] - &self.eye[k]);
        Some((&camera::dot(&normal, &from_eye) + &offset, normal))
    }

    /// How many half-spaces there are.
    pub fn plane_count(&self) -> usize {
        self.planes.len()
    }
}

/// Half-spaces and a box, both relative to the box's lower corner.
struct Relative {
    planes: Vec<[Dyadic; 4]>,
    size: Vector,
}

fn relative(planes: &[HalfSpace], bound: Bound, eye: &Vector, b: &Aabb) -> Relative {
    let (min, max) = (vector(b.min()), vector(b.max()));
    let from_eye: Vector = std::array::from_fn(|k| &min[k] - &eye[k]);
    let planes = planes.iter().map(|plane| {
        let [x, y, z, offset] = plane.at(match bound {
            Bound::Containing => &plane.factor.high,
            Bound::Contained => &plane.factor.low,
        });
        let normal = [x, y, z];
        let offset = &offset + &camera::dot(&normal, &from_eye);
        let [x, y, z] = normal;
        [x, y, z, offset]
    });
    Relative {
        planes: planes.collect(),
        size: std::array::from_fn(|k| &max[k] - &min[k]),
    }
}

impl Relative {
    /// The value of a half-space at the corner farthest along its normal, or against it.
    fn extreme(&self, plane: &[Dyadic; 4], along: Ordering) -> Dyadic {
        let taken = (0..3).filter(|&k| plane[k].sign() == along);
        taken.fold(plane[3].clone(), |sum, k| {
            &sum + &(&plane[k] * &self.size[k])
        })
    }
}

fn contains(r: &Relative) -> bool {
    let mut planes = r.planes.iter();
    planes.all(|plane| r.extreme(plane, Ordering::Less).sign() != Ordering::Less)
}

fn meets(r: &Relative) -> bool {
    let beyond = |plane| r.extreme(plane, Ordering::Greater).sign() == Ordering::Less;
    if r.planes.iter().any(beyond) {
        return false;
    }
    let zero = Dyadic::zero;
    let mut rows: Vec<Vec<Dyadic>> = Vec::with_capacity(6 + r.planes.len());
    for (k, size) in r.size.iter().enumerate() {
        let mut row = vec![zero(), zero(), zero(), zero()];
        row[k] = Dyadic::from(1);
        rows.push(row.clone());
        row[k] = Dyadic::from(-1);
        row[3] = size.clone();
        rows.push(row);
    }
    rows.extend(r.planes.iter().map(|plane| plane.to_vec()));
    feasible::common_point(&rows, 3).is_some()
}

/// How the distance from a point to the nearest point of a box compares with `distance` ≥ 0,
/// which may be infinite.
pub fn compare_distance(b: &Aabb, point: DVec3, distance: f64) -> Ordering {
    let part = |k: usize| {
        let below = Interval::difference(b.min()[k], point[k]);
        let above = Interval::difference(point[k], b.max()[k]);
        below.max(above).max(Interval::from(0.0))
    };
    compare([0, 1, 2].map(part), distance, || distance_squared(b, point))
}

/// The same for the farthest corner.
pub fn compare_farthest(b: &Aabb, point: DVec3, distance: f64) -> Ordering {
    let part = |k: usize| {
        let above = Interval::difference(point[k], b.min()[k]);
        let below = Interval::difference(b.max()[k], point[k]);
        below.max(above)
    };
    compare([0, 1, 2].map(part), distance, || farthest_squared(b, point))
}

/// Tries intervals first; the parts along the axes are not negative.
fn compare(parts: [Interval; 3], distance: f64, exact: impl Fn() -> Dyadic) -> Ordering {
    if distance == f64::INFINITY {
        return Ordering::Less;
    }
    let [x, y, z] = parts.map(Interval::squared);
    let squared = x + y + z;
    let limit = Interval::from(distance).squared();
    if squared.high < limit.low {
        Ordering::Less
    } else if squared.low > limit.high {
        Ordering::Greater
    } else {
        let distance = Dyadic::from(distance);
        exact().cmp(&(&distance * &distance))
    }
}

/// Squared distance from a point to the nearest point of a box, exact.
pub fn distance_squared(b: &Aabb, point: DVec3) -> Dyadic {
    let (min, max, point) = (vector(b.min()), vector(b.max()), vector(point));
    let part = |k: usize| {
        let (below, above) = (&min[k] - &point[k], &point[k] - &max[k]);
        below.max(above).max(Dyadic::zero())
    };
    squared_sum(&[0, 1, 2].map(part))
}

/// Squared distance from a point to the farthest corner of a box, exact.
pub fn farthest_squared(b: &Aabb, point: DVec3) -> Dyadic {
    let (min, max, point) = (vector(b.min()), vector(b.max()), vector(point));
    let part = |k: usize| (&point[k] - &min[k]).max(&max[k] - &point[k]);
    squared_sum(&[0, 1, 2].map(part))
}

fn squared_sum(v: &Vector) -> Dyadic {
    camera::dot(v, v)
}
