use std::collections::{BTreeSet, HashSet};

use citylod::geom::{Aabb, DVec3, PixelScale, View};
use citylod::terrain::{HeightField, Mesh};

type Post = [u32; 2];

/// What a mesh comes to.
pub struct Found {
    /// Largest vertical distance of a post in a triangle from it, m.
    pub error_m: f64,
    /// The same on the screen, pixels.
    pub error_px: f64,
}

/// Rounding of heights interpolated here, relative to the largest.
const ROUNDING: f64 = 1e-14;

/// Whether the cell with this south-west post is ground.
fn is_ground(field: &HeightField, [x, y]: Post) -> bool {
    let grid = field.grid();
    x + 1 < grid.columns()
        && y + 1 < grid.rows()
        && [[0, 0], [1, 0], [0, 1], [1, 1]]
            .iter()
            .all(|[dx, dy]| !field.height(x + dx, y + dy).is_nan())
}

/// Twice the signed area of a, b and c.
fn turn(a: [i64; 2], b: [i64; 2], c: [i64; 2]) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Panics where the mesh breaks a law. With a view, ground that may be in view must be covered;
/// without one, all of it.
pub fn examine(field: &HeightField, mesh: &Mesh, view: Option<&View>) {
    let corner = |vertex: u32| mesh.posts[vertex as usize];
    for (post, height) in mesh.posts.iter().zip(&mesh.heights) {
        let z = field.height(post[0], post[1]);
        assert!(
            height == &z && !z.is_nan(),
            "height {height} for {z} at {post:?}"
        );
    }
    let triangles: Vec<[Post; 3]> = mesh.triangles.iter().map(|t| t.map(corner)).collect();
    edges(field, &triangles, view.is_none());
    coverage(field, &triangles, view);
}

/// Each side belongs to one triangle, or to two that run along it in opposite directions; no
/// corner lies within a side; where everything is drawn, single sides run along the border of
/// the ground.
fn edges(field: &HeightField, triangles: &[[Post; 3]], whole: bool) {
    let corners: HashSet<Post> = triangles.iter().flatten().copied().collect();
    let mut sides = BTreeSet::new();
    for [a, b, c] in triangles {
        for side in [(*a, *b), (*b, *c), (*c, *a)] {
            assert!(sides.insert(side), "{side:?} twice in one direction");
        }
    }
    for (from, to) in &sides {
        let (dx, dy) = (
            i64::from(to[0]) - i64::from(from[0]),
            i64::from(to[1]) - i64::from(from[1]),
        );
        let steps = i64::from(gcd(dx.unsigned_abs() as u32, dy.unsigned_abs() as u32));
        let single = !sides.contains(&(*to, *from));
        for step in 0..steps {
            let at = [from[0], from[1]].map(i64::from);
            let at = [at[0] + dx / steps * step, at[1] + dy / steps * step];
            let post = at.map(|c| u32::try_from(c).unwrap());
            assert!(
                step == 0 || !corners.contains(&post),
                "{post:?} within {from:?}-{to:?}"
            );
            if single && whole {
                let [px, py] = at;
                // Cells to the left and right of the step.
                let beside = match (dx.signum(), dy.signum()) {
                    (1, 0) => [[px, py], [px, py - 1]],
                    (-1, 0) => [[px - 1, py - 1], [px - 1, py]],
                    (0, 1) => [[px - 1, py], [px, py]],
                    (0, -1) => [[px, py - 1], [px - 1, py - 1]],
                    _ => panic!("{from:?}-{to:?} is single and runs across"),
                };
                let ground = beside.map(|cell| match cell.map(u32::try_from) {
                    [Ok(x), Ok(y)] => is_ground(field, [x, y]),
                    _ => false,
                });
                assert_eq!(
                    ground,
                    [true, false],
                    "a crack along {from:?}-{to:?} at {post:?}"
                );
            }
        }
    }
}

