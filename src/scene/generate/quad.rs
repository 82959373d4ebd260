//! Convex pieces of ground, cut by straight lines.

use std::ops::Range;

use crate::geom::DVec2;

/// A convex quadrilateral, corners counter-clockwise.
///
/// Law: pieces cut from disjoint ranges of u or of v are convex and disjoint, because lines of
/// equal u and lines of equal v are straight.
#[derive(Debug, Clone, Copy)]
pub(super) struct Quad(pub [DVec2; 4]);

impl Quad {
    /// The point at (u, v); the corners are (0, 0), (1, 0), (1, 1), (0, 1).
    pub(super) fn at(&self, u: f64, v: f64) -> DVec2 {
        let [a, b, c, d] = self.0;
        let low = a + (b - a) * u;
        let high = d + (c - d) * u;
        low + (high - low) * v
    }

    /// Mean lengths along u and v, m.
    pub(super) fn size(&self) -> (f64, f64) {
        let [a, b, c, d] = self.0;
        (
            (a.distance(b) + d.distance(c)) * 0.5,
            (a.distance(d) + b.distance(c)) * 0.5,
        )
    }

    /// The piece over these ranges of u and v.
    pub(super) fn piece(&self, u: Range<f64>, v: Range<f64>) -> Self {
        Self([
            self.at(u.start, v.start),
            self.at(u.end, v.start),
            self.at(u.end, v.end),
            self.at(u.start, v.end),
        ])
    }

    /// The same ground with u along the longer side.
    pub(super) fn lengthwise(&self) -> Self {
        let [a, b, c, d] = self.0;
        let (length, depth) = self.size();
        if length < depth {
            Self([b, c, d, a])
        } else {
            *self
        }
    }

    /// Half extents of the largest box about the centre that stays `setback` m off every side,
    /// of about the proportions of the piece itself; `None` when there is no room.
    pub(super) fn room(&self, setback: f64) -> Option<DVec2> {
        let [a, b, c, d] = self.0;
        let center = self.at(0.5, 0.5);
        let (along, across) = ((b + c - a - d).abs() * 0.25, (c + d - a - b).abs() * 0.25);
        let half = along.max(across);
        let scale = [(a, b), (b, c), (c, d), (d, a)]
            .iter()
            .map(|&(p, q)| {
                let inward = (q - p).perp() / p.distance(q);
                (inward.dot(center - p) - setback) / inward.abs().dot(half)
            })
            .fold(f64::INFINITY, f64::min);
        (scale > 0.0).then(|| half * scale)
    }
}
