//! The answer to a view.

use std::ops::Range;

use crate::geom::PixelScale;

/// The objects to draw, as ranges of object numbers, and what finding them took.
///
/// Kept and handed in again, it allocates nothing in the long run.
#[derive(Debug, Clone, Default)]
pub struct Selection {
    /// Ranges in the making, one list per level, finest first; each list ascends.
    levels: Vec<Vec<Range<u32>>>,
    ranges: Vec<Range<u32>>,
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
    /// pixels: diagonal of its box at the distance of its nearest point. Infinite where an
    /// object around the eye may be missing.
    pub fn error_px(&self) -> f64 {
        self.bound
    }

    /// What it took.
    pub fn stats(&self) -> Stats {
        self.stats
    }

    /// Forgets everything but its memory; the next tree has so many levels.
    pub(super) fn clear(&mut self, levels: u32) {
        self.levels.resize_with(levels as usize, Vec::new);
        self.levels.iter_mut().for_each(Vec::clear);
        self.ranges.clear();
        self.bound = 0.0;
        self.stats = Stats::default();
    }

    /// Adds objects stored at `level`; they follow those added there before.
    #[inline]
    pub(super) fn add(&mut self, level: u32, objects: Range<u32>) {
        let Some(list) = self.levels.get_mut(level as usize) else {
            return;
        };
        match list.last_mut() {
            Some(last) if last.end == objects.start => last.end = objects.end,
            Some(last) if last.end > objects.start => {} // only in a damaged file
            _ if objects.is_empty() => {}
            _ => list.push(objects),
        }
    }

    /// Step 7: puts the levels together, coarsest first, and states what it took and what the
    /// largest size left out is: radii, per metre of distance where the view is a perspective.
    pub(super) fn finish(&mut self, largest_omitted: [f32; 8], pixels: PixelScale, stats: Stats) {
        for list in self.levels.iter().rev() {
            for objects in list {
                match self.ranges.last_mut() {
                    Some(last) if last.end == objects.start => last.end = objects.end,
                    _ => self.ranges.push(objects.clone()),
                }
            }
        }
        let largest = f64::from(largest_omitted.into_iter().fold(0.0, f32::max));
        let (PixelScale::PerRadian(scale) | PixelScale::PerMetre(scale)) = pixels;
        self.bound = 2.0 * largest * scale;
        self.stats = stats;
    }
}
