//! The levels of a tree as one walk sees them.

use super::RangeLod;
use crate::geom::{Filter, Threshold};
use crate::index::Arrays;

/// What the walk keeps of a level.
#[derive(Debug, Clone, Copy)]
pub(super) struct Level {
    /// Its far distance; where it has no range, that of the last level that has one.
    pub(super) far: Threshold,
    /// The first node not yet visited. In a sound file it only states what is so: nodes come in
    /// tree order. In a damaged one it keeps the walk finite.
    pub(super) next: u32,
    /// The level's last node, plus one.
    pub(super) end: u32,
}

impl Level {
    /// All levels of a tree, level 0 first; returns how many have a range.
    pub(super) fn all(
        arrays: &Arrays,
        filter: &Filter,
        lod: &RangeLod,
        levels: &mut Vec<Self>,
    ) -> u32 {
        let ends = arrays.level_nodes.get(1..).unwrap_or_default();
        let mut ends = ends.iter().rev();
        levels.clear();
        for (distance, &end) in lod.far_dists(ends.len() as u32).zip(ends.by_ref()) {
            let far = filter.threshold(distance);
            levels.push(Self { far, next: 0, end });
        }
        let ranged = levels.len();
        if let Some(&last) = levels.last() {
            levels.extend(ends.map(|&end| Self { end, ..last }));
        }
        ranged as u32
    }
}
