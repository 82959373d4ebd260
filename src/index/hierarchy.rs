//! A tree before it is packed: which objects lie in which node, whoever decided it.

use rayon::prelude::*;

use super::LodEnvelope;
use super::error::BuildError;
use crate::scene::{Scene, SceneObject};

/// Place of an object in [`canonical_order`]: the order of ids.
pub(super) type Canonical = u32;

/// Nodes level by level, each level in tree order: the children of a node follow one another, and
/// so do the children of the next node after them.
#[derive(Debug, Clone, Default)]
pub(super) struct Hierarchy {
    /// All objects, leaf by leaf; ascending within a leaf.
    pub objects: Vec<Canonical>,
    /// Leaves first, root last. Empty for a scene without objects.
    pub levels: Vec<Level>,
}

impl Hierarchy {
    /// Box and representative of every node, in file order: root first.
    pub(super) fn envelopes(&self) -> impl Iterator<Item = &LodEnvelope<Canonical>> {
        self.levels.iter().rev().flat_map(|level| &level.envelopes)
    }
}

/// All nodes at one height above the leaves.
#[derive(Debug, Clone, Default)]
pub(super) struct Level {
    /// Children of each node: nodes of the level below, or objects for leaves.
    pub children: Vec<u32>,
    /// Box and representative of each node.
    pub envelopes: Vec<LodEnvelope<Canonical>>,
}

impl Level {
    /// For each node, the first of its children in the level below, and the end of the last.
    pub(super) fn child_starts(&self) -> Vec<u32> {
        let mut starts = Vec::with_capacity(self.children.len() + 1);
        starts.push(0);
        let mut end = 0;
        for count in &self.children {
            end += count;
            starts.push(end);
        }
        starts
    }
}

/// The scene's objects in the order of their ids.
pub(super) fn canonical_order(scene: &Scene) -> Result<Vec<&SceneObject>, BuildError> {
    let mut objects: Vec<&SceneObject> = scene.objects.iter().collect();
    if u32::try_from(objects.len()).is_ok_and(|n| n < u32::MAX) {
        if objects.par_windows(2).all(|pair| pair[0].id < pair[1].id) {
            return Ok(objects);
        }
        objects.par_sort_by(|a, b| a.id.cmp(&b.id));
        match objects.windows(2).find(|pair| pair[0].id == pair[1].id) {
            None => Ok(objects),
            Some(pair) => Err(BuildError::DuplicateId {
                id: pair[0].id.to_string(),
            }),
        }
    } else {
        Err(BuildError::TooManyObjects {
            count: objects.len(),
        })
    }
}
