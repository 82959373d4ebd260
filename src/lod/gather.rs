//! What a node adds to the answer.
//!
//! Every object is stored once, at the highest level it is promoted to, so "the node's objects"
//! of the paper are its own ones and its representative, which an ancestor stores. On the way
//! down from the root the ancestor has added it already; only where the levels that have a range
//! begin below the root is it added with the node.

use std::ops::Range;

use super::lanes;
use super::retrieve::{Traversal, exact};
use crate::geom::{Eight, Lanes, PlaneSet};

impl Traversal<'_> {
    /// Adds the objects of neighbouring nodes inside the frustum (step 3).
    pub(super) fn add_inside(&mut self, level: u32, nodes: Range<u32>) {
        if self.enters(level) {
            for node in nodes.clone() {
                self.add_representative(node, 0);
            }
        }
        self.add_own(level, &nodes);
    }

    /// Adds the objects of a node that are not outside one of `planes` (step 5); of a node that
    /// passes through, none.
    pub(super) fn add_crossing(&mut self, level: u32, node: u32, planes: PlaneSet) {
        if level >= self.ranged_levels {
            return;
        }
        if self.enters(level) {
            self.add_representative(node, planes);
        }
        if let (Some(own), Some(&block)) = (
            self.own(&(node..node + 1)),
            self.arrays.own_block_starts.get(node as usize),
        ) {
            self.add_tested(level, own, block, planes);
        }
    }

    /// Adds all objects of neighbouring nodes, and below them down to level `cut`: one range per
    /// level.
    pub(super) fn add_subtrees(&mut self, level: u32, nodes: Range<u32>, cut: u32) {
        self.add_inside(level, nodes.clone());
        let mut nodes = nodes;
        for below in (cut..level).rev() {
            match self.children(below + 1, &nodes) {
                Some(children) => nodes = children,
                None => return,
            }
            self.add_own(below, &nodes);
        }
    }

    /// The nodes one level below `nodes`, unless they were visited before.
    #[inline]
    pub(super) fn children(&mut self, level: u32, nodes: &Range<u32>) -> Option<Range<u32>> {
        let below = level.checked_sub(1)? as usize;
        let start = *self.arrays.children.get(nodes.start as usize)?;
        let end = *self.arrays.children.get(nodes.end as usize)?;
        let level_end = *self
            .arrays
            .level_nodes
            .get(self.root as usize - below + 1)?;
        let next = self.next.get_mut(below)?;
        if start < *next || end < start || end > level_end {
            return None; // only in a damaged file
        }
        *next = end;
        Some(start..end)
    }

    /// Whether nobody above has added the representatives of nodes at this level: the levels
    /// above have no range.
    fn enters(&self, level: u32) -> bool {
        level < self.root && level + 1 >= self.ranged_levels
    }

    fn own(&self, nodes: &Range<u32>) -> Option<Range<u32>> {
        let start = *self.arrays.own.get(nodes.start as usize)?;
        let end = *self.arrays.own.get(nodes.end as usize)?;
        (start <= end && end as usize <= self.arrays.object_boxes.len()).then_some(start..end)
    }

    fn add_own(&mut self, level: u32, nodes: &Range<u32>) {
        if let Some(own) = self.own(nodes) {
            self.selection.add(level, own);
        }
    }

    /// Adds the object that stands for `node`, stored with an ancestor, unless it is outside one
    /// of `planes`.
    fn add_representative(&mut self, node: u32, planes: PlaneSet) {
        let Some(&object) = self.arrays.representatives.get(node as usize) else {
            return;
        };
        if object as usize >= self.arrays.object_boxes.len() {
            return; // only in a damaged file
        }
        let starts = self.arrays.level_objects;
        let coarser = starts.partition_point(|&start| start <= object) as u32;
        let Some(level) = (self.root + 1).checked_sub(coarser) else {
            return; // only in a damaged file
        };
        if planes == 0
            || exact(self.arrays.object_boxes, object)
                .is_some_and(|exact| !self.view.frustum().is_outside(&exact))
        {
            self.selection.add(level, object..object + 1);
        }
    }

    /// Adds the `objects`, whose boxes begin with `block`, that are not outside one of `planes`.
    fn add_tested(&mut self, level: u32, objects: Range<u32>, block: u32, planes: PlaneSet) {
        if planes == 0 {
            return self.selection.add(level, objects);
        }
        let tested = &mut self.stats.objects_tested;
        // In a damaged file nodes may share objects.
        *tested = tested.saturating_add(objects.end - objects.start);
        let blocks = self.arrays.own_blocks;
        let mut first = objects.start;
        for boxes in blocks.get(block as usize..).unwrap_or_default() {
            if first >= objects.end {
                break;
            }
            let count = (objects.end - first).min(8);
            let mut rest = self.visible(boxes, first, lanes::first(count), planes);
            while rest != 0 {
                let lane = rest.trailing_zeros();
                let run = lanes::run_length(rest, lane);
                let start = first + lane;
                self.selection.add(level, start..start + run);
                rest = lanes::after_run(rest, lane, run);
            }
            first += count;
        }
    }

    /// Which of eight objects are not outside; what f32 leaves open is decided in f64.
    #[inline]
    fn visible(&self, boxes: &Eight, first: u32, set: Lanes, planes: PlaneSet) -> Lanes {
        let (outside, touching) = self.filter.outside_or_touching(boxes, planes);
        let mut visible = set & touching;
        let open = set & !outside & !touching;
        if open != 0 {
            for lane in lanes::each(open) {
                if exact(self.arrays.object_boxes, first + lane)
                    .is_some_and(|exact| !self.view.frustum().is_outside(&exact))
                {
                    visible |= 1 << lane;
                }
            }
        }
        visible
    }
}
