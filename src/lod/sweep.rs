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

use super::retrieve::exact;
use super::selection::Stats;
use super::survey::Survey;
use super::{Selection, lanes};
use crate::geom::{
    Eight, EightDistances, Filter, Lanes, LargestSize, PixelScale, PlaneSet, SizeThreshold, View,
};
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
    open: [Vec<Siblings>; 2],
    /// Objects too small to be sure and too large to be left out, ascending by number.
    pub(super) border: Vec<Sized>,
    /// The same in the order of size, as far as needed.
    pub(super) ranked: Vec<Sized>,
    pub(super) survey: Survey,
}

/// An object of the frustum and its size, pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sized {
    pub(super) size: f64,
    pub(super) object: u32,
}

/// The children of a node.
#[derive(Debug, Clone, Copy)]
struct Siblings {
    first: u32,
    end: u32,
    /// Where their boxes begin.
    block: u32,
    /// Planes the parent crosses.
    planes: PlaneSet,
}

/// Adds what is sure to `selection`, which has been cleared, and lists the border. Returns a size
/// that nothing else of the frustum exceeds, pixels.
pub(super) fn sweep(
    tree: &LodTree,
    view: &View,
    filter: &Filter,
    wanted: Wanted,
    selection: &mut Selection,
) -> f64 {
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
        omitted: LargestSize::new(filter, view.pixels()),
        omitted_px: 0.0,
        next_object: 0,
        nodes_below: 0..0,
        below,
        border: &mut sizes.border,
        stats: selection.stats(),
        selection,
    };
    open.clear();
    open.push(Siblings {
        first: 0,
        end: 1,
        block: 0,
        planes: filter.all_planes(),
    });
    for level in (0..tree.level_count()).rev() {
        sweep.start_level(tree.level_count() - 1 - level);
        for siblings in &open {
            sweep.siblings(level, siblings);
        }
        std::mem::swap(&mut open, &mut sweep.below);
    }
    let (PixelScale::PerRadian(scale) | PixelScale::PerMetre(scale)) = view.pixels();
    let omitted = 2.0 * f64::from(sweep.omitted.bound()) * scale;
    let (omitted, stats) = (omitted.max(sweep.omitted_px), sweep.stats);
    sizes.open = [open, sweep.below];
    selection.sizes = sizes;
    selection.set_stats(stats);
    omitted
}

struct Sweep<'a> {
    arrays: Arrays<'a>,
    view: &'a View,
    filter: &'a Filter,
    sure: SizeThreshold,
    least: SizeThreshold,
    /// Of what f32 tells to be too small.
    omitted: LargestSize,
    /// Of what f64 does.
    omitted_px: f64,
    /// The first object not yet met. In a sound file it only states what is so; in a damaged one
    /// it keeps the walk short.
    next_object: u32,
    /// The same for nodes of the level below.
    nodes_below: Range<u32>,
    below: Vec<Siblings>,
    border: &'a mut Vec<Sized>,
    stats: Stats,
    selection: &'a mut Selection,
}

/// Radii that tell what eight boxes hold, by their distances.
struct Limits {
    /// Up to these nothing exceeds what is known to be left out.
    quiet: f32x8,
    /// Below these everything is too small.
    small: f32x8,
}

