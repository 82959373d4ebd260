//! Leaves out midpoints that can be drawn but that nobody needs.
//!
//! The fan of a split node has its four midpoints because of any one of them, or of its middle. A
//! midpoint is needed by a quarter beside it that is split or has a hole, on either side of it, or
//! by itself: if the criterion, asked about the side alone, would split.
//!
//! Source: D, section 2.1: after the test of a box, each vertex is tested by itself.

use super::cut::Cut;
use super::judge::Judge;
use super::quadtree::Node;

/// Spares the midpoints of a stitched cut that neither of their two nodes needs.
pub(super) fn spare_midpoints(judge: &Judge, cut: &mut Cut) {
    let nodes: Vec<Node> = cut.levels().flat_map(|level| cut.splits(level)).collect();
    for node in nodes {
        let flags = cut.flags(node);
        for side in (0..4).filter(|side| flags[*side]) {
            let neighbour = node.across(side);
            let split = neighbour.filter(|n| cut.state(*n).is_split());
            let needed = needs(judge, cut, node, side)
                || split.is_some_and(|n| needs(judge, cut, n, (side + 2) % 4));
            if !needed {
                cut.spare(node, side);
            }
        }
    }
}

/// Whether a split node needs the midpoint of a side.
fn needs(judge: &Judge, cut: &Cut, node: Node, side: usize) -> bool {
    let busy = |quarter: usize| {
        let child = node.child(quarter);
        judge.ground.record(child).holes > 0 || cut.state(child).is_split()
    };
    busy(side) || busy((side + 1) % 4) || judge.splits_side(node, side)
}
