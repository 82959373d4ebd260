//! Which of eight things are large enough on the screen: f32 where it is certain, f64 elsewhere.

use super::gather::not_outside;
use super::lanes;
use super::sweep::Sized;
use crate::geom::{
    Aabb, Eight, EightDistances, Filter, Floats, Lanes, PlaneSet, SizeThreshold, View,
};
use crate::index::Arrays;

/// What is asked of sizes.
pub(super) struct Sizing<'a> {
    pub(super) arrays: Arrays<'a>,
    pub(super) view: &'a View,
    pub(super) filter: &'a Filter,
    pub(super) sure: SizeThreshold,
    pub(super) least: SizeThreshold,
    /// Whether something was too small.
    pub(super) missed: bool,
    pub(super) border: &'a mut Vec<Sized>,
}

impl Sizing<'_> {
    /// Those of `set` that may hold something large enough.
    #[inline(always)]
    pub(super) fn large_enough<F: Floats>(
        &mut self,
        radii: F,
        distances: &EightDistances<F>,
        set: Lanes,
    ) -> Lanes {
        let large = set & !self.least.missed(radii, distances);
        self.missed |= large != set;
        large
    }

    /// Which of eight objects are drawn for sure; lists those of the border.
    #[inline(always)]
    pub(super) fn sure<F: Floats>(
        &mut self,
        block: usize,
        boxes: &Eight,
        first: u32,
        set: Lanes,
        planes: PlaneSet,
    ) -> Lanes {
        let Some(radii) = self.arrays.own_radii.get(block) else {
            return 0; // only in a damaged file
        };
        let radii = F::of(radii);
        let seen = self.seen::<F>(boxes, first, set, planes);
        let distances = self.filter.distances_in::<F>(boxes);
        let sure = seen & self.sure.reached(radii, &distances);
        let rest = seen ^ sure;
        if rest == 0 {
            return sure;
        }
        let open = rest & !self.least.missed(radii, &distances);
        self.missed |= open != rest;
        if open == 0 {
            return sure;
        }
        sure | self.decide(first, open)
    }

    /// Which of eight objects are not outside one of `planes`.
    #[inline(always)]
    fn seen<F: Floats>(&self, boxes: &Eight, first: u32, set: Lanes, planes: PlaneSet) -> Lanes {
        if planes == 0 {
            return set;
        }
        let (outside, touching) = self.filter.outside_or_touching_in::<F>(boxes, planes);
        let open = set & !(outside | touching);
        if open == 0 {
            return set & touching;
        }
        set & touching | not_outside(self.view, self.arrays.object_boxes, first, open)
    }

    /// Which of eight objects are sure, decided in f64; lists those of the border.
    #[inline(never)]
    fn decide(&mut self, first: u32, set: Lanes) -> Lanes {
        let mut sure = 0;
        for lane in lanes::each(set) {
            let object = first + lane;
            let Some(exact) = Aabb::nth(self.arrays.object_boxes, object) else {
                continue; // only in a damaged file
            };
            let size = self.view.size_px(&exact);
            if size >= self.sure.px && self.sure.px < f64::INFINITY {
                sure |= 1 << lane;
            } else if size >= self.least.px {
                self.border.push(Sized { size, object });
            } else {
                self.missed = true;
            }
        }
        sure
    }
}
