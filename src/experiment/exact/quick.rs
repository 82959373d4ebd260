//! The same questions in f64 intervals: certain answers for boxes that are not at a border.

use super::camera::HalfSpace;
use super::dyadic::Dyadic;
use super::feasible::common_point;
use super::interval::Interval;
use crate::geom::{Aabb, DVec3};

/// A half-space whose coefficients lie in intervals, the largest about 1.
#[derive(Debug, Clone)]
pub(super) struct QuickPlane {
    normal: [Interval; 3],
    offset: Interval,
}

/// The value of a half-space over a box: its terms at the lower and upper corner along each
/// axis.
struct Terms([[Interval; 2]; 3]);

impl QuickPlane {
    pub fn of(plane: &HalfSpace) -> Self {
        let (low, high) = (plane.at(&plane.factor.low), plane.at(&plane.factor.high));
        let largest = low[..3].iter().filter_map(Dyadic::magnitude).max();
        let scale = -largest.unwrap_or(0);
        let between = |k: usize| {
            let (a, b) = (
                low[k].clone().shifted(scale),
                high[k].clone().shifted(scale),
            );
            Interval {
                low: a.floor_f64().min(b.floor_f64()),
                high: a.ceil_f64().max(b.ceil_f64()),
            }
        };
        Self {
            normal: [between(0), between(1), between(2)],
            offset: between(3),
        }
    }

    fn terms(&self, reach: &[[Interval; 2]; 3]) -> Terms {
        Terms(std::array::from_fn(|k| {
            reach[k].map(|x| self.normal[k] * x)
        }))
    }

    /// The value at a corner: bit k of `upper` for the upper one along axis k.
    fn at_corner(&self, terms: &Terms, upper: usize) -> Interval {
        (0..3).fold(self.offset, |sum, k| sum + terms.0[k][(upper >> k) & 1])
    }

    fn at_point(&self, p: &[Interval; 3]) -> Interval {
        (0..3).fold(self.offset, |sum, k| sum + self.normal[k] * p[k])
    }
}

/// How a box lies to a frustum, as far as intervals tell.
pub(super) struct Told {
    /// Whether they meet.
    pub meets: Option<bool>,
    /// Whether the box is wholly inside.
    pub inside: Option<bool>,
}

/// What intervals tell of a box.
pub(super) fn ask(planes: &[QuickPlane], eye: DVec3, b: &Aabb) -> Told {
    let reach: [[Interval; 2]; 3] = std::array::from_fn(|k| {
        [b.min()[k], b.max()[k]].map(|corner| Interval::difference(corner, eye[k]))
    });
    let (mut all_inside, mut certainly_not_inside) = (true, false);
    let mut terms = Vec::with_capacity(planes.len());
    for plane in planes {
        let of = plane.terms(&reach);
        let over = |pick: fn(Interval, Interval) -> Interval| {
            let ends = of.0.iter().map(|[a, b]| pick(*a, *b));
            ends.fold(plane.offset, |sum, term| sum + term)
        };
        let (least, most) = (over(Interval::min), over(Interval::max));
        if most.high < 0.0 {
            return Told {
                meets: Some(false),
                inside: Some(false),
            };
        }
        all_inside &= least.low >= 0.0;
        certainly_not_inside |= least.high < 0.0;
        terms.push(of);
    }
    if all_inside {
        return Told {
            meets: Some(true),
            inside: Some(true),
        };
    }
    let corner_inside = |upper: usize| {
        let mut planes = planes.iter().zip(&terms);
        planes.all(|(plane, terms)| plane.at_corner(terms, upper).low >= 0.0)
    };
    let meets = (0..8).any(corner_inside) || witness(planes, eye, b);
    Told {
        meets: meets.then_some(true),
        inside: certainly_not_inside.then_some(false),
    }
}

/// Whether a point can be found that lies in the box and certainly in the frustum.
fn witness(planes: &[QuickPlane], eye: DVec3, b: &Aabb) -> bool {
    /// How far inside a point is looked for, relative to what goes into a plane's value.
    const DEEP: f64 = 1e-11;
    let to_corner = b.min() - eye;
    let size = b.size();
    let mut rows: Vec<Vec<f64>> = Vec::with_capacity(6 + planes.len());
    for k in 0..3 {
        let unit = |sign: f64| (0..3).map(move |i| if i == k { sign } else { 0.0 });
        rows.push(unit(1.0).chain([0.0]).collect());
        rows.push(unit(-1.0).chain([size[k]]).collect());
    }
    for plane in planes {
        let middle = |i: Interval| i.low.midpoint(i.high);
        let normal = DVec3::from_array(plane.normal.map(middle));
        let offset = middle(plane.offset) + normal.dot(to_corner);
        let terms = to_corner.abs().element_sum() + size.element_sum();
        let deep = DEEP * (terms + middle(plane.offset).abs());
        rows.push(vec![normal.x, normal.y, normal.z, offset - deep]);
    }
    let Some(point) = common_point(&rows, 3) else {
        return false;
    };
    let from_corner = DVec3::new(point[0], point[1], point[2]) / point[3];
    let point = (b.min() + from_corner).max(b.min()).min(b.max());
    if !point.is_finite() {
        return false;
    }
    let relative = [0, 1, 2].map(|k| Interval::difference(point[k], eye[k]));
    planes
        .iter()
        .all(|plane| plane.at_point(&relative).low >= 0.0)
}
