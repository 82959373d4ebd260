//! Boxes in blocks of eight.

use rayon::prelude::*;

use super::file::{Block, Radii};
use super::outward::outward;
use crate::geom::DVec3;

/// Where the blocks of each group of boxes begin; a group starts a block of its own.
pub(super) struct Blocks<'a> {
    /// First box of each group, then their number.
    groups: &'a [u32],
    /// First block of each group, then their number.
    pub(super) starts: Vec<u32>,
}

impl<'a> Blocks<'a> {
    /// Blocks for the groups that `groups` tells apart, the first of them numbered `first`.
    pub(super) fn new(first: u32, groups: &'a [u32]) -> Self {
        let mut starts = Vec::with_capacity(groups.len());
        let mut end = first;
        starts.push(end);
        for group in groups.windows(2) {
            end += (group[1] - group[0]).div_ceil(8);
            starts.push(end);
        }
        Self { groups, starts }
    }

    /// Number of all blocks, those before the first included.
    pub(super) fn count(&self) -> usize {
        self.starts.last().map_or(0, |&end| end as usize)
    }

    /// Fills one number a box in the order of the blocks.
    pub(super) fn fill_radii(&self, radii: &[f32], blocks: &mut [Radii]) {
        let groups = self
            .groups
            .windows(2)
            .flat_map(|group| radii[group[0] as usize..group[1] as usize].chunks(8));
        for (radii, block) in groups.zip(blocks) {
            block[..radii.len()].copy_from_slice(radii);
        }
    }

    /// Fills the blocks of all groups.
    pub(super) fn fill(&self, origin: DVec3, boxes: &[[f64; 6]], blocks: &mut [Block]) {
        // Pieces of groups, each with the blocks it owns.
        const PIECE: usize = 4096;
        let mut rest = blocks;
        let mut pieces = Vec::new();
        let groups = self.groups.len() - 1;
        for from in (0..groups).step_by(PIECE) {
            let to = (from + PIECE).min(groups);
            let (piece, after) = rest.split_at_mut((self.starts[to] - self.starts[from]) as usize);
            pieces.push((&self.groups[from..=to], piece));
            rest = after;
        }
        pieces.into_par_iter().for_each(|(groups, blocks)| {
            let boxes = groups
                .windows(2)
                .flat_map(|group| boxes[group[0] as usize..group[1] as usize].chunks(8));
            for (boxes, block) in boxes.zip(blocks) {
                place(origin, boxes, block);
            }
        });
    }
}

/// Writes at most eight boxes into a block, relative to the origin and rounded outward.
pub(super) fn place(origin: DVec3, boxes: &[[f64; 6]], block: &mut Block) {
    for (at, corners) in boxes.iter().enumerate() {
        for (lane, corner) in block.iter_mut().zip(outward(corners, origin)) {
            lane[at] = corner;
        }
    }
}
