//! Which object is stored where: level order, each object once.

use super::hierarchy::{Canonical, Hierarchy};

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
    /// For a hierarchy of so many objects.
    pub(super) fn new(objects: usize, hierarchy: &Hierarchy) -> Self {
        let stored_at = storage_levels(objects, hierarchy);
        let root = hierarchy.levels.len().wrapping_sub(1);
        let mut plan = Self {
            order: Vec::with_capacity(objects),
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
        debug_assert!(root == usize::MAX || plan.order.len() == objects);
        plan.children
            .push(next_child.min(plan.own.len() as u32 - 1));
        plan.levels.extend(first_nodes);
        plan.levels.extend(first_objects);
        plan
    }
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
