//! Below nodes whose distance is settled: they lie wholly in the range of one level.

use std::ops::Range;

use super::lanes;
use super::retrieve::{Open, Traversal};
use crate::geom::{Eight, EightDistances, Floats, Lanes, PlaneSet, Threshold};

/// Siblings that lie wholly in the range of one level, and which level that is.
#[derive(Default)]
pub(super) struct Settled {
    pub(super) set: Lanes,
    pub(super) at: [u8; 8],
}

impl Traversal<'_> {
    /// Which of `nearer` lie wholly in the range of one level below theirs, and in which: what is
    /// stored below that level is left out.
    #[inline(always)]
    pub(super) fn settle<F: Floats>(
        &mut self,
        level: u32,
        first: u32,
        boxes: &Eight,
        distances: &EightDistances<F>,
        nearer: Lanes,
    ) -> Settled {
        let farthest = self.filter.farthest_in::<F>(boxes);
        let mut settled = Settled::default();
        let mut open = nearer;
        let ranges = self.far.iter().take(level as usize);
        let mut below: Option<&Threshold> = None;
        for (cut, far) in (0..).zip(ranges) {
            if let Some(below) = below.replace(far) {
                open &= !settled.set & distances.not_nearer(below);
                if open == 0 {
                    break;
                }
            }
            let set = open & farthest.nearer(far);
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

    /// Step 6 where the distance is settled.
    #[inline]
    pub(super) fn open_settled(&mut self, level: u32, node: u32, planes: PlaneSet, cut: u32) {
        if level > cut
            && let Some((nodes, block)) = self.children(node)
        {
            self.below.push(Open::Settled {
                nodes,
                block,
                planes,
                cut,
            });
        }
    }

    /// Step 6 where the frustum is settled too, for a node whose own objects have been added,
    /// unless it passes through.
    #[inline]
    pub(super) fn whole(&mut self, level: u32, node: u32, cut: u32) {
        if level >= self.ranged_levels {
            if level < self.root {
                self.add_representative(node, 0);
            }
            self.own.whole(&(node..node + 1));
        }
        self.open_whole(level, node..node + 1, cut);
    }

    #[inline]
    pub(super) fn open_whole(&mut self, level: u32, nodes: Range<u32>, cut: u32) {
        if level > cut
            && let Some(nodes) = self.descent.children(&self.arrays, nodes)
        {
            match self.below.last_mut() {
                Some(Open::Whole {
                    nodes: last,
                    cut: same,
                }) if last.end == nodes.start && *same == cut => last.end = nodes.end,
                _ => self.below.push(Open::Whole { nodes, cut }),
            }
        }
    }

    /// `count` siblings of which the distance is settled.
    #[inline(always)]
    pub(super) fn settled<F: Floats>(
        &mut self,
        level: u32,
        boxes: &Eight,
        first: u32,
        count: u32,
        planes: PlaneSet,
        cut: u32,
    ) {
        let relations = self.filter.relations_in::<F>(boxes, planes);
        let visible = lanes::first(count) & !relations.outside;
        if level < self.ranged_levels {
            self.add(level, first, visible, &relations);
        }
        if level == cut {
            return;
        }
        for lane in lanes::each(visible) {
            if lanes::has(relations.inside, lane) {
                self.whole(level, first + lane, cut);
            } else {
                self.open_settled(level, first + lane, relations.open_planes(lane), cut);
            }
        }
    }
}
