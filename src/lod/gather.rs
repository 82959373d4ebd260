//! What the nodes of one level add to the answer: their own objects.
//!
//! The walk only lists them. They are looked at once the level is done, in one loop that does
//! nothing else: it is most of the work, and this way it keeps to the registers.

use std::ops::Range;

use super::lanes;
use super::ranges::Ranges;
use crate::geom::{Eight, EightRelations, Lanes, PlaneSet};
use crate::index::Arrays;

/// Nodes that add their own objects.
#[derive(Debug, Clone, Copy)]
enum Adding {
    /// Neighbouring nodes of which all is drawn.
    Whole { first: u32, end: u32 },
    /// Those of eight siblings, counted from `first`, in `set`. Each object is looked at, but for
    /// those of the nodes in `drawn`.
    Some {
        first: u32,
        set: u8,
        drawn: u8,
        relations: EightRelations,
    },
}

/// The nodes of one level that add their own objects.
#[derive(Debug, Clone, Default)]
pub(super) struct Gathered(Vec<Adding>);

impl Gathered {
    /// Forgets everything but its memory.
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// Adds the own objects of neighbouring nodes, all of which are drawn.
    #[inline]
    pub(super) fn whole(&mut self, nodes: &Range<u32>) {
        self.0.push(Adding::Whole {
            first: nodes.start,
            end: nodes.end,
        });
    }

    /// Adds the own objects of the nodes in `set`, counted from `first`. Each is looked at, but
    /// for those of the nodes in `drawn`.
    #[inline(always)]
    pub(super) fn nodes(
        &mut self,
        first: u32,
        set: Lanes,
        drawn: Lanes,
        relations: &EightRelations,
    ) {
        self.0.push(Adding::Some {
            first,
            set: set as u8,
            drawn: (set & drawn) as u8,
            relations: *relations,
        });
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
        drawn: impl FnMut(usize, &Eight, u32, Lanes, PlaneSet) -> Lanes,
    ) -> u32 {
        let mut listing = Listing {
            arrays,
            known: arrays.object_boxes.len() as u32,
            next: *next,
            ranges,
            drawn,
            tested: 0,
        };
        for adding in &self.0 {
            match *adding {
                Adding::Whole { first, end } => listing.whole(first, end),
                Adding::Some {
                    first,
                    set,
                    drawn,
                    relations,
                } => listing.some(first, set.into(), drawn.into(), &relations),
            }
        }
        *next = listing.next;
        listing.tested
    }
}

struct Listing<'a, D> {
    arrays: &'a Arrays<'a>,
    known: u32,
    next: u32,
    ranges: &'a mut Ranges,
    drawn: D,
    tested: u32,
}

impl<D: FnMut(usize, &Eight, u32, Lanes, PlaneSet) -> Lanes> Listing<'_, D> {
    /// The own objects of neighbouring nodes.
    #[inline(always)]
    fn own(&mut self, first: u32, end: u32) -> Option<Range<u32>> {
        let (&first, &end) = (
            self.arrays.own.get(first as usize)?,
            self.arrays.own.get(end as usize)?,
        );
        if first < self.next || end < first || end > self.known {
            return None; // only in a damaged file
        }
        self.next = end;
        Some(first..end)
    }

    #[inline(always)]
    fn whole(&mut self, first: u32, end: u32) {
        if let Some(objects) = self.own(first, end) {
            self.ranges.push(objects);
        }
    }

    #[inline(always)]
    fn some(&mut self, first: u32, set: Lanes, drawn: Lanes, relations: &EightRelations) {
        let mut rest = set;
        while rest != 0 {
            let lane = rest.trailing_zeros();
            let node = first + lane;
            // Neighbours of which all is drawn are one.
            let run = lanes::run_length(drawn, lane);
            if run > 0 {
                self.whole(node, node + run);
                rest = lanes::after_run(rest, lane, run);
            } else {
                self.look_at(node, relations.open_planes(lane));
                rest &= rest - 1;
            }
        }
    }

    /// Looks at the own objects of a node, eight at a time.
    #[inline(always)]
    fn look_at(&mut self, node: u32, planes: PlaneSet) {
        let block = self.arrays.own_block_starts.get(node as usize);
        let (Some(objects), Some(&block)) = (self.own(node, node + 1), block) else {
            return; // only in a damaged file
        };
        self.tested = self.tested.saturating_add(objects.end - objects.start);
        for (block, first) in (block as usize..).zip(objects.clone().step_by(8)) {
            let Some(boxes) = self.arrays.own_blocks.get(block) else {
                return; // only in a damaged file
            };
            let set = lanes::first((objects.end - first).min(8));
            let set = (self.drawn)(block, boxes, first, set, planes);
            self.ranges.push_runs(first, set);
        }
    }
}
