//! A selection as triangles between posts.

use super::ground::Ground;
use super::quadtree::Node;
use super::select::Selection;
use super::triangle::Post;
use crate::geom::DVec3;

/// Triangles between posts of the raster.
///
/// Laws: no triangle faces down or has no area; no two overlap; two that meet share a whole side
/// or a corner, never part of a side. Blocks repeat the posts on their common border.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Columns and rows.
    pub posts: Vec<Post>,
    /// Their heights, m, never NaN.
    pub heights: Vec<f32>,
    /// Three posts each, counter-clockwise from above.
    pub triangles: Vec<[u32; 3]>,
}

/// Numbers of the posts of one block that are in the mesh already.
struct Numbers {
    cells: usize,
    of_post: Vec<u32>,
    used: Vec<usize>,
}

const UNUSED: u32 = u32::MAX;

impl Selection {
    /// The selection's triangles. `ground` is the one it was made of.
    pub fn mesh(&self, ground: &Ground) -> Mesh {
        let mut mesh = Mesh::default();
        let mut numbers = Numbers::new(ground.layout().side() as usize);
        let mut block = None;
        self.cut().facets(ground, |facet| {
            let root = ground.root(facet.node);
            if block.replace(root) != Some(root) {
                numbers.forget();
            }
            let triangle = facet.corners.map(|post| {
                let number = numbers.of(root, post);
                if *number == UNUSED {
                    *number = mesh.posts.len() as u32;
                    mesh.posts.push(post);
                    mesh.heights.push(ground.height(root, post));
                }
                *number
            });
            mesh.triangles.push(triangle);
        });
        mesh
    }
}

impl Mesh {
    /// Where a vertex is, m.
    pub fn position(&self, ground: &Ground, vertex: u32) -> DVec3 {
        let [column, row] = self.posts[vertex as usize];
        let grid = ground.layout().grid();
        let height = f64::from(self.heights[vertex as usize]);
        DVec3::new(grid.x(column), grid.y(row), height)
    }
}

impl Numbers {
    fn new(side: usize) -> Self {
        Self {
            cells: side - 1,
            of_post: vec![UNUSED; side * side],
            used: Vec::new(),
        }
    }

    fn of(&mut self, block: Node, [column, row]: Post) -> &mut u32 {
        let x = column as usize - block.x as usize * self.cells;
        let y = row as usize - block.y as usize * self.cells;
        let at = y * (self.cells + 1) + x;
        if self.of_post[at] == UNUSED {
            self.used.push(at);
        }
        &mut self.of_post[at]
    }

    fn forget(&mut self) {
        for at in self.used.drain(..) {
            self.of_post[at] = UNUSED;
        }
    }
}
