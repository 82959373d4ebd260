//! About how large the n-th largest object of a view is.
//!
//! A best-first walk over the nodes that hold many. Of a node with few nothing is looked at but
//! what its parent keeps of it: its objects are counted as if their sizes were spread evenly, in
//! logarithm, from the least radius at the farthest corner to the largest at the nearest point.
//! Sizes are kept by bucket, a few to the octave, so that queue and counts are arrays: a bucket of
//! nodes is emptied before the next smaller one, and when as many objects are counted as are
//! wanted, nothing larger is left.
//!
//! The answer does not depend on the estimate, only the time it takes does.

use super::lanes;
use crate::geom::{EightDistances, Filter, Floats, Kernel, PixelScale, PlaneSet, View, widest};
use crate::index::{Arrays, LodTree, MAX_FAN_OUT};

/// Bits of an f32 below its exponent and the first three of its fraction: eight buckets for each
/// doubling of the squared size.
const BUCKET_BITS: u32 = 20;
/// Squared sizes below 2⁻⁴⁴ are in the first bucket, those from 2²⁰ on in the last: a radius of
/// 0.1 m at 400 km, and one of 1 km in a parallel view.
const LOWEST: usize = ((127 - 44) << 23 >> BUCKET_BITS) as usize;
const BUCKETS: usize = ((127 + 20) << 23 >> BUCKET_BITS) as usize + 1 - LOWEST;
/// A node that holds fewer than one in so many of the objects wanted is not entered.
const GRAIN: f32 = 64.0;
/// Most of what a node holds near the eye is far from it: distances are spread over so many
/// buckets at most, up to the farthest and down to half of it.
const WIDEST: usize = 16;
/// Radii over so many at most.
const MOST_UNLIKE: usize = 127;
/// 1 by each number up to that.
const ONE_BY: [f32; MOST_UNLIKE + 1] = {
    let mut one_by = [0.0; MOST_UNLIKE + 1];
    let mut number = 1;
    while number <= MOST_UNLIKE {
        one_by[number] = 1.0 / number as f32;
        number += 1;
    }
    one_by
};
/// A node that holds more than this many times the grain is always entered.
const COARSE: f32 = 8.0;
/// One that holds less, only where some of it is outside or the squares of the sizes in it differ
/// by more than this factor.
const NARROW: f32 = 12.0;
/// Of what a node holds that crosses the border of the frustum, so much is counted.
const CROSSING: f32 = 0.5;

/// Memory of a survey.
#[derive(Debug, Clone, Default)]
pub(super) struct Survey {
    /// The last node queued in each bucket, and all nodes with the one queued before them.
    last: Vec<u32>,
    queue: Vec<Queued>,
    /// Objects counted in each bucket, about.
    counts: Vec<f32>,
    /// Of objects that are only known by the node that holds them: second differences of their
    /// number by bucket.
    bends: Vec<f32>,
    /// About how many objects are stored with a node of each level or below it, leaves first.
    held: Vec<f32>,
}

#[derive(Debug, Clone, Copy)]
struct Queued {
    node: u32,
    before: u32,
    planes: PlaneSet,
    level: u32,
}

const NONE: u32 = u32::MAX;

impl Survey {
    /// About how large the `rank`-th largest object is, pixels; 0 where there are fewer.
    pub(super) fn estimate(
        &mut self,
        tree: &LodTree,
        view: &View,
        filter: &Filter,
        rank: u32,
    ) -> f64 {
        let arrays = tree.arrays();
        self.clear(&arrays);
        let rank = rank as f32;
        let mut walk = Walk {
            arrays,
            filter,
            perspective: matches!(view.pixels(), PixelScale::PerRadian(_)),
            grain: rank / GRAIN,
            bucket: BUCKETS - 1,
            survey: self,
        };
        walk.push(0, tree.level_count() - 1, filter.all_planes(), BUCKETS - 1);
        let (PixelScale::PerRadian(scale) | PixelScale::PerMetre(scale)) = view.pixels();
        2.0 * scale * widest(Down { walk, rank })
    }

