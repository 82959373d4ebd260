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
use super::level::Level;
use super::selection::Stats;
use super::{RangeLod, Selection};
use crate::geom::{
    Aabb, Eight, EightDistances, EightRelations, Filter, Lanes, LargestSize, PlaneSet, View,
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
    let arrays = tree.arrays();
    let mut levels = std::mem::take(&mut selection.walk);
    let ranged_levels = Level::all(&arrays, &filter, lod, &mut levels);
    let planes = filter.all_planes();
    let mut traversal = Traversal {
        arrays,
        view,
        ranged_levels,
        levels,
        root,
        omitted: LargestSize::new(&filter, view.pixels()),
        stats: Stats::default(),
        filter,
        selection,
    };
    traversal.siblings(root, 0..1, 0, planes, f32::INFINITY); // step 1
    let (largest, stats) = (traversal.omitted.bound(), traversal.stats);
    let levels = std::mem::take(&mut traversal.levels);
    selection.walk = levels;
    selection.finish(largest, view.pixels(), stats);
}

pub(super) struct Traversal<'a> {
    pub(super) arrays: Arrays<'a>,
    pub(super) view: &'a View,
    pub(super) filter: Filter,
    /// All levels, level 0 first.
    pub(super) levels: Vec<Level>,
    /// How many levels have a range; those above pass through.
    pub(super) ranged_levels: u32,
    /// Level of the root.
    pub(super) root: u32,
    /// Hidden radii of all nodes at which the walk stopped.
    omitted: LargestSize,
    pub(super) stats: Stats,
    pub(super) selection: &'a mut Selection,
}

/// Siblings that lie wholly in the range of one level, and which level that is.
#[derive(Default)]
struct Settled {
    set: Lanes,
    at: [u8; 8],
}

