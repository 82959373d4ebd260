//! The answer to a view.

use std::ops::Range;

use super::lanes;
use super::level::Level;
use super::sweep::Sizes;
use crate::geom::{Lanes, PixelScale};

/// The objects to draw, as ranges of object numbers, and what finding them took.
///
/// Kept and handed in again, it allocates nothing in the long run.
#[derive(Debug, Clone, Default)]
pub struct Selection {
    /// Ranges in the making, one list per level, finest first; each list ascends.
    levels: Vec<Vec<Range<u32>>>,
    ranges: Vec<Range<u32>>,
    /// Memory of the last merge.
    merged: Vec<Range<u32>>,
    /// What the walk keeps of each level, finest first.
    pub(super) walk: Vec<Level>,
    /// What a walk by size keeps.
    pub(super) sizes: Sizes,
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
    /// pixels: diagonal of its box at the distance of its nearest point. What an effect took out
    /// ([`Selection::retain`]) does not count. Infinite where an
    /// object around the eye may be missing.
    pub fn error_px(&self) -> f64 {
        self.bound
    }

    /// What it took.
    pub fn stats(&self) -> Stats {
        self.stats
    }

    /// Keeps only the objects for which `keep` holds; they are asked for once each, ascending.
    /// What this leaves out does not count for [`Selection::error_px`]. Returns how many went.
    pub fn retain(&mut self, mut keep: impl FnMut(u32) -> bool) -> u32 {
        let before = self.count();
        let Some(kept) = self.levels.first_mut() else {
            return 0; // nothing was ever selected
        };
        kept.clear();
        for object in self.ranges.drain(..).flatten() {
            if keep(object) {
                append(kept, object..object + 1);
            }
        }
        std::mem::swap(kept, &mut self.ranges);
        before - self.count()
    }

    /// Forgets everything but its memory; the next tree has so many levels.
    pub(super) fn clear(&mut self, levels: u32) {
        const USUAL: usize = 256;
        self.levels
            .resize_with(levels as usize, || Vec::with_capacity(USUAL));
        self.levels.iter_mut().for_each(Vec::clear);
        self.ranges.clear();
        self.bound = 0.0;
        self.stats = Stats::default();
    }

    /// Adds objects stored at `level`; they follow those added there before.
    #[inline]
    pub(super) fn add(&mut self, level: u32, objects: Range<u32>) {
        if let Some(list) = self.levels.get_mut(level as usize) {
            append(list, objects);
        }
    }

    /// The same for objects in `set`, counted from `first`.
    #[inline]
    pub(super) fn add_runs(&mut self, level: u32, first: u32, set: Lanes) {
        if let Some(list) = self.levels.get_mut(level as usize) {
            append_runs(list, first, set);
        }
    }

    /// Step 7: puts the levels together, coarsest first, and states what it took and what the
    /// largest size left out is: radii, per metre of distance where the view is a perspective.
    pub(super) fn finish(&mut self, largest_omitted: f32, pixels: PixelScale, stats: Stats) {
        self.ranges.reserve(self.levels.iter().map(Vec::len).sum());
        for list in self.levels.iter_mut().rev() {
            // Within a level no two are adjacent.
            if let (Some(last), Some(first)) = (self.ranges.last(), list.first_mut())
                && last.end == first.start
            {
                first.start = last.start;
                self.ranges.pop();
            }
            self.ranges.append(list);
        }
        let (PixelScale::PerRadian(scale) | PixelScale::PerMetre(scale)) = pixels;
        self.bound = 2.0 * f64::from(largest_omitted) * scale;
        self.stats = stats;
    }

    /// Adds objects in `set`, counted from `first`, behind all others.
    #[inline]
    pub(super) fn push_runs(&mut self, first: u32, set: Lanes) {
        append_runs(&mut self.ranges, first, set);
    }

    /// Adds objects behind all others.
    #[inline]
    pub(super) fn push(&mut self, objects: Range<u32>) {
        append(&mut self.ranges, objects);
    }

    /// Adds single objects, ascending, between the others.
    pub(super) fn merge(&mut self, objects: impl Iterator<Item = u32>) {
        let others = std::mem::take(&mut self.merged);
        let others = std::mem::replace(&mut self.ranges, others);
        self.ranges.clear();
        let mut rest = others.iter().cloned().peekable();
        for object in objects {
            while let Some(range) = rest.next_if(|range| range.start < object) {
                append(&mut self.ranges, range);
            }
            append(&mut self.ranges, object..object + 1);
        }
        rest.for_each(|range| append(&mut self.ranges, range));
        self.merged = others;
    }

    /// Forgets the objects added so far, not what it took to find them.
    pub(super) fn forget_ranges(&mut self) {
        self.ranges.clear();
    }

    /// States what it took.
    pub(super) fn set_stats(&mut self, stats: Stats) {
        self.stats = stats;
    }

    /// States the bound, pixels.
    pub(super) fn conclude(&mut self, error_px: f64) {
        self.bound = error_px;
    }
}

#[inline]
fn append_runs(list: &mut Vec<Range<u32>>, first: u32, set: Lanes) {
    let mut rest = set;
    while rest != 0 {
        let lane = rest.trailing_zeros();
        let run = lanes::run_length(rest, lane);
        append(list, first + lane..first + lane + run);
        rest = lanes::after_run(rest, lane, run);
    }
}

#[inline]
fn append(list: &mut Vec<Range<u32>>, objects: Range<u32>) {
    match list.last_mut() {
        Some(last) if last.end == objects.start => last.end = objects.end,
        Some(last) if last.end > objects.start => {} // only in a damaged file
        _ if objects.is_empty() => {}
        _ => list.push(objects),
    }
}
