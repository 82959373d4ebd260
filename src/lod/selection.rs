//! The answer to a view.

use std::ops::Range;

/// The objects to draw, as ranges of object numbers, and what finding them took.
///
/// Kept and handed in again, it allocates nothing in the long run.
#[derive(Debug, Clone, Default)]
pub struct Selection {
    /// Ranges in the making, one list per level, finest first; each list ascends.
    pub(super) levels: Vec<Vec<Range<u32>>>,
    pub(super) ranges: Vec<Range<u32>>,
    pub(super) bound: f64,
    pub(super) stats: Stats,
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
        &self.ranges
    }

    /// How many objects there are to draw.
    pub fn count(&self) -> u32 {
        self.ranges.iter().map(|r| r.end - r.start).sum()
    }

    /// Their numbers one by one, ascending.
    pub fn objects(&self) -> impl Iterator<Item = u32> + '_ {
        self.ranges.iter().cloned().flatten()
    }

    /// No object that meets the frustum and was left out is larger than this on the screen, in
    /// pixels: diagonal of its box at the distance of its nearest point. Infinite where an
    /// object around the eye may be missing.
    pub fn error_px(&self) -> f64 {
        self.bound
    }

    /// What it took.
    pub fn stats(&self) -> Stats {
        self.stats
    }
}
