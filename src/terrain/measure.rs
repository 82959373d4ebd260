//! The numbers of a node's record, computed once per block, from the cells up.

use super::block::{Block, NodeRecord};
use super::layout::{Layout, Posts};
use super::quadtree::{Node, QUARTERS, child_number, level_start};
use super::triangle::{Post, doubled_area, height_between, height_on};

/// Sums over the posts of cells, each cell counting its four. Heights are relative to one post
/// of the block, so that high ground loses nothing.
#[derive(Clone, Copy, Default)]
struct Moments {
    count: f64,
    sum: f64,
    squares: f64,
}

struct Measured<'a> {
    layout: &'a Layout,
    block: &'a Block,
    root: Node,
    base: f64,
    records: Vec<NodeRecord>,
}

/// Records of all nodes of a block whose heights are known. `root` is its level-0 node.
pub(super) fn records(layout: &Layout, block: &Block, root: Node) -> Vec<NodeRecord> {
    let known = block.heights().iter().find(|z| !z.is_nan());
    let mut measured = Measured {
        layout,
        block,
        root,
        base: known.map_or(0.0, |&z| f64::from(z)),
        records: vec![NodeRecord::NOTHING; level_start(layout.levels())],
    };
    let mut below: Vec<Moments> = measured
        .nodes(layout.levels())
        .map(|n| measured.cell(n).1)
        .collect();
    for level in (0..layout.levels()).rev() {
        let nodes: Vec<Node> = measured.nodes(level).collect();
        below = nodes
            .into_iter()
            .map(|n| measured.gather(n, &below))
            .collect();
    }
    measured.pattern_errors();
    measured.records
}