    fn clear(&mut self, arrays: &Arrays) {
        self.last.clear();
        self.last.resize(BUCKETS, NONE);
        self.counts.clear();
        self.counts.resize(BUCKETS, 0.0);
        self.bends.clear();
        self.bends.resize(BUCKETS, 0.0);
        self.queue.clear();
        self.held.clear();
        let starts = arrays.level_nodes.windows(2).zip(arrays.level_objects);
        let objects = arrays.object_boxes.len() as f32;
        self.held.extend(starts.rev().map(|(nodes, &first)| {
            (objects - first as f32) / (nodes[1].saturating_sub(nodes[0])).max(1) as f32
        }));
    }
}

/// Radius by distance, or radius, at this share of a bucket, counted from its largest.
fn size_within(bucket: usize, share: f32) -> f64 {
    if bucket + 1 == BUCKETS {
        return f64::INFINITY;
    }
    let place = ((LOWEST + bucket) as f64 + 1.0 - f64::from(share)) * f64::from(1 << BUCKET_BITS);
    f64::from(f32::from_bits(place as u32)).sqrt()
}

/// From the largest size down to that of the `rank`-th largest object.
struct Down<'a> {
    walk: Walk<'a>,
    rank: f32,
}

impl Kernel for Down<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<F: Floats>(self) -> f64 {
        let Self { mut walk, rank } = self;
        let (mut seen, mut density, mut slope) = (0.0, 0.0_f32, 0.0);
        loop {
            while let Some(node) = walk.pop() {
                walk.visit::<F>(&node);
            }
            let bucket = walk.bucket;
            slope += walk.survey.bends[bucket];
            density += slope;
            let counted = walk.survey.counts[bucket] + density.max(0.0);
            if seen + counted >= rank && counted > 0.0 {
                return size_within(bucket, (rank - seen) / counted);
            }
            seen += counted;
            match bucket.checked_sub(1) {
                Some(next) => walk.bucket = next,
                None => return 0.0,
            }
        }
    }
}

struct Walk<'a> {
    arrays: Arrays<'a>,
    filter: &'a Filter,
    perspective: bool,
    /// Nodes that hold no more objects are not entered.
    grain: f32,
    /// The largest that is not yet done.
    bucket: usize,
    survey: &'a mut Survey,
}

