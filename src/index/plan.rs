//! Which object is stored where: level order, each object once.

use rayon::prelude::*;

use super::hierarchy::{Canonical, Hierarchy};
use super::outward::stored_radius;
use crate::scene::SceneObject;

/// Which object is stored where.
pub(super) struct Plan {
    /// Objects in file order.
    pub(super) order: Vec<Canonical>,
    /// First own object of each node, then the end.
    pub(super) own: Vec<u32>,
    /// First child of each inner node, then the end.
    pub(super) children: Vec<u32>,
    /// The `levels` section.
    pub(super) levels: Vec<u32>,
}

impl Plan {
    pub(super) fn new(objects: &[&SceneObject], hierarchy: &Hierarchy) -> Self {
        let stored_at = storage_levels(objects.len(), hierarchy);
        let root = hierarchy.levels.len().wrapping_sub(1);
        let mut plan = Self {
            order: Vec::with_capacity(objects.len()),
            own: vec![0],
            children: vec![],
            levels: vec![],
        };
        let mut first_objects = vec![0];
        let mut first_nodes = vec![0];
        let mut next_child = 1;
        for (k, level) in hierarchy.levels.iter().enumerate().rev() {
            let starts = level.child_starts();
            for node in starts.windows(2) {
                let children = node[0] as usize..node[1] as usize;
                if k == 0 {
                    let own = hierarchy.objects[children].iter().copied();
                    plan.order
                        .extend(own.filter(|&o| stored_at[o as usize] == 0));
                } else {
                    let below = &hierarchy.levels[k - 1].envelopes[children];
                    let own = below.iter().filter_map(|c| c.best().map(|best| best.key));
                    let own = own.filter(|&o| usize::from(stored_at[o as usize]) == k);
                    plan.order.extend(own);
                    plan.children.push(next_child);
                    next_child += node[1] - node[0];
                }
                plan.own.push(plan.order.len() as u32);
            }
            first_nodes.push(plan.own.len() as u32 - 1);
            first_objects.push(plan.order.len() as u32);
        }
        debug_assert!(root == usize::MAX || plan.order.len() == objects.len());
        plan.children
            .push(next_child.min(plan.own.len() as u32 - 1));
        plan.levels.extend(first_nodes);
        plan.levels.extend(first_objects);
        plan
    }

    /// The radii a traversal reads.
    pub(super) fn radii(&self, arranged: &[&SceneObject]) -> Radii {
        let own: Vec<f32> = arranged
            .par_iter()
            .map(|o| stored_radius(o.bounds.radius()))
            .collect();
        let mut held: Vec<f32> = self
            .own
            .windows(2)
            .map(|node| largest(&own[node[0] as usize..node[1] as usize]))
            .collect();
        let mut hidden = vec![0.0; held.len()];
        for node in (0..self.children.len() - 1).rev() {
            let children = self.children[node] as usize..self.children[node + 1] as usize;
            hidden[node] = largest(&held[children]);
            held[node] = hidden[node].max(held[node]);
        }
        Radii { own, held, hidden }
    }
}

/// Radii rounded up, m; 0 where there is nothing.
pub(super) struct Radii {
    /// Of each object.
    pub(super) own: Vec<f32>,
    /// Largest of each node's own objects and of those below it.
    pub(super) held: Vec<f32>,
    /// Largest below each node that is not its own.
    pub(super) hidden: Vec<f32>,
}

fn largest(radii: &[f32]) -> f32 {
    radii.iter().copied().fold(0.0, f32::max)
}

/// The level each object is stored at: one above the highest node it stands for, the root at most.
fn storage_levels(objects: usize, hierarchy: &Hierarchy) -> Vec<u8> {
    let mut stored_at = vec![0_u8; objects];
    let inner = hierarchy.levels.len().saturating_sub(1);
    for (k, level) in hierarchy.levels[..inner].iter().enumerate() {
        for best in level.envelopes.iter().filter_map(|e| e.best()) {
            stored_at[best.key as usize] = k as u8 + 1;
        }
    }
    stored_at
}
