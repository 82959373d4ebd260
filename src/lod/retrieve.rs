//! Retrieval in seven steps.
//!
//! Source: Gong et al., "An adaptive control method of LODs for 3D scene based on R-tree index",
//! section 2.2. Steps are cited where they are taken.
//!
//! The law that makes the cut valid: a child's box lies inside its parent's, and the view
//! distance is monotone, in floating point too ([`crate::geom::Aabb::distance`]), so no node is
//! nearer than its parent.
//!
//! Siblings are taken eight at a time. And a node whose box lies wholly in the range of one level
//! *settles* the distance for all nodes below: those above that level are nearer than their
//! ranges, those at that level in it. So below it only the frustum is asked, and where that is
//! settled too, the subtree is one range of objects per level.

use std::ops::Range;

use wide::f32x8;

use super::lanes;
use super::selection::Stats;
use super::{RangeLod, Selection};
use crate::geom::{
    Aabb, DVec3, Eight, EightDistances, EightRelations, Filter, Lanes, PixelScale, PlaneSet,
    Threshold, View,
};
use crate::index::{Arrays, LodTree};

/// Finds what a view calls for, into `selection`, whose memory is used again.
///
/// Total: answers for every view and every setting, in time linear in the nodes visited. Source:
/// Gong, section 2.2.
pub fn retrieve(tree: &LodTree, view: &View, lod: &RangeLod, selection: &mut Selection) {
    selection.clear(tree.level_count());
    let Some(root) = tree.level_count().checked_sub(1) else {
        return;
    };
    let filter = Filter::new(view.frustum(), tree.origin(), &tree.bounds());
    let far: Vec<Threshold> = lod
        .far_dists(tree.level_count())
        .into_iter()
        .map(|distance| filter.threshold(distance))
        .collect();
    let planes = filter.all_planes();
    let level_starts = tree.arrays().level_nodes.iter();
    let mut traversal = Traversal {
        arrays: tree.arrays(),
        view,
        ranged_levels: far.len() as u32,
        far,
        root,
        next: level_starts.rev().skip(1).copied().collect(),
        largest_omitted: f32x8::ZERO,
        stats: Stats::default(),
        filter,
        selection,
    };
    traversal.siblings(root, 0..1, 0, planes, f32::INFINITY); // step 1
    let (largest_omitted, stats) = (traversal.largest_omitted, traversal.stats);
    selection.finish(largest_omitted.to_array(), view.pixels(), stats);
}

pub(super) struct Traversal<'a> {
    pub(super) arrays: Arrays<'a>,
    pub(super) view: &'a View,
    pub(super) filter: Filter,
    /// Far distance of each level that has a range, level 0 first.
    far: Vec<Threshold>,
    /// How many levels have a range; those above pass through.
    pub(super) ranged_levels: u32,
    /// Level of the root.
    pub(super) root: u32,
    /// For each level, the first node not yet visited. In a sound file it only states what is so:
    /// nodes come in tree order. In a damaged one it keeps the walk finite.
    pub(super) next: Vec<u32>,
    /// Largest hidden radius of all nodes at which the walk stopped, divided by the distance where
    /// things look smaller with distance.
    largest_omitted: f32x8,
    pub(super) stats: Stats,
    pub(super) selection: &'a mut Selection,
}

/// Eight siblings, sorted by what becomes of them.
struct Siblings {
    /// Inside the frustum, and in the range of their level.
    stopped_inside: Lanes,
    /// Nearer than the range of their level, so their children are looked at.
    nearer: Lanes,
    /// Lies wholly in the range of one level.
    settled: Lanes,
    relations: EightRelations,
}