/// Two points of each cell, on either side of both diagonals and on no line between posts, are
/// covered once, or not at all where there is no ground; ground that may be in view is covered.
fn coverage(field: &HeightField, triangles: &[[Post; 3]], view: Option<&View>) {
    const UNIT: i64 = 1 << 20;
    const POINTS: [[i64; 2]; 4] = [
        [524_309, 131_101],
        [917_503, 500_009],
        [500_029, 950_039],
        [130_003, 524_287],
    ];
    let grid = field.grid();
    let columns = grid.columns() as usize;
    let mut times = vec![[0_u8; 4]; field.heights().len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|p| p.map(|c| i64::from(c) * UNIT));
        assert!(turn(a, b, c) > 0, "{triangle:?} faces down or has no area");
        let [x, y] = [0, 1].map(|axis| {
            let ends = triangle.map(|p| p[axis]);
            *ends.iter().min().unwrap()..*ends.iter().max().unwrap()
        });
        for (row, column) in y.flat_map(|row| x.clone().map(move |column| (row, column))) {
            for (n, [px, py]) in POINTS.into_iter().enumerate() {
                let at = [i64::from(column) * UNIT + px, i64::from(row) * UNIT + py];
                let turns = [turn(a, b, at), turn(b, c, at), turn(c, a, at)];
                assert!(
                    !turns.contains(&0),
                    "the point is on a line: choose another"
                );
                if turns.iter().all(|t| *t > 0) {
                    times[row as usize * columns + column as usize][n] += 1;
                }
            }
        }
    }
    for row in 0..grid.rows() {
        for column in 0..grid.columns() {
            let covered = times[row as usize * columns + column as usize];
            if !is_ground(field, [column, row]) {
                assert_eq!(covered, [0; 4], "a hole is covered at {column}, {row}");
                continue;
            }
            assert!(
                covered.iter().all(|n| *n <= 1),
                "{covered:?} at {column}, {row}"
            );
            let posts = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[dx, dy]| {
                let (column, row) = (column + dx, row + dy);
                DVec3::new(
                    grid.x(column),
                    grid.y(row),
                    f64::from(field.height(column, row)),
                )
            });
            let hidden = view.is_some_and(|v| v.frustum().is_outside(&Aabb::around(posts)));
            assert!(
                hidden || covered == [1; 4],
                "{covered:?} at {column}, {row}"
            );
        }
    }
}

/// How far posts are from the mesh, by brute force.
pub fn measure(field: &HeightField, mesh: &Mesh, view: &View) -> Found {
    let grid = field.grid();
    let mut found = Found {
        error_m: 0.0,
        error_px: 0.0,
    };
    let z = |p: Post| f64::from(field.height(p[0], p[1]));
    for triangle in &mesh.triangles {
        let posts = triangle.map(|vertex| mesh.posts[vertex as usize]);
        let [a, b, c] = posts.map(|p| p.map(i64::from));
        let area = turn(a, b, c) as f64;
        let [x, y] = [0, 1].map(|axis| {
            let ends = posts.map(|p| p[axis]);
            *ends.iter().min().unwrap()..=*ends.iter().max().unwrap()
        });
        for (row, column) in y.flat_map(|row| x.clone().map(move |column| (row, column))) {
            let at = [i64::from(column), i64::from(row)];
            let weights = [turn(b, c, at), turn(c, a, at), turn(a, b, at)];
            if weights.iter().any(|w| *w < 0) {
                continue;
            }
            let heights = posts.map(z);
            let surface = weights
                .iter()
                .zip(heights)
                .map(|(w, z)| *w as f64 / area * z)
                .sum::<f64>();
            let post = z([column, row]);
            let largest = heights.iter().fold(post.abs(), |most, z| most.max(z.abs()));
            let error = (surface - post).abs() - largest * ROUNDING;
            if error <= 0.0 {
                continue;
            }
            // From the eye to the nearer end of the gap, or to the gap itself beside it.
            let eye = view.eye();
            let nearest = eye.z.clamp(surface.min(post), surface.max(post));
            let at = DVec3::new(grid.x(column), grid.y(row), nearest);
            let px = match view.pixels() {
                PixelScale::PerMetre(scale) => error * scale,
                PixelScale::PerRadian(scale) => error * scale / at.distance(eye),
            };
            found.error_m = found.error_m.max(error);
            found.error_px = found.error_px.max(px);
        }
    }
    found
}
