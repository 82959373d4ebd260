//! A city that changes: objects are inserted and removed, representatives stay right.

use std::collections::BTreeMap;

use compact_str::CompactString;
use rstar::{ParentNode, RStarInsertionStrategy, RTree, RTreeNode, RTreeObject, RTreeParams};

use super::hierarchy::{Canonical, Hierarchy, Level};
use super::meta::Meta;
use super::rows::Rows;
use super::{
    BuildError, Candidate, LodEnvelope, LodTree, MAX_FAN_OUT, MIN_FAN_OUT, Promotion, pack,
};
use crate::scene::{Scene, SceneObject};

/// Fan-out for rstar.
#[derive(Debug, Clone, Copy)]
struct FanOut;

impl RTreeParams for FanOut {
    const MIN_SIZE: usize = MIN_FAN_OUT;
    const MAX_SIZE: usize = MAX_FAN_OUT;
    /// Beckmann et al. ("The R*-tree", 1990) advise 30 % of the most.
    const REINSERTION_COUNT: usize = 2;
    type DefaultInsertionStrategy = RStarInsertionStrategy;
}

/// What rstar holds of an object.
#[derive(Debug, Clone, PartialEq)]
struct Entry {
    envelope: LodEnvelope<CompactString>,
}

impl Entry {
    fn of(object: &SceneObject, promotion: Promotion) -> Self {
        Self {
            envelope: LodEnvelope::of(
                &object.bounds,
                Candidate {
                    score: promotion.score(object),
                    key: object.id.clone(),
                },
            ),
        }
    }
}

impl RTreeObject for Entry {
    type Envelope = LodEnvelope<CompactString>;

    fn envelope(&self) -> Self::Envelope {
        self.envelope.clone()
    }
}

/// An R-tree (rstar's R*-tree) of a city that can be edited, and packed again for querying.
///
/// Inserting or removing costs what it costs in rstar, O(log n) on average; [`CityTree::pack`] is
/// linear. For a city that is only read, [`super::build`] is many times faster and packs tighter.
#[derive(Debug)]
pub struct CityTree {
    objects: BTreeMap<CompactString, SceneObject>,
    tree: RTree<Entry, FanOut>,
    promotion: Promotion,
    meta: Meta,
}

impl CityTree {
    /// Loads all objects of a scene with rstar's own bulk loader.
    ///
    /// # Errors
    /// [`BuildError::DuplicateId`] when an id repeats.
    pub fn bulk_load(scene: Scene, promotion: Promotion) -> Result<Self, BuildError> {
        let meta = Meta::of(&scene);
        let mut objects = BTreeMap::new();
        for object in scene.objects {
            if let Some(twin) = objects.insert(object.id.clone(), object) {
                return Err(BuildError::DuplicateId {
                    id: twin.id.to_string(),
                });
            }
        }
        let entries = objects.values().map(|o| Entry::of(o, promotion)).collect();
        Ok(Self {
            tree: RTree::bulk_load_with_params(entries),
            objects,
            promotion,
            meta,
        })
    }

    /// How many objects there are.
    pub fn len(&self) -> usize {
        self.objects.len()
    }

    /// Whether there is no object.
    pub fn is_empty(&self) -> bool {
        self.objects.is_empty()
    }

    /// Adds an object.
    ///
    /// # Errors
    /// [`BuildError::DuplicateId`] when its id is taken; remove the other one first.
    pub fn insert(&mut self, object: SceneObject) -> Result<(), BuildError> {
        if self.objects.contains_key(&object.id) {
            return Err(BuildError::DuplicateId {
                id: object.id.to_string(),
            });
        }
        self.tree.insert(Entry::of(&object, self.promotion));
        self.objects.insert(object.id.clone(), object);
        Ok(())
    }

    /// Takes an object out; `None` when no object has this id.
    pub fn remove(&mut self, id: &str) -> Option<SceneObject> {
        let object = self.objects.remove(id)?;
        self.tree.remove(&Entry::of(&object, self.promotion));
        Some(object)
    }

    /// The packed tree with exactly this tree's nodes and representatives.
    ///
    /// # Errors
    /// [`BuildError::TooManyObjects`] when there are more objects than 32 bits count.
    pub fn pack(&self) -> Result<LodTree, BuildError> {
        if u32::try_from(self.objects.len()).is_ok_and(|n| n < u32::MAX) {
            let objects: Vec<&SceneObject> = self.objects.values().collect();
            let hierarchy = self.hierarchy(&objects);
            let meta = self.meta.clone().with_classes(&objects);
            let rows = Rows::new(&objects, &meta);
            Ok(pack::pack(&rows, &hierarchy, self.promotion, meta))
        } else {
            Err(BuildError::TooManyObjects {
                count: self.objects.len(),
            })
        }
    }

    fn hierarchy(&self, objects: &[&SceneObject]) -> Hierarchy {
        let mut hierarchy = Hierarchy::default();
        if !objects.is_empty() {
            flatten(self.tree.root(), objects, &mut hierarchy);
        }
        hierarchy
    }
}

/// Appends the subtree of `node` and tells its height above the leaves, which rstar keeps the
/// same for all children of a node.
fn flatten(node: &ParentNode<Entry>, objects: &[&SceneObject], hierarchy: &mut Hierarchy) -> usize {
    let canonical = |key: &CompactString| {
        // Every key of the tree is in the map that `objects` was made from.
        objects.partition_point(|o| o.id < *key) as Canonical
    };
    let first = hierarchy.objects.len();
    let mut height = 0;
    for child in node.children() {
        match child {
            RTreeNode::Leaf(entry) => {
                let key = entry.envelope.best().map(|best| canonical(&best.key));
                hierarchy.objects.extend(key);
            }
            RTreeNode::Parent(inner) => height = 1 + flatten(inner, objects, hierarchy),
        }
    }
    if height == 0 {
        hierarchy.objects[first..].sort_unstable();
    }
    if hierarchy.levels.len() <= height {
        hierarchy.levels.resize_with(height + 1, Level::default);
    }
    let level = &mut hierarchy.levels[height];
    level.children.push(node.children().len() as u32);
    level.envelopes.push(node.envelope().map_key(canonical));
    height
}
