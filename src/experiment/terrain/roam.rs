//! ROAM as a yardstick: triangles bisected at the middle of their longest side, down to an error.
//!
//! The vertices are those of the quadtree; a vertex needs two others, and what it needs is there.
//! Its error is that of the two triangles that it halves, over all posts in them and all that is
//! below: ROAM's wedgies, as thin as they can be.
//!
//! Source: Duchaineau et al., "`ROAMing` terrain: real-time optimally adapting meshes", 1997,
//! with splits forced through the dependencies; Lindstrom and Pascucci, "Terrain simplification
//! simplified", 2002, for the dependencies.

use super::measured::posts_about;
use crate::geom::{DVec3, PixelScale, View};
use crate::terrain::{HeightField, Mesh, height_on};

/// A square field of 2^k + 1 posts a side.
pub(super) struct Roam<'a> {
    field: &'a HeightField,
    side: u32,
    /// For each post: the error, m, of the triangles that it halves, and of all that need it.
    errors: Vec<f32>,
}

/// Two posts that a vertex needs; `None` beyond the border.
type Needs = [Option<[u32; 2]>; 2];

impl<'a> Roam<'a> {
    pub(super) fn new(field: &'a HeightField) -> Self {
        let side = field.grid().columns() - 1;
        let mut roam = Self {
            field,
            side,
            errors: vec![0.0; field.grid().count()],
        };
        let mut step = 1;
        while step < side {
            roam.raise(&roam.midpoints(step), step);
            roam.raise(&roam.middles(step), step);
            step *= 2;
        }
        roam
    }

    /// Middles of sides of length 2·`step`.
    fn midpoints(&self, step: u32) -> Vec<[u32; 2]> {
        self.lattice(step, |x, y| (x + y) % 2 == 1)
    }

    /// Middles of squares of side 2·`step`.
    fn middles(&self, step: u32) -> Vec<[u32; 2]> {
        self.lattice(step, |x, y| x % 2 == 1 && y % 2 == 1)
    }

    fn lattice(&self, step: u32, wanted: impl Fn(u32, u32) -> bool) -> Vec<[u32; 2]> {
        let across = self.side / step + 1;
        let all = (0..across).flat_map(|y| (0..across).map(move |x| [x, y]));
        let wanted = all.filter(|[x, y]| wanted(*x, *y));
        wanted.map(|at| at.map(|c| c * step)).collect()
    }

    /// The posts that `at`, a middle at this step, needs, and the ends of the line it bends. With
    /// that line for their longest side, the triangles that it halves have their right angles at
    /// the former.
    fn about(&self, at: [u32; 2], step: u32) -> (Needs, [[u32; 2]; 2]) {
        let [x, y] = at.map(i64::from);
        let s = i64::from(step);
        let inside = |[x, y]: [i64; 2]| {
            let on = |c: i64| (0..=i64::from(self.side)).contains(&c);
            (on(x) && on(y)).then_some([x as u32, y as u32])
        };
        let end = |[x, y]: [i64; 2]| [x as u32, y as u32];
        let [across, up] = at.map(|c| c / step % 2);
        match (across, up) {
            // On a horizontal or vertical side: the middles of the squares on either side.
            (1, 0) => (
                [inside([x, y - s]), inside([x, y + s])],
                [end([x - s, y]), end([x + s, y])],
            ),
            (0, _) => (
                [inside([x - s, y]), inside([x + s, y])],
                [end([x, y - s]), end([x, y + s])],
            ),
            // In a square: its diagonal runs from the middle of the square above it.
            _ => {
                let falling = (x / s / 2 + y / s / 2) % 2 == 1;
                let corners = |f: i64| [[x - s, y - s * f], [x + s, y + s * f]];
                let (diagonal, other) = if falling { (-1, 1) } else { (1, -1) };
                (corners(other).map(inside), corners(diagonal).map(end))
            }
        }
    }

