//! What a retrieval leaves out: the largest of it bounds the error.

use std::ops::Range;

use wide::f32x8;

use super::retrieve::Traversal;
use crate::geom::{Aabb, Eight, EightDistances, Filter, Lanes};

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
    #[inline]
    pub(super) fn note_hidden(
        &mut self,
        cut: u32,
        level: u32,
        first: u32,
        distances: &EightDistances,
        stopped: Lanes,
    ) {
        if let Some(&radii) = self.arrays.hidden_below(cut, level, first) {
            let radii = f32x8::from(radii);
            if self.omitted.exceeding(radii, distances, stopped) != 0 {
                self.omitted.raise(radii, distances, stopped);
            }
        }
    }

    /// The same for nodes left out altogether: what they hold is hidden below their parent, and
    /// no larger than their box.
    #[inline]
    pub(super) fn note_beyond(
        &mut self,
        boxes: &Eight,
        distances: &EightDistances,
        beyond: Lanes,
        parent_hidden: f32,
    ) {
        let hidden = f32x8::splat(parent_hidden);
        if self.omitted.exceeding(hidden, distances, beyond) != 0 {
            let radii = Filter::radii(boxes).fast_min(hidden);
            self.omitted.raise(radii, distances, beyond);
        }
    }
}
