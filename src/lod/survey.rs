//! About how large the n-th largest object of a view is.
//!
//! A best-first walk over a sample of the tree. Sizes are kept by bucket, a few to the octave, so
//! that queue and counts are arrays: a bucket of nodes is emptied before the next smaller one,
//! and when as many objects are counted as are wanted, nothing larger is left. For large budgets
//! most leaves are passed over; each that is looked at counts for several.
//!
//! The answer does not depend on the estimate, only the time it takes does.

use wide::f32x8;

use super::lanes;
use super::sweep::Wanted;
use crate::geom::{Eight, Filter, PixelScale, PlaneSet, View};
use crate::index::{Arrays, LodTree};

/// Bits of an f32 below its exponent and the first three of its fraction: eight buckets for each
/// doubling of the squared size.
const BUCKET_BITS: u32 = 20;
/// All buckets of positive numbers, infinity included.
const BUCKETS: usize = (f32::INFINITY.to_bits() >> BUCKET_BITS) as usize + 1;
/// From here on a sample will do. It grows with the root of the budget, so that the objects it
/// counts and those it leaves to be ranked stay in proportion.
const SAMPLE: u32 = 128;
/// Of the children of a node at most one in so many is passed over.
const SPARSEST: u32 = 4;
/// Objects of a sample come in groups, so it strays as if it were this much smaller.
const GROUPED: f64 = 2.5;

/// Memory of a survey.
#[derive(Debug, Clone, Default)]
pub(super) struct Survey {
    /// The last node queued in each bucket, and all nodes with the one queued before them.
    last: Vec<u32>,
    queue: Vec<Queued>,
    /// Objects counted in each bucket.
    counts: Vec<u32>,
}

#[derive(Debug, Clone, Copy)]
struct Queued {
    node: u32,
    before: u32,
    planes: PlaneSet,
    level: u32,
    /// Nodes it stands for, itself included.
    weight: u32,
}

const NONE: u32 = u32::MAX;

impl Survey {
    /// Two sizes that the `rank`-th largest object most likely lies between.
    pub(super) fn estimate(
        &mut self,
        tree: &LodTree,
        view: &View,
        filter: &Filter,
        rank: u32,
    ) -> Wanted {
        self.last.clear();
        self.last.resize(BUCKETS, NONE);
        self.counts.clear();
        self.counts.resize(BUCKETS, 0);
        self.queue.clear();
        let rate = (rank / SAMPLE).isqrt().next_power_of_two();
        let strays = 1.5 * (GROUPED * f64::from(rate - 1) / f64::from(rank.max(1))).sqrt();
        let margin = 2.0 + f64::from(rank) * (strays + 0.01);
        let most = f64::from(rank) + margin;
        let mut walk = Walk {
            arrays: tree.arrays(),
            filter,
            perspective: matches!(view.pixels(), PixelScale::PerRadian(_)),
            rate,
            bucket: BUCKETS - 1,
            survey: self,
        };
        walk.push(
            0,
            tree.level_count() - 1,
            filter.all_planes(),
            1,
            f32::INFINITY,
        );
        let mut seen = 0.0;
        while seen < most {
            while let Some(node) = walk.pop() {
                walk.visit(&node);
            }
            seen += f64::from(walk.survey.counts[walk.bucket]);
            if walk.bucket == 0 {
                break;
            }
            walk.bucket -= 1;
        }
        let (PixelScale::PerRadian(scale) | PixelScale::PerMetre(scale)) = view.pixels();
        let size = |count| self.size_of(count).map(|ratio| 2.0 * scale * ratio);
        let least = size(most).unwrap_or(0.0);
        let sure = size(f64::from(rank) - margin).unwrap_or(least);
        Wanted { sure, least }
    }

