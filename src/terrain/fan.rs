//! The triangles of a cut: two for a block drawn whole, a fan for every split node.

use super::cut::{Cut, State};
use super::ground::Ground;
use super::quadtree::{Node, Quarter};
use super::triangle::{Post, doubled_area};

/// A triangle of a cut and the nodes that it lies in.
#[derive(Debug, Clone, Copy)]
pub struct Facet {
    /// Counter-clockwise from above; never without area.
    pub corners: [Post; 3],
    /// The node whose fan it belongs to, or the block itself.
    pub node: Node,
    /// Quarters of the fan that it lies in, the second one where a midpoint was skipped; `None`
    /// for a block drawn whole.
    pub quarters: Option<[Quarter; 2]>,
}

impl Cut {
    /// Hands every triangle of the cut to `draw`, block by block, coarse fans first.
    pub fn facets(&self, ground: &Ground, mut draw: impl FnMut(Facet)) {
        for (root, block) in self.blocks() {
            if self.state(root) == State::Drawn {
                let corners = ground.layout().posts(root).corners();
                for at in [[0, 1, 2], [0, 2, 3]] {
                    draw(Facet {
                        corners: at.map(|corner: usize| corners[corner]),
                        node: root,
                        quarters: None,
                    });
                }
            }
            for node in block.all_splits(root, self.levels().end) {
                self.fan(ground, node, &mut draw);
            }
        }
    }

    /// Which of the four neighbours of a split node are there to be matched: true where the node
    /// of the same level is split too or no ground is drawn, false where the side's midpoint must
    /// be skipped. South, east, north, west. A midpoint that could be drawn may still be spared
    /// ([`Cut::spares`]).
    ///
    /// Source: A, section 2: a flag array of length 4.
    pub fn flags(&self, node: Node) -> [bool; 4] {
        [0, 1, 2, 3].map(|side| {
            let neighbour = node.across(side);
            neighbour.is_none_or(|n| self.cover(n) != State::Drawn)
        })
    }

    fn fan(&self, ground: &Ground, node: Node, draw: &mut impl FnMut(Facet)) {
        let posts = ground.layout().posts(node);
        let (corners, midpoints) = (posts.corners(), posts.midpoints());
        let drawn = [0, 1, 2, 3].map(|quarter| self.is_drawn(ground, node.child(quarter)));
        let flags = self.flags(node);
        for side in 0..4 {
            let next = (side + 1) % 4;
            let mut facet = |wanted, from, to, quarters| {
                let corners = [posts.middle, from, to];
                if wanted && doubled_area(corners) != 0 {
                    draw(Facet {
                        corners,
                        node,
                        quarters: Some(quarters),
                    });
                }
            };
            if flags[side] && !self.spares(node, side) {
                facet(drawn[side], corners[side], midpoints[side], [side, side]);
                facet(drawn[next], midpoints[side], corners[next], [next, next]);
            } else {
                let any = drawn[side] || drawn[next];
                facet(any, corners[side], corners[next], [side, next]);
            }
        }
    }

    /// Whether a quarter's triangles belong to its parent's fan: it is not split itself, not out
    /// of view and not a hole.
    pub(super) fn is_drawn(&self, ground: &Ground, quarter: Node) -> bool {
        if quarter.level == self.levels().end {
            ground.record(quarter).has_ground()
        } else {
            self.state(quarter) == State::Drawn
        }
    }
}
