//! What a retrieval leaves out: the largest of it bounds the error.

use std::ops::Range;

use wide::f32x8;

use super::retrieve::Traversal;
use crate::geom::{Aabb, Eight, EightDistances, Filter, Floats, Lanes};

impl Traversal<'_> {
    pub(super) fn hidden(&self, node: u32) -> f32 {
        let hidden = self.arrays.hidden_radii.get(node as usize);
        hidden.copied().unwrap_or(f32::INFINITY)
    }

    /// Largest radius of the objects that stand for `nodes`.
    #[cold]
    pub(super) fn promoted(&self, nodes: &Range<u32>) -> f32 {
        let representatives = self.arrays.representatives;
        let radius = |&object: &u32| {
            let bounds = Aabb::nth(self.arrays.object_boxes, object);
            bounds.map_or(f32::INFINITY, |b| (b.radius() as f32).next_up())
        };
        let range = nodes.start as usize..nodes.end as usize;
        representatives.get(range).map_or(f32::INFINITY, |all| {
            all.iter().map(radius).fold(0.0, f32::max)
        })
    }

    /// Keeps the largest size on the screen of what is stored at levels lower than `cut` below the
    /// nodes of `level` in the set `stopped`.
    #[inline(always)]
    pub(super) fn note_hidden<F: Floats>(
        &mut self,
        cut: u32,
        level: u32,
        first: u32,
        distances: &EightDistances<F>,
        stopped: Lanes,
    ) {
        if let Some(radii) = self.arrays.hidden_below(cut, level, first) {
            let exceeding = self
                .omitted
                .exceeding(F::of_array(radii), distances, stopped);
            if exceeding != 0 {
                let radii = f32x8::from(*radii);
                self.omitted.raise(radii, &distances.in_memory(), stopped);
            }
        }
    }

    /// The same for nodes left out altogether: what they hold is hidden below their parent, and
    /// no larger than their box.
    #[inline(always)]
    pub(super) fn note_beyond<F: Floats>(
        &mut self,
        boxes: &Eight,
        distances: &EightDistances<F>,
        beyond: Lanes,
        parent_hidden: f32,
    ) {
        let hidden = F::splat(parent_hidden);
        if self.omitted.exceeding(hidden, distances, beyond) != 0 {
            let radii = Filter::radii(boxes).fast_min(f32x8::splat(parent_hidden));
            self.omitted.raise(radii, &distances.in_memory(), beyond);
        }
    }
}