    /// The radius by distance that so many of the objects counted exceed.
    fn size_of(&self, count: f64) -> Option<f64> {
        let mut above = 0.0;
        for (bucket, &counted) in self.counts.iter().enumerate().rev() {
            let counted = f64::from(counted);
            if above + counted >= count {
                let share = ((count - above) / counted.max(1.0)).max(0.0);
                let place = (bucket as f64 + 1.0 - share) * f64::from(1 << BUCKET_BITS);
                let squared = if bucket + 1 == BUCKETS {
                    f32::INFINITY
                } else {
                    f32::from_bits(place as u32)
                };
                return Some(f64::from(squared).sqrt());
            }
            above += counted;
        }
        None
    }
}

struct Walk<'a> {
    arrays: Arrays<'a>,
    filter: &'a Filter,
    perspective: bool,
    /// One object in about so many is looked at.
    rate: u32,
    /// The largest that is not yet done.
    bucket: usize,
    survey: &'a mut Survey,
}

impl Walk<'_> {
    fn push(&mut self, node: u32, level: u32, planes: PlaneSet, weight: u32, squared: f32) {
        let bucket = bucket_of(squared).min(self.bucket);
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
                weight,
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
            self.push_children(queued);
        }
    }

    fn count_own(&mut self, queued: &Queued) {
        let starts = self.arrays.own.get(queued.node as usize..);
        let block = self.arrays.own_block_starts.get(queued.node as usize);
        let (Some(&[first, end, ..]), Some(&block)) = (starts, block) else {
            return; // only in a damaged file
        };
        let boxes = self
            .arrays
            .own_blocks
            .get(block as usize..)
            .unwrap_or_default();
        let radii = self
            .arrays
            .own_radii
            .get(block as usize..)
            .unwrap_or_default();
        let blocks = boxes.iter().zip(radii);
        for ((boxes, &radii), first) in blocks.zip((first..end).step_by(8)) {
            let mut set = lanes::first((end - first).min(8));
            if queued.planes != 0 {
                set &= !self.filter.outside_or_touching(boxes, queued.planes).0;
            }
            let sizes = self.squared_sizes(boxes, radii);
            for lane in lanes::each(set) {
                let bucket = bucket_of(sizes[lane as usize & 7]);
                let count = &mut self.survey.counts[bucket];
                *count = count.saturating_add(queued.weight);
            }
        }
    }

    fn push_children(&mut self, queued: &Queued) {
        let starts = self.arrays.children.get(queued.node as usize..);
        let block = self.arrays.child_block_starts.get(queued.node as usize);
        let (Some(&[first, end, ..]), Some(&block)) = (starts, block) else {
            return; // only in a damaged file
        };
        let level = queued.level - 1;
        let sparseness = self.sparseness(level);
        // Another place in each group of siblings.
        let place = queued.node.wrapping_mul(0x9e37_79b9) >> 16;
        let boxes = self
            .arrays
            .child_blocks
            .get(block as usize..)
            .unwrap_or_default();
        let radii = self
            .arrays
            .child_radii
            .get(block as usize..)
            .unwrap_or_default();
        let blocks = boxes.iter().zip(radii);
        for ((boxes, &held), first) in blocks.zip((first..end).step_by(8)) {
            let relations = self.filter.relations(boxes, queued.planes);
            let seen = lanes::first((end - first).min(8)) & !relations.outside;
            let sizes = self.squared_sizes(boxes, held);
            for lane in lanes::each(seen) {
                if (lane ^ place) & (sparseness - 1) == 0 {
                    let weight = queued.weight.saturating_mul(sparseness);
                    let planes = relations.open_planes(lane);
                    let size = sizes[lane as usize & 7];
                    self.push(first + lane, level, planes, weight, size);
                }
            }
        }
    }

    /// One node in so many of this level is looked at: leaves are passed over first.
    fn sparseness(&self, level: u32) -> u32 {
        let above = SPARSEST.saturating_pow(level);
        (self.rate / above).clamp(1, SPARSEST)
    }

    /// Squares of radii by distances, about.
    fn squared_sizes(&self, boxes: &Eight, radii: [f32; 8]) -> [f32; 8] {
        let radii = f32x8::from(radii);
        let squared = radii * radii;
        if self.perspective {
            (squared / self.filter.distances(boxes).squared()).to_array()
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