impl Walk<'_> {
    fn push(&mut self, node: u32, level: u32, planes: PlaneSet, bucket: usize) {
        let queue = &mut self.survey.queue;
        if let Some(last) = self.survey.last.get_mut(bucket)
            // More only in a damaged file, where nodes may share children.
            && queue.len() < self.arrays.representatives.len()
        {
            let before = std::mem::replace(last, queue.len() as u32);
            queue.push(Queued {
                node,
                before,
                planes,
                level,
            });
        }
    }

    fn pop(&mut self) -> Option<Queued> {
        let last = self.survey.last.get_mut(self.bucket)?;
        let node = *self.survey.queue.get(*last as usize)?;
        *last = node.before;
        Some(node)
    }

    #[inline(always)]
    fn visit<F: Floats>(&mut self, queued: &Queued) {
        self.count_own::<F>(queued);
        if queued.level > 0 {
            self.count_children::<F>(queued);
        }
    }

    #[inline(always)]
    fn count_own<F: Floats>(&mut self, queued: &Queued) {
        let starts = self.arrays.own.get(queued.node as usize..);
        let block = self.arrays.own_block_starts.get(queued.node as usize);
        let (Some(&[first, end, ..]), Some(&block)) = (starts, block) else {
            return; // only in a damaged file
        };
        if end.saturating_sub(first) > MAX_FAN_OUT as u32 {
            return; // only in a damaged file
        }
        let boxes = self.arrays.own_blocks.get(block as usize..);
        let radii = self.arrays.own_radii.get(block as usize..);
        let blocks = boxes
            .unwrap_or_default()
            .iter()
            .zip(radii.unwrap_or_default());
        for ((boxes, radii), first) in blocks.zip((first..end).step_by(8)) {
            let mut set = lanes::first((end - first).min(8));
            if queued.planes != 0 {
                set &= !self
                    .filter
                    .outside_or_touching_in::<F>(boxes, queued.planes)
                    .0;
            }
            let sizes = self.squared_sizes(F::of(radii), self.filter.distances_in::<F>(boxes));
            let sizes = sizes.to_array();
            for lane in lanes::each(set) {
                let bucket = bucket_of(sizes[lane as usize & 7]);
                self.survey.counts[bucket] += 1.0;
            }
        }
    }

    #[inline(always)]
    fn count_children<F: Floats>(&mut self, queued: &Queued) {
        let starts = self.arrays.children.get(queued.node as usize..);
        let block = self.arrays.child_block_starts.get(queued.node as usize);
        let (Some(&[first, end, ..]), Some(&block)) = (starts, block) else {
            return; // only in a damaged file
        };
        if end.saturating_sub(first) > MAX_FAN_OUT as u32 {
            return; // only in a damaged file
        }
        let level = queued.level - 1;
        let held = self.survey.held.get(level as usize).copied();
        let held = held.unwrap_or_default();
        for (block, first) in (block as usize..).zip((first..end).step_by(8)) {
            let (Some(boxes), Some(largest), Some(least)) = (
                self.arrays.child_blocks.get(block),
                self.arrays.child_radii.get(block),
                self.arrays.child_least_radii.get(block),
            ) else {
                return; // only in a damaged file
            };
            let relations = self.filter.relations_in::<F>(boxes, queued.planes);
            let seen = lanes::first((end - first).min(8)) & !relations.outside;
            let (largest, least) = (F::of(largest), F::of(least));
            let high = self.squared_sizes(largest, self.filter.distances_in::<F>(boxes));
            let low = self.squared_sizes(least, self.filter.farthest_in::<F>(boxes));
            let entered = if held > COARSE * self.grain {
                seen
            } else if held > self.grain {
                // Where sizes hardly differ and none is outside, there is little to learn.
                seen & (!relations.inside | (low * F::splat(NARROW)).less(high))
            } else {
                0
            };
            let (high, low) = (high.to_array(), low.to_array());
            for lane in lanes::each(entered) {
                let bucket = bucket_of(high[lane as usize & 7]).min(self.bucket);
                self.push(first + lane, level, relations.open_planes(lane), bucket);
            }
            let (largest, least) = ((largest * largest).to_array(), (least * least).to_array());
            for lane in lanes::each(seen & !entered) {
                let at = lane as usize & 7;
                let inside = lanes::has(relations.inside, lane);
                let counted = if inside { held } else { held * CROSSING };
                let low = bucket_of(low[at]);
                let width = bucket_of(high[at]).saturating_sub(low);
                let buckets = |squared: f32| (squared.to_bits() >> BUCKET_BITS) as usize;
                let by_radius = buckets(largest[at]).saturating_sub(buckets(least[at]));
                let by_radius = by_radius.min(width);
                self.spread(counted, low, by_radius, width - by_radius);
            }
        }
    }

    /// Counts so many objects between two sizes. Radii and distances spread evenly, so sizes do
    /// like the sums of two dice.
    #[inline(always)]
    fn spread(&mut self, objects: f32, low: usize, by_radius: usize, by_distance: usize) {
        let by_distance = by_distance.min(WIDEST - 1) + 1;
        let by_radius = by_radius.min(MOST_UNLIKE - 1) + 1;
        let bend = objects * ONE_BY[by_radius] * ONE_BY[by_distance];
        let high = (low + by_radius + by_distance - 2).min(self.bucket);
        let bends = &mut self.survey.bends;
        for (below, bend) in [
            (0, bend),
            (by_radius, -bend),
            (by_distance, -bend),
            (by_radius + by_distance, bend),
        ] {
            // What is smaller than all buckets does not matter.
            if let Some(at) = bends.get_mut(high.wrapping_sub(below)) {
                *at += bend;
            }
        }
    }

    /// Squares of radii by distances, about.
    #[inline(always)]
    fn squared_sizes<F: Floats>(&self, radii: F, distances: EightDistances<F>) -> F {
        let squared = radii * radii;
        if self.perspective {
            squared / distances.squared()
        } else {
            squared
        }
    }
}

fn bucket_of(squared: f32) -> usize {
    // Not a number only in a damaged file.
    let squared = if squared >= 0.0 { squared } else { 0.0 };
    let bucket = (squared.to_bits() >> BUCKET_BITS) as usize;
    bucket.saturating_sub(LOWEST).min(BUCKETS - 1)
}
