//! Ids and depths, pixel by pixel.

use super::clip::{self, Point, Polygon};
use super::coverage::{Snapped, Spans, snap};
use super::projector::{DEPTH, FAR, Gradient, LONGEST_SIDE, NEAR, Projector, W, X, Y};
use crate::geom::{Aabb, DVec3};

/// The id of pixels where nothing is drawn.
pub const NONE: u32 = u32::MAX;

/// Which object is seen at each pixel, and at which depth.
///
/// Surfaces are opaque and have two sides. A pixel shows the nearest surface on the ray through
/// its centre, between the near and the far side of the view; of equally near ones, that with the
/// lowest id. So the picture does not depend on the order of drawing. Coverage is decided on
/// vertices snapped to 1/4096 pixel, depth on the exact planes.
#[derive(Debug)]
pub struct IdBuffer {
    width: u32,
    height: u32,
    ids: Vec<u32>,
    depth: Vec<f64>,
    spans: Spans,
    vertices: Vec<Point>,
}

impl IdBuffer {
    /// An empty buffer of width × height pixels, each at most [`LONGEST_SIDE`].
    pub fn new(width: u32, height: u32) -> Self {
        let [width, height] = [width, height].map(|side| side.min(LONGEST_SIDE));
        let pixels = width as usize * height as usize;
        Self {
            width,
            height,
            ids: vec![NONE; pixels],
            depth: vec![f64::INFINITY; pixels],
            spans: Spans::default(),
            vertices: Vec::new(),
        }
    }

    /// Removes everything drawn.
    pub fn clear(&mut self) {
        self.ids.fill(NONE);
        self.depth.fill(f64::INFINITY);
    }

    /// Width × height, pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// The id at a pixel, where something is drawn.
    pub fn id(&self, column: u32, row: u32) -> Option<u32> {
        let inside = column < self.width && row < self.height;
        let at = row as usize * self.width as usize + column as usize;
        inside.then(|| self.ids[at]).filter(|&id| id != NONE)
    }

    /// Ids row by row from the top, [`NONE`] where nothing is drawn.
    pub fn ids(&self) -> &[u32] {
        &self.ids
    }

    /// Depths row by row from the top: −1/metres along the line of sight in perspective, metres in
    /// parallel projections ([`Projector::metres`]). Less is nearer; infinite where nothing is
    /// drawn. Affine across a plane.
    pub fn depth(&self) -> &[f64] {
        &self.depth
    }

    /// Each id that is seen with the number of its pixels, ids ascending.
    pub fn visible_pixels(&self) -> Vec<(u32, u32)> {
        let runs = self.ids.chunk_by(|a, b| a == b);
        let mut runs: Vec<(u32, u32)> = runs
            .filter(|run| run[0] != NONE)
            .map(|run| (run[0], run.len() as u32))
            .collect();
        runs.sort_unstable();
        runs.dedup_by(|run, kept| {
            let same = run.0 == kept.0;
            kept.1 += if same { run.1 } else { 0 };
            same
        });
        runs
    }

    /// Draws the surface of a box: of one beyond the near side, the faces that turn to the eye
    /// are all that can be seen of it; of one that the near side cuts open, also what lies behind.
    ///
    /// `id` is any number but [`NONE`].
    pub fn draw_box(&mut self, projector: &Projector, b: &Aabb, id: u32) {
        if b.is_empty() {
            return;
        }
        let corners = projector.corners(b);
        if misses_the_window(&corners) {
            return;
        }
        let points: [Point; 8] = std::array::from_fn(|i| corners.map(|form| form[i]));
        let outside = points.each_ref().map(clip::outside);
        // Which of the two is the near side, a matrix leaves open.
        let cut_open = [NEAR, FAR, W]
            .iter()
            .any(|&f| corners[f].iter().any(|&v| v <= 0.0));
        let places = points
            .each_ref()
            .map(|p| snap(projector.place(p[X], p[Y], p[W])));
        let depths = corners[DEPTH].map(|metres| projector.screen_depth(metres));
        for axis in 0..3 {
            for (at_max, coordinate) in [b.min()[axis], b.max()[axis]].into_iter().enumerate() {
                let side = if at_max == 0 { 1.0 } else { -1.0 };
                if !cut_open && !projector.faces(axis, coordinate, side) {
                    continue;
                }
                let face = face(axis, at_max);
                let plane = projector.axis_depth(axis, coordinate);
                let sides = face.iter().fold(0, |sides, &i| sides | outside[i]);
                if sides == 0 {
                    let range = range(face.map(|i| depths[i]));
                    self.fill(&face.map(|i| places[i]), plane, range, id);
                } else {
                    self.fill_cut(projector, &face.map(|i| points[i]), sides, plane, id);
                }
            }
        }
    }

