//! Which of eight things are large enough on the screen: f32 where it is certain, f64 elsewhere.

use super::border::Border;
use super::gather::not_outside;
use super::lanes;
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
    /// Lists what is between the two. None where they are the same and finite: there what f32
    /// leaves open is decided in f64 at once.
    pub(super) border: Option<&'a mut Border>,
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
        match &mut self.border {
            Some(border) => border.push(first, open, radii, &distances),
            None => return sure | self.decide(first, open),
        }
        sure
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

    /// Which of eight objects are sure, decided in f64.
    #[inline(never)]
    fn decide(&mut self, first: u32, set: Lanes) -> Lanes {
        let large = |&lane: &u32| {
            let exact = Aabb::nth(self.arrays.object_boxes, first + lane);
            exact.is_some_and(|exact| self.view.size_px(&exact) >= self.sure.px)
        };
        let sure = lanes::each(set).filter(large);
        let sure = sure.fold(0, |set, lane| set | 1 << lane);
        self.missed |= sure != set;
        sure
    }
}