impl Traversal<'_> {
    /// Steps 2 to 6 for the nodes `nodes` of one level, which are all children of one node.
    /// `planes` are those the parent crosses; `parent_hidden` is its hidden radius.
    /// `block` is where their boxes begin.
    fn siblings(
        &mut self,
        level: u32,
        nodes: Range<u32>,
        block: u32,
        planes: PlaneSet,
        parent_hidden: f32,
    ) {
        let blocks = self.arrays.child_blocks;
        let mut first = nodes.start;
        for boxes in blocks.get(block as usize..).unwrap_or_default() {
            if first >= nodes.end {
                break;
            }
            let count = (nodes.end - first).min(8);
            self.eight(level, boxes, first, count, planes, parent_hidden);
            first += count;
        }
    }

    fn eight(
        &mut self,
        level: u32,
        boxes: &Eight,
        first: u32,
        count: u32,
        planes: PlaneSet,
        parent_hidden: f32,
    ) {
        self.stats.nodes_visited += count;
        // Step 2. Of an ambiguous box it is safe to say that it crosses: its objects are tested.
        let relations = self.filter.relations(boxes, planes);
        let visible = lanes::first(count) & !relations.outside;
        if visible == 0 {
            return;
        }
        // Steps 3 and 5: where does the distance lie to the range of the level?
        let distances = self.filter.distances(boxes);
        let limit = self.far[level.min(self.ranged_levels - 1) as usize];
        let kept = self.nearer(first, &distances, &limit, visible);
        let nearer = if level == 0 {
            0
        } else if level < self.ranged_levels {
            let near = self.far[level as usize - 1];
            self.nearer(first, &distances, &near, kept)
        } else {
            kept
        };
        let mut siblings = Siblings {
            stopped_inside: kept & !nearer & relations.inside,
            nearer,
            settled: 0,
            relations,
        };
        let mut settled_at = [0; 8];
        if nearer != 0 {
            siblings.settled = self.settle(level, boxes, &distances, nearer, &mut settled_at);
        }
        let cut = lanes::each(siblings.settled).filter(|&lane| settled_at[lane as usize] > 0);
        let stopped = (kept & !nearer) | cut.fold(0, |set, lane| set | 1 << lane);
        if level > 0 && stopped != 0 {
            self.note_hidden(first, &distances, stopped);
        }
        if kept != visible {
            self.note_beyond(boxes, &distances, visible & !kept, parent_hidden);
        }
        self.take(level, first, kept, &siblings, &settled_at);
    }

    /// The boxes of `set` nearer than a threshold; what f32 leaves open is decided in f64.
    fn nearer(
        &self,
        first: u32,
        distances: &EightDistances,
        threshold: &Threshold,
        set: Lanes,
    ) -> Lanes {
        if threshold.distance == f64::INFINITY {
            return set;
        }
        let mut nearer = set & distances.nearer(threshold);
        let open = set & !nearer & !distances.not_nearer(threshold);
        if open != 0 {
            for lane in lanes::each(open) {
                if exact(self.arrays.node_boxes, first + lane)
                    .is_some_and(|b| b.distance(self.view.eye()) < threshold.distance)
                {
                    nearer |= 1 << lane;
                }
            }
        }
        nearer
    }

    /// Which of `nearer` lie wholly in the range of one level below theirs, and in which.
    fn settle(
        &self,
        level: u32,
        boxes: &Eight,
        distances: &EightDistances,
        nearer: Lanes,
        settled_at: &mut [u8; 8],
    ) -> Lanes {
        let farthest = self.filter.farthest(boxes);
        let mut settled = 0;
        for cut in 0..level.min(self.ranged_levels) as usize {
            let from_near = if cut == 0 {
                Lanes::MAX
            } else {
                distances.not_nearer(&self.far[cut - 1])
            };
            let open = nearer & !settled & from_near;
            if open == 0 {
                break;
            }
            let set = open & farthest.nearer(&self.far[cut]);
            settled |= set;
            for lane in lanes::each(set) {
                settled_at[lane as usize] = cut as u8;
            }
        }
        settled
    }

    /// Steps 3 to 6 for siblings in their order, which is that of their objects.
    fn take(
        &mut self,
        level: u32,
        first: u32,
        kept: Lanes,
        siblings: &Siblings,
        settled_at: &[u8; 8],
    ) {
        let mut rest = kept;
        while rest != 0 {
            let lane = rest.trailing_zeros();
            let node = first + lane;
            let run = if lanes::has(siblings.stopped_inside, lane) {
                let run = lanes::run_length(siblings.stopped_inside, lane);
                self.add_inside(level, node..node + run);
                run
            } else if lanes::has(siblings.settled & siblings.relations.inside, lane) {
                let cut = settled_at[lane as usize];
                let same = |other: u32| settled_at[other as usize] == cut;
                let set = siblings.settled & siblings.relations.inside;
                let run = (1..lanes::run_length(set, lane))
                    .find(|&more| !same(lane + more))
                    .unwrap_or_else(|| lanes::run_length(set, lane));
                self.add_subtrees(level, node..node + run, u32::from(cut));
                run
            } else {
                let planes = siblings.relations.open_planes(lane);
                self.add_crossing(level, node, planes);
                if lanes::has(siblings.settled, lane) {
                    let cut = u32::from(settled_at[lane as usize]);
                    self.settled_children(level, node, planes, cut);
                } else if lanes::has(siblings.nearer, lane) {
                    self.open_children(level, node, planes);
                }
                1
            };
            rest = lanes::after_run(rest, lane, run);
        }
    }

    /// Steps 4 and 6: on to the children of a node nearer than its range.
    fn open_children(&mut self, level: u32, node: u32, planes: PlaneSet) {
        if let (Some(children), Some(&block)) = (
            self.children(level, &(node..node + 1)),
            self.arrays.child_block_starts.get(node as usize),
        ) {
            // A node without a range has added nothing, its own objects neither.
            let hidden = if level < self.ranged_levels {
                self.hidden(node)
            } else {
                f32::INFINITY
            };
            self.siblings(level - 1, children, block, planes, hidden);
        }
    }

    /// Step 6 where the distance is settled: all below down to level `cut` is drawn that is not
    /// outside the frustum.
    fn settled_children(&mut self, level: u32, node: u32, planes: PlaneSet, cut: u32) {
        let (Some(children), Some(&block)) = (
            self.children(level, &(node..node + 1)),
            self.arrays.child_block_starts.get(node as usize),
        ) else {
            return;
        };
        let blocks = self.arrays.child_blocks;
        let mut first = children.start;
        for boxes in blocks.get(block as usize..).unwrap_or_default() {
            if first >= children.end {
                break;
            }
            let count = (children.end - first).min(8);
            self.settled_eight(level - 1, boxes, first, count, planes, cut);
            first += count;
        }
    }

    fn settled_eight(
        &mut self,
        level: u32,
        boxes: &Eight,
        first: u32,
        count: u32,
        planes: PlaneSet,
        cut: u32,
    ) {
        self.stats.nodes_visited += count;
        let relations = self.filter.relations(boxes, planes);
        let mut rest = lanes::first(count) & !relations.outside;
        while rest != 0 {
            let lane = rest.trailing_zeros();
            let node = first + lane;
            let inside = rest & relations.inside;
            let run = if lanes::has(inside, lane) {
                let run = lanes::run_length(inside, lane);
                self.add_subtrees(level, node..node + run, cut);
                run
            } else {
                let planes = relations.open_planes(lane);
                self.add_crossing(level, node, planes);
                if level > cut {
                    self.settled_children(level, node, planes, cut);
                }
                1
            };
            rest = lanes::after_run(rest, lane, run);
        }
    }

    fn hidden(&self, node: u32) -> f32 {
        let hidden = self.arrays.hidden_radii.get(node as usize);
        hidden.copied().unwrap_or(f32::INFINITY)
    }

    /// Keeps the largest size on the screen of what lies below the nodes the walk stopped at.
    fn note_hidden(&mut self, first: u32, distances: &EightDistances, stopped: Lanes) {
        let radii = self.arrays.hidden_radii.get(first as usize..);
        if let Some(radii) = radii.and_then(|r| r.first_chunk()) {
            self.note(radii, distances, stopped);
        }
    }

    /// The same for nodes left out altogether: what they hold is hidden below their parent, and
    /// no larger than their box.
    fn note_beyond(
        &mut self,
        boxes: &Eight,
        distances: &EightDistances,
        beyond: Lanes,
        parent_hidden: f32,
    ) {
        let radii = Filter::radii(boxes).map(|radius| radius.min(parent_hidden));
        self.note(&radii, distances, beyond);
    }

    fn note(&mut self, radii: &[f32; 8], distances: &EightDistances, set: Lanes) {
        let size = match self.view.pixels() {
            PixelScale::PerRadian(_) => self.filter.largest_angles(radii, distances, set),
            PixelScale::PerMetre(_) => Filter::of_set(radii, set),
        };
        self.largest_omitted = self.largest_omitted.fast_max(size);
    }
}

/// The exact box, where it is one.
pub(super) fn exact(boxes: &[[f64; 6]], at: u32) -> Option<Aabb> {
    let [x0, y0, z0, x1, y1, z1] = *boxes.get(at as usize)?;
    Aabb::new(DVec3::new(x0, y0, z0), DVec3::new(x1, y1, z1)).ok()
}