impl Sweep<'_> {
    /// Levels count from the coarsest here.
    fn start_level(&mut self, level: u32) {
        let starts = self.arrays.level_nodes;
        let start = |level: u32| starts.get(level as usize).copied().unwrap_or(0);
        self.nodes_below = start(level + 1)..start(level + 2);
        self.below.clear();
    }

    fn siblings(&mut self, level: u32, siblings: &Siblings) {
        let mut first = siblings.first;
        let mut block = siblings.block;
        while first < siblings.end {
            let (Some(boxes), Some(&held)) = (
                self.arrays.child_blocks.get(block as usize),
                self.arrays.child_radii.get(block as usize),
            ) else {
                return; // only in a damaged file
            };
            let count = (siblings.end - first).min(8);
            self.eight(level, boxes, held.into(), first, count, siblings.planes);
            first += count;
            block += 1;
        }
    }

    #[inline]
    fn eight(
        &mut self,
        level: u32,
        boxes: &Eight,
        held: f32x8,
        first: u32,
        count: u32,
        planes: PlaneSet,
    ) {
        self.stats.nodes_visited += count;
        let relations = self.filter.relations(boxes, planes);
        let visible = lanes::first(count) & !relations.outside;
        if visible == 0 {
            return;
        }
        let distances = self.filter.distances(boxes);
        let limits = self.limits(&distances);
        let large = self.large_enough(held, &distances, &limits, visible);
        if large == 0 {
            return;
        }
        let deeper = match self.arrays.hidden_radii.get(first as usize..) {
            Some(radii) if level > 0 => match radii.first_chunk::<8>() {
                Some(&hidden) => self.large_enough(hidden.into(), &distances, &limits, large),
                None => 0, // only in a damaged file
            },
            _ => 0,
        };
        let farthest = self.filter.farthest(boxes);
        let sure = self.sure.certain_radii(&farthest).to_array();
        let quiet = limits.quiet.to_array();
        for lane in lanes::each(large) {
            let planes = relations.open_planes(lane);
            let of_lane = |radii: &[f32; 8]| f32x8::splat(radii[lane as usize & 7]);
            self.own(first + lane, planes, of_lane(&quiet), of_lane(&sure));
            if lanes::has(deeper, lane) {
                self.open(first + lane, planes);
            }
        }
    }

    #[inline]
    fn limits(&self, distances: &EightDistances) -> Limits {
        let small = self.least.impossible_radii(distances);
        let quiet = self.omitted.quiet_radii(distances).fast_min(small);
        Limits { quiet, small }
    }

    /// Those of `set` that may hold something large enough.
    #[inline]
    fn large_enough(
        &mut self,
        radii: f32x8,
        distances: &EightDistances,
        limits: &Limits,
        set: Lanes,
    ) -> Lanes {
        let set = set & !lanes::of(radii.simd_le(limits.quiet));
        let missed = set & lanes::of(radii.simd_lt(limits.small));
        if missed != 0 {
            self.omitted.raise(radii, distances, missed);
        }
        set & !missed
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
            self.below.push(Siblings {
                first,
                end,
                block,
                planes,
            });
        }
    }

    /// Adds or lists a node's own objects: those of a radius up to `quiet` are too small and do
    /// not raise the bound, those above `sure` are large enough.
    #[inline]
    fn own(&mut self, node: u32, planes: PlaneSet, quiet: f32x8, sure: f32x8) {
        let starts = self.arrays.own.get(node as usize..);
        let block = self.arrays.own_block_starts.get(node as usize);
        let (Some(&[mut first, end, ..]), Some(&block)) = (starts, block) else {
            return; // only in a damaged file
        };
        if first < self.next_object {
            return; // only in a damaged file
        }
        let mut block = block as usize;
        while first < end {
            let Some(&radii) = self.arrays.own_radii.get(block) else {
                return; // only in a damaged file
            };
            let radii = f32x8::from(radii);
            let all = lanes::first((end - first).min(8));
            let small = lanes::of(radii.simd_le(quiet));
            let large = if planes == 0 {
                all & lanes::of(radii.simd_gt(sure))
            } else {
                0
            };
            // Mostly that tells, and the boxes need not be looked at.
            if all & !(small | large) == 0 {
                self.selection.push_runs(first, large);
            } else {
                self.objects(block, radii, first, all, planes);
            }
            first = first.saturating_add(8);
            block += 1;
        }
        self.next_object = end;
    }

    /// Eight objects by their own distances.
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
        self.stats.objects_tested += set.count_ones();
        let distances = self.filter.distances(boxes);
        if planes != 0 {
            let (outside, touching) = self.filter.outside_or_touching(boxes, planes);
            set &= !outside;
            if set & !touching != 0 {
                set = set & touching | self.not_outside(first, set & !touching);
            }
        }
        let missed = set & self.least.missed(radii, &distances);
        if missed != 0 && self.omitted.exceeding(radii, &distances, missed) != 0 {
            self.omitted.raise(radii, &distances, missed);
        }
        let large = set & !missed;
        let mut sure = large & self.sure.reached(radii, &distances);
        if sure != large {
            sure |= self.decide(first, large & !sure);
        }
        self.selection.push_runs(first, sure);
    }

    /// Which of eight objects are not outside, decided in f64.
    #[cold]
    fn not_outside(&self, first: u32, set: Lanes) -> Lanes {
        let seen = |&lane: &u32| {
            exact(self.arrays.object_boxes, first + lane)
                .is_some_and(|exact| !self.view.frustum().is_outside(&exact))
        };
        lanes::each(set)
            .filter(seen)
            .fold(0, |set, lane| set | 1 << lane)
    }

    /// Which of eight objects are sure, decided in f64; lists those of the border.
    #[inline(never)]
    fn decide(&mut self, first: u32, set: Lanes) -> Lanes {
        let mut sure = 0;
        for lane in lanes::each(set) {
            let object = first + lane;
            let Some(exact) = exact(self.arrays.object_boxes, object) else {
                continue; // only in a damaged file
            };
            let size = self.view.size_px(&exact);
            if size >= self.sure.px && self.sure.px < f64::INFINITY {
                sure |= 1 << lane;
            } else if size >= self.least.px {
                self.border.push(Sized { size, object });
            } else {
                self.omitted_px = self.omitted_px.max(size);
            }
        }
        sure
    }
}
