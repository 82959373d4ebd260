//! Everything of a size: the walk that error mode and budget mode share.
//!
//! Breadth first. Nodes and objects are numbered in level order, so a walk level by level meets
//! both in ascending order, and ranges come out as they are listed.
//!
//! The law that makes the cut valid: a node's distance is at most that of anything in it and the
//! radius kept for it at least that of anything in it, in floating point too, and the size is
//! monotone in both ([`View::size_px`]). So what is certainly too small for the node is too small
//! for all it holds. Certainty is f32's ([`SizeThreshold`]); what it leaves open is entered if a
//! node, decided in f64 if an object.

use std::ops::Range;

use wide::f32x8;

use super::budget::Last;
use super::gather::not_outside;
use super::selection::Stats;
use super::survey::Survey;
use super::{Selection, lanes};
use crate::geom::{Aabb, Eight, Filter, Lanes, PlaneSet, SizeThreshold, View};
use crate::index::{Arrays, LodTree};

/// Two sizes, pixels, `least` ≤ `sure`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted {
    /// Objects of this size or larger are drawn; where it is infinite, none is sure.
    pub(super) sure: f64,
    /// Those between are listed with their sizes, in [`Sizes::border`].
    pub(super) least: f64,
}

/// Memory of a walk.
#[derive(Debug, Clone, Default)]
pub(super) struct Sizes {
    /// Siblings to look at, in this level and the next.
    open: [Vec<Open>; 2],
    /// Objects too small to be sure and too large to be left out, ascending by number.
    pub(super) border: Vec<Sized>,
    /// The same in the order of size, as far as needed.
    pub(super) ranked: Vec<Sized>,
    /// What the last budget came to.
    pub(super) last: Option<Last>,
    pub(super) survey: Survey,
}

/// An object of the frustum and its size, pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sized {
    pub(super) size: f64,
    pub(super) object: u32,
}

/// Neighbouring nodes.
#[derive(Debug, Clone, Copy)]
enum Open {
    /// The children of a node.
    Siblings {
        first: u32,
        end: u32,
        /// Where their boxes begin.
        block: u32,
        /// Planes the parent crosses.
        planes: PlaneSet,
    },
    /// Whatever they hold is drawn.
    Whole { first: u32, end: u32 },
}

/// Adds what is sure to `selection`, which has been cleared, and lists the border. Returns whether
/// anything of the frustum may be left out, all of which is smaller than `wanted.least`.
pub(super) fn sweep(
    tree: &LodTree,
    view: &View,
    filter: &Filter,
    wanted: Wanted,
    selection: &mut Selection,
) -> bool {
    let mut sizes = std::mem::take(&mut selection.sizes);
    sizes.border.clear();
    let [mut open, below] = std::mem::take(&mut sizes.open);
    let threshold = |px| SizeThreshold::new(filter, view.pixels(), px);
    let mut sweep = Sweep {
        arrays: tree.arrays(),
        view,
        filter,
        sure: threshold(wanted.sure),
        least: threshold(wanted.least),
        missed: false,
        next_object: 0,
        nodes_below: 0..0,
        below,
        border: &mut sizes.border,
        stats: selection.stats(),
        selection,
    };
    open.clear();
    open.push(Open::Siblings {
        first: 0,
        end: 1,
        block: 0,
        planes: filter.all_planes(),
    });
    for level in (0..tree.level_count()).rev() {
        sweep.start_level(tree.level_count() - 1 - level);
        for &nodes in &open {
            match nodes {
                Open::Siblings {
                    first,
                    end,
                    block,
                    planes,
                } => sweep.siblings(level, first..end, block, planes),
                Open::Whole { first, end } => sweep.whole(level, first..end),
            }
        }
        std::mem::swap(&mut open, &mut sweep.below);
    }
    let (missed, stats) = (sweep.missed, sweep.stats);
    sizes.open = [open, sweep.below];
    selection.sizes = sizes;
    selection.set_stats(stats);
    missed
}

