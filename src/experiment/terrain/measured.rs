//! How far posts are from a mesh, by looking at each.

use crate::geom::{DVec3, PixelScale, View};
use crate::terrain::{Ground, Mesh, Post, height_on};

/// Vertical distances of posts from the triangle over or under them.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Measured {
    pub worst_m: f64,
    /// On the screen; the post and the surface, whichever is nearer.
    pub worst_px: f64,
    /// Over all posts, each once.
    pub mean_px: f64,
}

/// Over all posts of all triangles.
pub(super) fn measured(ground: &Ground, mesh: &Mesh, view: &View) -> Measured {
    let grid = ground.layout().grid();
    let mut found = Measured::default();
    let (mut seen, mut posts) = (vec![false; grid.count()], 0_u32);
    for triangle in &mesh.triangles {
        let corners = triangle.map(|vertex| mesh.posts[vertex as usize]);
        let heights = triangle.map(|vertex| f64::from(mesh.heights[vertex as usize]));
        for post in posts_about(corners) {
            let (surface, true) = height_on(corners, heights, post) else {
                continue;
            };
            let z = f64::from(ground.post(post[0], post[1]));
            let metres = (surface - z).abs();
            let eye = view.eye();
            let nearest = eye.z.clamp(surface.min(z), surface.max(z));
            let at = DVec3::new(grid.x(post[0]), grid.y(post[1]), nearest);
            let pixels = match view.pixels() {
                _ if metres == 0.0 => 0.0,
                PixelScale::PerMetre(scale) => metres * scale,
                PixelScale::PerRadian(scale) => metres * scale / at.distance(eye),
            };
            found.worst_m = found.worst_m.max(metres);
            found.worst_px = found.worst_px.max(pixels);
            let number = post[1] as usize * grid.columns() as usize + post[0] as usize;
            if !std::mem::replace(&mut seen[number], true) {
                posts += 1;
                found.mean_px += pixels;
            }
        }
    }
    found.mean_px /= f64::from(posts.max(1));
    found
}

/// The posts of the rectangle about a triangle.
pub(super) fn posts_about(corners: [Post; 3]) -> impl Iterator<Item = Post> {
    let span = |axis: usize| {
        let ends = corners.map(|post| post[axis]);
        let least = ends.into_iter().fold(u32::MAX, u32::min);
        least..=ends.into_iter().fold(0, u32::max)
    };
    let columns = span(0);
    span(1).flat_map(move |row| columns.clone().map(move |column| [column, row]))
}
