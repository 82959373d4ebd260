//! Which of eight objects are seen: f32 where it is certain, f64 elsewhere.

use super::lanes;
use crate::geom::{Aabb, Eight, Filter, Floats, Lanes, PlaneSet, View};
use crate::index::Arrays;

/// What decides whether an object is seen.
#[derive(Clone, Copy)]
pub(super) struct Sight<'a> {
    pub(super) view: &'a View,
    pub(super) filter: &'a Filter,
    pub(super) object_boxes: &'a [[f64; 6]],
}

impl<'a> Sight<'a> {
    pub(super) fn new(view: &'a View, filter: &'a Filter, arrays: &Arrays<'a>) -> Self {
        Self {
            view,
            filter,
            object_boxes: arrays.object_boxes,
        }
    }

    /// Which of eight objects from `first` on, those in `set`, are not outside one of `planes`.
    #[inline(always)]
    pub(super) fn seen<F: Floats>(
        &self,
        boxes: &Eight,
        first: u32,
        set: Lanes,
        planes: PlaneSet,
    ) -> Lanes {
        if planes == 0 {
            return set;
        }
        let (outside, touching) = self.filter.outside_or_touching_in::<F>(boxes, planes);
        let open = set & !(outside | touching);
        if open == 0 {
            return set & touching;
        }
        // What f32 leaves open is decided in f64.
        set & touching | self.not_outside(first, open)
    }

    /// Which of eight objects are not outside the frustum, decided in f64.
    #[cold]
    fn not_outside(&self, first: u32, set: Lanes) -> Lanes {
        let seen = |&lane: &u32| {
            let exact = Aabb::nth(self.object_boxes, first + lane);
            exact.is_some_and(|exact| !self.view.frustum().is_outside(&exact))
        };
        lanes::each(set)
            .filter(seen)
            .fold(0, |set, lane| set | 1 << lane)
    }
}
