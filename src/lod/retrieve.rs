//! Retrieval in seven steps.
//!
//! Source: Gong et al., "An adaptive control method of LODs for 3D scene based on R-tree index",
//! section 2.2. Steps are cited where they are taken.
//!
//! The law that makes the cut valid: a child's box lies inside its parent's, and the view
//! distance is monotone, in floating point too ([`crate::geom::Aabb::distance`]), so no node is
//! nearer than its parent.
//!
//! Level by level, siblings eight at a time. And a node whose box lies wholly in the range of one
//! level *settles* the distance for all nodes below: those above that level are nearer than their
//! ranges, those at that level in it. So below it only the frustum is asked, and where that is
//! settled too, the subtree is one range of objects per level.
//!
//! Every object is stored once, at the highest level it is promoted to, so "the node's objects"
//! of the paper are its own ones and its representative, which an ancestor stores. On the way
//! down from the root the ancestor has added it already; only where the levels that have a range
//! begin below the root is it added with the node.

use std::ops::Range;

use super::descent::Descent;
use super::gather::Gathered;
use super::lanes;
use super::ranges::Ranges;
use super::selection::Stats;
use super::sight::Sight;
use super::{RangeLod, Selection};
use crate::geom::{
    Aabb, Eight, EightRelations, Filter, Floats, Kernel, Lanes, LargestSize, PixelScale, PlaneSet,
    Threshold, View, widest,
};
use crate::index::{Arrays, LodTree};

/// Finds what a view calls for, into `selection`, whose memory is used again.
///
/// Total: answers for every view and every setting, in time linear in the nodes visited. Source:
/// Gong, section 2.2.
pub fn retrieve(tree: &LodTree, view: &View, lod: &RangeLod, selection: &mut Selection) {
    selection.clear();
    let Some(root) = tree.level_count().checked_sub(1) else {
        return;
    };
    let filter = Filter::new(view.frustum(), tree.origin(), &tree.bounds());
    let Selection { walk, ranges, .. } = selection;
    let Walk {
        far,
        open,
        below,
        own,
        representatives,
    } = walk;
    far.clear();
    far.extend(lod.far_dists(root + 1).map(|far| filter.threshold(far)));
    open.clear();
    open.push(Open::Near {
        nodes: 0..1,
        block: 0,
        planes: filter.all_planes(),
        hidden: f32::INFINITY,
    }); // step 1
    let arrays = tree.arrays();
    let mut traversal = Traversal {
        arrays,
        view,
        filter: &filter,
        ranged_levels: far.len() as u32,
        far,
        root,
        omitted: LargestSize::new(&filter, view.pixels()),
        stats: Stats::default(),
        descent: Descent::to(&arrays, 1),
        below,
        own,
        representatives,
    };
    let mut next = 0;
    for level in (0..=root).rev() {
        traversal.start(level);
        widest(LookAt {
            traversal: &mut traversal,
            level,
            open,
        });
        if level + 1 == traversal.ranged_levels {
            traversal.merge_representatives(ranges);
        }
        // Step 7: coarse levels come first.
        widest(ListObjects {
            traversal: &mut traversal,
            next: &mut next,
            ranges,
        });
        std::mem::swap(open, traversal.below);
    }
    let (largest, stats) = (traversal.omitted.bound(), traversal.stats);
    let (PixelScale::PerRadian(scale) | PixelScale::PerMetre(scale)) = view.pixels();
    selection.set_stats(stats);
    selection.conclude(2.0 * f64::from(largest) * scale);
}

/// Memory of a walk.
#[derive(Debug, Clone, Default)]
pub(super) struct Walk {
    /// Far distances of the levels that have a range, level 0 first.
    far: Vec<Threshold>,
    /// What is to be looked at in a level, and in the one below it.
    open: Vec<Open>,
    below: Vec<Open>,
    own: Gathered,
    representatives: Vec<u32>,
}

/// Neighbouring nodes: what is left to ask of them.
#[derive(Debug, Clone)]
pub(super) enum Open {
    /// The children of a node nearer than its range.
    Near {
        nodes: Range<u32>,
        /// Where their boxes begin.
        block: u32,
        /// Planes the parent crosses.
        planes: PlaneSet,
        /// The parent's hidden radius.
        hidden: f32,
    },
    /// Children of which the distance is settled: all below down to level `cut` is drawn that is
    /// not outside the frustum.
    Settled {
        nodes: Range<u32>,
        block: u32,
        planes: PlaneSet,
        cut: u32,
    },
    /// All below down to level `cut` is drawn.
    Whole { nodes: Range<u32>, cut: u32 },
}

