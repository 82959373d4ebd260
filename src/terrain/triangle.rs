//! A triangle between posts, in whole numbers.

/// A post by column and row.
pub type Post = [u32; 2];

/// Twice the area of a triangle of posts, in cells; positive where it runs counter-clockwise.
pub fn doubled_area([a, b, c]: [Post; 3]) -> i64 {
    let [ax, ay] = a.map(i64::from);
    let [bx, by] = b.map(i64::from);
    let [cx, cy] = c.map(i64::from);
    (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
}

/// Height of the plane through three posts above `at`, and whether `at` lies in the closed
/// triangle. The triangle must have an area. Where all three heights are equal, so is the result.
pub fn height_on(triangle: [Post; 3], heights: [f64; 3], at: Post) -> (f64, bool) {
    let [a, b, c] = triangle;
    let weights = [[at, b, c], [a, at, c], [a, b, at]].map(doubled_area);
    let area = doubled_area(triangle);
    let sum: f64 = weights
        .iter()
        .zip(heights)
        .map(|(&weight, height)| weight as f64 * height)
        .sum();
    let inside = weights.iter().all(|&w| w == 0 || (w > 0) == (area > 0));
    (sum / area as f64, inside)
}

/// Height of the line between two posts that share a column or row, above a third between them.
pub fn height_between([a, b]: [Post; 2], [za, zb]: [f64; 2], at: Post) -> f64 {
    let along = |p: Post| f64::from(p[0].abs_diff(a[0]) + p[1].abs_diff(a[1]));
    if a == b || za == zb {
        za
    } else {
        za + (zb - za) * (along(at) / along(b))
    }
}