struct Sweep<'a> {
    arrays: Arrays<'a>,
    view: &'a View,
    filter: &'a Filter,
    sure: SizeThreshold,
    least: SizeThreshold,
    /// Whether something was too small.
    missed: bool,
    /// The first object not yet met. In a sound file it only states what is so; in a damaged one
    /// it keeps the walk short.
    next_object: u32,
    /// The same for nodes of the level below.
    nodes_below: Range<u32>,
    below: Vec<Open>,
    border: &'a mut Vec<Sized>,
    stats: Stats,
    selection: &'a mut Selection,
}

/// Radii of the objects stored with eight nodes or below them.
struct Held {
    largest: f32x8,
    least: f32x8,
}

impl Sweep<'_> {
    /// Levels count from the coarsest here.
    fn start_level(&mut self, level: u32) {
        let starts = self.arrays.level_nodes;
        let start = |level: u32| starts.get(level as usize).copied().unwrap_or(0);
        self.nodes_below = start(level + 1)..start(level + 2);
        self.below.clear();
    }

    fn siblings(&mut self, level: u32, nodes: Range<u32>, block: u32, planes: PlaneSet) {
        let mut first = nodes.start;
        let mut block = block as usize;
        while first < nodes.end {
            let (Some(boxes), Some(&held), Some(&least)) = (
                self.arrays.child_blocks.get(block),
                self.arrays.child_radii.get(block),
                self.arrays.child_least_radii.get(block),
            ) else {
                return; // only in a damaged file
            };
            let count = (nodes.end - first).min(8);
            let radii = Held {
                largest: held,
                least,
            };
            self.eight(level, boxes, &radii, first, count, planes);
            first += count;
            block += 1;
        }
    }

    /// Adds the own objects of neighbouring nodes and lists their children, all of which are drawn.
    fn whole(&mut self, level: u32, nodes: Range<u32>) {
        let ends = |starts: &[u32]| {
            let start = *starts.get(nodes.start as usize)?;
            Some((start, *starts.get(nodes.end as usize)?))
        };
        if let Some((start, end)) = ends(self.arrays.own)
            && self.next_object <= start
            && start <= end
            && end as usize <= self.arrays.object_boxes.len()
        {
            self.next_object = end;
            self.selection.push(start..end);
        }
        if level > 0
            && let Some((first, end)) = ends(self.arrays.children)
            && self.nodes_below.start <= first
            && first <= end
            && end <= self.nodes_below.end
        {
            self.nodes_below.start = end;
            match self.below.last_mut() {
                Some(Open::Whole { end: last, .. }) if *last == first => *last = end,
                _ => self.below.push(Open::Whole { first, end }),
            }
        }
    }

    #[inline]
    fn eight(
        &mut self,
        level: u32,
        boxes: &Eight,
        held: &Held,
        first: u32,
        count: u32,
        planes: PlaneSet,
    ) {
        let visited = &mut self.stats.nodes_visited;
        *visited = visited.saturating_add(count);
        let relations = self.filter.relations(boxes, planes);
        let visible = lanes::first(count) & !relations.outside;
        if visible == 0 {
            return;
        }
        let distances = self.filter.distances(boxes);
        let small = self.least.impossible_radii(&distances);
        let large = self.large_enough(held.largest, small, visible);
        if large == 0 {
            return;
        }
        let deeper = match self.arrays.hidden_radii.get(first as usize..) {
            Some(radii) if level > 0 => match radii.first_chunk::<8>() {
                Some(&hidden) => self.large_enough(hidden.into(), small, large),
                None => 0, // only in a damaged file
            },
            _ => 0,
        };
        let farthest = self.filter.farthest(boxes);
        let sure = self.sure.certain_radii(&farthest);
        let whole = large & relations.inside & lanes::of(held.least.simd_gt(sure));
        let (small, sure) = (small.to_array(), sure.to_array());
        let end = first as usize + count as usize;
        let (Some(own), Some(own_blocks)) = (
            self.arrays.own.get(first as usize..=end),
            self.arrays.own_block_starts.get(first as usize..end),
        ) else {
            return; // only in a damaged file
        };
        for lane in lanes::each(large) {
            let node = first + lane;
            if lanes::has(whole, lane) {
                self.whole(level, node..node + 1);
                continue;
            }
            let planes = relations.open_planes(lane);
            if let (Some(&[start, end, ..]), Some(&block)) =
                (own.get(lane as usize..), own_blocks.get(lane as usize))
            {
                let of_lane = |radii: &[f32; 8]| f32x8::splat(radii[lane as usize & 7]);
                self.own(start..end, block, planes, of_lane(&small), of_lane(&sure));
            }
            if lanes::has(deeper, lane) {
                self.open(node, planes);
            }
        }
    }

    /// Those of `set` that may hold something large enough.
    #[inline]
    fn large_enough(&mut self, radii: f32x8, small: f32x8, set: Lanes) -> Lanes {
        let large = set & !lanes::of(radii.simd_lt(small));
        self.missed |= large != set;
        large
    }

    /// Lists the children of a node to be looked at.
    #[inline]
    fn open(&mut self, node: u32, planes: PlaneSet) {
        let starts = self.arrays.children.get(node as usize..);
        let block = self.arrays.child_block_starts.get(node as usize);
        if let (Some(&[first, end, ..]), Some(&block)) = (starts, block)
            && self.nodes_below.start <= first
            && first <= end
            && end <= self.nodes_below.end
        {
            self.nodes_below.start = end;
            self.below.push(Open::Siblings {
                first,
                end,
                block,
                planes,
            });
        }
    }

    /// Adds or lists a node's own objects: those of a radius below `small` are too small, those
    /// above `sure` are large enough.
    #[inline]
    fn own(
        &mut self,
        objects: Range<u32>,
        block: u32,
        planes: PlaneSet,
        small: f32x8,
        sure: f32x8,
    ) {
        let Range { start, end } = objects;
        let known = self.arrays.object_boxes.len();
        if start < self.next_object || end < start || end as usize > known {
            return; // only in a damaged file
        }
        let mut first = start;
        let mut block = block as usize;
        while first < end {
            let Some(&radii) = self.arrays.own_radii.get(block) else {
                return; // only in a damaged file
            };
            let open = self.large_enough(radii, small, lanes::first((end - first).min(8)));
            // Mostly that tells, and the boxes need not be looked at.
            if planes == 0 && open & !lanes::of(radii.simd_gt(sure)) == 0 {
                self.selection.push_runs(first, open);
            } else if open != 0 {
                self.objects(block, radii, first, open, planes);
            }
            first = first.saturating_add(8);
            block += 1;
        }
        self.next_object = end;
    }

    /// Eight objects by their own distances.
    #[inline]
    fn objects(
        &mut self,
        block: usize,
        radii: f32x8,
        first: u32,
        mut set: Lanes,
        planes: PlaneSet,
    ) {
        let Some(boxes) = self.arrays.own_blocks.get(block) else {
            return; // only in a damaged file
        };
        let tested = &mut self.stats.objects_tested;
        *tested = tested.saturating_add(set.count_ones());
        if planes != 0 {
            let (outside, touching) = self.filter.outside_or_touching(boxes, planes);
            set &= !outside;
            if set & !touching != 0 {
                set = set & touching
                    | not_outside(self.view, self.arrays.object_boxes, first, set & !touching);
            }
        }
        let distances = self.filter.distances(boxes);
        let mut sure = set & self.sure.reached(radii, &distances);
        let rest = set ^ sure;
        if rest != 0 {
            let open = rest & !self.least.missed(radii, &distances);
            self.missed |= open != rest;
            if open != 0 {
                sure |= self.decide(first, open);
            }
        }
        self.selection.push_runs(first, sure);
    }

    /// Which of eight objects are sure, decided in f64; lists those of the border.
    #[inline(never)]
    fn decide(&mut self, first: u32, set: Lanes) -> Lanes {
        let mut sure = 0;
        for lane in lanes::each(set) {
            let object = first + lane;
            let Some(exact) = Aabb::nth(self.arrays.object_boxes, object) else {
                continue; // only in a damaged file
            };
            let size = self.view.size_px(&exact);
            if size >= self.sure.px && self.sure.px < f64::INFINITY {
                sure |= 1 << lane;
            } else if size >= self.least.px {
                self.border.push(Sized { size, object });
            } else {
                self.missed = true;
            }
        }
        sure
    }
}
