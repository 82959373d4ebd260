//! Cuts polygons off before they are projected, where a projection would turn them inside out.
//!
//! Sutherland and Hodgman, "Reentrant polygon clipping" (1974), in homogeneous coordinates.

use super::projector::{FAR, FORMS, NEAR, W, X, Y};

/// How far polygons reach beyond the window, in half windows, before they are cut there too:
/// keeps places on the buffer small, and w at or above 0.
const GUARD: f64 = 2.0;

/// The sides a polygon is cut at; each is a bit of an [`outside`].
const SIDES: usize = 6;

/// A point as its forms.
pub(super) type Point = [f64; FORMS];

/// A polygon cut by all sides has three vertices or four and one more for each.
pub(super) const MOST_VERTICES: usize = 4 + SIDES;

/// How far a point is on the kept side of a side.
fn height(point: &Point, side: usize) -> f64 {
    match side {
        0 => point[NEAR],
        1 => point[FAR],
        2 => GUARD * point[W] + point[X],
        3 => GUARD * point[W] - point[X],
        4 => GUARD * point[W] + point[Y],
        _ => GUARD * point[W] - point[Y],
    }
}

/// The sides a point is beyond, one bit each. What is not a number is beyond.
pub(super) fn outside(point: &Point) -> u32 {
    (0..SIDES).fold(0, |sides, side| {
        let within = height(point, side) >= 0.0;
        sides | u32::from(!within) << side
    })
}

/// The convex polygon that `sides` leave of `polygon`.
///
/// An edge is cut at the same point from either of its ends, so that polygons that share it still
/// do.
pub(super) fn clip(polygon: &mut Polygon, sides: u32) {
    for side in (0..SIDES).filter(|side| sides >> side & 1 == 1) {
        let whole = std::mem::take(polygon);
        let points = whole.points();
        let mut from = points.last();
        for to in points {
            if let Some(from) = from {
                let (before, after) = (height(from, side), height(to, side));
                if (before >= 0.0) != (after >= 0.0) {
                    // Weighted by the distances, inner end first: where all is positive nothing
                    // cancels.
                    polygon.push(if before >= 0.0 {
                        between(from, to, before, after)
                    } else {
                        between(to, from, after, before)
                    });
                }
                if after >= 0.0 {
                    polygon.push(*to);
                }
            }
            from = Some(to);
        }
    }
}

fn between(inner: &Point, outer: &Point, inside: f64, outside: f64) -> Point {
    let share = inside / (inside - outside);
    std::array::from_fn(|i| inner[i] * (1.0 - share) + outer[i] * share)
}

/// A few points.
#[derive(Debug, Clone, Copy)]
pub(super) struct Polygon {
    points: [Point; MOST_VERTICES],
    count: usize,
}

impl Default for Polygon {
    fn default() -> Self {
        Self {
            points: [[0.0; FORMS]; MOST_VERTICES],
            count: 0,
        }
    }
}

impl Polygon {
    pub(super) fn of(points: &[Point]) -> Self {
        let mut polygon = Self::default();
        for point in points {
            polygon.push(*point);
        }
        polygon
    }

    pub(super) fn points(&self) -> &[Point] {
        &self.points[..self.count]
    }

    /// Convex polygons gain no more than one vertex a side; what rounding made of a degenerate
    /// one beyond that is dropped.
    fn push(&mut self, point: Point) {
        if let Some(place) = self.points.get_mut(self.count) {
            *place = point;
            self.count += 1;
        }
    }
}
