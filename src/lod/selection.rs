//! The answer to a view.

use std::ops::Range;

use super::ranges::Ranges;
use super::retrieve::Walk;
use super::sweep::Sizes;

/// The objects to draw, as ranges of object numbers, and what finding them took.
///
/// Kept and handed in again, it allocates nothing in the long run.
#[derive(Debug, Clone, Default)]
pub struct Selection {
    pub(super) ranges: Ranges,
    /// Memory of a walk by distance.
    pub(super) walk: Walk,
    /// Memory of a walk by size.
    pub(super) sizes: Sizes,
    /// Of the ranges, since the answer was concluded.
    count: u32,
    bound: f64,
    stats: Stats,
}

/// What a retrieval did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Stats {
    /// Nodes whose box was looked at.
    pub nodes_visited: u32,
    /// Objects whose box was looked at.
    pub objects_tested: u32,
}

impl Selection {
    /// Object numbers to draw: ascending, disjoint, never adjacent. Coarse levels come first.
    pub fn ranges(&self) -> &[Range<u32>] {
        self.ranges.as_slice()
    }

    /// How many objects there are to draw.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Their numbers one by one, ascending.
    pub fn objects(&self) -> impl Iterator<Item = u32> + '_ {
        self.ranges().iter().cloned().flatten()
    }

    /// No object that meets the frustum and was left out is larger than this on the screen, in
    /// pixels: diagonal of its box at the distance of its nearest point. What an effect took out
    /// ([`Selection::retain`]) does not count. Infinite where an object around the eye may be
    /// missing.
    pub fn error_px(&self) -> f64 {
        self.bound
    }

    /// What it took.
    pub fn stats(&self) -> Stats {
        self.stats
    }

    /// Keeps only the objects for which `keep` holds; they are asked for once each, ascending.
    /// What this leaves out does not count for [`Selection::error_px`]. Returns how many went.
    pub fn retain(&mut self, keep: impl FnMut(u32) -> bool) -> u32 {
        let before = self.count;
        self.ranges.retain(keep);
        self.count = self.ranges.count();
        before - self.count
    }

    /// Forgets everything but its memory.
    pub(super) fn clear(&mut self) {
        self.ranges.clear();
        self.count = 0;
        self.bound = 0.0;
        self.stats = Stats::default();
    }

    /// Forgets the objects added so far, not what it took to find them.
    pub(super) fn forget_ranges(&mut self) {
        self.ranges.clear();
    }

    /// States what it took.
    pub(super) fn set_stats(&mut self, stats: Stats) {
        self.stats = stats;
    }

    /// States the bound, pixels: the answer is whole.
    pub(super) fn conclude(&mut self, error_px: f64) {
        self.count = self.ranges.count();
        self.bound = error_px;
    }
}
