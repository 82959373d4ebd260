//! What a walk keeps of each level: its range, and how far it has come.

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
        let mut ranges = arrays.level_nodes.windows(2).rev();
        levels.clear();
        for (distance, range) in lod.far_dists(ranges.len() as u32).zip(ranges.by_ref()) {
            let far = filter.threshold(distance);
            levels.push(Self {
                far,
                next: range[0],
                end: range[1],
            });
        }
        let ranged = levels.len();
        if let Some(&Self { far, .. }) = levels.last() {
            levels.extend(ranges.map(|range| Self {
                far,
                next: range[0],
                end: range[1],
            }));
        }
        ranged as u32
    }
}
