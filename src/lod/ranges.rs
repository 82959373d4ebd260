//! Object numbers as ranges.

use std::ops::Range;

use super::lanes;
use crate::geom::Lanes;

/// Ranges in the making: ascending, disjoint, never adjacent.
#[derive(Debug, Clone, Default)]
pub(super) struct Ranges {
    list: Vec<Range<u32>>,
    /// Memory of the last change.
    spare: Vec<Range<u32>>,
}

impl Ranges {
    pub(super) fn as_slice(&self) -> &[Range<u32>] {
        &self.list
    }

    /// How many objects there are.
    pub(super) fn count(&self) -> u32 {
        self.list.iter().map(|range| range.end - range.start).sum()
    }

    /// Forgets everything but its memory.
    pub(super) fn clear(&mut self) {
        self.list.clear();
    }

    /// Adds objects behind all others.
    #[inline]
    pub(super) fn push(&mut self, objects: Range<u32>) {
        push(&mut self.list, objects);
    }

    /// The same for those in `set`, counted from `first`.
    #[inline]
    pub(super) fn push_runs(&mut self, first: u32, set: Lanes) {
        let mut rest = set;
        while rest != 0 {
            let lane = rest.trailing_zeros();
            let run = lanes::run_length(rest, lane);
            self.push(first + lane..first + lane + run);
            rest = lanes::after_run(rest, lane, run);
        }
    }

    /// Adds single objects, ascending, between the others.
    pub(super) fn merge(&mut self, objects: impl Iterator<Item = u32>) {
        std::mem::swap(&mut self.list, &mut self.spare);
        self.list.clear();
        let mut rest = self.spare.iter().cloned().peekable();
        for object in objects {
            while let Some(range) = rest.next_if(|range| range.start < object) {
                push(&mut self.list, range);
            }
            push(&mut self.list, object..object + 1);
        }
        rest.for_each(|range| push(&mut self.list, range));
    }

    /// Keeps only the objects for which `keep` holds; they are asked for once each, ascending.
    pub(super) fn retain(&mut self, mut keep: impl FnMut(u32) -> bool) {
        std::mem::swap(&mut self.list, &mut self.spare);
        self.list.clear();
        for object in self.spare.iter().cloned().flatten() {
            if keep(object) {
                push(&mut self.list, object..object + 1);
            }
        }
    }
}

#[inline]
fn push(list: &mut Vec<Range<u32>>, objects: Range<u32>) {
    match list.last_mut() {
        Some(last) if last.end == objects.start => last.end = objects.end,
        Some(last) if last.end > objects.start => {} // only in a damaged file
        _ if objects.is_empty() => {}
        _ => list.push(objects),
    }
}
