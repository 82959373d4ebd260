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

use std::ops::Range;

use wide::f32x8;

use super::lanes;
use crate::geom::{EightDistances, Filter, PixelScale, PlaneSet, View};
use crate::index::{Arrays, LodTree};

/// Bits of an f32 below its exponent and the first three of its fraction: eight buckets for each
/// doubling of the squared size.
const BUCKET_BITS: u32 = 20;
/// All buckets of positive numbers, infinity included.
const BUCKETS: usize = (f32::INFINITY.to_bits() >> BUCKET_BITS) as usize + 1;
/// A node that holds fewer than one in so many of the objects wanted is not entered.
const GRAIN: f32 = 128.0;
/// Around the eye sizes have no end: those of a node are spread over so many buckets at most.
const WIDEST: usize = 48;
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
        let mut seen = 0.0;
        loop {
            while let Some(node) = walk.pop() {
                walk.visit(&node);
            }
            let bucket = walk.bucket;
            let counted = walk.survey.counts[bucket];
            if seen + counted >= rank && counted > 0.0 {
                let (PixelScale::PerRadian(scale) | PixelScale::PerMetre(scale)) = view.pixels();
                return 2.0 * scale * size_within(bucket, (rank - seen) / counted);
            }
            seen += counted;
            match bucket.checked_sub(1) {
                Some(next) => walk.bucket = next,
                None => return 0.0,
            }
        }
    }

    fn clear(&mut self, arrays: &Arrays) {
        self.last.clear();
        self.last.resize(BUCKETS, NONE);
        self.counts.clear();
        self.counts.resize(BUCKETS, 0.0);
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
    let place = (bucket as f64 + 1.0 - f64::from(share)) * f64::from(1 << BUCKET_BITS);
    f64::from(f32::from_bits(place as u32)).sqrt()
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

    fn visit(&mut self, queued: &Queued) {
        self.count_own(queued);
        if queued.level > 0 {
            self.count_children(queued);
        }
    }

    fn count_own(&mut self, queued: &Queued) {
        let starts = self.arrays.own.get(queued.node as usize..);
        let block = self.arrays.own_block_starts.get(queued.node as usize);
        let (Some(&[first, end, ..]), Some(&block)) = (starts, block) else {
            return; // only in a damaged file
        };
        let boxes = self.arrays.own_blocks.get(block as usize..);
        let radii = self.arrays.own_radii.get(block as usize..);
        let blocks = boxes
            .unwrap_or_default()
            .iter()
            .zip(radii.unwrap_or_default());
        for ((boxes, &radii), first) in blocks.zip((first..end).step_by(8)) {
            let mut set = lanes::first((end - first).min(8));
            if queued.planes != 0 {
                set &= !self.filter.outside_or_touching(boxes, queued.planes).0;
            }
            let sizes = self.squared_sizes(radii, &self.filter.distances(boxes));
            for lane in lanes::each(set) {
                let bucket = bucket_of(sizes[lane as usize & 7]);
                self.survey.counts[bucket] += 1.0;
            }
        }
    }

    fn count_children(&mut self, queued: &Queued) {
        let starts = self.arrays.children.get(queued.node as usize..);
        let block = self.arrays.child_block_starts.get(queued.node as usize);
        let (Some(&[first, end, ..]), Some(&block)) = (starts, block) else {
            return; // only in a damaged file
        };
        let level = queued.level - 1;
        let held = self.survey.held.get(level as usize).copied();
        let held = held.unwrap_or_default();
        for (block, first) in (block as usize..).zip((first..end).step_by(8)) {
            let (Some(boxes), Some(&largest), Some(&least)) = (
                self.arrays.child_blocks.get(block),
                self.arrays.child_radii.get(block),
                self.arrays.child_least_radii.get(block),
            ) else {
                return; // only in a damaged file
            };
            let relations = self.filter.relations(boxes, queued.planes);
            let seen = lanes::first((end - first).min(8)) & !relations.outside;
            let largest = self.squared_sizes(largest, &self.filter.distances(boxes));
            if held > self.grain {
                for lane in lanes::each(seen) {
                    let bucket = bucket_of(largest[lane as usize & 7]).min(self.bucket);
                    self.push(first + lane, level, relations.open_planes(lane), bucket);
                }
            } else {
                let least = self.squared_sizes(least, &self.filter.farthest(boxes));
                for lane in lanes::each(seen) {
                    let of_lane = |sizes: &[f32; 8]| bucket_of(sizes[lane as usize & 7]);
                    let inside = lanes::has(relations.inside, lane);
                    let counted = if inside { held } else { held * CROSSING };
                    self.spread(counted, of_lane(&least)..of_lane(&largest) + 1);
                }
            }
        }
    }

    /// Counts so many objects, evenly in these buckets.
    fn spread(&mut self, objects: f32, buckets: Range<usize>) {
        let start = buckets.start.min(BUCKETS - 1);
        let end = buckets.end.clamp(start + 1, (start + WIDEST).min(BUCKETS));
        let share = objects / (end - start) as f32;
        for count in &mut self.survey.counts[start..end] {
            *count += share;
        }
    }

    /// Squares of radii by distances, about.
    fn squared_sizes(&self, radii: f32x8, distances: &EightDistances) -> [f32; 8] {
        let squared = radii * radii;
        if self.perspective {
            (squared / distances.squared()).to_array()
        } else {
            squared.to_array()
        }
    }
}

fn bucket_of(squared: f32) -> usize {
    // Not a number only in a damaged file.
    let squared = if squared >= 0.0 { squared } else { 0.0 };
    (squared.to_bits() >> BUCKET_BITS) as usize
}