pub(super) struct Traversal<'a> {
    pub(super) arrays: Arrays<'a>,
    pub(super) view: &'a View,
    pub(super) filter: &'a Filter,
    pub(super) far: &'a [Threshold],
    /// How many levels have a range; those above pass through.
    pub(super) ranged_levels: u32,
    /// Level of the root.
    pub(super) root: u32,
    /// Hidden radii of all nodes at which the walk stopped.
    pub(super) omitted: LargestSize,
    pub(super) stats: Stats,
    pub(super) descent: Descent,
    pub(super) below: &'a mut Vec<Open>,
    pub(super) own: &'a mut Gathered,
    /// Of nodes whose ancestors pass through.
    pub(super) representatives: &'a mut Vec<u32>,
}

/// Looks at the nodes of a level.
struct LookAt<'a, 'b> {
    traversal: &'a mut Traversal<'b>,
    level: u32,
    open: &'a [Open],
}

impl Kernel for LookAt<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Floats>(self) {
        for open in self.open {
            self.traversal.look_at::<F>(self.level, open);
        }
    }
}

/// Lists the objects that a level adds.
struct ListObjects<'a, 'b> {
    traversal: &'a mut Traversal<'b>,
    next: &'a mut u32,
    ranges: &'a mut Ranges,
}

impl Kernel for ListObjects<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Floats>(self) {
        let Traversal {
            arrays,
            view,
            filter,
            own,
            stats,
            ..
        } = self.traversal;
        let sight = Sight::new(view, filter, arrays);
        let seen =
            |_, boxes: &Eight, first, set, planes| sight.seen::<F>(boxes, first, set, planes);
        let tested = own.list(arrays, self.next, self.ranges, seen);
        stats.objects_tested = stats.objects_tested.saturating_add(tested);
    }
}

impl Traversal<'_> {
    fn start(&mut self, level: u32) {
        self.descent = Descent::to(&self.arrays, self.root - level + 1);
        self.below.clear();
        self.own.clear();
    }

    #[inline(always)]
    fn look_at<F: Floats>(&mut self, level: u32, open: &Open) {
        match open {
            Open::Near {
                nodes,
                block,
                planes,
                hidden,
            } => self.siblings(nodes, *block, |walk, boxes, first, count| {
                walk.near::<F>(level, boxes, first, count, *planes, *hidden);
            }),
            Open::Settled {
                nodes,
                block,
                planes,
                cut,
            } => self.siblings(nodes, *block, |walk, boxes, first, count| {
                walk.settled::<F>(level, boxes, first, count, *planes, *cut);
            }),
            Open::Whole { nodes, cut } => {
                self.own.whole(nodes);
                self.open_whole(level, nodes.clone(), *cut);
            }
        }
    }

    /// Looks at siblings eight at a time; `block` is where their boxes begin.
    #[inline(always)]
    fn siblings(
        &mut self,
        nodes: &Range<u32>,
        block: u32,
        mut eight: impl FnMut(&mut Self, &Eight, u32, u32),
    ) {
        let blocks = self.arrays.child_blocks.get(block as usize..);
        let firsts = nodes.clone().step_by(8);
        for (boxes, first) in blocks.unwrap_or_default().iter().zip(firsts) {
            let count = (nodes.end - first).min(8);
            let visited = &mut self.stats.nodes_visited;
            *visited = visited.saturating_add(count);
            eight(self, boxes, first, count);
        }
    }

    /// The children of a node, and where their boxes begin.
    #[inline]
    pub(super) fn children(&mut self, node: u32) -> Option<(Range<u32>, u32)> {
        let block = *self.arrays.child_block_starts.get(node as usize)?;
        let nodes = self.descent.children(&self.arrays, node..node + 1)?;
        Some((nodes, block))
    }

    /// Adds the objects of the siblings in `set`, which have a range: all of those inside the
    /// frustum (step 3), of others what is not outside (step 5).
    #[inline]
    pub(super) fn add(&mut self, level: u32, first: u32, set: Lanes, relations: &EightRelations) {
        if level < self.root && level + 1 == self.ranged_levels {
            for lane in lanes::each(set) {
                self.add_representative(first + lane, relations.open_planes(lane));
            }
        }
        if set != 0 {
            self.own.nodes(first, set, relations.inside, relations);
        }
    }

    /// Adds the object that stands for `node`, stored with an ancestor that has added nothing,
    /// unless it is outside one of `planes`.
    #[cold]
    pub(super) fn add_representative(&mut self, node: u32, planes: PlaneSet) {
        let Some(&object) = self.arrays.representatives.get(node as usize) else {
            return;
        };
        let Some(exact) = Aabb::nth(self.arrays.object_boxes, object) else {
            return; // only in a damaged file
        };
        if planes == 0 || !self.view.frustum().is_outside_of(planes, &exact) {
            self.representatives.push(object);
        }
    }

    /// Puts the representatives in their places: they are stored at the levels that pass through,
    /// all of which are done when the first level that has a range is.
    fn merge_representatives(&mut self, ranges: &mut Ranges) {
        if !self.representatives.is_empty() {
            self.representatives.sort_unstable();
            ranges.merge(self.representatives.drain(..));
        }
    }
}
