//! Nodes of which the distance is yet to be compared with the ranges.

use super::lanes;
use super::retrieve::{Open, Traversal};
use super::settle::Settled;
use crate::geom::{Aabb, Eight, EightDistances, EightRelations, Floats, Lanes, PlaneSet};

impl Traversal<'_> {
    /// Steps 2 to 6 for `count` children of a node nearer than its range.
    #[inline(always)]
    pub(super) fn near<F: Floats>(
        &mut self,
        level: u32,
        boxes: &Eight,
        first: u32,
        count: u32,
        planes: PlaneSet,
        parent_hidden: f32,
    ) {
        // Step 2. Of an ambiguous box it is safe to say that it crosses: its objects are tested.
        let relations = self.filter.relations_in::<F>(boxes, planes);
        let visible = lanes::first(count) & !relations.outside;
        if visible == 0 {
            return;
        }
        // Steps 3 and 5: where does the distance lie to the range of the level?
        let distances = self.filter.distances_in::<F>(boxes);
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
    #[inline(always)]
    fn nearer<F: Floats>(
        &self,
        first: u32,
        distances: &EightDistances<F>,
        level: u32,
        set: Lanes,
    ) -> Lanes {
        // Levels that pass through do so as far as the last that has a range reaches.
        let Some(far) = self.far.get(level as usize).or(self.far.last()) else {
            return set;
        };
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

    /// Steps 4 and 6 for siblings nearer than their range.
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
        for lane in lanes::each(nearer) {
            let node = first + lane;
            let cut = u32::from(settled.at[lane as usize & 7]);
            if lanes::has(whole, lane) {
                self.whole(level, node, cut);
            } else {
                let planes = relations.open_planes(lane);
                if lanes::has(settled.set, lane) {
                    self.open_settled(level, node, planes, cut);
                } else {
                    self.open_near(level, node, planes);
                }
            }
        }
    }

    /// Steps 4 and 6: on to the children of a node nearer than its range.
    #[inline]
    fn open_near(&mut self, level: u32, node: u32, planes: PlaneSet) {
        if let Some((nodes, block)) = self.children(node) {
            // A node without a range has added nothing, its own objects neither.
            let hidden = if level < self.ranged_levels {
                self.hidden(node)
            } else {
                self.hidden(node).max(self.promoted(&nodes))
            };
            self.below.push(Open::Near {
                nodes,
                block,
                planes,
                hidden,
            });
        }
    }
}
