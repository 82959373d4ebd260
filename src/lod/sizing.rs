//! Which of eight things are large enough on the screen: f32 where it is certain, f64 elsewhere.

use super::border::Border;
use super::lanes;
use super::sight::Sight;
use crate::geom::{Aabb, Eight, EightDistances, Floats, Lanes, PlaneSet, SizeThreshold};
use crate::index::Arrays;

/// What is asked of sizes.
pub(super) struct Sizing<'a> {
    pub(super) arrays: Arrays<'a>,
    pub(super) sight: Sight<'a>,
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
        let seen = self.sight.seen::<F>(boxes, first, set, planes);
        let distances = self.sight.filter.distances_in::<F>(boxes);
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

    /// Which of eight objects are sure, decided in f64.
    #[inline(never)]
    fn decide(&mut self, first: u32, set: Lanes) -> Lanes {
        let large = |&lane: &u32| {
            let exact = Aabb::nth(self.sight.object_boxes, first + lane);
            exact.is_some_and(|exact| self.sight.view.size_px(&exact) >= self.sure.px)
        };
        let sure = lanes::each(set).filter(large);
        let sure = sure.fold(0, |set, lane| set | 1 << lane);
        self.missed |= sure != set;
        sure
    }
}
