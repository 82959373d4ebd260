//! What the nodes of one level add to the answer: their own objects.
//!
//! The walk only lists them. They are looked at once the level is done, in one loop that does
//! nothing else: it is most of the work, and this way it keeps to the registers.

use std::ops::Range;

use super::lanes;
use super::ranges::Ranges;
use crate::geom::{Aabb, Eight, Lanes, PlaneSet, View};
use crate::index::Arrays;

/// Objects stored with one node, or with neighbouring nodes of which all are drawn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Own {
    first: u32,
    end: u32,
    /// Where their boxes begin, or [`ALL_DRAWN`].
    block: u32,
    /// Planes the node crosses.
    planes: PlaneSet,
}

/// Stands for a block: nothing needs to be looked at.
const ALL_DRAWN: u32 = u32::MAX;

/// The own objects of one level in the making.
#[derive(Debug, Clone, Default)]
pub(super) struct Gathered(Vec<Own>);

impl Gathered {
    /// Forgets everything but its memory.
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// Adds the own objects of neighbouring nodes, all of which are drawn.
    #[inline]
    pub(super) fn whole(&mut self, arrays: &Arrays, nodes: &Range<u32>) {
        let own = |node: u32| arrays.own.get(node as usize).copied();
        if let (Some(first), Some(end)) = (own(nodes.start), own(nodes.end)) {
            self.0.push(Own {
                first,
                end,
                block: ALL_DRAWN,
                planes: 0,
            });
        }
    }

    /// Adds the own objects of the nodes in `set`, counted from `first`. Each is looked at, but
    /// for those of the nodes in `drawn`.
    #[inline(always)]
    pub(super) fn nodes(
        &mut self,
        arrays: &Arrays,
        first: u32,
        set: Lanes,
        drawn: Lanes,
        planes: impl Fn(u32) -> PlaneSet,
    ) {
        let (Some(own), Some(blocks)) = (
            arrays.own.get(first as usize..),
            arrays.own_block_starts.get(first as usize..),
        ) else {
            return; // only in a damaged file
        };
        self.0.extend(lanes::each(set).filter_map(|lane| {
            let at = lane as usize;
            let (&[first, end], &block) = (own.get(at..)?.first_chunk()?, blocks.get(at)?);
            let block = if lanes::has(drawn, lane) {
                ALL_DRAWN
            } else {
                block
            };
            let planes = planes(lane);
            Some(Own {
                first,
                end,
                block,
                planes,
            })
        }));
    }

    /// Lists the objects that are drawn: `drawn` tells which of eight, by the number of their
    /// block, the boxes in it, the first of them, those to be looked at, and the planes they may
    /// cross. `next` is the first object not yet met: in a sound file it only states what is so,
    /// in a damaged one it keeps the loop short. Returns how many were looked at.
    #[inline(always)]
    pub(super) fn list(
        &self,
        arrays: &Arrays,
        next: &mut u32,
        ranges: &mut Ranges,
        mut drawn: impl FnMut(usize, &Eight, u32, Lanes, PlaneSet) -> Lanes,
    ) -> u32 {
        let known = arrays.object_boxes.len() as u32;
        let mut tested = 0;
        for &Own {
            mut first,
            end,
            block,
            planes,
        } in &self.0
        {
            if first < *next || end < first || end > known {
                continue; // only in a damaged file
            }
            *next = end;
            if block == ALL_DRAWN {
                ranges.push(first..end);
                continue;
            }
            tested += end - first;
            let mut block = block as usize;
            while first < end {
                let Some(boxes) = arrays.own_blocks.get(block) else {
                    break; // only in a damaged file
                };
                let set = lanes::first((end - first).min(8));
                let set = drawn(block, boxes, first, set, planes);
                ranges.push_runs(first, set);
                first = first.saturating_add(8);
                block += 1;
            }
        }
        tested
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
