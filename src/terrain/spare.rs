//! Leaves out midpoints that can be drawn but that nobody needs.
//!
//! The fan of a split node has its four midpoints because of any one of them, or of its middle. A
//! midpoint is needed by a quarter beside it that is split or has a hole, on either side of it, or
//! by itself: if the criterion, asked about the side alone, would split.
//!
//! Source: D, section 2.1: after the test of a box, each vertex is tested by itself.

use super::block::NodeRecord;
use super::criterion::{Criterion, Seen};
use super::cut::Cut;
use super::quadtree::Node;
use super::refine::Judge;
use super::triangle::height_between;
use crate::geom::DVec3;

/// Spares the midpoints of a stitched cut that neither of their two nodes needs.
pub(super) fn spare_midpoints(judge: &Judge, cut: &mut Cut) {
    // C asks how heights are spread over an area; a side has none.
    if judge.criterion == Criterion::Motion {
        return;
    }
    let ground = judge.ground;
    let nodes: Vec<Node> = cut.levels().flat_map(|level| cut.splits(level)).collect();
    for node in nodes {
        let flags = cut.flags(ground, node);
        for side in (0..4).filter(|side| flags[*side]) {
            let neighbour = node.across(side);
            let split = neighbour.filter(|n| cut.state(ground, *n).is_split());
            let needed = judge.needs(cut, node, side)
                || split.is_some_and(|n| judge.needs(cut, n, (side + 2) % 4));
            if !needed {
                cut.spare(ground, node, side);
            }
        }
    }
}

impl Judge<'_> {
    fn needs(&self, cut: &Cut, node: Node, side: usize) -> bool {
        let busy = |quarter: usize| {
            let child = node.child(quarter);
            self.ground.record(child).holes > 0
                || child.level < cut.levels().end && cut.state(self.ground, child).is_split()
        };
        busy(side)
            || busy((side + 1) % 4)
            || self.splits_side(node, side)
            || self.errs_without_midpoint(node, side)
    }

    /// Whether the criterion would split what errs as the side does without its midpoint, seen
    /// there.
    fn splits_side(&self, node: Node, side: usize) -> bool {
        let (layout, grid) = (self.ground.layout(), self.ground.layout().grid());
        let posts = layout.posts(node);
        let (corners, middle) = (posts.corners(), posts.midpoints()[side]);
        let ends = [corners[side], corners[(side + 1) % 4]];
        let z = |post| f64::from(self.ground.height(node, post));
        let error = (z(middle) - height_between(ends, ends.map(z), middle)).abs();
        let record = NodeRecord {
            vertex_error: error as f32,
            error: self.ground.record(node).skipped[side],
            ..NodeRecord::NOTHING
        };
        let vertex = DVec3::new(grid.x(middle[0]), grid.y(middle[1]), z(middle));
        let seen = Seen {
            record: &record,
            to_eye: self.view.eye() - vertex,
            side: layout.side_m(node.level),
            block_side: layout.side_m(0),
        };
        self.criterion.splits(&seen, &self.knobs)
    }
}
