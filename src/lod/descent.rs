//! From one level down to the next.
//!
//! Nodes and objects are numbered in level order, so a walk level by level meets both in ascending
//! order, and ranges come out as they are listed.

use std::ops::Range;

use crate::index::Arrays;

/// The nodes of a level, to be handed out in their order. In a sound file it only states what is
/// so; in a damaged one it keeps the walk short.
#[derive(Debug)]
pub(super) struct Descent {
    rest: Range<u32>,
}

impl Descent {
    /// To the level at this depth, 0 for the root's.
    pub(super) fn to(arrays: &Arrays, depth: u32) -> Self {
        let start = |depth: u32| {
            let start = arrays.level_nodes.get(depth as usize);
            start.copied().unwrap_or(0)
        };
        Self {
            rest: start(depth)..start(depth + 1),
        }
    }

    /// The children of neighbouring nodes, unless they were handed out before.
    #[inline]
    pub(super) fn children(&mut self, arrays: &Arrays, nodes: Range<u32>) -> Option<Range<u32>> {
        let first = *arrays.children.get(nodes.start as usize)?;
        let end = *arrays.children.get(nodes.end as usize)?;
        if first < self.rest.start || end < first || end > self.rest.end {
            return None; // only in a damaged file
        }
        self.rest.start = end;
        Some(first..end)
    }
}