impl Measured<'_> {
    /// All nodes of a level, in the order of their numbers.
    fn nodes(&self, level: u32) -> impl Iterator<Item = Node> + use<> {
        let root = self.root;
        (0..1_u32 << (2 * level)).map(move |number| root.numbered(level, number))
    }

    fn z(&self, post: Post) -> f64 {
        f64::from(self.block.height(self.root, post))
    }

    /// What a single cell is: its range, and its moments.
    fn cell(&self, cell: Node) -> (NodeRecord, Moments) {
        let posts = self.layout.posts(cell);
        let mut record = NodeRecord::NOTHING;
        let mut moments = Moments::default();
        if posts.is_flat() {
            return (record, moments);
        }
        let heights = posts
            .corners()
            .map(|post| self.block.height(self.root, post));
        if heights.iter().any(|z| z.is_nan()) {
            record.holes = 1;
            return (record, moments);
        }
        for z in heights {
            record.low = record.low.min(z);
            record.high = record.high.max(z);
            moments.add(f64::from(z) - self.base);
        }
        (record, moments)
    }

    fn record(&self, node: Node) -> NodeRecord {
        if node.level == self.layout.levels() {
            self.cell(node).0
        } else {
            self.records[node.index()]
        }
    }

    /// Everything but the error of the drawn patterns, from the four children up.
    fn gather(&mut self, node: Node, below: &[Moments]) -> Moments {
        let mut record = NodeRecord::NOTHING;
        let mut moments = Moments::default();
        for (quarter, place) in QUARTERS.into_iter().enumerate() {
            let child = self.record(node.child(quarter));
            record.low = record.low.min(child.low);
            record.high = record.high.max(child.high);
            record.vertex_error = record.vertex_error.max(child.vertex_error);
            record.deviation = record.deviation.max(child.deviation);
            record.holes += child.holes;
            moments.join(below[child_number(node.number(), node.level, place) as usize]);
        }
        if record.has_ground() {
            let bend = self.vertex_error(&self.layout.posts(node));
            record.vertex_error = record.vertex_error.max(upward(bend, 0.0));
            record.deviation = record.deviation.max(upward(moments.deviation(), 0.0));
        }
        self.records[node.index()] = record;
        moments
    }

    /// Largest of A's Δh₁ to Δh₆: of the midpoints of the four sides from the sides, and of the
    /// middle from both diagonals. Unknown posts count for nothing.
    fn vertex_error(&self, posts: &Posts) -> f64 {
        let (corners, midpoints) = (posts.corners(), posts.midpoints());
        let sides = (0..4).map(|side| {
            let ends = [corners[side], corners[(side + 1) % 4]];
            let line = height_between(ends, ends.map(|p| self.z(p)), midpoints[side]);
            (self.z(midpoints[side]) - line).abs()
        });
        // A middle that was folded lies beside the diagonal, on one of the triangles it parts.
        let middle = self.z(posts.middle);
        let diagonals = [[0, 1, 2], [0, 2, 3], [1, 2, 3], [1, 3, 0]]
            .into_iter()
            .map(|at| {
                let triangle = at.map(|corner| corners[corner]);
                match self.on_triangle(triangle, posts.middle) {
                    Some(height) => (middle - height).abs(),
                    None => 0.0,
                }
            });
        sides.chain(diagonals).fold(0.0, f64::max)
    }

    /// Height of a triangle of posts above one of them; `None` beside it, or without an area.
    fn on_triangle(&self, triangle: [Post; 3], at: Post) -> Option<f64> {
        if doubled_area(triangle) == 0 {
            return None;
        }
        let (height, inside) = height_on(triangle, triangle.map(|p| self.z(p)), at);
        inside.then_some(height)
    }

    /// Largest vertical distance between a triangle and the posts in it.
    fn distance(&self, triangle: [Post; 3]) -> f64 {
        if doubled_area(triangle) == 0 {
            return 0.0;
        }
        let span = |axis: usize| {
            let ends = triangle.map(|p| p[axis]);
            ends.into_iter().fold(u32::MAX, u32::min)..=ends.into_iter().fold(0, u32::max)
        };
        let heights = triangle.map(|p| self.z(p));
        let posts = span(1).flat_map(|row| span(0).map(move |column| [column, row]));
        posts
            .map(|post| match height_on(triangle, heights, post) {
                (height, true) => (self.z(post) - height).abs(),
                _ => 0.0,
            })
            .fold(0.0, f64::max)
    }

    /// Errors of every pattern that may be drawn: a quarter as two triangles of its parent's fan,
    /// and two quarters with the midpoint between them skipped.
    fn pattern_errors(&mut self) {
        if self.is_whole(self.root) {
            let root = self.layout.posts(self.root).corners();
            for at in [[0, 1, 2], [0, 2, 3]] {
                let half = at.map(|corner: usize| root[corner]);
                let error = self.distance(half);
                self.raise_error(self.root, |record| &mut record.whole, error);
            }
        }
        for level in 0..self.layout.levels() {
            for node in self.nodes(level) {
                self.fan_errors(node);
            }
        }
        // From the bottom up: a node may be drawn as any pattern below it.
        for level in (0..self.layout.levels() - 1).rev() {
            for node in self.nodes(level) {
                for quarter in 0..4 {
                    let below = self.record(node.child(quarter));
                    let record = &mut self.records[node.index()];
                    record.error = record.error.max(below.error);
                    record.margin = record.margin.max(below.margin);
                }
            }
        }
    }

    /// Whether a node may be drawn in one piece: it has no hole.
    fn is_whole(&self, node: Node) -> bool {
        self.record(node).holes == 0
    }

    fn fan_errors(&mut self, node: Node) {
        if !self.record(node).has_ground() {
            return;
        }
        let posts = self.layout.posts(node);
        let (corners, midpoints, middle) = (posts.corners(), posts.midpoints(), posts.middle);
        for side in 0..4 {
            let next = (side + 1) % 4;
            let quarters = [side, next].map(|quarter| node.child(quarter));
            let whole = quarters.map(|q| self.is_whole(q));
            let halves = [
                [middle, corners[side], midpoints[side]],
                [middle, midpoints[side], corners[next]],
            ];
            for k in 0..2 {
                if whole[k] {
                    let error = self.distance(halves[k]);
                    self.raise_error(quarters[k], |record| &mut record.whole, error);
                }
            }
            if whole == [true, true] {
                let error = self.distance([middle, corners[side], corners[next]]);
                self.raise_error(node, |record| &mut record.skipped[side], error);
                // Splitting the quarters does not mend it, but it is drawn over them.
                for quarter in quarters {
                    self.raise(quarter, |record| &mut record.margin, error);
                }
            }
        }
    }

    /// Raises the error of a pattern, and that of its node and its margin with it.
    fn raise_error(
        &mut self,
        node: Node,
        pattern: impl Fn(&mut NodeRecord) -> &mut f32,
        error: f64,
    ) {
        self.raise(node, pattern, error);
        self.raise(node, |record| &mut record.error, error);
        self.raise(node, |record| &mut record.margin, error);
    }

    /// Raises one number of a record. A cell has no record, and no post that errs.
    fn raise(&mut self, node: Node, which: impl Fn(&mut NodeRecord) -> &mut f32, error: f64) {
        if node.level == self.layout.levels() {
            return;
        }
        let all = self.records[self.root.index()];
        let magnitude = f64::from(all.low.abs().max(all.high.abs()));
        let number = which(&mut self.records[node.index()]);
        *number = number.max(upward(error, magnitude));
    }
}

impl Moments {
    fn add(&mut self, height: f64) {
        self.count += 1.0;
        self.sum += height;
        self.squares += height * height;
    }

    fn join(&mut self, other: Self) {
        self.count += other.count;
        self.sum += other.sum;
        self.squares += other.squares;
    }

    /// The square root of the variance, which C's equation (3) calls the variance.
    fn deviation(&self) -> f64 {
        let mean = self.sum / self.count;
        (self.squares / self.count - mean * mean).max(0.0).sqrt()
    }
}

/// An f32 no less than a length that was computed from heights up to `magnitude`: three products
/// and sums and a quotient round by less than 8 units of the heights. Zero stays zero.
fn upward(length: f64, magnitude: f64) -> f32 {
    if length == 0.0 {
        return 0.0;
    }
    ((length + 8.0 * f64::EPSILON * magnitude) as f32).next_up()
}
