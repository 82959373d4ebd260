//! Which pixels a convex polygon covers: an exact rule, so that neighbours leave no hole.
//!
//! Vertices are snapped to 1/4096 pixel; from there on all is integer arithmetic. A pixel is
//! covered if its centre lies inside the snapped polygon, on a left border or on a horizontal
//! upper border. Two triangles that share an edge share its snapped vertices and step along it in
//! the same integers, so of the centres near it each belongs to exactly one of them. A polygon of
//! more vertices that snapping makes a trifle concave is filled to its hull, row by row.

use std::ops::Range;

use super::projector::LONGEST_SIDE;

/// Steps of a snapped coordinate in a pixel.
const STEPS: i64 = 4096;

/// A point on the buffer in steps of 1/4096 pixel, rounded to nearest.
pub(super) type Snapped = [i32; 2];

/// Clipping keeps places within this of the buffer's corner, pixels, but for a rounding where w is
/// next to 0; products of two such numbers of steps fit 64 bits.
const FARTHEST: f64 = 2.0 * LONGEST_SIDE as f64;

/// Rounds a place on the buffer, pixels. What is not a number, as where w is 0, becomes 0.
pub(super) fn snap(place: [f64; 2]) -> Snapped {
    place.map(|pixels| {
        let steps = pixels.clamp(-FARTHEST, FARTHEST) * STEPS as f64;
        steps.round_ties_even() as i32
    })
}

/// The covered part of consecutive rows.
#[derive(Debug, Default)]
pub(super) struct Spans {
    first_row: i32,
    /// Columns `start..end`, row by row.
    columns: Vec<[i32; 2]>,
}

/// First pixel whose centre is not before a snapped coordinate.
fn pixel_from(coordinate: i32) -> i32 {
    let half = (STEPS / 2) as i32;
    // ⌈(c − ½) / 1⌉ in steps, without overflow.
    (coordinate - half + (STEPS as i32 - 1)).div_euclid(STEPS as i32)
}

impl Spans {
    /// Finds the pixels of a convex polygon, in either winding, within a buffer of this size;
    /// false where there are none.
    pub(super) fn cover(&mut self, polygon: &[Snapped], size: [u32; 2]) -> bool {
        let (mut low, mut high) = ([i32::MAX; 2], [i32::MIN; 2]);
        for vertex in polygon {
            for axis in 0..2 {
                low[axis] = low[axis].min(vertex[axis]);
                high[axis] = high[axis].max(vertex[axis]);
            }
        }
        if polygon.is_empty() {
            return false;
        }
        let [width, height] = size.map(u32::cast_signed);
        let rows = pixel_from(low[1]).max(0)..pixel_from(high[1]).min(height);
        let columns = pixel_from(low[0]).max(0)..pixel_from(high[0]).min(width);
        if rows.is_empty() || columns.is_empty() {
            return false;
        }
        self.first_row = rows.start;
        self.columns.clear();
        self.columns.resize(rows.len(), [i32::MAX, i32::MIN]);
        let mut from = polygon[polygon.len() - 1];
        for &to in polygon {
            self.walk(from, to, rows.end);
            from = to;
        }
        for [start, end] in &mut self.columns {
            *start = (*start).max(0);
            *end = (*end).min(width);
        }
        true
    }

    /// Rows with their covered columns.
    pub(super) fn rows(&self) -> impl Iterator<Item = (i32, Range<i32>)> + '_ {
        let rows = (self.first_row..).zip(&self.columns);
        rows.filter(|(_, [start, end])| start < end)
            .map(|(row, &[start, end])| (row, start..end))
    }

    /// Steps along an edge and widens each row up to it.
    ///
    /// The edge meets the centre line of row j, y = (j + ½) steps, at x = x₀ + (y − y₀) dx / dy;
    /// the pixel from there on is ⌈(x − ½) / 1⌉, here as `numerator / (dy · STEPS)`. From row to
    /// row the numerator grows by dx · STEPS: quotient and remainder are stepped, exactly.
    fn walk(&mut self, from: Snapped, to: Snapped, last_row: i32) {
        let (upper, lower) = if from[1] <= to[1] {
            (from, to)
        } else {
            (to, from)
        };
        let first = pixel_from(upper[1]).max(self.first_row);
        let end = pixel_from(lower[1]).min(last_row);
        if first >= end {
            return;
        }
        let dx = i64::from(lower[0]) - i64::from(upper[0]);
        let dy = i64::from(lower[1]) - i64::from(upper[1]);
        let centre = i64::from(first) * STEPS + STEPS / 2;
        let denominator = dy * STEPS;
        let numerator =
            (i64::from(upper[0]) - STEPS / 2) * dy + (centre - i64::from(upper[1])) * dx;
        // Rounded up: the rest is what is missing.
        let mut column = -(-numerator).div_euclid(denominator);
        let mut rest = (-numerator).rem_euclid(denominator);
        let [start, end] = [first, end].map(|row| (row - self.first_row) as usize);
        let rows = &mut self.columns[start..end];
        if let [only] = rows {
            widen(only, column as i32);
            return;
        }
        let step = dx.div_euclid(dy);
        let step_rest = dx.rem_euclid(dy) * STEPS;
        for row in rows {
            widen(row, column as i32);
            column += step;
            rest -= step_rest;
            if rest < 0 {
                rest += denominator;
                column += 1;
            }
        }
    }
}

fn widen(span: &mut [i32; 2], column: i32) {
    span[0] = span[0].min(column);
    span[1] = span[1].max(column);
}