    /// Draws triangles, seen from both sides. Ones without area, with a vertex that is not
    /// finite, or with a number past the last vertex, are left out.
    pub fn draw_mesh(
        &mut self,
        projector: &Projector,
        vertices: &[DVec3],
        triangles: &[[u32; 3]],
        id: u32,
    ) {
        let each = triangles.iter().map(|&triangle| (triangle, id));
        self.draw_triangles(projector, vertices, each);
    }

    /// The same with an id for each triangle.
    pub fn draw_triangles(
        &mut self,
        projector: &Projector,
        vertices: &[DVec3],
        triangles: impl IntoIterator<Item = ([u32; 3], u32)>,
    ) {
        let mut points = std::mem::take(&mut self.vertices);
        points.clear();
        points.extend(vertices.iter().map(|&vertex| projector.point(vertex)));
        for (triangle, id) in triangles {
            let [Some(&a), Some(&b), Some(&c)] = triangle.map(|i| vertices.get(i as usize)) else {
                continue;
            };
            if !(a.is_finite() && b.is_finite() && c.is_finite()) {
                continue;
            }
            let Some(plane) = projector.triangle_depth([a, b, c]) else {
                continue;
            };
            let corners = triangle.map(|i| points[i as usize]);
            let sides = corners.iter().fold(0, |sides, p| sides | clip::outside(p));
            if sides == 0 {
                let places = corners.map(|p| snap(projector.place(p[X], p[Y], p[W])));
                let depths = corners.map(|p| projector.screen_depth(p[DEPTH]));
                self.fill(&places, plane, range(depths), id);
            } else {
                self.fill_cut(projector, &corners, sides, plane, id);
            }
        }
        self.vertices = points;
    }

    /// Fills what `sides` leave of a polygon.
    fn fill_cut(
        &mut self,
        projector: &Projector,
        corners: &[Point],
        sides: u32,
        plane: Gradient,
        id: u32,
    ) {
        let mut polygon = Polygon::of(corners);
        clip::clip(&mut polygon, sides);
        let points = polygon.points();
        let mut places = [Snapped::default(); clip::MOST_VERTICES];
        for (place, point) in places.iter_mut().zip(points) {
            *place = snap(projector.place(point[X], point[Y], point[W]));
        }
        let depths = points.iter().map(|p| projector.screen_depth(p[DEPTH]));
        self.fill(&places[..points.len()], plane, range(depths), id);
    }

    /// Fills a convex polygon on a plane. Where the plane is seen edge-on, centres that snapping
    /// moved over its border would lie anywhere on it: depth is kept within that of the vertices.
    fn fill(
        &mut self,
        polygon: &[Snapped],
        plane: Gradient,
        [nearest, farthest]: [f64; 2],
        id: u32,
    ) {
        if !self.spans.cover(polygon, self.size()) {
            return;
        }
        for (row, columns) in self.spans.rows() {
            let start = plane.constant + plane.down * f64::from(row);
            let at = row as usize * self.width as usize;
            let pixels = at + columns.start as usize..at + columns.end as usize;
            let depths = &mut self.depth[pixels.clone()];
            let ids = &mut self.ids[pixels];
            for ((column, depth), pixel) in columns.zip(depths).zip(ids) {
                let here = start + plane.across * f64::from(column);
                let here = here.max(nearest).min(farthest);
                let seen = here < *depth || (here == *depth && id < *pixel);
                *depth = if seen { here } else { *depth };
                *pixel = if seen { id } else { *pixel };
            }
        }
    }
}

/// Numbers of the corners of a face, in a circle.
fn face(axis: usize, at_max: usize) -> [usize; 4] {
    let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
    let corner = at_max << axis;
    [corner, corner + u, corner + u + v, corner + v]
}

/// Whether all corners lie beyond one side of the window.
fn misses_the_window(corners: &[[f64; 8]; 6]) -> bool {
    let w = &corners[W];
    let beyond = |height: &dyn Fn(usize) -> f64| (0..8).all(|i| height(i) < 0.0);
    beyond(&|i| w[i] + corners[X][i])
        || beyond(&|i| w[i] - corners[X][i])
        || beyond(&|i| w[i] + corners[Y][i])
        || beyond(&|i| w[i] - corners[Y][i])
        || beyond(&|i| corners[NEAR][i])
        || beyond(&|i| corners[FAR][i])
}

fn range(depths: impl IntoIterator<Item = f64>) -> [f64; 2] {
    depths
        .into_iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], depth| {
            [low.min(depth), high.max(depth)]
        })
}
