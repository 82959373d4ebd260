//! Heights between posts.

use super::field::{Grid, HeightField};
use super::ground::Ground;

/// How heights between posts are found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Interpolation {
    /// From the four posts of the cell.
    Bilinear,
    /// From the sixteen posts around; smooth across cells. Posts that are not known are
    /// extrapolated along their row or column.
    Bicubic,
    /// Bicubic in cells whose heights have at least this standard deviation (m), bilinear in the
    /// others. 0 is bicubic everywhere, infinity bilinear.
    ///
    /// Source: C, section 3.2.
    ByVariance {
        /// T, m.
        threshold: f64,
    },
}

/// A cell of the grid and where in it a point is, 0 to 1 each way.
#[derive(Clone, Copy)]
struct Within {
    cell: [u32; 2],
    at: [f64; 2],
}

impl HeightField {
    /// Height at a point, m; `None` beyond the posts and where a post that counts is unknown.
    ///
    /// Laws: at a post it is the post's height; planes come out as planes.
    pub fn height_at(&self, x: f64, y: f64, how: Interpolation) -> Option<f64> {
        let post = |column, row| f64::from(self.height(column, row));
        how.height(self.grid(), &post, x, y)
    }
}

impl Ground {
    /// Where the vertical line through a point meets the ground at full detail, m; `None` beyond
    /// it, over holes, and where a block that counts is not in memory.
    pub fn raycast(&self, x: f64, y: f64, how: Interpolation) -> Option<f64> {
        let post = |column, row| f64::from(self.post(column, row));
        how.height(self.layout().grid(), &post, x, y)
    }
}

impl Interpolation {
    fn height(self, grid: &Grid, post: &impl Fn(u32, u32) -> f64, x: f64, y: f64) -> Option<f64> {
        let columns = between(x, grid.columns(), |column| grid.x(column))?;
        let rows = between(y, grid.rows(), |row| grid.y(row))?;
        let within = Within {
            cell: [columns.0, rows.0],
            at: [columns.1, rows.1],
        };
        let corners = within.corners(post);
        let bilinear = within.bilinear(corners);
        let cubic = match self {
            Self::Bilinear => false,
            Self::Bicubic => true,
            Self::ByVariance { threshold } => variance(corners) >= threshold * threshold,
        };
        if cubic && !bilinear.is_nan() {
            return Some(within.bicubic(grid, post));
        }
        Some(bilinear).filter(|z| !z.is_nan())
    }
}

/// The post at or before `c`, and what is left to the next one, 0 to 1.
fn between(c: f64, count: u32, post: impl Fn(u32) -> f64) -> Option<(u32, f64)> {
    let last = count - 1;
    if !(c >= post(0) && c <= post(last)) {
        return None;
    }
    if last == 0 {
        return Some((0, 0.0));
    }
    let guess = (c - post(0)) / (post(last) - post(0)) * f64::from(last);
    let mut before = (guess as u32).min(last - 1);
    // The quotient rounds; the posts decide.
    while before > 0 && post(before) > c {
        before -= 1;
    }
    while before + 1 < last && post(before + 1) <= c {
        before += 1;
    }
    let part = (c - post(before)) / (post(before + 1) - post(before));
    Some((before, part))
}

/// Between two values; at either end that one alone, whether the other is known or not.
fn linear(t: f64, a: f64, b: f64) -> f64 {
    if t == 0.0 {
        a
    } else if t == 1.0 {
        b
    } else {
        a * (1.0 - t) + b * t
    }
}

/// The cubic through `b` and `c` with the slopes of central differences. An end that is not known
/// continues the line through the two beside it.
///
/// Source: Keys, "Cubic convolution interpolation for digital image processing", 1981, a = −1/2.
fn cubic(t: f64, [a, b, c, d]: [f64; 4]) -> f64 {
    if t == 0.0 {
        return b;
    }
    if t == 1.0 {
        return c;
    }
    let a = if a.is_nan() { 2.0 * b - c } else { a };
    let d = if d.is_nan() { 2.0 * c - b } else { d };
    let (first, second) = ((c - a) / 2.0, (d - b) / 2.0);
    let turn = c - b;
    b + t * (first + t * ((3.0 * turn - 2.0 * first - second) + t * (first + second - 2.0 * turn)))
}

impl Within {
    fn corners(&self, post: &impl Fn(u32, u32) -> f64) -> [f64; 4] {
        let [x, y] = self.cell;
        [
            post(x, y),
            post(x + 1, y),
            post(x, y + 1),
            post(x + 1, y + 1),
        ]
    }

    /// Source: C, equation (4).
    fn bilinear(&self, [sw, se, nw, ne]: [f64; 4]) -> f64 {
        let [x, y] = self.at;
        linear(y, linear(x, sw, se), linear(x, nw, ne))
    }

    /// Source: C, equation (5), with the coefficients of Keys's cubic.
    fn bicubic(&self, grid: &Grid, post: &impl Fn(u32, u32) -> f64) -> f64 {
        let ([x, y], [tx, ty]) = (self.cell, self.at);
        let known = |column: Option<u32>, row: Option<u32>| match (column, row) {
            (Some(c), Some(r)) if c < grid.columns() && r < grid.rows() => post(c, r),
            _ => f64::NAN,
        };
        let around = |at: u32| {
            [
                at.checked_sub(1),
                Some(at),
                at.checked_add(1),
                at.checked_add(2),
            ]
        };
        let rows = around(y).map(|row| cubic(tx, around(x).map(|column| known(column, row))));
        cubic(ty, rows)
    }
}

/// Of the heights of a cell's four posts, m²; NaN where one is unknown. C compares its square
/// root.
///
/// Source: C, equations (2) and (3).
fn variance(heights: [f64; 4]) -> f64 {
    let mean = heights.iter().sum::<f64>() / 4.0;
    heights.iter().map(|z| (z - mean) * (z - mean)).sum::<f64>() / 4.0
}
