//! What a node adds to the answer.
//!
//! Every object is stored once, at the highest level it is promoted to, so "the node's objects"
//! of the paper are its own ones and its representative, which an ancestor stores. On the way
//! down from the root the ancestor has added it already; only where the levels that have a range
//! begin below the root is it added with the node.

use std::ops::Range;

use super::lanes;
use super::retrieve::Traversal;
use crate::geom::{Aabb, Eight, EightRelations, Lanes, PlaneSet, View};

impl Traversal<'_> {
    /// Adds the objects of the siblings in `set`, which have a range: all of those inside the
    /// frustum (step 3), of others what is not outside (step 5).
    #[inline]
    pub(super) fn add(&mut self, level: u32, first: u32, set: Lanes, relations: &EightRelations) {
        if self.enters(level) {
            self.add_representatives(first, set, relations);
        }
        let inside = set & relations.inside;
        let mut rest = set;
        while rest != 0 {
            let lane = rest.trailing_zeros();
            let node = first + lane;
            let run = if lanes::has(inside, lane) {
                let run = lanes::run_length(inside, lane);
                self.add_own(level, &(node..node + run));
                run
            } else {
                self.add_crossing(level, node, relations.open_planes(lane));
                1
            };
            rest = lanes::after_run(rest, lane, run);
        }
    }

    /// Adds a node's own objects that are not outside one of `planes`.
    #[inline]
    fn add_crossing(&mut self, level: u32, node: u32, planes: PlaneSet) {
        if let (Some(own), Some(&block)) = (
            self.own(&(node..node + 1)),
            self.arrays.own_block_starts.get(node as usize),
        ) {
            self.add_tested(level, own, block, planes);
        }
    }

    /// Adds all objects below neighbouring nodes, down to level `cut`: one range per level. The
    /// nodes' own objects have been added, unless they pass through.
    pub(super) fn add_subtrees(&mut self, level: u32, nodes: Range<u32>, cut: u32) {
        if level >= self.ranged_levels {
            if self.enters(level) {
                for node in nodes.clone() {
                    self.add_representative(node, 0);
                }
            }
            self.add_own(level, &nodes);
        }
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
        let start = *self.arrays.children.get(nodes.start as usize)?;
        let end = *self.arrays.children.get(nodes.end as usize)?;
        let below = self.levels.get_mut(level.checked_sub(1)? as usize)?;
        if start < below.next || end < start || end > below.end {
            return None; // only in a damaged file
        }
        below.next = end;
        Some(start..end)
    }

    /// Whether nobody above has added the representatives of nodes at this level: the levels
    /// above have no range.
    #[inline]
    fn enters(&self, level: u32) -> bool {
        level < self.root && level + 1 >= self.ranged_levels
    }

    #[inline]
    fn own(&self, nodes: &Range<u32>) -> Option<Range<u32>> {
        let start = *self.arrays.own.get(nodes.start as usize)?;
        let end = *self.arrays.own.get(nodes.end as usize)?;
        (start <= end && end as usize <= self.arrays.object_boxes.len()).then_some(start..end)
    }

    #[inline]
    fn add_own(&mut self, level: u32, nodes: &Range<u32>) {
        if let Some(own) = self.own(nodes) {
            self.selection.add(level, own);
        }
    }

    /// Adds the objects that stand for the siblings in `set`.
    #[cold]
    fn add_representatives(&mut self, first: u32, set: Lanes, relations: &EightRelations) {
        for lane in lanes::each(set) {
            self.add_representative(first + lane, relations.open_planes(lane));
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
            || Aabb::nth(self.arrays.object_boxes, object)
                .is_some_and(|exact| !self.view.frustum().is_outside_of(planes, &exact))
        {
            self.selection.add(level, object..object + 1);
        }
    }

    /// Adds the `objects`, whose boxes begin with `block`, that are not outside one of `planes`.
    #[inline]
    fn add_tested(&mut self, level: u32, objects: Range<u32>, block: u32, planes: PlaneSet) {
        let tested = &mut self.stats.objects_tested;
        // In a damaged file nodes may share objects.
        *tested = tested.saturating_add(objects.end - objects.start);
        let mut first = objects.start;
        let mut block = block as usize;
        while first < objects.end {
            let Some(boxes) = self.arrays.own_blocks.get(block) else {
                return; // only in a damaged file
            };
            let count = (objects.end - first).min(8);
            let visible = self.visible(boxes, first, lanes::first(count), planes);
            self.selection.add_runs(level, first, visible);
            first += count;
            block += 1;
        }
    }

    /// Which of eight objects are not outside; what f32 leaves open is decided in f64.
    #[inline]
    fn visible(&self, boxes: &Eight, first: u32, set: Lanes, planes: PlaneSet) -> Lanes {
        let (outside, touching) = self.filter.outside_or_touching(boxes, planes);
        let open = set & !(outside | touching);
        if open == 0 {
            set & touching
        } else {
            set & touching | not_outside(self.view, self.arrays.object_boxes, first, open)
        }
    }
}

/// Which of eight objects from `first` on are not outside the frustum, decided in f64.
#[cold]
pub(super) fn not_outside(view: &View, boxes: &[[f64; 6]], first: u32, set: Lanes) -> Lanes {
    let seen = |&lane: &u32| {
        let exact = Aabb::nth(boxes, first + lane);
        exact.is_some_and(|exact| !view.frustum().is_outside(&exact))
    };
    lanes::each(set)
        .filter(seen)
        .fold(0, |set, lane| set | 1 << lane)
}