    fn z(&self, [x, y]: [u32; 2]) -> f32 {
        self.field.height(x, y)
    }

    fn index(&self, [x, y]: [u32; 2]) -> usize {
        (y * (self.side + 1) + x) as usize
    }

    /// Largest vertical distance between a triangle and the posts in it.
    fn distance(&self, triangle: [[u32; 2]; 3]) -> f32 {
        let heights = triangle.map(|post| f64::from(self.z(post)));
        let away = posts_about(triangle).filter_map(|post| {
            let (height, inside) = height_on(triangle, heights, post);
            inside.then(|| (f64::from(self.z(post)) - height).abs())
        });
        away.fold(0.0, f64::max) as f32
    }

    /// Own errors of these posts, and all of it passed on to what they need.
    fn raise(&mut self, posts: &[[u32; 2]], step: u32) {
        for &at in posts {
            let (needs, [a, b]) = self.about(at, step);
            let halved = needs.into_iter().flatten();
            let own = halved.map(|apex| self.distance([apex, a, b]));
            let index = self.index(at);
            let error = own.fold(self.errors[index], f32::max);
            self.errors[index] = error;
            for needed in needs.into_iter().flatten() {
                let needed = self.index(needed);
                self.errors[needed] = self.errors[needed].max(error);
            }
        }
    }

    /// The mesh whose vertices, where left out, err by no more than `most_px` on the screen.
    pub(super) fn mesh(&self, view: &View, most_px: f64) -> Mesh {
        let mut active = vec![false; self.errors.len()];
        let mut step = 1;
        while step < self.side {
            for at in self.midpoints(step).into_iter().chain(self.middles(step)) {
                let index = self.index(at);
                if active[index] || self.error_px(at, view) > most_px {
                    active[index] = true;
                    let (needs, _) = self.about(at, step);
                    for needed in needs.into_iter().flatten() {
                        let needed = self.index(needed);
                        active[needed] = true;
                    }
                }
            }
            step *= 2;
        }
        let mut mesh = Mesh::default();
        let posts = (0..=self.side).flat_map(|y| (0..=self.side).map(move |x| [x, y]));
        mesh.posts.extend(posts);
        mesh.heights.extend_from_slice(self.field.heights());
        let far = self.side;
        for apex in [[far, 0], [0, far]] {
            let base = if apex[0] == 0 {
                [[far, far], [0, 0]]
            } else {
                [[0, 0], [far, far]]
            };
            self.bisect(&active, [apex, base[1], base[0]], &mut mesh.triangles);
        }
        mesh
    }

    /// A triangle, its right angle first, counter-clockwise; in halves where the middle of its
    /// longest side is active.
    fn bisect(&self, active: &[bool], triangle: [[u32; 2]; 3], out: &mut Vec<[u32; 3]>) {
        let [apex, from, to] = triangle;
        let middle = [0, 1].map(|axis| u32::midpoint(from[axis], to[axis]));
        let ends = [from, to, apex];
        if ends.contains(&middle) || !active[self.index(middle)] || is_cell(from, to) {
            out.push(triangle.map(|post| self.index(post) as u32));
        } else {
            self.bisect(active, [middle, to, apex], out);
            self.bisect(active, [middle, apex, from], out);
        }
    }

    fn error_px(&self, at: [u32; 2], view: &View) -> f64 {
        let grid = self.field.grid();
        let error = f64::from(self.errors[self.index(at)]);
        let post = DVec3::new(grid.x(at[0]), grid.y(at[1]), f64::from(self.z(at)));
        match view.pixels() {
            PixelScale::PerMetre(scale) => error * scale,
            PixelScale::PerRadian(scale) => error * scale / post.distance(view.eye()),
        }
    }
}

/// Whether a longest side crosses a single cell: no post is in its middle.
fn is_cell(from: [u32; 2], to: [u32; 2]) -> bool {
    from[0].abs_diff(to[0]).max(from[1].abs_diff(to[1])) < 2
}
