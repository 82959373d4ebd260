//! How far posts are from a mesh, by looking at each.

use crate::geom::{DVec3, PixelScale, View};
use crate::terrain::{Ground, Mesh, Post, height_on};

/// Largest vertical distance of a post from the triangle over or under it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Worst {
    pub metres: f64,
    /// On the screen; the post and the surface, whichever is nearer.
    pub pixels: f64,
}

/// Over all posts of all triangles.
pub(super) fn worst(ground: &Ground, mesh: &Mesh, view: &View) -> Worst {
    let grid = ground.layout().grid();
    let mut worst = Worst::default();
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
                PixelScale::PerMetre(scale) => metres * scale,
                PixelScale::PerRadian(scale) => metres * scale / at.distance(eye),
            };
            worst.metres = worst.metres.max(metres);
            if metres > 0.0 {
                worst.pixels = worst.pixels.max(pixels);
            }
        }
    }
    worst
}

fn posts_about(corners: [Post; 3]) -> impl Iterator<Item = Post> {
    let span = |axis: usize| {
        let ends = corners.map(|post| post[axis]);
        let least = ends.into_iter().fold(u32::MAX, u32::min);
        least..=ends.into_iter().fold(0, u32::max)
    };
    let columns = span(0);
    span(1).flat_map(move |row| columns.clone().map(move |column| [column, row]))
}