impl Settled {
    /// How many of `set` follow one another from `lane` on that are settled at the same level.
    #[inline]
    fn run_length(&self, set: Lanes, lane: u32) -> u32 {
        let run = lanes::run_length(set, lane);
        let at = |other: u32| self.at[other as usize & 7];
        (1..run)
            .find(|&more| at(lane + more) != at(lane))
            .unwrap_or(run)
    }
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
        let mut first = nodes.start;
        let mut block = block as usize;
        while first < nodes.end {
            let Some(boxes) = self.arrays.child_blocks.get(block) else {
                return; // only in a damaged file
            };
            let count = (nodes.end - first).min(8);
            self.eight(level, boxes, first, count, planes, parent_hidden);
            first += count;
            block += 1;
        }
    }

    #[inline]
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
        let kept = self.nearer(first, &distances, level, visible);
        if kept != visible {
            self.note_beyond(boxes, &distances, visible & !kept, parent_hidden);
        }
        let nearer = if level == 0 {
            0
        } else if level < self.ranged_levels {
            self.nearer(first, &distances, level - 1, kept)
        } else {
            kept
        };
        if level < self.ranged_levels {
            self.add(level, first, kept, &relations);
        }
        if nearer != kept && level > 0 {
            self.note_hidden(level, level, first, &distances, kept & !nearer);
        }
        if nearer != 0 {
            let settled = self.settle(level, first, boxes, &distances, nearer);
            self.descend(level, first, nearer, &relations, &settled);
        }
    }

    /// The boxes of `set` nearer than the far distance of a level; what f32 leaves open is
    /// decided in f64.
    #[inline]
    fn nearer(&self, first: u32, distances: &EightDistances, level: u32, set: Lanes) -> Lanes {
        let far = &self.levels[level as usize].far;
        if far.distance == f64::INFINITY {
            return set;
        }
        let nearer = set & distances.nearer(far);
        if nearer == set {
            return set;
        }
        let open = (set ^ nearer) & !distances.not_nearer(far);
        if open == 0 {
            nearer
        } else {
            nearer | self.nearer_than(far.distance, first, open)
        }
    }

    /// The same, decided in f64.
    #[cold]
    fn nearer_than(&self, far: f64, first: u32, set: Lanes) -> Lanes {
        let nearer = |&lane: &u32| {
            Aabb::nth(self.arrays.node_boxes, first + lane)
                .is_some_and(|exact| exact.distance(self.view.eye()) < far)
        };
        lanes::each(set)
            .filter(nearer)
            .fold(0, |set, lane| set | 1 << lane)
    }

    /// Which of `nearer` lie wholly in the range of one level below theirs, and in which: what is
    /// stored below that level is left out.
    #[inline]
    fn settle(
        &mut self,
        level: u32,
        first: u32,
        boxes: &Eight,
        distances: &EightDistances,
        nearer: Lanes,
    ) -> Settled {
        let farthest = self.filter.farthest(boxes);
        let mut settled = Settled::default();
        let mut open = nearer;
        for cut in 0..level.min(self.ranged_levels) {
            if cut > 0 {
                open &= !settled.set & distances.not_nearer(&self.levels[cut as usize - 1].far);
                if open == 0 {
                    break;
                }
            }
            let set = open & farthest.nearer(&self.levels[cut as usize].far);
            settled.set |= set;
            if cut > 0 && set != 0 {
                self.note_hidden(cut, level, first, distances, set);
                for lane in lanes::each(set) {
                    settled.at[lane as usize & 7] = cut as u8;
                }
            }
        }
        settled
    }

    /// Steps 4 and 6 for siblings nearer than their range, in their order, which is that of the
    /// objects below them.
    #[inline]
    fn descend(
        &mut self,
        level: u32,
        first: u32,
        nearer: Lanes,
        relations: &EightRelations,
        settled: &Settled,
    ) {
        let whole = settled.set & relations.inside;
        let mut rest = nearer;
        while rest != 0 {
            let lane = rest.trailing_zeros();
            let node = first + lane;
            let run = if lanes::has(whole, lane) {
                let run = settled.run_length(whole, lane);
                let cut = u32::from(settled.at[lane as usize & 7]);
                self.add_subtrees(level, node..node + run, cut);
                run
            } else {
                let planes = relations.open_planes(lane);
                if lanes::has(settled.set, lane) {
                    let cut = u32::from(settled.at[lane as usize & 7]);
                    self.settled_children(level, node, planes, cut);
                } else {
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
                self.hidden(node).max(self.promoted(&children))
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
        let mut first = children.start;
        let mut block = block as usize;
        while first < children.end {
            let Some(boxes) = self.arrays.child_blocks.get(block) else {
                return; // only in a damaged file
            };
            let count = (children.end - first).min(8);
            self.settled_eight(level - 1, boxes, first, count, planes, cut);
            first += count;
            block += 1;
        }
    }

    #[inline]
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
        let visible = lanes::first(count) & !relations.outside;
        if level < self.ranged_levels {
            self.add(level, first, visible, &relations);
        }
        if level == cut {
            return;
        }
        let mut rest = visible;
        while rest != 0 {
            let lane = rest.trailing_zeros();
            let node = first + lane;
            let run = if lanes::has(relations.inside, lane) {
                let run = lanes::run_length(rest & relations.inside, lane);
                self.add_subtrees(level, node..node + run, cut);
                run
            } else {
                self.settled_children(level, node, relations.open_planes(lane), cut);
                1
            };
            rest = lanes::after_run(rest, lane, run);
        }
    }

    fn hidden(&self, node: u32) -> f32 {
        let hidden = self.arrays.hidden_radii.get(node as usize);
        hidden.copied().unwrap_or(f32::INFINITY)
    }

    /// Largest radius of the objects that stand for `nodes`.
    #[cold]
    fn promoted(&self, nodes: &Range<u32>) -> f32 {
        let representatives = self.arrays.representatives;
        let radius = |&object: &u32| {
            let bounds = Aabb::nth(self.arrays.object_boxes, object);
            bounds.map_or(f32::INFINITY, |b| (b.radius() as f32).next_up())
        };
        let range = nodes.start as usize..nodes.end as usize;
        representatives.get(range).map_or(f32::INFINITY, |all| {
            all.iter().map(radius).fold(0.0, f32::max)
        })
    }

    /// Keeps the largest size on the screen of what is stored at levels lower than `cut` below the
    /// nodes of `level` in the set `stopped`.
    #[inline]
    fn note_hidden(
        &mut self,
        cut: u32,
        level: u32,
        first: u32,
        distances: &EightDistances,
        stopped: Lanes,
    ) {
        if let Some(&radii) = self.arrays.hidden_below(cut, level, first) {
            let radii = f32x8::from(radii);
            if self.omitted.exceeding(radii, distances, stopped) != 0 {
                self.omitted.raise(radii, distances, stopped);
            }
        }
    }

    /// The same for nodes left out altogether: what they hold is hidden below their parent, and
    /// no larger than their box.
    #[inline]
    fn note_beyond(
        &mut self,
        boxes: &Eight,
        distances: &EightDistances,
        beyond: Lanes,
        parent_hidden: f32,
    ) {
        let hidden = f32x8::splat(parent_hidden);
        if self.omitted.exceeding(hidden, distances, beyond) != 0 {
            let radii = Filter::radii(boxes).fast_min(hidden);
            self.omitted.raise(radii, distances, beyond);
        }
    }
}
