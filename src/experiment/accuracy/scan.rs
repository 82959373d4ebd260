//! What a retrieval without a tree costs: every box, eight at a time.

use rayon::prelude::*;
use wide::f32x8;

use crate::geom::{ALL_LANES, Aabb, Eight, Filter, Lanes, SizeThreshold, View};
use crate::index::LodTree;

/// The boxes of objects in the order of a scan, eight to a block, no lane unused but in the last.
pub(super) struct Scan {
    numbers: Vec<u32>,
    blocks: Vec<Block>,
}

struct Block {
    /// Relative to the tree's origin, rounded outward.
    boxes: Eight,
    /// Rounded up.
    radii: f32x8,
}

impl Scan {
    /// Of these objects of a tree, in this order.
    pub(super) fn new(tree: &LodTree, numbers: Vec<u32>) -> Self {
        let block = |objects: &[u32]| {
            let mut block = Block {
                boxes: [f32x8::ZERO; 6],
                radii: f32x8::ZERO,
            };
            for (lane, &object) in objects.iter().enumerate() {
                let corners = tree.relative_box(object).unwrap_or_default();
                for (row, corner) in block.boxes.iter_mut().zip(corners) {
                    row.as_mut_array()[lane] = corner;
                }
                block.radii.as_mut_array()[lane] = (bounds(tree, object).radius() as f32).next_up();
            }
            block
        };
        Self {
            blocks: numbers.par_chunks(8).map(block).collect(),
            numbers,
        }
    }

    /// Every object of the frustum of at least this size, pixels: size first, then the planes;
    /// what f32 leaves open is decided in f64. The same answer as error mode gives.
    pub(super) fn large(&self, tree: &LodTree, view: &View, px: f64, found: &mut Vec<u32>) {
        found.clear();
        let filter = Filter::new(view.frustum(), tree.origin(), &tree.bounds());
        let threshold = SizeThreshold::new(&filter, view.pixels(), px);
        let planes = filter.all_planes();
        for (block, numbers) in self.blocks.iter().zip(self.numbers.chunks(8)) {
            let distances = filter.distances(&block.boxes);
            let missed = threshold.missed(block.radii, &distances);
            if missed == ALL_LANES {
                continue;
            }
            let (outside, touching) = filter.outside_or_touching(&block.boxes, planes);
            let open = !(missed | outside) & used(numbers);
            if open == 0 {
                continue;
            }
            let sure = touching & threshold.reached(block.radii, &distances);
            take(numbers, open, sure, found, |object| {
                let bounds = bounds(tree, object);
                view.size_px(&bounds) >= px && !view.frustum().is_outside(&bounds)
            });
        }
    }

    /// The same answer one object after another in f64, as one would write it down.
    pub(super) fn plain(tree: &LodTree, view: &View, px: f64, found: &mut Vec<u32>) {
        found.clear();
        for (object, corners) in (0..).zip(tree.arrays().object_boxes) {
            if let Ok(bounds) = Aabb::from_array(*corners)
                && view.size_px(&bounds) >= px
                && !view.frustum().is_outside(&bounds)
            {
                found.push(object);
            }
        }
    }

    /// Those of the first `count` objects that are in the frustum.
    pub(super) fn in_view(&self, tree: &LodTree, view: &View, count: usize, found: &mut Vec<u32>) {
        found.clear();
        let filter = Filter::new(view.frustum(), tree.origin(), &tree.bounds());
        let planes = filter.all_planes();
        let numbers = &self.numbers[..count.min(self.numbers.len())];
        for (block, numbers) in self.blocks.iter().zip(numbers.chunks(8)) {
            let (outside, touching) = filter.outside_or_touching(&block.boxes, planes);
            take(
                numbers,
                !outside & used(numbers),
                touching,
                found,
                |object| !view.frustum().is_outside(&bounds(tree, object)),
            );
        }
    }
}

/// The lanes of a block that hold an object.
fn used(numbers: &[u32]) -> Lanes {
    ALL_LANES >> (8 - numbers.len())
}

/// Takes the objects of a block in `open` that are `sure` or else `wanted`.
#[inline]
fn take(
    numbers: &[u32],
    open: Lanes,
    sure: Lanes,
    found: &mut Vec<u32>,
    wanted: impl Fn(u32) -> bool,
) {
    let mut open = open;
    while open != 0 {
        let lane = open.trailing_zeros();
        if let Some(&object) = numbers.get(lane as usize)
            && ((sure >> lane) & 1 == 1 || wanted(object))
        {
            found.push(object);
        }
        open &= open.wrapping_sub(1);
    }
}

fn bounds(tree: &LodTree, object: u32) -> Aabb {
    tree.bounds_of(object).unwrap_or(Aabb::EMPTY)
}
