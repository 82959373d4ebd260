//! The traversal: breadth first from the blocks down, two queues, one level at a time.

use rayon::prelude::*;

use super::criterion::{Criterion, Knobs, Seen};
use super::cut::{BlockCut, Cut, State};
use super::ground::Ground;
use super::quadtree::Node;
use crate::geom::View;

/// One thread or all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Workers {
    /// The calling thread.
    #[default]
    One,
    /// The threads of the current rayon pool.
    Pool,
}

/// How a view judges nodes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Judge<'a> {
    pub ground: &'a Ground,
    pub view: &'a View,
    pub criterion: Criterion,
    pub knobs: Knobs,
    /// What errs by more on the screen is drawn in parts, whatever the criterion says.
    pub max_error_px: f64,
}

impl Judge<'_> {
    /// What a node is by itself.
    ///
    /// A node with holes is split down to the cells, so that holes are drawn as they are. A
    /// single cell has nothing to be split into.
    pub fn state(&self, node: Node) -> State {
        let record = self.ground.record(node);
        let bounds = self.ground.bounds(node, &record);
        if !record.has_ground() || self.view.frustum().is_outside(&bounds) {
            return State::Hidden;
        }
        if record.is_mixed() {
            return State::Split;
        }
        let posts = self.ground.layout().posts(node);
        let cells = [0, 1].map(|axis| posts.last[axis] - posts.first[axis]);
        let seen = Seen {
            record: &record,
            to_eye: self.view.eye() - bounds.center(),
            side: self.ground.layout().side_m(node.level),
            block_side: self.ground.layout().side_m(0),
        };
        let splits =
            || self.criterion.splits(&seen, &self.knobs) || self.errs(record.error, &bounds);
        if cells != [1, 1] && splits() {
            State::Split
        } else {
            State::Drawn
        }
    }

    /// The state of a node that is not to be split.
    pub fn whole(&self, node: Node) -> State {
        let record = self.ground.record(node);
        let bounds = self.ground.bounds(node, &record);
        if !record.has_ground() || self.view.frustum().is_outside(&bounds) {
            State::Hidden
        } else {
            State::Drawn
        }
    }

    /// Breadth first through one block: the nodes of a level are judged, the children of those
    /// that are split wait in the second queue, and the queues are swapped.
    ///
    /// Source: A, section 1.3.
    fn refine_block(&self, root: Node) -> Option<BlockCut> {
        let layout = self.ground.layout();
        self.ground.block_of(root)?;
        let mut cut = BlockCut::new(layout.levels());
        let (mut current, mut next) = (vec![root], Vec::new());
        while !current.is_empty() {
            for node in current.drain(..) {
                let state = self.state(node);
                cut.states[node.index()] = state;
                if state == State::Split {
                    cut.splits[node.level as usize].push(node);
                    if node.level + 1 < layout.levels() {
                        next.extend((0..4).map(|quarter| node.child(quarter)));
                    }
                }
            }
            std::mem::swap(&mut current, &mut next);
        }
        // A block out of view is as good as one that was never looked at.
        (cut.states[0] != State::Hidden).then_some(cut)
    }

    /// The cut as the criterion alone makes it, without regard to neighbours.
    ///
    /// With a pool, blocks are the queue from which its threads take work; judging a node costs
    /// less than handing it over, so a thread goes on with a block to the end. The result is the
    /// same.
    ///
    /// Source: D, section 2.3.
    pub fn refine(&self, workers: Workers) -> Cut {
        let layout = self.ground.layout();
        let numbers = 0..layout.block_count();
        let refine = |number| self.refine_block(layout.block(number));
        let blocks = match workers {
            Workers::One => numbers.map(refine).collect(),
            Workers::Pool => numbers.into_par_iter().map(refine).collect(),
        };
        Cut::new(self.ground, blocks)
    }
}
